//! Places in the queues of a resource, and which of two comes first.

use apex_model::task::TaskId;
use apex_model::time::Time;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// Last repetition, parent, step and number: a repeated task comes behind one that was not or was earlier; else written order
/// among siblings, creation order among others.
pub type FamilyOrder = (Time, TaskId, u32, TaskId);

/// A rank that counts among the tasks below one parent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RankAmong {
    /// The parent of the ranked steps.
    pub parent: TaskId,
    /// The rank.
    pub rank: f64,
}

/// A place in a queue. The first is the greatest priority, then the lower rank, then the task that has begun, then the
/// written order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct QueueKey {
    /// Priority at the time of the claim; of one that rises, now.
    pub priority: f64,
    /// Its rank, if one counts.
    pub rank: Option<RankAmong>,
    /// It has begun, and was interrupted.
    pub begun: bool,
    /// Parent, step and number.
    pub order: FamilyOrder,
}

impl Eq for QueueKey {}

impl PartialOrd for QueueKey {
    fn partial_cmp(&self, other: &QueueKey) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for QueueKey {
    fn cmp(&self, other: &QueueKey) -> Ordering {
        let rank = match (self.rank, other.rank) {
            (Some(own), Some(others)) => own.parent.cmp(&others.parent).then(own.rank.total_cmp(&others.rank)),
            (own, others) => own.is_some().cmp(&others.is_some()),
        };
        let by_priority = other.priority.total_cmp(&self.priority).then(rank);
        by_priority.then(other.begun.cmp(&self.begun)).then(self.order.cmp(&other.order))
    }
}

impl QueueKey {
    /// Returns the claimant at this place.
    pub fn task(&self) -> TaskId {
        self.order.3
    }
}

/// A place among claimants of one importance whose priorities rise with their urgency: the earlier due is the first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RisingKey {
    /// From 0 to 10.
    pub importance: f64,
    /// Instant of its greatest urgency.
    pub due: Time,
    /// It has begun, and was interrupted.
    pub begun: bool,
    /// Parent, step and number.
    pub order: FamilyOrder,
}

/// Position of a claimant in a queue.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum QueuePlace {
    /// At a place that time does not change.
    Steady(QueueKey),
    /// At one that rises.
    Rising(RisingKey),
}

/// Begun claimants first, then in order.
pub(super) type Among = (bool, FamilyOrder);
