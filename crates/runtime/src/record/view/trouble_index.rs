//! An index of failures, interruptions and faults, shared by all views of a record and grown with it. (english: allow)

use crate::error::RecordError;
use crate::record::{EffectKind, Effects, RecordReader};
use apex_model::because::{Because, Cause};
use apex_model::effect::{Decision, Effect};
use apex_model::task::{TaskId, TaskState, is_failure_word};
use serde::Serialize;

/// Kind of the effects that report faults.
const FAULT: &str = "trouble"; // english: allow
/// Kind of the effects that create tasks.
const CREATED: &str = "created";

/// A failure, an interruption or a fault.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Trouble {
    /// Mission time in nanoseconds.
    pub t_ns: i64,
    /// Kind of the entry.
    pub kind: TroubleKind,
    /// The goal, target or message concerned.
    pub subject: String,
    /// Cause; empty for a fault whose message is its cause.
    pub cause: String,
    /// The number of the task concerned, if there is one.
    pub task: Option<u64>,
    /// The number of the subtask whose failure is the cause.
    pub failed_child: Option<u64>,
    /// The number of the task that handles the failure, for the fault that reports a handled failure.
    pub handler_task: Option<u64>,
    /// The goal of that task as known at the instant of the query.
    pub handler: Option<String>,
    /// `file:line:column` of the clause of PDL.
    pub place: Option<String>,
    /// The target's identifier, if the entry concerns a target.
    pub target: Option<String>,
    /// Identifiers of the targets that the goal of the task concerned names.
    pub targets: Vec<String>,
    /// The kind of the cause, a word of `docs/reference/flight-record.md`; null for entries that are not decisions.
    pub cause_kind: Option<String>,
}

/// Kind of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "kebab-case")]
pub enum TroubleKind {
    /// A task failed.
    Failed,
    /// A task was interrupted: it lost a resource, or was suspended.
    Interrupted,
    /// The executive met a fault: an error in an expression, a limit, a stray answer.
    Fault,
    /// A target that was planned or new is in no plan.
    LeftOut,
    /// The flight ended in failure.
    Ended,
}

/// Failures, interruptions and faults, kept in memory and grown with the record. Bound: each effect is read once.
#[derive(Default)]
pub(super) struct TroubleIndex {
    read_to: i64,
    /// By time.
    entries: Vec<Trouble>,
}

impl TroubleIndex {
    /// Returns the number of the last effect that was read.
    pub(super) fn read_to(&self) -> i64 {
        self.read_to
    }

    /// Returns the entries up to mission time `until` in nanoseconds.
    pub(super) fn until(&self, until: i64) -> &[Trouble] {
        let end = self.entries.partition_point(|entry| entry.t_ns <= until);
        self.entries.get(..end).unwrap_or_default()
    }

    /// Reads effects up to `last`. Of successive interruptions with the same instant and the same cause, only the first is kept.
    pub(super) fn refresh(&mut self, reader: &RecordReader, last: i64) -> Result<(), RecordError> {
        let effects = reader.effects()?;
        for place in effects.table.place_after(self.read_to)..effects.table.place_after(last) {
            let Some(kind) = effects.table.kind(place).and_then(kind_of) else { continue };
            let told = effects.told(place)?;
            let is_fault = kind == TroubleKind::Fault;
            let repeats = is_fault && told.row.subject == told.row.text;
            let trouble = Trouble {
                t_ns: told.at.0,
                kind,
                handler_task: if is_fault { handler_task(&effects, place, told.row.task)? } else { None },
                handler: None,
                failed_child: failed_child(&told.effect),
                subject: told.row.subject,
                cause: if repeats { String::new() } else { told.row.text },
                task: told.row.task.map(|task| task.0),
                place: told.row.place,
                target: None,
                targets: Vec::new(),
                cause_kind: cause_kind(&told.effect).map(str::to_owned),
            };
            let is_same = |before: &Trouble| {
                kind == TroubleKind::Interrupted
                    && (before.t_ns, before.kind, &before.cause) == (trouble.t_ns, kind, &trouble.cause)
            };
            if !self.entries.last().is_some_and(is_same) {
                self.entries.push(trouble);
            }
        }
        self.read_to = self.read_to.max(last);
        Ok(())
    }
}

/// Returns the kind of the cause of a decision.
fn cause_kind(effect: &Effect) -> Option<&'static str> {
    match effect {
        Effect::Decided(decision) => Some(decision.because.cause.kind()),
        _ => None,
    }
}

/// Returns the subtask whose failure is the cause of a decision.
fn failed_child(effect: &Effect) -> Option<u64> {
    match effect {
        Effect::Decided(Decision { because: Because { cause: Cause::ChildFailed { child }, .. }, .. }) => Some(child.0),
        _ => None,
    }
}

/// Returns the task that handles the failure of `task`, which the fault at `place` reports: it is created directly after that.
fn handler_task(effects: &Effects<'_>, place: usize, task: Option<TaskId>) -> Result<Option<u64>, RecordError> {
    let next = place + 1;
    if effects.table.kind(next).is_none_or(|kind| kind.word != CREATED) {
        return Ok(None);
    }
    Ok(match effects.effect(next)? {
        Effect::Decided(Decision {
            task: Some(handler),
            because: Because { cause: Cause::HandlesFailure { of }, .. },
            ..
        }) if Some(of) == task => Some(handler.0),
        _ => None,
    })
}

/// Returns the kind of the entry for an effect; `None` if the effect makes no entry.
fn kind_of(kind: &EffectKind) -> Option<TroubleKind> {
    match (kind.word, kind.to, kind.outcome) {
        (FAULT, ..) => Some(TroubleKind::Fault),
        ("transition", Some(TaskState::Interrupted), _) => Some(TroubleKind::Interrupted),
        ("transition", _, Some(outcome)) if is_failure_word(outcome) => Some(TroubleKind::Failed),
        _ => None,
    }
}
