//! Earliest arrivals: a time-dependent search over bends.
//!
//! A label is a bend in one of the intervals in which flight is permitted there. Arriving earlier in an interval is never worse, because
//! the vehicle can hold there. Bound: O(legs log bends) for each search, times the intervals of a bend.

use super::network::{ArrivalTurn, DirectedLeg, EndpointId, Network, reversed};
use super::spans::Span;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A time by which labels are sorted.
#[derive(Clone, Copy, Debug)]
struct TimeKey(f64);

impl PartialEq for TimeKey {
    fn eq(&self, other: &TimeKey) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for TimeKey {}

impl PartialOrd for TimeKey {
    fn partial_cmp(&self, other: &TimeKey) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for TimeKey {
    fn cmp(&self, other: &TimeKey) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// The earliest arrival at a bend in one of its intervals.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ArrivalLabel {
    arrive_s: f64,
    /// The preceding label (`None` at the first bend), and the leg from its bend or from the place of departure.
    before: Option<(Option<usize>, DirectedLeg)>,
}

/// The earliest arrivals at all bends for one departure.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    /// Index of the first label of each bend; the labels of its other intervals follow.
    firsts: Vec<usize>,
    labels: Vec<ArrivalLabel>,
}

impl Tree {
    /// Returns the legs that lead to a label, and the labels at their ends.
    fn rides(&self, label: usize) -> (Vec<DirectedLeg>, Vec<usize>) {
        let (mut rides, mut labels, mut here) = (Vec::new(), Vec::new(), Some(label));
        while let Some(number) = here {
            labels.push(number);
            let Some((before, ride)) = self.labels.get(number).and_then(|label| label.before) else { break };
            rides.push(ride);
            here = before.filter(|_| rides.len() <= self.labels.len());
        }
        rides.reverse();
        labels.reverse();
        (rides, labels)
    }

    fn bend_of(&self, label: usize) -> usize {
        self.firsts.partition_point(|first| *first <= label).saturating_sub(1)
    }
}

/// A way that a search has found.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FoundPath {
    pub(super) arrive_s: f64,
    pub(super) rides: Vec<DirectedLeg>,
    /// The bends between.
    pub(super) path_vertices: Vec<usize>,
}

impl Network {
    /// Returns the earliest arrivals at bends after leaving `from` at `depart_s` or holding there first.
    pub(super) fn tree(&mut self, from: EndpointId, depart_s: f64) -> Tree {
        let mut tree = Tree::default();
        for open_s in &self.bends_open_s {
            tree.firsts.push(tree.labels.len());
            tree.labels.extend(open_s.iter().map(|_| ArrivalLabel { arrive_s: f64::INFINITY, before: None }));
        }
        let mut open: BinaryHeap<Reverse<(TimeKey, usize)>> = BinaryHeap::new();
        let Some(until_s) = self.may_hold_until_s(from, depart_s) else { return tree };
        for join in self.joins_of_place(from) {
            self.relax(&mut tree, &mut open, (None, depart_s, until_s), &join);
        }
        let mut settled = vec![false; tree.labels.len()];
        while let Some(Reverse((TimeKey(now_s), label))) = open.pop() {
            let Some(seen @ false) = settled.get_mut(label) else { continue };
            *seen = true;
            let bend = tree.bend_of(label);
            let span = tree.firsts.get(bend).and_then(|first| self.bends_open_s.get(bend)?.get(label - first));
            let Some((_, until_s)) = span.copied() else { continue };
            // By index, because relaxing a leg stores its times in the network.
            for index in 0..self.joins_of_bend(bend).len() {
                let Some(join) = self.joins_of_bend(bend).get(index).copied() else { continue };
                self.relax(&mut tree, &mut open, (Some(label), now_s, until_s), &join);
            }
        }
        tree
    }

    /// Returns the instant until which a vehicle may hold at a place; `None` if it is not permitted there now.
    pub(super) fn may_hold_until_s(&self, place: EndpointId, now_s: f64) -> Option<f64> {
        let open_s = &self.places.get(place.0)?.open_s;
        open_s.iter().find(|(from_s, until_s)| *from_s <= now_s && now_s <= *until_s).map(|(_, until_s)| *until_s)
    }

    fn relax(
        &mut self,
        tree: &mut Tree,
        open: &mut BinaryHeap<Reverse<(TimeKey, usize)>>,
        (before, now_s, hold_until_s): (Option<usize>, f64, f64),
        join: &ArrivalTurn,
    ) {
        self.work += 1;
        let Some(first) = tree.firsts.get(join.bend).copied() else { return };
        let count = self.bends_open_s.get(join.bend).map_or(0, Vec::len);
        for index in 0..count {
            let span = self.bends_open_s.get(join.bend).and_then(|spans| spans.get(index));
            let Some((from_s, until_s)) = span.copied() else { continue };
            let best_s = tree.labels.get(first + index).map_or(f64::NEG_INFINITY, |label| label.arrive_s);
            if best_s <= now_s {
                continue;
            }
            let ready_s = if from_s.is_finite() { now_s.max(self.retreat(join.ride, from_s)) } else { now_s };
            let depart_s = self.first_open(join.ride, ready_s);
            if depart_s > hold_until_s || !depart_s.is_finite() {
                continue;
            }
            let arrive_s = self.arrive(join.ride, depart_s);
            if arrive_s < best_s && arrive_s <= until_s {
                if let Some(label) = tree.labels.get_mut(first + index) {
                    *label = ArrivalLabel { arrive_s, before: Some((before, join.ride)) };
                }
                open.push(Reverse((TimeKey(arrive_s), first + index)));
            }
        }
    }

    /// Returns the way to a place over the bends of a tree with the earliest arrival; `None` if no bend leads there.
    pub(super) fn way_over(&mut self, tree: &Tree, to: EndpointId) -> Option<FoundPath> {
        let mut best: Option<(f64, usize, DirectedLeg)> = None;
        for join in self.joins_of_place(to) {
            let ride = reversed(&join);
            let Some(first) = tree.firsts.get(join.bend).copied() else { continue };
            let spans: Vec<Span> = self.bends_open_s.get(join.bend).cloned().unwrap_or_default();
            for (index, (_, until_s)) in spans.into_iter().enumerate() {
                let Some(label) = tree.labels.get(first + index).copied() else { continue };
                let beaten = best.is_some_and(|(best_s, _, _)| best_s <= label.arrive_s);
                if beaten || !label.arrive_s.is_finite() {
                    continue;
                }
                let depart_s = self.first_open(ride, label.arrive_s);
                if depart_s > until_s || !depart_s.is_finite() {
                    continue;
                }
                let arrive_s = self.arrive(ride, depart_s);
                if best.is_none_or(|(best_s, _, _)| arrive_s < best_s) {
                    best = Some((arrive_s, first + index, ride));
                }
            }
        }
        let (arrive_s, label, last) = best?;
        let (mut rides, labels) = tree.rides(label);
        rides.push(last);
        let path_vertices = labels.into_iter().map(|label| tree.bend_of(label)).collect();
        Some(FoundPath { arrive_s, rides, path_vertices })
    }
}
