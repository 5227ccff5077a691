//! Kinds of effects: the properties of an effect that follow from its shape alone.

use crate::effect_describer::outcome_word;
use apex_model::cause::Cause;
use apex_model::effect::{Decision, DecisionKind, Effect};
use apex_model::task::{TaskId, TaskState};

/// Part of an effect that a scan needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EffectNeed {
    Nothing,
    /// Kind, task and instant, which cost little.
    Kind,
    Effect,
}

/// Kind of an effect, which all effects of a shape share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct EffectKind {
    /// `transition`, `command`, ..: `docs/reference/flight-record.md` lists them.
    pub(crate) word: &'static str,
    /// State after, for `transition`.
    pub(crate) to: Option<TaskState>,
    /// A word of `apex_model::task::OUTCOME_WORDS`, for the transition to `terminated`.
    pub(crate) outcome: Option<&'static str>,
    /// True if the effect grants resources.
    pub(crate) grants: bool,
    /// True if the effect is about a task.
    pub(in crate::record) has_task: bool,
}

impl EffectKind {
    /// Returns the part of an effect of this kind that a list of tasks needs.
    pub(crate) fn wanted_of_tasks(&self) -> EffectNeed {
        match self.word {
            "created" | "selected" => EffectNeed::Effect,
            "transition" => EffectNeed::Kind,
            _ => EffectNeed::Nothing,
        }
    }

    /// Returns true if the effect states the task's goal.
    pub(in crate::record) fn tells_goal(&self) -> bool {
        matches!(self.word, "created" | "selected")
    }

    /// Returns the kind of `effect`.
    pub(in crate::record) fn of(effect: &Effect) -> EffectKind {
        let mut kind = EffectKind { word: word(effect), to: None, outcome: None, grants: false, has_task: false };
        kind.has_task = EffectKind::task_of(effect).is_some();
        if let Effect::Decided(Decision { kind: DecisionKind::Transition { to, outcome, .. }, because, .. }) = effect {
            kind.to = Some(*to);
            kind.outcome = outcome.as_ref().map(outcome_word);
            kind.grants = matches!(because.cause, Cause::ResourcesGranted { .. });
        }
        kind
    }

    /// Returns the task that an effect is about.
    pub(in crate::record) fn task_of(effect: &Effect) -> Option<TaskId> {
        match effect {
            Effect::Decided(decision) => decision.task,
            Effect::Solve(request) => Some(request.task),
            Effect::Command { task, .. }
            | Effect::Inform { task, .. }
            | Effect::Publish { task, .. }
            | Effect::Print { task, .. }
            | Effect::Ask { task, .. }
            | Effect::Tell { task, .. } => Some(*task),
            Effect::WithdrawCommand { .. }
            | Effect::CancelSolve(_)
            | Effect::WithdrawQuestion { .. }
            | Effect::AgentEnded { .. }
            | Effect::EndApplication { .. } => None,
        }
    }
}

/// Returns the word for an effect's kind, as used by the describer.
fn word(effect: &Effect) -> &'static str {
    match effect {
        Effect::Decided(decision) => match decision.kind {
            DecisionKind::Created { .. } => "created",
            DecisionKind::Transition { .. } => "transition",
            DecisionKind::Satisfied { .. } => "satisfied",
            DecisionKind::Bound { .. } => "bound",
            DecisionKind::Selected { .. } => "selected",
            DecisionKind::Refused { .. } => "refused",
            DecisionKind::ProcedureAdded { .. } => "procedure-added",
            DecisionKind::Trouble { .. } => "trouble", // english: allow
        },
        Effect::Command { .. } => "command",
        Effect::WithdrawCommand { .. } => "withdraw",
        Effect::Solve(_) => "solve",
        Effect::CancelSolve(_) => "cancel-solve",
        Effect::Inform { .. } => "inform",
        Effect::Publish { .. } => "publish",
        Effect::Print { .. } => "print",
        Effect::Ask { .. } => "ask",
        Effect::WithdrawQuestion { .. } => "withdraw-question",
        Effect::Tell { .. } => "tell",
        Effect::AgentEnded { .. } => "agent-ended",
        Effect::EndApplication { .. } => "end-application",
    }
}
