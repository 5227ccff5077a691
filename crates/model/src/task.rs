//! Names, states and outcomes of tasks (paper, section III). The executive's `state::task` holds the tasks themselves.

use crate::value::Value;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Number of a task, from a counter of the agent, never reused.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct TaskId(pub u64);

impl fmt::Display for TaskId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "T{}", self.0)
    }
}

impl fmt::Debug for TaskId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// The five states of a task (paper, section III).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum TaskState {
    /// Waits for its preconditions.
    Pending,
    /// Waits for its resources.
    Enabled,
    /// Works.
    Ongoing,
    /// Lost a resource, or was suspended.
    Interrupted,
    /// Ended.
    Terminated,
}

impl TaskState {
    /// Returns the state's word in PDL and in traces.
    pub fn word(self) -> &'static str {
        match self {
            TaskState::Pending => "pending",
            TaskState::Enabled => "enabled",
            TaskState::Ongoing => "ongoing",
            TaskState::Interrupted => "interrupted",
            TaskState::Terminated => "terminated",
        }
    }
}

impl fmt::Display for TaskState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// Outcome of a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Outcome {
    /// As intended, with its value.
    Success(Value),
    /// Without success; the decision's cause states the reason.
    Failure,
    /// Its parent ended first, or another task terminated it.
    Cut,
    /// It did not begin: its `skip-when` or `exit-when` held before, or what it waits for can no longer occur.
    Skipped,
    /// Its `exit-when` held while it was ongoing.
    Exited,
    /// A failure: its `precondition` did not hold when it was to begin.
    PreconditionFailed,
    /// A failure: its `invariant` did not hold while it was ongoing.
    InvariantViolated,
}

impl Outcome {
    /// Returns true for each kind of failure: its parent fails unless a clause handles it.
    pub fn is_failure(&self) -> bool {
        matches!(self, Outcome::Failure | Outcome::PreconditionFailed | Outcome::InvariantViolated)
    }

    /// Returns the outcome's word in traces and answers.
    pub fn word(&self) -> &'static str {
        match self {
            Outcome::Success(_) => "success",
            Outcome::Failure => "failure",
            Outcome::Cut => "cut",
            Outcome::Skipped => "skipped",
            Outcome::Exited => "exited",
            Outcome::PreconditionFailed => "precondition failed",
            Outcome::InvariantViolated => "invariant violated",
        }
    }

    /// Returns the past tense of the outcome for sentences about a task: `it failed`.
    pub fn phrase(&self) -> &'static str {
        match self {
            Outcome::Success(_) => "succeeded",
            Outcome::Failure => "failed",
            Outcome::Cut => "was cut",
            Outcome::Skipped => "was skipped",
            Outcome::Exited => "exited",
            Outcome::PreconditionFailed => "failed by its precondition",
            Outcome::InvariantViolated => "failed by its invariant",
        }
    }

    /// Returns the words of [`OUTCOME_STATES`] that hold of a task with this outcome.
    pub fn states(&self) -> &'static [&'static str] {
        match self {
            Outcome::Success(_) => &["succeeded"],
            Outcome::Failure => &["failed"],
            Outcome::Cut => &["cut"],
            Outcome::Skipped => &["skipped"],
            Outcome::Exited => &["exited"],
            Outcome::PreconditionFailed => &["failed", "precondition-failed"],
            Outcome::InvariantViolated => &["failed", "invariant-violated"],
        }
    }
}

/// The words of all outcomes, as [`Outcome::word`] returns them.
pub const OUTCOME_WORDS: [&str; 7] =
    ["success", "failure", "cut", "skipped", "exited", "precondition failed", "invariant violated"];

/// Returns true for the word of each kind of failure; see [`Outcome::is_failure`].
pub fn is_failure_word(word: &str) -> bool {
    matches!(word, "failure" | "precondition failed" | "invariant violated")
}

/// Words for the final outcome of a task in conditions: `(failed ?s)`, `(state ?s = failed)`.
pub const OUTCOME_STATES: &[&str] =
    &["succeeded", "failed", "cut", "skipped", "exited", "precondition-failed", "invariant-violated"];

/// The words of [`OUTCOME_STATES`] that only a failure has.
pub const FAILURE_STATES: &[&str] = &["failed", "precondition-failed", "invariant-violated"];
