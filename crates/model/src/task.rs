//! Names, states and outcomes of tasks (paper, section III). The executive's `state::task` holds the tasks themselves.

use crate::value::Value;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Numbers a task; from a counter of the agent, never reused.
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
    /// The state's word in PDL and in traces.
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
    /// Not; the decision's cause says why.
    Failure,
    /// Its parent ended first, or another task terminated it.
    Cut,
}
