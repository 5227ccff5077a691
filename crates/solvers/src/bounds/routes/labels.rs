//! The best walk through exact times that comes back to no target it remembers: labels from one end to the other.
//!
//! A label is a way to be at a node at a time, with what it gathered. It remembers of the targets it has seen those that the
//! targets since then remember (*ng-routes*: Baldacci, Mingozzi and Roberti 2011), and comes back to none of them. A label
//! goes no further when another is there no later, with no less, and may go wherever it may; or when what is known of the
//! rest of the flight says that no route that begins with it is worth what is wanted.
//! Bound: labels are limited, and steps are charged.

use super::completion::Completion;
use super::front::Front;
use super::late::Late;
use super::memory::{Targets, bit_of};
use super::rest::Rest;
use crate::planners::single_visit::steady::network::{END, Network, START};
use apex_planning::solver::Budget;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Labels made at most, each of 48 bytes, and half as much again for those who keep what is left of them: some 220 MB.
const LABELS_MAX: usize = 3_000_000;
/// Steps for one unit of work.
pub(super) const STEPS_PER_UNIT: u64 = 160;
/// Labels among which a new one looks for one of the same place and memory.
const RECENT: usize = 1 << 15;

/// A way to be at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Label {
    pub(super) value: f64,
    /// Targets that it remembers, and does not come back to.
    pub(super) seen: Targets,
    pub(super) time: i32,
    pub(super) node: u32,
    /// The label it came from; its own number at the start.
    from: u32,
}

/// What is known of the rest of a flight, under prices.
#[derive(Clone, Copy)]
pub(super) enum Ahead<'a> {
    Walks(&'a Completion),
    Labels(&'a Rest),
}

/// What is given back of prices at the end.
#[derive(Clone, Copy)]
pub(super) enum Given<'a> {
    /// Visits have paid: all prices.
    All(f64),
    /// Visits are worth their values: the prices of those targets that may still be seen.
    Open(&'a [f64]),
}

/// One search for walks.
pub(super) struct Search<'a> {
    pub(super) network: &'a Network,
    pub(super) late: &'a Late,
    /// What a visit of each node is worth.
    pub(super) worth: &'a [f64],
    /// For each target those that it remembers.
    pub(super) remembers: &'a [Targets],
    /// For each node those that may follow it.
    pub(super) onward: &'a [Vec<u32>],
    pub(super) ahead: Ahead<'a>,
    pub(super) given: Given<'a>,
    /// Routes that are worth less are not looked for. It stays where it is, however good a walk is found: what labels say to
    /// the other end must hold for all routes that are wanted.
    pub(super) wanted: f64,
    /// By so much a label may have less than another and still beat it: anything above nought proves nothing.
    pub(super) slack: f64,
}

/// Walks that are told of a search beside the best one.
const OTHERS_MAX: usize = 16;

/// What a search found.
pub(super) struct Found {
    /// What the best walk is worth, with what is given back; negative infinity where none is worth what was wanted.
    pub(super) value: f64,
    pub(super) walk: Vec<u32>,
    /// The best walks that are wanted, one for each last node at most.
    pub(super) others: Vec<Vec<u32>>,
    /// The labels that nothing has beaten, earliest first.
    pub(super) labels: Vec<Label>,
}

impl Found {
    /// Is no route worth what was wanted? The walk may be empty where prices are higher than anything gathered.
    pub(super) fn is_nothing(&self) -> bool {
        self.value == f64::NEG_INFINITY
    }
}

