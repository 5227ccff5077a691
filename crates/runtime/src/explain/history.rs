//! The history of a task, from the decisions about it.

use super::cause::CauseDetail;
use super::moment::{MethodDetail, Moment};
use crate::effect_describer::cause_text;
use crate::error::RecordError;
use crate::record::view::decisions::{DecisionRow, Decisions};
use apex_model::because::{Because, Cause, Strength};
use apex_model::effect::{Decision, DecisionKind, Effect, Method};
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
        let mut method = None;
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
                let text = selected_text(&row);
                method = selected_method(&row).map(|method| MethodDetail::of(method, &text));
                self.method = Some(text.clone());
                (format!("selected {text}"), because.map(cause_text).unwrap_or_default())
            }
            "refused" => {
                self.blocked = self.conflict(because, row.at);
                (format!("refused {}", row.subject), row.text.clone())
            }
            "satisfied" => (format!("{} satisfied", row.subject), row.text.clone()),
            "bound" | "procedure-added" => (row.subject.clone(), row.text.clone()),
            // The message of a failure that is handled is its cause, reported already.
            "trouble" if row.subject.starts_with(&row.text) => (format!("trouble: {}", row.text), String::new()), // english: allow
            // The cause of a failed expression is its message, with words before it.
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
            method,
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

/// Returns the selected method, for the kind `selected`.
fn selected_method(row: &DecisionRow) -> Option<&Method> {
    match row.effect.as_ref()? {
        Effect::Decided(Decision { kind: DecisionKind::Selected { method, .. }, .. }) => Some(method),
        _ => None,
    }
}

/// Returns the selected method as text, `procedure file.pdl:3:1`: the row's text without the cause that follows it.
pub(super) fn selected_text(row: &DecisionRow) -> String {
    let cause = because_of(row).map(|because| format!(" because {}", cause_text(because)));
    cause.and_then(|cause| row.text.strip_suffix(&cause)).unwrap_or(&row.text).to_owned()
}
