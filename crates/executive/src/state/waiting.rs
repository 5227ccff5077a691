//! Claimants of one resource: all of them, and queues of those whose place depends on themselves alone.
//!
//! A claimant is in a queue if its place among the others changes only with variables, or rises with its urgency in a way that never
//! changes the order of its equals. The first claimants then decide for all behind them. Other claimants are apart: if there is one, all
//! claimants are compared, unless ranks alone order all of them.

use crate::state::claim::{Claim, QueuedClaim};
use crate::state::orders::{Group, Orders, Signature, class_of};
use crate::state::queue_place::{QueueKey, QueuePlace, RankAmong, TurnOrder};
use crate::state::resource_id::ResourceId;
use crate::state::turns::InTurn;
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Greatest number of groups of one resource that are searched linearly.
const GROUPS_MAX: usize = 32;

/// Enabled and interrupted tasks that claim a resource.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Waiting {
    claims: BTreeMap<TaskId, Claim>,
    all: Orders,
    /// By the needs of the claimants, and the class of their expected durations.
    groups: BTreeMap<Signature, BTreeMap<u16, Group>>,
    /// By parent: the number of claimants with a rank below it, and the priority of the one added last.
    ranked: BTreeMap<TaskId, (usize, f64)>,
    /// By parent: ranks of claimants below it.
    ranks: BTreeMap<TaskId, Ranks>,
    /// Claimants whose place depends on variables or on more.
    sensitive: BTreeSet<TaskId>,
    /// Number of claimants without a place.
    apart: usize,
    /// Number of claimants that have one rank, and a priority that stays or rises with urgency.
    #[serde(default)]
    members: usize,
}

/// Ranks of claimants below one parent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Ranks {
    /// Number of claimants of each rank, by its bits.
    counts: BTreeMap<u64, usize>,
    /// Number of claimants for which it is the lowest rank.
    lowest: usize,
    /// Number of claimants without a constant place among others of the same rank.
    unsteady: usize,
}

impl Waiting {
    /// Adds the claim of the task, or replaces it.
    pub fn insert(&mut self, task: TaskId, claim: Claim) {
        self.remove(task);
        self.members += usize::from(claim.is_of_family());
        match &claim {
            Claim::Queued(claim) => {
                self.apart += usize::from(claim.place.is_none());
                if claim.varies {
                    self.sensitive.insert(task);
                }
                self.count_ranks(claim);
                self.all.enter(claim);
                let group =
                    self.groups.entry(claim.signature()).or_default().entry(class_of(claim.expected)).or_default();
                group.orders.enter(claim);
                *group.spans.entry(claim.expected).or_default() += 1;
            }
            Claim::Apart => {
                self.apart += 1;
                self.sensitive.insert(task);
            }
        }
        self.claims.insert(task, claim);
    }

    /// Removes the task. Returns false if it did not wait.
    pub fn remove(&mut self, task: TaskId) -> bool {
        let Some(claim) = self.claims.remove(&task) else { return false };
        self.sensitive.remove(&task);
        self.members = self.members.saturating_sub(usize::from(claim.is_of_family()));
        match claim {
            Claim::Queued(claim) => {
                self.apart -= usize::from(claim.place.is_none());
                self.discount_ranks(&claim);
                self.all.leave(&claim);
                self.leave_group(&claim);
            }
            Claim::Apart => self.apart -= 1,
        }
        true
    }

    fn leave_group(&mut self, claim: &QueuedClaim) {
        let (signature, class) = (claim.signature(), class_of(claim.expected));
        let Some(classes) = self.groups.get_mut(&signature) else { return };
        if let Some(group) = classes.get_mut(&class) {
            group.orders.leave(claim);
            count_down(&mut group.spans, &claim.expected);
            if group.spans.is_empty() {
                classes.remove(&class);
            }
        }
        if classes.is_empty() {
            self.groups.remove(&signature);
        }
    }

    fn count_ranks(&mut self, claim: &QueuedClaim) {
        if let Some((rank, priority)) = rank_in_queue(claim) {
            let group = self.ranked.entry(rank.parent).or_default();
            *group = (group.0 + 1, priority);
        }
        for (index, (key, rank)) in claim.by_rank.iter().filter_map(|key| Some((key, key.rank?))).enumerate() {
            let ranks = self.ranks.entry(rank.parent).or_default();
            *ranks.counts.entry(bits_of(rank.rank)).or_default() += 1;
            ranks.lowest += usize::from(index == 0);
            ranks.unsteady += usize::from(!claim.is_steady_within(key));
        }
    }

