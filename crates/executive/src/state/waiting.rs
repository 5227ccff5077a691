//! Claimants of one resource: all of them, and queues of those whose place follows from themselves alone.
//!
//! A claimant is in a queue when its place among the others changes with nothing but variables, or rises with its
//! urgency in a way that never changes the order of its equals. The first ones then decide for all behind them.
//! Others stand apart: where there is one of them, all claimants are compared.

use crate::state::queue_place::{Among, FamilyOrder, QueueKey, QueuePlace, RankAmong};
use crate::state::resource_id::ResourceId;
use crate::state::turns::{InTurn, Rest};
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Urgency is greatest from this long before a task is due.
pub const GREATEST_URGENCY_BEFORE: Duration = Duration(500_000_000);

/// Kind of wait of a claimant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Claim {
    /// In a queue.
    Queued {
        /// Position in the queue; none where it must be compared with each of the others, unless ranks alone count.
        place: Option<QueuePlace>,
        /// Its priority reads variables: its place must be found again when one of them changes.
        varies: bool,
        /// Expected duration, if stated.
        expected: Option<Duration>,
        /// Amount that it needs of this resource.
        #[serde(default)]
        amount: f64,
        /// Other resources that it needs.
        others: Vec<ResourceId>,
        /// Its places among the tasks below each ranked task above it.
        #[serde(default)]
        by_rank: Vec<QueueKey>,
    },
    /// Not in a queue.
    Apart,
}

/// Claimants of one importance, whose priorities rise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct RisingLine {
    /// Those whose urgency was not the greatest at the last inspection, the earlier due first.
    rising: BTreeSet<(Time, bool, FamilyOrder)>,
    /// Those whose urgency is the greatest.
    risen: BTreeSet<Among>,
}

/// Enabled and interrupted tasks that claim a resource.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Waiting {
    claims: BTreeMap<TaskId, Claim>,
    steady: BTreeSet<QueueKey>,
    /// By the bits of the importance, which order as the importance does.
    lines: BTreeMap<u64, RisingLine>,
    /// By parent: how many of the claimants have a rank below it, and the priority of the one that came last.
    ranked: BTreeMap<TaskId, (usize, f64)>,
    /// By what claimants need together: how many of them need how much of this resource, for how long.
    together: BTreeMap<Vec<ResourceId>, Spans>,
    /// Those whose place depends on variables or on more.
    sensitive: BTreeSet<TaskId>,
    /// Number of those without a place.
    apart: usize,
    /// By parent: those with a rank below it, in the order of their ranks.
    #[serde(default)]
    siblings: BTreeMap<TaskId, Siblings>,
}

/// By the bits of the amount, which order as amounts do: how many claimants say that they take how long.
type Spans = BTreeMap<u64, BTreeMap<Option<Duration>, usize>>;

impl Claim {
    /// Returns the claim on one of several resources.
    pub fn of_amount(mut self, needed: f64) -> Claim {
        if let Claim::Queued { amount, .. } = &mut self {
            *amount = needed;
        }
        self
    }
}

/// Claimants with ranks below one parent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Siblings {
    keys: BTreeSet<QueueKey>,
    /// Number of claimants of each rank, by its bits.
    ranks: BTreeMap<u64, usize>,
}

impl Waiting {
    /// Adds the task, or changes how it waits.
    pub fn insert(&mut self, task: TaskId, claim: Claim) {
        self.remove(task);
        match &claim {
            Claim::Queued { place, varies, expected, amount, others, by_rank } => {
                match place {
                    Some(place) => self.enter(place),
                    None => self.apart += 1,
                }
                if *varies {
                    self.sensitive.insert(task);
                }
                for (parent, bits, key) in by_rank.iter().filter_map(sibling) {
                    let siblings = self.siblings.entry(parent).or_default();
                    siblings.keys.insert(key);
                    *siblings.ranks.entry(bits).or_default() += 1;
                }
                let spans = self.together.entry(others.clone()).or_default().entry(amount.to_bits()).or_default();
                *spans.entry(*expected).or_default() += 1;
            }
            Claim::Apart => {
                self.apart += 1;
                self.sensitive.insert(task);
            }
        }
        self.claims.insert(task, claim);
    }

    /// Takes the task out. False if it did not wait.
    pub fn remove(&mut self, task: TaskId) -> bool {
        let Some(claim) = self.claims.remove(&task) else { return false };
        self.sensitive.remove(&task);
        match claim {
            Claim::Queued { place, expected, amount, others, by_rank, .. } => {
                match &place {
                    Some(place) => self.leave(place),
                    None => self.apart -= 1,
                }
                for (parent, bits, key) in by_rank.iter().filter_map(sibling) {
                    let Some(siblings) = self.siblings.get_mut(&parent) else { continue };
                    siblings.keys.remove(&key);
                    count_down(&mut siblings.ranks, &bits);
                    if siblings.keys.is_empty() {
                        self.siblings.remove(&parent);
                    }
                }
                self.part(&others, amount, expected);
            }
            Claim::Apart => self.apart -= 1,
        }
        true
    }

