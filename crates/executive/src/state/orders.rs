//! The orders in which claimants take turns, and the groups of claimants with equal needs.

use crate::state::claim::QueuedClaim;
use crate::state::queue::Queue;
use crate::state::queue_place::{QueueKey, TurnOrder};
use crate::state::resource_id::ResourceId;
use crate::state::turns::{InTurn, Rest};
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Claimants in each order that may count.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Orders {
    /// Claimants whose place depends on themselves alone.
    pub(super) plain: Queue,
    /// Claimants with ranks, ordered without their ranks.
    pub(super) level: Queue,
    /// By parent: the claimants with a rank below it, in the order of their ranks.
    pub(super) below: BTreeMap<TaskId, BTreeSet<QueueKey>>,
}

impl Orders {
    pub(super) fn enter(&mut self, claim: &QueuedClaim) {
        claim.place.iter().for_each(|place| self.plain.enter(place));
        claim.level.iter().for_each(|place| self.level.enter(place));
        for (key, rank) in claim.by_rank.iter().filter_map(|key| Some((key, key.rank?))) {
            self.below.entry(rank.parent).or_default().insert(*key);
        }
    }

    pub(super) fn leave(&mut self, claim: &QueuedClaim) {
        claim.place.iter().for_each(|place| self.plain.leave(place));
        claim.level.iter().for_each(|place| self.level.leave(place));
        for (key, rank) in claim.by_rank.iter().filter_map(|key| Some((key, key.rank?))) {
            let Some(keys) = self.below.get_mut(&rank.parent) else { continue };
            keys.remove(key);
            if keys.is_empty() {
                self.below.remove(&rank.parent);
            }
        }
    }

    pub(super) fn settle(&mut self, now: Time) {
        self.plain.settle(now);
        self.level.settle(now);
    }

    /// Returns the claimants in the order of their turns.
    pub(super) fn in_turn<F: Fn(f64, Time) -> f64>(&self, order: TurnOrder, now: Time, risen_to: F) -> InTurn<'_, F> {
        match order {
            TurnOrder::Plain => self.plain.in_turn(now, risen_to),
            TurnOrder::Level(_) => self.level.in_turn(now, risen_to),
            TurnOrder::Below(parent) => {
                let keys = self.below.get(&parent).into_iter().map(Rest::steady);
                InTurn::new(keys.collect(), false, risen_to, now)
            }
        }
    }
}

/// The needs of a claimant: other resources with their amounts, and the amount of this one, as bit patterns.
pub(super) type Signature = (Vec<(ResourceId, u64)>, u64);

/// Claimants that need the same resources for nearly as long.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Group {
    pub(super) orders: Orders,
    /// The number of claimants with each expected duration.
    pub(super) spans: BTreeMap<Option<Duration>, usize>,
}

impl Group {
    /// Returns the shortest expected duration in the group; `None` if none is stated.
    pub fn shortest(&self) -> Option<Duration> {
        self.spans.keys().flatten().next().copied()
    }

    /// Returns its claimants in the order of their turns.
    pub fn in_turn<F: Fn(f64, Time) -> f64>(&self, order: TurnOrder, now: Time, risen_to: F) -> InTurn<'_, F> {
        self.orders.in_turn(order, now, risen_to)
    }
}

/// Returns the class of a duration: durations of one class differ by at most a fourth.
pub(super) fn class_of(expected: Option<Duration>) -> u16 {
    const UNKNOWN: u16 = u16::MAX;
    let Some(expected) = expected else { return UNKNOWN };
    let nanoseconds = expected.0.max(1).unsigned_abs();
    let octave = nanoseconds.ilog2();
    let fourth = if octave < 2 { 0 } else { (nanoseconds >> (octave - 2)) & 3 };
    (octave * 4) as u16 + fourth as u16
}
