//! Wakes: the instants of scheduled events, so that nothing has to poll.

use crate::state::clause::MonitorId;
use apex_model::effect::{CommandId, QuestionId, SolveRequestId};
use apex_model::task::TaskId;
use apex_model::time::Time;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Kind of wake.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Wake {
    /// A primitive's duration ends.
    Duration(TaskId),
    /// A primitive's update forms run.
    Update(TaskId),
    /// A command without an answer has failed.
    CommandTimeout(CommandId),
    /// A monitor's verdict can change by time alone.
    Monitor(MonitorId),
    /// The next probe for the monitor's condition is due, or the time for probing is over.
    Probing(MonitorId),
    /// A repetition's least interval is over.
    MinimumInterval(TaskId),
    /// A rising priority overtakes another one.
    PriorityCrossing(TaskId),
    /// The operator's time is over.
    Question(QuestionId),
    /// A request to a solver without an answer has failed.
    SolveTimeout(SolveRequestId),
}

/// Identifies an entry of the queue, so that it can be cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct WakeKey {
    /// Instant.
    pub at: Time,
    /// Number of the entry among those of one instant, in order of creation.
    pub number: u64,
}

/// The queue of wakes, in order of time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WakeQueue {
    entries: BTreeMap<WakeKey, Wake>,
    next: u64,
}

impl WakeQueue {
    /// Schedules `wake` at `at`.
    pub fn schedule(&mut self, at: Time, wake: Wake) -> WakeKey {
        let key = WakeKey { at, number: self.next };
        self.next = self.next.saturating_add(1);
        self.entries.insert(key, wake);
        key
    }

    /// Cancels an entry; does nothing if the entry no longer exists.
    pub fn cancel(&mut self, key: WakeKey) {
        self.entries.remove(&key);
    }

    /// Returns the earliest entry.
    pub fn first(&self) -> Option<(WakeKey, Wake)> {
        self.entries.first_key_value().map(|(key, wake)| (*key, *wake))
    }

    /// Takes the earliest entry if it is due at `now`.
    pub fn take_due(&mut self, now: Time) -> Option<Wake> {
        let entry = self.entries.first_entry()?;
        (entry.key().at <= now).then(|| entry.remove())
    }

    /// Returns the number of entries.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Returns true if there are no entries.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }
}