impl Search<'_> {
    /// The best walk that is wanted; nothing where labels or units did not suffice.
    pub(super) fn run(&self, until: u64, budget: &mut dyn Budget) -> Option<Found> {
        let mut made = vec![Label { value: 0.0, seen: 0, time: 0, node: START, from: 0 }];
        // Numbers of labels that were beaten before anything came from them.
        let mut free: Vec<u32> = Vec::new();
        let mut settled: Vec<u32> = Vec::new();
        let mut fronts = vec![Front::default(); self.network.nodes.len()];
        let mut recent = vec![made.first().copied(); RECENT];
        // Time and number in one word: earlier ones first, of these those made first.
        let mut open = BinaryHeap::from([Reverse(0_u64)]);
        // For each last node the most that is wanted, and its label.
        let mut homes = vec![(f64::NEG_INFINITY, 0_u32); self.network.nodes.len()];
        let mut steps = 0_u64;
        while let Some(Reverse(key)) = open.pop() {
            let own = key as u32;
            let Some(label) = made.get(own as usize).copied() else { continue };
            let closed = label.seen | self.late.missed(label.node, label.time);
            steps += 8;
            if let Some(front) = fronts.get_mut(label.node as usize) {
                if front.beats(label.value - self.slack, closed, &mut steps) {
                    free.push(own);
                    continue;
                }
                front.insert(label.value, label.seen, &mut steps);
            }
            settled.push(own);
            let total = label.value + self.given_at_end();
            if total >= self.wanted
                && label.time + self.network.leg(label.node, END) <= self.network.limit()
                && let Some(home) = homes.get_mut(label.node as usize).filter(|home| total > home.0)
            {
                *home = (total, own);
            }
            for node in self.onward.get(label.node as usize).into_iter().flatten() {
                let Some(next) = self.extended(&label, closed, own, *node, &mut steps) else { continue };
                let beats = |front: &Front, steps: &mut u64| front.beats(next.value - self.slack, next.seen, steps);
                if fronts.get(*node as usize).is_some_and(|front| beats(front, &mut steps))
                    || self.is_known(&mut recent, &next)
                {
                    continue;
                }
                let number = free.pop().unwrap_or(made.len() as u32);
                match made.get_mut(number as usize) {
                    Some(slot) => *slot = next,
                    None => made.push(next),
                }
                open.push(Reverse((next.time as u64) << 32 | u64::from(number)));
            }
            if steps >= STEPS_PER_UNIT {
                budget.charge(steps / STEPS_PER_UNIT);
                steps %= STEPS_PER_UNIT;
                if budget.used() >= until || budget.exhausted() || made.len() > LABELS_MAX {
                    return None;
                }
            }
        }
        budget.charge(1);
        let labels = settled.iter().filter_map(|number| made.get(*number as usize).copied()).collect();
        homes.retain(|(value, _)| *value > f64::NEG_INFINITY);
        homes.sort_unstable_by(|(a, left), (b, right)| b.total_cmp(a).then(left.cmp(right)));
        let mut walks = homes.iter().take(1 + OTHERS_MAX).map(|(_, last)| walk(&made, *last));
        let value = homes.first().map_or(f64::NEG_INFINITY, |(value, _)| *value);
        Some(Found { value, walk: walks.next().unwrap_or_default(), others: walks.collect(), labels })
    }

    fn given_at_end(&self) -> f64 {
        match self.given {
            Given::All(sum) => sum,
            Given::Open(_) => 0.0,
        }
    }

    /// The label at `node` after `label`, if it may be there and can still come to what is `wanted`.
    #[inline]
    fn extended(&self, label: &Label, closed: Targets, own: u32, node: u32, steps: &mut u64) -> Option<Label> {
        let data = self.network.node(node);
        let bit = bit_of(data.target);
        let arrive = label.time + self.network.leg(label.node, node);
        *steps += 2;
        if closed & bit != 0 || arrive > data.close {
            return None;
        }
        let time = arrive.max(data.open);
        let value = label.value + self.worth.get(node as usize).copied().unwrap_or(0.0);
        let seen = (label.seen & self.remembers.get(data.target as usize).copied().unwrap_or(Targets::MAX)) | bit;
        let given = match self.given {
            Given::All(sum) => sum,
            Given::Open(prices) => {
                let closed = seen | self.late.missed(node, time);
                let prices = (0..).zip(prices);
                *steps += 16;
                prices.filter(|(target, _)| closed & bit_of(*target) == 0).map(|(_, price)| price).sum()
            }
        };
        let needed = self.wanted - value - given;
        let may = match self.ahead {
            Ahead::Walks(completion) => {
                let free = |next: u32| seen & bit_of(self.network.node(next).target) == 0;
                completion.after(node, time, free) >= needed
            }
            Ahead::Labels(rest) => rest.may(node, time, seen & !bit, needed, steps),
        };
        may.then_some(Label { value, seen, time, node, from: own })
    }

    /// Was a label made not long ago that is at the same node, no later and with no less, and remembers the same?
    #[inline]
    fn is_known(&self, recent: &mut [Option<Label>], next: &Label) -> bool {
        let halves = next.seen as u64 ^ ((next.seen >> 64) as u64).wrapping_mul(0xD6E8_FEB8_6659_FD93);
        let mixed = (halves ^ u64::from(next.node).rotate_left(57)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let Some(slot) = recent.get_mut((mixed >> 49) as usize) else { return false };
        let same = slot.filter(|other| other.node == next.node && other.seen == next.seen);
        if same.is_some_and(|other| other.time <= next.time && other.value >= next.value - self.slack) {
            return true;
        }
        *slot = Some(*next);
        false
    }
}

/// The nodes of a walk in order, without the start.
fn walk(labels: &[Label], last: u32) -> Vec<u32> {
    let mut nodes = Vec::new();
    let mut number = last;
    while let Some(label) = labels.get(number as usize).filter(|label| label.node != START) {
        nodes.push(label.node);
        number = label.from;
    }
    nodes.reverse();
    nodes
}
