//! The best route of few targets, proven: labels through exact times that remember where they have been.
//!
//! A label is a way to be at a node at a time, with what it gathered. It remembers of the targets it has seen those that the
//! targets since then remember (their neighbourhoods, after the *ng-routes* of Baldacci, Mingozzi and Roberti 2011), and
//! comes back to none that it remembers. A label goes no further when another is there no later, with no less, and may go
//! wherever it may; or when not even walks, under the prices of `bound`, could raise it above what some route is worth.
//! Where the best label comes back to a target, the targets between remember that one, and all is done again
//! (decremental state space relaxation, Righini and Salani 2008): it ends with a route that nothing beats.
//! Bound: labels are limited, and charged; where they do not suffice, what is left open bounds every route.

use super::super::network::{END, FIRST, Network, START};
use super::completion::Completion;
use apex_model::solver::Budget;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Sets of targets are words of 64 bits.
pub(super) const TARGETS_MAX: usize = 64;
/// Targets that each one remembers in the beginning, itself included. Tests have few targets, and want walks that come back.
const REMEMBERED: usize = if cfg!(test) { 3 } else { 8 };
/// Labels kept at most: some tens of megabytes.
const LABELS_MAX: usize = 1_000_000;
/// Comparisons of labels for one unit of work.
const STEPS_PER_UNIT: u64 = 200;
/// Values nearer than this are the same.
const SAME: f64 = 1e-9;

/// A way to be at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Label {
    node: u32,
    time: i32,
    value: f64,
    /// Targets that it does not come back to, and those it would be too late for.
    closed: u64,
    /// Targets that it remembers.
    seen: u64,
    /// The label it came from; its own number at the start.
    from: u32,
}

/// Earlier ones come first, then those that gathered more, so that who beats another one is always looked at before.
#[derive(Clone, Copy, PartialEq)]
struct Next(Label, u32);

impl Eq for Next {}

impl Ord for Next {
    fn cmp(&self, other: &Next) -> Ordering {
        let (a, b) = (&self.0, &other.0);
        a.time
            .cmp(&b.time)
            .then(b.value.total_cmp(&a.value))
            .then(a.closed.count_ones().cmp(&b.closed.count_ones()))
            .then(self.1.cmp(&other.1))
    }
}

impl PartialOrd for Next {
    fn partial_cmp(&self, other: &Next) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// What the labels say.
pub(super) struct Proven {
    /// No route is worth more.
    pub(super) bound: f64,
    /// A route that is worth more than what was known, as its nodes.
    pub(super) better: Option<Vec<u32>>,
}

/// The most that any route is worth, where it is more than `reached`. `least` is the least gain that counts: where all
/// values are whole, nothing between two whole numbers does.
pub(super) fn best(
    network: &Network,
    completion: &Completion,
    prices: &[f64],
    (reached, least): (f64, f64),
    (until, budget): (u64, &mut dyn Budget),
) -> Option<Proven> {
    if network.targets > TARGETS_MAX {
        return None;
    }
    let mut search = Search::new(network, completion, prices, reached + least - SAME);
    loop {
        let (value, walk) = search.run(until, budget)?;
        match search.comes_back(&walk) {
            false if walk.is_empty() => return Some(Proven { bound: reached, better: None }),
            false => return Some(Proven { bound: value, better: Some(walk) }),
            true => search.remember_cycles(&walk),
        }
        if budget.used() >= until || budget.exhausted() {
            return Some(Proven { bound: value, better: None });
        }
    }
}

struct Search<'n> {
    network: &'n Network,
    completion: &'n Completion,
    prices: &'n [f64],
    /// What does not reach this is left.
    wanted: f64,
    /// For each target those that it remembers.
    remembers: Vec<u64>,
    /// Ticks from node to node by whatever way, without waiting.
    quickest: Vec<i32>,
}