    fn discount_ranks(&mut self, claim: &QueuedClaim) {
        if let Some((rank, _)) = rank_in_queue(claim)
            && let Some(group) = self.ranked.get_mut(&rank.parent)
        {
            group.0 -= 1;
            if group.0 == 0 {
                self.ranked.remove(&rank.parent);
            }
        }
        for (index, (key, rank)) in claim.by_rank.iter().filter_map(|key| Some((key, key.rank?))).enumerate() {
            let Some(ranks) = self.ranks.get_mut(&rank.parent) else { continue };
            count_down(&mut ranks.counts, &bits_of(rank.rank));
            ranks.lowest -= usize::from(index == 0);
            ranks.unsteady -= usize::from(!claim.is_steady_within(key));
            if ranks.counts.is_empty() {
                self.ranks.remove(&rank.parent);
            }
        }
    }

    /// Notes which claimants have reached the greatest urgency.
    pub fn settle(&mut self, now: Time) {
        self.all.settle(now);
        if self.has_rising() && self.groups.len() <= GROUPS_MAX {
            self.groups.values_mut().flat_map(BTreeMap::values_mut).for_each(|group| group.orders.settle(now));
        }
    }

    /// Returns true if the task waits.
    pub fn contains(&self, task: TaskId) -> bool {
        self.claims.contains_key(&task)
    }

    /// Returns true if no task waits.
    pub fn is_empty(&self) -> bool {
        self.claims.is_empty()
    }

    /// Returns the number of tasks that wait.
    pub fn len(&self) -> usize {
        self.claims.len()
    }

