//! Monitors in their tasks: the clause and task of each monitor.

use crate::state::monitors::monitor::{Interest, Monitor};
use crate::state::wake::WakeKey;
use apex_model::task::TaskId;
use apex_model::value::Value;
use serde::{Deserialize, Serialize};

/// Number of a monitor, from a counter of the agent; never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct MonitorId(pub u64);

/// The clauses that hold a condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Clause {
    /// `waitfor`: the task is enabled.
    Waitfor,
    /// `end-when`, `(terminate (when C))`: the task ends.
    EndWhen,
    /// `restart-when`: the task starts over.
    RestartWhen,
    /// `suspend-when`: the task is suspended.
    SuspendWhen,
    /// The `until` of `suspend-when`: the suspension ends.
    SuspendUntil,
    /// `resume-when`: the suspension ends.
    ResumeWhen,
    /// `skip-when`: the task is not begun.
    SkipWhen,
    /// `exit-when`: the task ends without success or failure.
    ExitWhen,
}

impl Clause {
    /// Returns the clause's name in PDL.
    pub fn word(self) -> &'static str {
        match self {
            Clause::Waitfor => "waitfor",
            Clause::EndWhen => "end-when",
            Clause::RestartWhen => "restart-when",
            Clause::SuspendWhen => "suspend-when",
            Clause::SuspendUntil => "until",
            Clause::ResumeWhen => "resume-when",
            Clause::SkipWhen => "skip-when",
            Clause::ExitWhen => "exit-when",
        }
    }
}

/// Level of a clause, which determines the meaning of its variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Level {
    /// At the step: variables of the surrounding procedure.
    Step,
    /// At the procedure: variables of the task's own controller.
    Procedure,
}

/// A monitor with its place in a task. Small, because a hundred thousand may wait.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClauseMonitor {
    /// The task.
    pub task: TaskId,
    /// The clause.
    pub clause: Clause,
    /// Level of the clause.
    pub level: Level,
    /// The condition's state.
    pub monitor: Monitor,
    /// Key of the monitor in the agent's table of interests, if the monitor alone does not determine it.
    pub filing: Option<Box<Filing>>,
    /// The wake that the monitor requested.
    pub wake: Option<WakeKey>,
}

/// Key under which a monitor is filed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Filing {
    /// Its interests, sorted.
    pub interests: Vec<Interest>,
    /// The second word of the message that the monitor waits for, if known.
    pub second: Option<Value>,
}
