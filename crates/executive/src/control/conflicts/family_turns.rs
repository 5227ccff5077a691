//! Turns of ranked families (TC)
//! What: lists the claimants of ranked families by their own priorities, and determines which begun work precedes its equals.
//! Runs: contend phase, for `families`.  Reads: ResourceTable, priorities, ranks.  Writes: nothing.
//! Bound: O(log c) for a turn of c claimants, and O(m) for begun work, with m claimants of one family.
//! PDL: `rank`, `priority`, section 9, conflict; decision 0204.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::competition::is_eligible;
use crate::control::conflicts::queues::risen_to;
use crate::control::cycle::Cycle;
use crate::state::queue_place::{QueueKey, RankAmong};
use crate::state::turns::TurnSource;
use crate::state::waiting::Waiting;
use apex_model::task::TaskId;
use std::collections::BTreeSet;

/// Claimants by their own priorities, the greatest first.
pub(super) struct OwnTurns<'a, 'c> {
    cycle: &'a Cycle<'c>,
    waiting: &'a Waiting,
    turns: Box<dyn TurnSource + 'a>,
    head: Option<QueueKey>,
    /// Claimants that have begun and do not precede their equals, at the places that they have instead.
    held_back: BTreeSet<QueueKey>,
}

impl<'a, 'c> OwnTurns<'a, 'c> {
    pub(super) fn of(cycle: &'a Cycle<'c>, waiting: &'a Waiting) -> OwnTurns<'a, 'c> {
        let turns = Box::new(waiting.by_own_priority(cycle.now, risen_to(cycle)));
        OwnTurns { cycle, waiting, turns, head: None, held_back: BTreeSet::new() }
    }

    /// Returns the next claimant.
    pub(super) fn head(&mut self) -> Option<QueueKey> {
        while self.head.is_none() {
            let Some(next) = self.turns.next() else { break };
            let place = effective(self.cycle, self.waiting, next);
            if place == next {
                self.head = Some(next);
            } else {
                self.held_back.insert(place);
            }
        }
        self.head.into_iter().chain(self.held_back.first().copied()).min()
    }

    /// Takes the next claimant.
    pub(super) fn take(&mut self) -> Option<QueueKey> {
        let next = self.head()?;
        if self.head == Some(next) {
            self.head = None;
        } else {
            self.held_back.remove(&next);
        }
        Some(next)
    }

    /// Returns the claimants that can be the next one at a later time: the first of each kind of priority, without the tasks that hold
    /// what they need.
    pub(super) fn heads(&mut self, holders: &BTreeSet<TaskId>) -> Vec<TaskId> {
        let agent = &*self.cycle.agent;
        let heads = self.turns.heads_that(&|task| is_eligible(agent, task) && !holders.contains(&task));
        let all = heads.iter().chain(&self.head).chain(&self.held_back);
        all.map(QueueKey::task).collect()
    }
}

/// Returns the places of a claimant: by its own priority now, and in its family.
pub(super) fn places(cycle: &Cycle<'_>, waiting: &Waiting, task: TaskId) -> Option<(QueueKey, QueueKey)> {
    let (worth, own) = waiting.family_places(task, risen_to(cycle))?;
    Some((effective(cycle, waiting, worth), own))
}

/// Returns the place of a claimant by its own priority, where begun work that is held back counts as not begun.
fn effective(cycle: &Cycle<'_>, waiting: &Waiting, worth: QueueKey) -> QueueKey {
    let rank = waiting.rank_of(worth.task()).filter(|_| worth.begun);
    QueueKey { begun: worth.begun && !rank.is_some_and(|rank| is_held_back(cycle, waiting, rank)), ..worth }
}

/// Returns true if a claimant that has not begun precedes tasks with this rank: it takes from them the advantage of begun work.
pub(super) fn is_held_back(cycle: &Cycle<'_>, waiting: &Waiting, rank: RankAmong) -> bool {
    let mut before = waiting.below(rank.parent).take_while(|key| is_lower(key, rank.rank));
    before.any(|key| !key.begun && is_eligible(cycle.agent, key.task()))
}

pub(super) fn is_lower(key: &QueueKey, rank: f64) -> bool {
    key.rank.is_some_and(|own| own.rank < rank)
}

pub(super) fn is_greater(key: &QueueKey, rank: f64) -> bool {
    key.rank.is_some_and(|own| own.rank > rank)
}