    fn part(&mut self, others: &Vec<ResourceId>, amount: f64, expected: Option<Duration>) {
        let Some(amounts) = self.together.get_mut(others) else { return };
        if let Some(spans) = amounts.get_mut(&amount.to_bits()) {
            count_down(spans, &expected);
            if spans.is_empty() {
                amounts.remove(&amount.to_bits());
            }
        }
        if amounts.is_empty() {
            self.together.remove(others);
        }
    }

    fn enter(&mut self, place: &QueuePlace) {
        match place {
            QueuePlace::Steady(key) => {
                if let Some(rank) = key.rank {
                    let group = self.ranked.entry(rank.parent).or_default();
                    *group = (group.0 + 1, key.priority);
                }
                self.steady.insert(*key);
            }
            QueuePlace::Rising(key) => {
                let line = self.lines.entry(key.importance.to_bits()).or_default();
                line.rising.insert((key.due, !key.begun, key.order));
            }
        }
    }

    fn leave(&mut self, place: &QueuePlace) {
        match place {
            QueuePlace::Steady(key) => {
                self.steady.remove(key);
                let Some(parent) = key.rank.map(|rank| rank.parent) else { return };
                if let Some(group) = self.ranked.get_mut(&parent) {
                    group.0 -= 1;
                    if group.0 == 0 {
                        self.ranked.remove(&parent);
                    }
                }
            }
            QueuePlace::Rising(key) => {
                let bits = key.importance.to_bits();
                let Some(line) = self.lines.get_mut(&bits) else { return };
                if !line.rising.remove(&(key.due, !key.begun, key.order)) {
                    line.risen.remove(&(!key.begun, key.order));
                }
                if line.rising.is_empty() && line.risen.is_empty() {
                    self.lines.remove(&bits);
                }
            }
        }
    }

    /// Notes which claimants have reached the greatest urgency.
    pub fn settle(&mut self, now: Time) {
        for line in self.lines.values_mut() {
            while let Some((due, waits, order)) = line.rising.first().copied().filter(|first| has_risen(first.0, now)) {
                line.rising.remove(&(due, waits, order));
                line.risen.insert((waits, order));
            }
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

    /// Tasks whose place may change with a variable or with what is measured.
    pub fn sensitive(&self) -> impl Iterator<Item = TaskId> + '_ {
        self.sensitive.iter().copied()
    }

    /// Returns true if all claimants that wait have a place that follows from themselves alone.
    pub fn all_in_queues(&self) -> bool {
        self.apart == 0
    }

    /// Returns the parent, if all claimants have ranks below it and no two the same: then nothing else counts between them.
    pub fn parent_of_ranks(&self) -> Option<TaskId> {
        // One that is above all is above the first. The highest comes first: it is the same for most resources.
        let Claim::Queued { by_rank, .. } = self.claims.first_key_value()?.1 else { return None };
        let count = self.claims.len();
        let mut parents = by_rank.iter().rev().filter_map(|key| Some(key.rank?.parent));
        parents.find(|parent| {
            let siblings = self.siblings.get(parent);
            siblings.is_some_and(|siblings| siblings.keys.len() == count && siblings.ranks.len() == count)
        })
    }

    /// Returns true if a claimant has this rank below the parent.
    pub fn has_rank(&self, rank: RankAmong) -> bool {
        self.siblings.get(&rank.parent).is_some_and(|siblings| siblings.ranks.contains_key(&bits_of(rank.rank)))
    }

    /// Returns the claimants in the order of their ranks, where they have no other order and need none.
    fn queue_by_rank(&self) -> Option<&BTreeSet<QueueKey>> {
        let parent = self.ordered_below()?;
        self.siblings.get(&parent).map(|siblings| &siblings.keys)
    }

    /// Returns the parent below which ranks are the order of the queue, so that priorities do not count between claimants.
    pub fn ordered_below(&self) -> Option<TaskId> {
        self.parent_of_ranks().filter(|_| !self.all_in_queues())
    }

    /// Returns true if time, or a change of a variable or measurement, may change the order.
    pub fn is_sensitive(&self) -> bool {
        !self.sensitive.is_empty() || !self.lines.is_empty()
    }

    /// Returns true if the priority of a queued claimant rises.
    pub fn has_rising(&self) -> bool {
        !self.lines.is_empty()
    }

    /// Returns the shortest time that one of those in queues says that it takes who need no more than this.
    pub fn shortest(&self, room: f64) -> Option<Duration> {
        self.together(room).filter_map(|(_, shortest)| shortest).min()
    }

    /// Returns the joint needs of queued claimants who need no more than this, with the shortest expected duration among them.
    pub fn together(&self, room: f64) -> impl Iterator<Item = (&[ResourceId], Option<Duration>)> {
        let shortest = |spans: &BTreeMap<Option<Duration>, usize>| spans.keys().flatten().next().copied();
        self.together.iter().filter_map(move |(needs, amounts)| {
            let mut fitting = amounts.range(..=room.max(0.0).to_bits()).map(|(_, spans)| shortest(spans)).peekable();
            fitting.peek()?;
            Some((needs.as_slice(), fitting.flatten().min()))
        })
    }

    /// Returns the resources that queued claimants need in addition to this one.
    pub fn others(&self) -> impl Iterator<Item = ResourceId> + '_ {
        self.together.keys().flatten().copied()
    }