impl<'n> Search<'n> {
    fn new(network: &'n Network, completion: &'n Completion, prices: &'n [f64], wanted: f64) -> Search<'n> {
        let quickest = quickest(network);
        Search { network, completion, prices, wanted, remembers: neighbourhoods(network), quickest }
    }

    /// The value of the best walk that is wanted with its nodes, none where there is no such walk; nothing where labels or
    /// units did not suffice.
    fn run(&self, until: u64, budget: &mut dyn Budget) -> Option<(f64, Vec<u32>)> {
        let network = self.network;
        let mut labels: Vec<Label> = Vec::new();
        let mut settled: Vec<Vec<u32>> = vec![Vec::new(); network.nodes.len()];
        let mut open = BinaryHeap::new();
        let start = Label { node: START, time: 0, value: 0.0, closed: 0, seen: 0, from: 0 };
        let mut number = 0;
        open.push(Reverse(Next(start, number)));
        let mut home: Option<(f64, u32)> = None;
        let mut steps = 0_u64;
        while let Some(Reverse(Next(label, _))) = open.pop() {
            let Some(others) = settled.get_mut(label.node as usize) else { continue };
            let ahead =
                others.partition_point(|other| labels.get(*other as usize).is_some_and(|it| it.value >= label.value));
            steps += 1 + network.nodes.len() as u64 + ahead as u64;
            let beats = |other: &u32| labels.get(*other as usize).is_some_and(|it| it.closed & !label.closed == 0);
            if others.iter().take(ahead).any(beats) {
                continue;
            }
            let own = labels.len() as u32;
            others.insert(ahead, own);
            labels.push(label);
            if steps >= STEPS_PER_UNIT {
                budget.charge(steps / STEPS_PER_UNIT);
                steps %= STEPS_PER_UNIT;
                if budget.used() >= until || budget.exhausted() || labels.len() + open.len() > LABELS_MAX {
                    return None;
                }
            }
            let wanted = home.map_or(self.wanted, |(value, _)| value + SAME);
            if label.value >= wanted && label.time + network.leg(label.node, END) <= network.limit() {
                home = Some((label.value, own));
            }
            for node in network.visits() {
                if let Some(next) = self.extended(&label, own, node, wanted) {
                    number += 1;
                    open.push(Reverse(Next(next, number)));
                }
            }
        }
        budget.charge(1 + steps / STEPS_PER_UNIT);
        let Some((value, last)) = home else { return Some((f64::NEG_INFINITY, Vec::new())) };
        Some((value, walk(&labels, last)))
    }

    /// The label at `node` after `label`, if it may be there and can still come to what is `wanted`.
    fn extended(&self, label: &Label, own: u32, node: u32, wanted: f64) -> Option<Label> {
        let network = self.network;
        let data = network.node(node);
        let bit = bit_of(data.target);
        let arrive = label.time + network.leg(label.node, node);
        if label.closed & bit != 0 || arrive > data.close {
            return None;
        }
        let time = arrive.max(data.open);
        let value = label.value + data.value;
        let seen = (label.seen & self.remembers.get(data.target as usize).copied().unwrap_or(u64::MAX)) | bit;
        let closed = seen | self.too_late(node, time);
        // Prices are given back for what may still be seen, and for nothing else.
        let rest = self.completion.after(node, time, |next| closed & bit_of(network.node(next).target) == 0);
        let prices = self.prices.iter().enumerate();
        let given: f64 = prices.filter(|(target, _)| closed & (1 << target) == 0).map(|(_, price)| price).sum();
        (value + rest + given >= wanted).then_some(Label { node, time, value, closed, seen, from: own })
    }

    /// Targets that no way reaches in time.
    fn too_late(&self, node: u32, time: i32) -> u64 {
        let nodes = self.network.nodes.len();
        let row = self.quickest.get(node as usize * nodes..(node as usize + 1) * nodes).unwrap_or_default();
        let visits = row.iter().zip(&self.network.nodes).skip(FIRST as usize);
        let in_time = visits.filter(|(quickest, data)| time.saturating_add(**quickest) <= data.close);
        !in_time.fold(0, |set, (_, data)| set | bit_of(data.target))
    }

    fn comes_back(&self, walk: &[u32]) -> bool {
        let mut seen = 0;
        walk.iter().any(|node| {
            let bit = bit_of(self.network.node(*node).target);
            let back = seen & bit != 0;
            seen |= bit;
            back
        })
    }

    /// The targets between two visits of one remember that one.
    fn remember_cycles(&mut self, walk: &[u32]) {
        let targets: Vec<u32> = walk.iter().map(|node| self.network.node(*node).target).collect();
        for (index, target) in targets.iter().enumerate() {
            let Some(before) = targets.iter().take(index).rposition(|other| other == target) else { continue };
            for between in targets.get(before + 1..index).unwrap_or_default() {
                if let Some(remembers) = self.remembers.get_mut(*between as usize) {
                    *remembers |= bit_of(*target);
                }
            }
        }
    }
}

/// The set of one target.
fn bit_of(target: u32) -> u64 {
    1_u64.checked_shl(target).unwrap_or(0)
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

/// For each target itself and those nearest to it.
fn neighbourhoods(network: &Network) -> Vec<u64> {
    let mut away = vec![vec![i32::MAX; network.targets]; network.targets];
    for from in network.visits() {
        for to in network.visits().filter(|to| *to != from) {
            let (a, b) = (network.node(from).target as usize, network.node(to).target as usize);
            if let Some(away) = away.get_mut(a).and_then(|row| row.get_mut(b)) {
                *away = (*away).min(network.leg(from, to)).min(network.leg(to, from));
            }
        }
    }
    let near = |(target, row): (usize, &Vec<i32>)| {
        let mut order: Vec<usize> = (0..network.targets).filter(|other| *other != target).collect();
        order.sort_by_key(|other| (row.get(*other).copied().unwrap_or(i32::MAX), *other));
        order.truncate(REMEMBERED - 1);
        order.iter().fold(bit_of(target as u32), |set, other| set | bit_of(*other as u32))
    };
    away.iter().enumerate().map(near).collect()
}

/// The quickest way from node to node through any others.
fn quickest(network: &Network) -> Vec<i32> {
    let count = network.nodes.len();
    let mut quickest: Vec<i32> =
        (0..count * count).map(|index| network.leg((index / count) as u32, (index % count) as u32)).collect();
    for through in network.visits().map(|node| node as usize) {
        let onward: Vec<i32> = quickest.get(through * count..(through + 1) * count).unwrap_or_default().to_vec();
        for row in quickest.chunks_mut(count) {
            let Some(to_there) = row.get(through).copied() else { continue };
            for (ticks, on) in row.iter_mut().zip(&onward) {
                *ticks = (*ticks).min(to_there.saturating_add(*on));
            }
        }
    }
    quickest
}
