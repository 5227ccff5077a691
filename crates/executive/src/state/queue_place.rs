//! Places in the queues of a resource, and their order.

use apex_model::task::TaskId;
use apex_model::time::Time;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// Last repetition, parent, step and number. A repeated task comes after one that was not repeated, or was repeated earlier; otherwise
/// written order counts among siblings, and creation order among others.
pub type FamilyOrder = (Time, TaskId, u32, TaskId);

/// A rank that counts among the tasks below one parent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RankAmong {
    /// The parent of the ranked steps.
    pub parent: TaskId,
    /// The rank.
    pub rank: f64,
}

/// A place in a queue. The order is: greater priority, lower rank, greater priority among equal ranks, begun tasks first, family order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct QueueKey {
    /// Priority at the time of the claim; for a rising priority, its present value.
    pub priority: f64,
    /// Its rank, if a rank counts.
    pub rank: Option<RankAmong>,
    /// Its priority among claimants of the same rank, in orders where ranks precede priorities.
    #[serde(default)]
    pub within: f64,
    /// True if the task has begun and was interrupted.
    pub begun: bool,
    /// Last repetition, parent, step and number.
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
        let by_priority = by_priority.then(other.within.total_cmp(&self.within));
        by_priority.then(other.begun.cmp(&self.begun)).then(self.order.cmp(&other.order))
    }
}

impl QueueKey {
    /// Returns the claimant at this place.
    pub fn task(&self) -> TaskId {
        self.order.3
    }
}

/// The order that counts among all claimants of a resource.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TurnOrder {
    /// By priorities, and by ranks among equals.
    Plain,
    /// All claimants have this rank and no lower one: by priorities alone.
    Level(RankAmong),
    /// By ranks below this task, and by priorities among equals.
    Below(TaskId),
}

/// A place among claimants of one importance whose priorities rise with their urgency: the earliest due is first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RisingKey {
    /// From 0 to 10.
    pub importance: f64,
    /// Instant of its greatest urgency.
    pub due: Time,
    /// True if the task has begun and was interrupted.
    pub begun: bool,
    /// Last repetition, parent, step and number.
    pub order: FamilyOrder,
}

/// Position of a claimant in a queue: the first of its places there, which is that of its greatest priority now.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct QueuePlace {
    /// The place that does not change with time; `None` if all its priorities rise.
    pub steady: Option<QueueKey>,
    /// Places that rise.
    pub rising: Vec<RisingKey>,
}

impl QueuePlace {
    /// Returns the place now; `risen_to` computes a priority from importance and due instant.
    pub fn now(&self, risen_to: impl Fn(f64, Time) -> f64) -> Option<QueueKey> {
        let risen = self.rising.iter().map(|key| key.risen(risen_to(key.importance, key.due)));
        self.steady.into_iter().chain(risen).min()
    }

    /// Returns false if time alone never brings this place before the other: each of its priorities rises behind one of the other.
    pub fn may_overtake(&self, other: &QueuePlace) -> bool {
        let behind =
            |own: &RisingKey| other.rising.iter().any(|each| own.importance <= each.importance && own.due >= each.due);
        !self.rising.iter().all(behind)
    }

    /// Returns the number of places.
    pub(super) fn len(&self) -> usize {
        self.rising.len() + usize::from(self.steady.is_some())
    }
}

impl RisingKey {
    /// Returns the place with this priority.
    fn risen(&self, priority: f64) -> QueueKey {
        QueueKey { priority, rank: None, within: 0.0, begun: self.begun, order: self.order }
    }
}

/// Begun claimants first, then in order.
pub(super) type Among = (bool, FamilyOrder);
