//! Labelling search for the best ng-route through exact times, from one end of the flight to the other.
//!
//! A label is a partial route: a node, a time, the profit so far, and an ng-memory. The memory holds the visited targets that
//! all later targets of the route remember (Baldacci, Mingozzi and Roberti 2011); the route must not revisit them. A label
//! is pruned if
//!
//! - another label at its node is not later, has at least its profit, and may visit every target that it may visit; or
//! - its profit plus its completion bound is below the cutoff.
//!
//! Bound: at most [`LABELS_MAX`] labels; every step charges the work budget.

use super::label_completion::LabelCompletion;
use super::latest_departures::LatestDepartures;
use super::ng_sets::{Targets, bit_of};
use super::pareto_front::ParetoFront;
use super::walk_completion::WalkCompletion;
use crate::routing::network::{END, Network, START};
use apex_planning::solver::Budget;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Maximum number of labels: 48 bytes each, half as much again if the caller keeps the undominated ones, 220 MB in all.
const LABELS_MAX: usize = 3_000_000;
/// Search steps per unit of work.
pub(super) const STEPS_PER_UNIT: u64 = 160;
/// Size of the cache in which a new label looks for one with equal node and memory.
const RECENT: usize = 1 << 15;

/// A partial route.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Label {
    pub(super) value: f64,
    /// Targets that the route must not revisit.
    pub(super) memory: Targets,
    pub(super) time: i32,
    pub(super) node: u32,
    /// Index of the preceding label; a start label precedes itself.
    from: u32,
}

/// Upper bound on the profit that a partial route can still gain, under the current multipliers.
#[derive(Clone, Copy)]
pub(super) enum CompletionBound<'a> {
    Walks(&'a WalkCompletion),
    Labels(&'a LabelCompletion),
}

/// Multipliers that are refunded at the end of a route.
#[derive(Clone, Copy)]
pub(super) enum MultiplierRefund<'a> {
    /// Visits were charged: refund all multipliers, given as their sum.
    All(f64),
    /// Visits earned their full values: refund the multipliers of the targets that may still be visited.
    Unvisited(&'a [f64]),
}

/// One run of the labelling algorithm.
pub(super) struct Labelling<'a> {
    pub(super) network: &'a Network,
    pub(super) latest_departures: &'a LatestDepartures,
    /// Reduced profit of a visit of each node.
    pub(super) reduced_profit: &'a [f64],
    /// The ng-set of each target: the visited targets that a route remembers there.
    pub(super) ng_sets: &'a [Targets],
    /// The nodes that may follow each node.
    pub(super) successors: &'a [Vec<u32>],
    pub(super) completion_bound: CompletionBound<'a>,
    pub(super) refund: MultiplierRefund<'a>,
    /// Routes with less profit are pruned. The cutoff stays constant even when better routes are found: the completion bounds that the
    /// labels give to the opposite direction must hold for all routes above it.
    pub(super) cutoff: f64,
    /// A label dominates others of up to this much more profit; above zero the result is not a proof.
    pub(super) slack: f64,
}

/// Maximum number of routes reported in addition to the best one.
const OTHERS_MAX: usize = 16;

/// Result of a run.
pub(super) struct LabellingResult {
    /// Profit of the best route with the refund; negative infinity if no route reaches the cutoff.
    pub(super) value: f64,
    pub(super) walk: Vec<u32>,
    /// The best routes above the cutoff, at most one per last node.
    pub(super) others: Vec<Vec<u32>>,
    /// The undominated labels, earliest first.
    pub(super) labels: Vec<Label>,
}

impl LabellingResult {
    /// Returns true if no route reaches the cutoff. The walk may be empty if the multipliers exceed all profits.
    pub(super) fn is_nothing(&self) -> bool {
        self.value == f64::NEG_INFINITY
    }
}