    /// Returns the priority of those that have ranks; `None` if no rank counts.
    ///
    /// # Errors
    /// When the order of ranks and priorities cannot be read from the queues: ranks below several parents, or claimants
    /// without rank that are as important.
    pub fn priority_of_ranked(&self) -> Result<Option<f64>, OrderUnknown> {
        if !self.all_in_queues() {
            return self.parent_of_ranks().map(|_| Some(0.0)).ok_or(OrderUnknown);
        }
        let mut groups = self.ranked.values();
        let Some((_, priority)) = groups.next().copied() else { return Ok(None) };
        let unknown = groups.next().is_some() || self.has_unranked_at(priority) || self.has_rising();
        if unknown { Err(OrderUnknown) } else { Ok(Some(priority)) }
    }

    fn has_unranked_at(&self, priority: f64) -> bool {
        let order = (Time::BEGINNING, TaskId(0), 0, TaskId(0));
        let first = QueueKey { priority, rank: None, begun: true, order };
        self.steady.range(first..).next().is_some_and(|key| key.rank.is_none() && key.priority == priority)
    }

    /// Returns true if the place of one more claimant determines which tasks precede it.
    pub fn takes_in(&self, key: &QueueKey) -> bool {
        if !self.all_in_queues() {
            return false;
        }
        let alike = |(parent, group): (&TaskId, &(usize, f64))| {
            key.rank.is_some_and(|rank| rank.parent == *parent) == (group.1 == key.priority)
        };
        self.ranked.iter().all(alike)
            && (key.rank.is_none() || !self.has_unranked_at(key.priority) && !self.has_rising())
    }

    /// Returns the place of the task in its queue; `risen_to` computes a priority from importance and due instant.
    pub fn key_of(&self, task: TaskId, risen_to: impl Fn(f64, Time) -> f64) -> Option<QueueKey> {
        let Claim::Queued { place, by_rank, .. } = self.claims.get(&task)? else { return None };
        if !self.all_in_queues() {
            let parent = self.parent_of_ranks()?;
            return by_rank.iter().find(|key| key.rank.is_some_and(|rank| rank.parent == parent)).copied();
        }
        match (*place)? {
            QueuePlace::Steady(key) => Some(key),
            QueuePlace::Rising(key) => Some(QueueKey {
                priority: risen_to(key.importance, key.due),
                rank: None,
                begun: key.begun,
                order: key.order,
            }),
        }
    }

    /// Returns the claimants in queues, the first one first; `risen_to` computes a priority from importance and due instant.
    pub fn in_turn<F: Fn(f64, Time) -> f64>(&self, now: Time, risen_to: F) -> InTurn<'_, F> {
        if let Some(by_rank) = self.queue_by_rank() {
            return InTurn::new(vec![Rest::Steady(by_rank.iter())], risen_to, now);
        }
        let mut lines = vec![Rest::Steady(self.steady.iter())];
        for (importance, line) in &self.lines {
            let fresh: Vec<_> = line.rising.iter().take_while(|each| has_risen(each.0, now)).collect();
            let mut rising = line.rising.iter();
            let mut caught_up: Vec<(Time, Among)> = fresh.into_iter().map(|(due, a, b)| (*due, (*a, *b))).collect();
            rising.by_ref().take(caught_up.len()).for_each(drop);
            caught_up.sort_by_key(|(_, among)| *among);
            let (risen, caught_up) = (line.risen.iter().peekable(), caught_up.into_iter().peekable());
            let importance = f64::from_bits(*importance);
            lines.push(Rest::Rising { importance, risen, caught_up, rising });
        }
        InTurn::new(lines, risen_to, now)
    }
}

/// Places in queues do not say which claimant is the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OrderUnknown;

fn has_risen(due: Time, now: Time) -> bool {
    due - now <= GREATEST_URGENCY_BEFORE
}

/// Bits of a rank: equal ranks have equal bits.
fn bits_of(rank: f64) -> u64 {
    (rank + 0.0).to_bits()
}

fn sibling(key: &QueueKey) -> Option<(TaskId, u64, QueueKey)> {
    let rank = key.rank?;
    Some((rank.parent, bits_of(rank.rank), *key))
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
