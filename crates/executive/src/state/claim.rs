//! The claim of a task on one resource: its places in queues, its needs, and its expected duration.

use crate::state::queue_place::{QueueKey, QueuePlace, TurnOrder};
use crate::state::resource_id::ResourceId;
use apex_model::time::{Duration, Time};
use serde::{Deserialize, Serialize};

/// Kind of wait of a claimant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Claim {
    /// In a queue.
    Queued(Box<QueuedClaim>),
    /// Not in a queue.
    Apart,
}

/// A claim in a queue.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct QueuedClaim {
    /// Position in the queue; `None` if the claimant must be compared with each of the others, unless ranks alone count.
    pub place: Option<QueuePlace>,
    /// Position among claimants that all have the lowest of its ranks.
    pub level: Option<QueuePlace>,
    /// True if its priority reads variables: its place must be computed again when one of them changes.
    pub varies: bool,
    /// Expected duration, if stated.
    pub expected: Option<Duration>,
    /// Needed amount of this resource.
    pub amount: f64,
    /// Other needed resources, with the bit patterns of the amounts.
    pub others: Vec<(ResourceId, u64)>,
    /// Its places among the tasks below each of its ranked ancestors, the lowest ancestor first.
    pub by_rank: Vec<QueueKey>,
}

impl Claim {
    /// Returns this claim for `resource`, of which the amount `needed` is required.
    pub fn of(mut self, resource: ResourceId, needed: f64) -> Claim {
        if let Claim::Queued(claim) = &mut self {
            claim.amount = needed;
            claim.others.retain(|(other, _)| *other != resource);
        }
        self
    }

    /// Returns true if the claimant has one rank, and its priority stays or rises with its urgency.
    pub(super) fn is_of_family(&self) -> bool {
        let Claim::Queued(claim) = self else { return false };
        claim.by_rank.len() == 1 && claim.level.is_some() && !claim.varies
    }
}

impl QueuedClaim {
    /// Returns true if its place among others of the same rank never changes.
    pub fn is_steady_within(&self, key: &QueueKey) -> bool {
        let lowest = self.by_rank.first() == Some(key);
        lowest && !self.varies && self.level.as_ref().is_some_and(|level| level.rising.is_empty())
    }

    /// Returns the needed resources in a form that can be compared.
    pub(super) fn signature(&self) -> (Vec<(ResourceId, u64)>, u64) {
        (self.others.clone(), self.amount.to_bits())
    }

    /// Returns its place in this order, if it has one; `risen_to` computes a priority from importance and due instant.
    pub fn key_in(&self, order: TurnOrder, risen_to: impl Fn(f64, Time) -> f64) -> Option<QueueKey> {
        match order {
            TurnOrder::Plain => self.place.as_ref()?.now(risen_to),
            TurnOrder::Level(_) => self.level.as_ref()?.now(risen_to),
            TurnOrder::Below(parent) => {
                self.by_rank.iter().find(|key| key.rank.is_some_and(|rank| rank.parent == parent)).copied()
            }
        }
    }
}