impl Labelling<'_> {
    /// Returns the best route above the cutoff; `None` if labels or units did not suffice.
    pub(super) fn run(&self, until: u64, budget: &mut dyn Budget) -> Option<LabellingResult> {
        let mut made = vec![Label { value: 0.0, memory: 0, time: 0, node: START, from: 0 }];
        // Indices of labels that were dominated before any label followed them: their slots are used again.
        let mut free: Vec<u32> = Vec::new();
        let mut settled: Vec<u32> = Vec::new();
        let mut fronts = vec![ParetoFront::default(); self.network.nodes.len()];
        let mut recent = vec![made.first().copied(); RECENT];
        // Time and index in one integer: earlier labels first, and of equal times the one made first.
        let mut open = BinaryHeap::from([Reverse(0_u64)]);
        // For each last node the greatest profit above the cutoff, and its label.
        let mut homes = vec![(f64::NEG_INFINITY, 0_u32); self.network.nodes.len()];
        let mut steps = 0_u64;
        while let Some(Reverse(key)) = open.pop() {
            let own = key as u32;
            let Some(label) = made.get(own as usize).copied() else { continue };
            let closed = label.memory | self.latest_departures.missed(label.node, label.time);
            steps += 8;
            if let Some(front) = fronts.get_mut(label.node as usize) {
                if front.beats(label.value - self.slack, closed, &mut steps) {
                    free.push(own);
                    continue;
                }
                front.insert(label.value, label.memory, &mut steps);
            }
            settled.push(own);
            let total = label.value + self.refund_at_end();
            if total >= self.cutoff
                && label.time + self.network.leg(label.node, END) <= self.network.limit()
                && let Some(home) = homes.get_mut(label.node as usize).filter(|home| total > home.0)
            {
                *home = (total, own);
            }
            for node in self.successors.get(label.node as usize).into_iter().flatten() {
                let Some(next) = self.extended(&label, closed, own, *node, &mut steps) else { continue };
                let beats =
                    |front: &ParetoFront, steps: &mut u64| front.beats(next.value - self.slack, next.memory, steps);
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
        Some(LabellingResult { value, walk: walks.next().unwrap_or_default(), others: walks.collect(), labels })
    }

    fn refund_at_end(&self) -> f64 {
        match self.refund {
            MultiplierRefund::All(sum) => sum,
            MultiplierRefund::Unvisited(_) => 0.0,
        }
    }

    /// Returns the label that extends `label` to `node`, if the visit is allowed and the route can still reach the cutoff.
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
        let value = label.value + self.reduced_profit.get(node as usize).copied().unwrap_or(0.0);
        let memory = (label.memory & self.ng_sets.get(data.target as usize).copied().unwrap_or(Targets::MAX)) | bit;
        let refund = match self.refund {
            MultiplierRefund::All(sum) => sum,
            MultiplierRefund::Unvisited(multipliers) => {
                let closed = memory | self.latest_departures.missed(node, time);
                let multipliers = (0..).zip(multipliers);
                *steps += 16;
                multipliers.filter(|(target, _)| closed & bit_of(*target) == 0).map(|(_, price)| price).sum()
            }
        };
        let needed = self.cutoff - value - refund;
        let may = match self.completion_bound {
            CompletionBound::Walks(completion) => {
                let free = |next: u32| memory & bit_of(self.network.node(next).target) == 0;
                completion.after(node, time, free) >= needed
            }
            CompletionBound::Labels(rest) => rest.may(node, time, memory & !bit, needed, steps),
        };
        may.then_some(Label { value, memory, time, node, from: own })
    }

    /// Returns true if the cache holds a label with equal node and memory that is at least as early and has at least
    /// this profit.
    #[inline]
    fn is_known(&self, recent: &mut [Option<Label>], next: &Label) -> bool {
        let halves = next.memory as u64 ^ ((next.memory >> 64) as u64).wrapping_mul(0xD6E8_FEB8_6659_FD93);
        let mixed = (halves ^ u64::from(next.node).rotate_left(57)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let Some(slot) = recent.get_mut((mixed >> 49) as usize) else { return false };
        let same = slot.filter(|other| other.node == next.node && other.memory == next.memory);
        if same.is_some_and(|other| other.time <= next.time && other.value >= next.value - self.slack) {
            return true;
        }
        *slot = Some(*next);
        false
    }
}

/// Returns the nodes of a route in order, without the start.
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
