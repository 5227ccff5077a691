//! Who waits for a resource: all claimants, and those of them that can stand in queue.
//!
//! A claimant stands in queue when its place among the others follows from itself alone: it wants just this resource,
//! all of it, and its priority changes with nothing but variables. The first in queue then decides for all behind it.
//! Others stand apart: where there is one of them, everybody must be looked at.

use apex_model::task::TaskId;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

/// A place in a queue. The first is the greatest priority, then who has begun, then the written order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct QueueKey {
    /// Priority at the time of the claim.
    pub priority: f64,
    /// It has begun, and was interrupted.
    pub begun: bool,
    /// Parent, step and number.
    pub order: (TaskId, u32, TaskId),
}

impl Eq for QueueKey {}

impl PartialOrd for QueueKey {
    fn partial_cmp(&self, other: &QueueKey) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for QueueKey {
    fn cmp(&self, other: &QueueKey) -> Ordering {
        let by_priority = other.priority.total_cmp(&self.priority);
        by_priority.then(other.begun.cmp(&self.begun)).then(self.order.cmp(&other.order))
    }
}

impl QueueKey {
    /// Who stands here.
    pub fn task(&self) -> TaskId {
        self.order.2
    }
}

/// How a claimant waits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Claim {
    /// At this turn.
    Queued {
        /// Where.
        turn: QueueKey,
        /// Its priority reads variables: its turn must be looked at again when one of them changes.
        varies: bool,
    },
    /// Not in queue.
    Apart,
}

/// Enabled and interrupted tasks that claim a resource.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Waiting {
    claims: BTreeMap<TaskId, Claim>,
    queue: BTreeSet<QueueKey>,
    apart: usize,
    varying: usize,
}

impl Waiting {
    /// Adds the task, or changes how it waits.
    pub fn insert(&mut self, task: TaskId, claim: Claim) {
        self.remove(task);
        match claim {
            Claim::Queued { turn, varies } => {
                self.queue.insert(turn);
                self.varying += usize::from(varies);
            }
            Claim::Apart => self.apart += 1,
        }
        self.claims.insert(task, claim);
    }

    /// Takes the task out. False if it did not wait.
    pub fn remove(&mut self, task: TaskId) -> bool {
        let Some(claim) = self.claims.remove(&task) else { return false };
        match claim {
            Claim::Queued { turn, varies } => {
                self.queue.remove(&turn);
                self.varying -= usize::from(varies);
            }
            Claim::Apart => self.apart -= 1,
        }
        true
    }

    /// Does the task wait?
    pub fn contains(&self, task: TaskId) -> bool {
        self.claims.contains_key(&task)
    }

    /// True when nobody waits.
    pub fn is_empty(&self) -> bool {
        self.claims.is_empty()
    }

    /// All who wait, in order of creation.
    pub fn tasks(&self) -> impl Iterator<Item = TaskId> + '_ {
        self.claims.keys().copied()
    }

    /// Those in queue, the first first.
    pub fn queue(&self) -> impl Iterator<Item = &QueueKey> {
        self.queue.iter()
    }

    /// Do all who wait stand in queue?
    pub fn all_in_line(&self) -> bool {
        self.apart == 0
    }

    /// May a change of a variable, or of what is measured, change who is first?
    pub fn is_sensitive(&self) -> bool {
        self.apart > 0 || self.varying > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(task: u64, priority: f64, begun: bool) -> QueueKey {
        QueueKey { priority, begun, order: (TaskId(0), 0, TaskId(task)) }
    }

    #[test]
    fn the_line_is_in_order_and_counts_are_kept() {
        let mut waiting = Waiting::default();
        for (task, priority, begun) in [(1, 1.0, false), (2, 3.0, false), (3, 3.0, true), (4, 3.0, false)] {
            waiting.insert(TaskId(task), Claim::Queued { turn: turn(task, priority, begun), varies: task == 1 });
        }
        waiting.insert(TaskId(9), Claim::Apart);
        let queue = |waiting: &Waiting| waiting.queue().map(|each| each.task().0).collect::<Vec<_>>();
        assert_eq!(queue(&waiting), [3, 2, 4, 1]);
        assert!(waiting.is_sensitive() && !waiting.all_in_line());
        waiting.insert(TaskId(1), Claim::Queued { turn: turn(1, 5.0, false), varies: false });
        assert!(waiting.remove(TaskId(9)) && !waiting.remove(TaskId(9)));
        assert_eq!(queue(&waiting), [1, 3, 2, 4]);
        assert!(!waiting.is_sensitive() && waiting.all_in_line());
    }
}