    /// Returns all tasks that wait, in order of creation.
    pub fn tasks(&self) -> impl Iterator<Item = TaskId> + '_ {
        self.claims.keys().copied()
    }

    /// Returns the tasks whose place may change with a variable or a measurement.
    pub fn sensitive(&self) -> impl Iterator<Item = TaskId> + '_ {
        self.sensitive.iter().copied()
    }

    /// Returns the order that counts among all claimants; `None` if all must be compared.
    pub fn order(&self) -> Option<TurnOrder> {
        if self.apart == 0 {
            return Some(TurnOrder::Plain);
        }
        self.level().map(TurnOrder::Level).or_else(|| self.parent_of_ranks().map(TurnOrder::Below))
    }

    /// Returns the rank of all claimants, if it is the same and the lowest one of each.
    fn level(&self) -> Option<RankAmong> {
        let Claim::Queued(first) = self.claims.first_key_value()?.1 else { return None };
        let rank = first.by_rank.first()?.rank?;
        let ranks = self.ranks.get(&rank.parent)?;
        let all = ranks.counts.len() == 1 && ranks.lowest == self.claims.len();
        (all && self.all.level.len() == self.claims.len()).then_some(rank)
    }

    /// Returns the highest parent below which ranks order all claimants: only the rank counts between different ranks, and only constant
    /// priorities between equal ones.
    pub fn parent_of_ranks(&self) -> Option<TaskId> {
        // A parent that is above all claimants is above the first. The highest is tried first: it is the same for most resources.
        let Claim::Queued(first) = self.claims.first_key_value()?.1 else { return None };
        let count = self.claims.len();
        let mut parents = first.by_rank.iter().rev().filter_map(|key| Some(key.rank?.parent));
        parents.find(|parent| {
            let all = self.all.below.get(parent).is_some_and(|keys| keys.len() == count);
            all && self.ranks.get(parent).is_some_and(|ranks| ranks.counts.len() == count || ranks.unsteady == 0)
        })
    }

    /// Returns true if several claimants have the same rank below the parent.
    pub fn has_equal_ranks(&self, parent: TaskId) -> bool {
        self.ranks.get(&parent).is_some_and(|ranks| ranks.counts.len() < self.claims.len())
    }

    /// Returns true if claimants of this rank need only be compared with the holder: no claimant has the rank, or constant priorities
    /// order all that have it.
    pub fn admits_rank(&self, rank: RankAmong) -> bool {
        self.ranks.get(&rank.parent).is_none_or(|ranks| ranks.unsteady == 0) || !self.has_rank(rank)
    }

    /// True if a claimant has this rank below the parent.
    pub fn has_rank(&self, rank: RankAmong) -> bool {
        self.ranks.get(&rank.parent).is_some_and(|ranks| ranks.counts.contains_key(&bits_of(rank.rank)))
    }

    /// Returns the parent below which ranks are the order of the queue, so that priorities do not count between different ranks.
    pub fn ordered_below(&self) -> Option<TaskId> {
        match self.order()? {
            TurnOrder::Below(parent) => Some(parent),
            TurnOrder::Plain | TurnOrder::Level(_) => None,
        }
    }

    /// Returns true if time, or a change of a variable or measurement, may change the order.
    pub fn is_sensitive(&self) -> bool {
        !self.sensitive.is_empty() || self.has_rising()
    }

    /// Returns true if the priority of a queued claimant rises.
    pub fn has_rising(&self) -> bool {
        self.all.plain.has_rising() || self.all.level.has_rising()
    }

    /// Returns the shortest expected duration of queued claimants that need at most the free capacity; `None` if none is stated.
    pub fn shortest(&self, room: f64) -> Option<Duration> {
        let fits = |signature: &Signature| f64::from_bits(signature.1) <= room;
        let groups = self.groups.iter().filter(|(signature, _)| fits(signature));
        groups.flat_map(|(_, classes)| classes.values()).filter_map(Group::shortest).min()
    }

    /// Returns the groups of claimants: their needs of other resources, and of this one.
    pub fn groups(&self) -> impl Iterator<Item = (&[(ResourceId, u64)], f64, &Group)> {
        self.groups.iter().flat_map(|((others, amount), classes)| {
            classes.values().map(move |group| (others.as_slice(), f64::from_bits(*amount), group))
        })
    }

    /// Returns true if the claimants have so many different needs that grouping them is useless.
    pub fn has_many_groups(&self) -> bool {
        self.groups.len() > GROUPS_MAX
    }

    /// The joint needs of claimants, in addition to this resource.
    pub fn together(&self) -> impl Iterator<Item = &[(ResourceId, u64)]> {
        self.groups.keys().map(|(others, _)| others.as_slice())
    }

    /// Returns the resources that queued claimants need in addition to this one.
    pub fn others(&self) -> impl Iterator<Item = ResourceId> + '_ {
        self.together().flatten().map(|(other, _)| *other)
    }

    /// Returns true if each claimant has one rank, and a priority that stays or rises with urgency.
    pub fn are_families(&self) -> bool {
        self.members == self.claims.len() && self.members > 0
    }

    /// Returns the claimants of ranked families in the order of their present priorities without ranks.
    pub fn by_own_priority<F: Fn(f64, Time) -> f64>(&self, now: Time, risen_to: F) -> InTurn<'_, F> {
        self.all.level.in_turn(now, risen_to)
    }

    /// Returns true if the places in queues do not tell the order of claimants with equal ranks below the parent: a priority rises, or
    /// one of them has begun.
    pub fn has_open_ties(&self, parent: TaskId) -> bool {
        let Some((ranks, keys)) = self.ranks.get(&parent).zip(self.all.below.get(&parent)) else { return false };
        ranks.counts.len() < keys.len() && self.changes_below(parent)
    }

    /// Returns true if a claimant with a rank below the parent has begun, or has a priority that rises.
    pub fn changes_below(&self, parent: TaskId) -> bool {
        self.ranks.get(&parent).is_some_and(|ranks| ranks.unsteady > 0) || self.below(parent).any(|key| key.begun)
    }

    /// Returns the claimants with a rank below the parent, in the order of their ranks.
    pub fn below(&self, parent: TaskId) -> impl Iterator<Item = QueueKey> + '_ {
        self.all.below.get(&parent).into_iter().flatten().copied()
    }

    /// Returns the places of a claimant of a ranked family: by its own priority now, and by its rank.
    pub fn family_places(&self, task: TaskId, risen_to: impl Fn(f64, Time) -> f64) -> Option<(QueueKey, QueueKey)> {
        let Claim::Queued(claim) = self.claims.get(&task)? else { return None };
        Some((claim.level.as_ref()?.now(risen_to)?, *claim.by_rank.first()?))
    }

    /// Returns the lowest rank of a claimant.
    pub fn rank_of(&self, task: TaskId) -> Option<RankAmong> {
        let Claim::Queued(claim) = self.claims.get(&task)? else { return None };
        claim.by_rank.first()?.rank
    }

    /// Returns the needed amount of a claimant.
    pub fn amount_of(&self, task: TaskId) -> f64 {
        match self.claims.get(&task) {
            Some(Claim::Queued(claim)) => claim.amount,
            _ => 0.0,
        }
    }

    /// Returns the priority of those that have ranks; `None` if no rank counts.
    ///
    /// # Errors
    /// If the queues do not determine the order of ranks and priorities: ranks below several parents, or claimants without rank that have
    /// the same priority.
    pub fn priority_of_ranked(&self) -> Result<Option<f64>, OrderUnknown> {
        match self.order() {
            None => return Err(OrderUnknown),
            Some(TurnOrder::Below(_)) => return Ok(Some(0.0)),
            Some(TurnOrder::Level(_)) => return Ok(None),
            Some(TurnOrder::Plain) => {}
        }
        let mut groups = self.ranked.values();
        let Some((_, priority)) = groups.next().copied() else { return Ok(None) };
        let unknown = groups.next().is_some() || self.has_unranked_at(priority) || self.all.plain.has_rising();
        if unknown { Err(OrderUnknown) } else { Ok(Some(priority)) }
    }

    fn has_unranked_at(&self, priority: f64) -> bool {
        let order = (Time::BEGINNING, TaskId(0), 0, TaskId(0));
        let first = QueueKey { priority, rank: None, within: f64::INFINITY, begun: true, order };
        self.all.plain.first_from(first).is_some_and(|key| key.rank.is_none() && key.priority == priority)
    }

    /// Returns true if the place of one more claimant determines which tasks precede it.
    pub fn takes_in(&self, key: &QueueKey) -> bool {
        if self.apart > 0 {
            return false;
        }
        let alike = |(parent, group): (&TaskId, &(usize, f64))| {
            key.rank.is_some_and(|rank| rank.parent == *parent) == (group.1 == key.priority)
        };
        self.ranked.iter().all(alike)
            && (key.rank.is_none() || !self.has_unranked_at(key.priority) && !self.all.plain.has_rising())
    }

    /// The place of the task in this order; `risen_to` computes a priority from importance and due instant.
    pub fn key_of(&self, task: TaskId, order: TurnOrder, risen_to: impl Fn(f64, Time) -> f64) -> Option<QueueKey> {
        let Claim::Queued(claim) = self.claims.get(&task)? else { return None };
        claim.key_in(order, risen_to)
    }

    /// Returns the places of the task by its priorities, in an order where these count.
    pub fn place_of(&self, task: TaskId, order: TurnOrder) -> Option<&QueuePlace> {
        let Claim::Queued(claim) = self.claims.get(&task)? else { return None };
        match order {
            TurnOrder::Plain => claim.place.as_ref(),
            TurnOrder::Level(_) | TurnOrder::Below(_) => claim.level.as_ref(),
        }
    }

    /// Returns the queued claimants in the order of their turns; `risen_to` computes a priority from importance and due instant.
    pub fn in_turn<F: Fn(f64, Time) -> f64>(&self, now: Time, risen_to: F) -> InTurn<'_, F> {
        self.all.in_turn(self.order().unwrap_or(TurnOrder::Plain), now, risen_to)
    }
}

/// The places in queues do not determine which claimant is the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OrderUnknown;

fn rank_in_queue(claim: &QueuedClaim) -> Option<(RankAmong, f64)> {
    let key = claim.place.as_ref()?.steady?;
    Some((key.rank?, key.priority))
}

/// Bits of a rank: equal ranks have equal bits.
fn bits_of(rank: f64) -> u64 {
    (rank + 0.0).to_bits()
}

fn count_down<K: Ord>(counts: &mut BTreeMap<K, usize>, key: &K) {
    if let Some(count) = counts.get_mut(key) {
        *count -= 1;
        if *count == 0 {
            counts.remove(key);
        }
    }
}

#[cfg(test)]
#[path = "waiting_tests.rs"]
mod tests;
