//! Probing: goals that are pursued repeatedly while a task waits for a condition with `:probing` (active sensing).

use crate::state::clause::{Level, MonitorId};
use crate::state::wake::WakeKey;
use apex_model::expression::Template;
use apex_model::probing::ProbingEnd;
use apex_model::source::Place;
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};
use serde::{Deserialize, Serialize};

/// Identifies a probing: the monitor, and the index of the `:probing` among those of its condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ProbingId {
    /// The monitor of the whole condition.
    pub monitor: MonitorId,
    /// Counted in written order.
    pub part: u32,
}

/// A goal that is pursued as long as a task waits for a condition. At most one of its probes lives at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Probing {
    /// The task whose clause it serves.
    pub waiting: TaskId,
    /// Level of the clause: for a clause of the step the probes are children of the waiting task's parent, otherwise of the task itself.
    pub level: Level,
    /// The condition with the option.
    pub place: Place,
    /// The goal to pursue.
    pub goal: Template,
    /// Minimum time from the start of one probe to the start of the next.
    pub interval: Duration,
    /// Time after the start of the first probe in which probes may begin; `None`: unlimited.
    pub time_limit: Option<Duration>,
    /// Maximum number of probes; `None`: unlimited.
    pub count_limit: Option<u64>,
    /// Number of probes begun.
    pub begun: u64,
    /// Beginning of the first probe.
    pub first_at: Option<Time>,
    /// Beginning of the last probe.
    pub last_at: Option<Time>,
    /// The probe that runs now.
    pub running: Option<TaskId>,
    /// The wake for the next probe or for the end of the time limit.
    pub wake: Option<WakeKey>,
    /// Reason for which no further probe will begin; `None` while one may begin.
    pub end: Option<ProbingEnd>,
    /// True if the clause is no longer watched: this entry is removed when its last probe has ended.
    pub forgotten: bool,
}

impl Probing {
    /// Returns the earliest start of the next probe: `now` for the first one.
    pub fn next_at(&self, now: Time) -> Time {
        self.last_at.map_or(now, |last| last + self.interval)
    }

    /// Returns the end of the time limit; `None` before the first probe, and without a limit.
    pub fn deadline(&self) -> Option<Time> {
        Some(self.first_at? + self.time_limit?)
    }
}
