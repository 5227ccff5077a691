//! The history of a task, from the decisions about it.

use super::cause::CauseDetail;
use super::moment::Moment;
use crate::effect_describer::cause_text;
use crate::error::RecordError;
use crate::method_detail::MethodDetail;
use crate::record::view::decisions::{DecisionRow, Decisions};
use apex_model::because::{Because, Cause, Strength};
use apex_model::effect::Effect;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;

/// A task's history up to an instant.
pub(super) struct History {
    pub(super) moments: Vec<Moment>,
    /// The state's word.
    pub(super) state: String,
    /// The goal as known last.
    pub(super) goal: Option<String>,
    pub(super) method: Option<String>,
    pub(super) blocked: Option<Conflict>,
}

/// The conflict that a task lost last, if it has not won since.
pub(super) struct Conflict {
    pub(super) by: TaskId,
    pub(super) resource: String,
    pub(super) since: Time,
    pub(super) winner: Strength,
    pub(super) loser: Strength,
}

impl History {
    /// Reads the decisions about `task`.
    pub(super) fn read(decisions: Decisions<'_>, task: TaskId) -> Result<History, RecordError> {
        let state = TaskState::Pending.word().into();
        let mut history = History { moments: Vec::new(), state, goal: None, method: None, blocked: None };
        decisions.about(task, |row| history.add(row))?;
        Ok(history)
    }

    /// Returns true for states in which a task waits for requirements that the agent can name.
    pub(super) fn waits(&self) -> bool {
        self.state != TaskState::Terminated.word()
    }

    fn add(&mut self, row: DecisionRow) {
        let because = because_of(&row);
        let (what, text) = match row.kind.as_str() {
            "created" => {
                self.goal = Some(row.subject.clone());
                ("created".to_owned(), row.text.clone())
            }
            "transition" => {
                self.state = row.to.clone().unwrap_or_default();
                self.blocked = self.conflict(because, row.at);
                let outcome = row.outcome.as_ref().map(|outcome| format!(" ({outcome})")).unwrap_or_default();
                let words = |state: &Option<String>| state.clone().unwrap_or_default();
                (format!("{} -> {}{outcome}", words(&row.from), words(&row.to)), row.text.clone())
            }
            "selected" => {
                self.goal = Some(row.subject.clone());
                let text = row.method.as_ref().map(MethodDetail::to_string).unwrap_or_default();
                let what = format!("selected {text}");
                self.method = Some(text);
                (what, because.map(cause_text).unwrap_or_default())
            }
            "refused" => {
                self.blocked = self.conflict(because, row.at);
                (format!("refused {}", row.subject), row.text.clone())
            }
            "satisfied" => (format!("{} satisfied", row.subject), row.text.clone()),
            "bound" | "procedure-added" => (row.subject.clone(), row.text.clone()),
            // The message of an error is its cause, or the end of it: a failed expression's cause has words before the message.
            "trouble" if row.text.ends_with(&row.subject) => (format!("trouble: {}", row.text), String::new()), // english: allow
            "trouble" => (format!("trouble: {}", row.subject), row.text.clone()), // english: allow
            "print" => (format!("prints {}", row.text), String::new()),
            "solve" | "ask" => (format!("{}s: {} ({})", row.kind, row.subject, row.text), String::new()),
            other => (format!("{other} {}", row.subject), String::new()),
        };
        self.moments.push(Moment {
            id: row.id,
            t: row.at.seconds(),
            what: what.replace('\n', "\\n"),
            because: text,
            cause: because.map(CauseDetail::of),
            kind: row.kind,
            place: row.place,
            from: row.from,
            to: row.to,
            outcome: row.outcome,
            subject: row.subject,
            method: row.method,
        });
    }

    /// Returns the conflict that a cause reports; a repeated conflict keeps its first instant.
    fn conflict(&self, because: Option<&Because>, at: Time) -> Option<Conflict> {
        let Cause::Outranked { by, resource, winner, loser, .. } = &because?.cause else { return None };
        let (by, resource) = (*by, resource.to_string());
        let known = self.blocked.as_ref().filter(|known| known.by == by && known.resource == resource);
        let since = known.map_or(at, |known| known.since);
        Some(Conflict { by, resource, since, winner: *winner, loser: *loser })
    }
}

/// Returns the cause that a decision states.
pub(super) fn because_of(row: &DecisionRow) -> Option<&Because> {
    match row.effect.as_ref()? {
        Effect::Decided(decision) => Some(&decision.because),
        Effect::Command { because, .. } | Effect::Publish { because, .. } => Some(because),
        _ => None,
    }
}
