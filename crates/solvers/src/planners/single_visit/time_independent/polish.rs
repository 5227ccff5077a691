//! Shortening of a route that visits every target: reversed runs and moved runs of up to three visits, with restarts from local changes.
//!
//! Only the order changes, so a leg is as good as its length in both directions together; the caller compares the whole route. An
//! iteration exchanges two neighbouring runs of some visits, improves around these places, and is taken back if the route got longer.
//! Source: D. S. Johnson, L. A. McGeoch, "The traveling salesman problem: a case study in local optimization", 1997.

use super::route::Route;
use crate::routing::network::{END, Network, START};
use apex_planning::random::Generator;
use apex_planning::solver::Budget;
use std::collections::VecDeque;

/// Inspected legs and moved visits per unit of work.
const LOOKS_PER_UNIT: u64 = 150;
/// Fixed work of an iteration, in inspected legs, and the visits of the copied route that count as one inspected leg.
const LOOKS_PER_ITERATION: u64 = 120;
const VISITS_PER_LOOK: u64 = 8;
/// Neighbours of a visit that are tried.
const NEAR: usize = 10;
/// Maximum number of visits of a moved run.
const RUN_MAX: usize = 3;
/// Maximum number of visits of each of the two runs that are exchanged at random.
const EXCHANGED_MAX: usize = 30;
/// Routes of fewer visits are left to other moves.
const VISITS_MIN: usize = 8;

/// Returns a shorter order of the visits of `route`, found within `units`.
pub(super) fn shorter(
    network: &Network,
    route: &Route,
    units: u64,
    rng: &mut Generator,
    budget: &mut dyn Budget,
) -> Vec<u32> {
    let until = budget.used().saturating_add(units);
    let order: Vec<u32> = route.stops.iter().map(|stop| stop.node).collect();
    let mut path = Path::new(network, order);
    if route.count() < VISITS_MIN {
        return path.visits();
    }
    path.open.extend(path.order.clone());
    path.is_open.fill(true);
    path.improve(budget, until);
    let mut kept = (path.order.clone(), path.places.clone(), path.length);
    while budget.used() < until && !budget.exhausted() {
        path.exchange_runs(rng);
        path.improve(budget, until);
        path.looked += LOOKS_PER_ITERATION + path.order.len() as u64 / VISITS_PER_LOOK;
        path.charge(budget);
        if path.length <= kept.2 {
            kept.0.clone_from(&path.order);
            kept.1.clone_from(&path.places);
            kept.2 = path.length;
        } else {
            path.order.clone_from(&kept.0);
            path.places.clone_from(&kept.1);
            path.length = kept.2;
        }
    }
    path.order = kept.0;
    path.visits()
}

/// An order of nodes between the start and the end, which stay in place.
struct Path<'n> {
    network: &'n Network,
    order: Vec<u32>,
    /// The index of each node in the order.
    places: Vec<u32>,
    /// Length in comparison with the first order.
    length: i64,
    /// Nodes around which an improvement may exist.
    open: VecDeque<u32>,
    is_open: Vec<bool>,
    looked: u64,
}

impl<'n> Path<'n> {
    fn new(network: &'n Network, order: Vec<u32>) -> Path<'n> {
        let mut places = vec![u32::MAX; network.nodes.len()];
        for (index, node) in order.iter().enumerate() {
            if let Some(place) = places.get_mut(*node as usize) {
                *place = index as u32;
            }
        }
        let is_open = vec![false; network.nodes.len()];
        Path { network, order, places, length: 0, open: VecDeque::new(), is_open, looked: 0 }
    }

    fn visits(&self) -> Vec<u32> {
        self.order.iter().copied().filter(|node| *node != START && *node != END).collect()
    }

    fn at(&self, index: usize) -> u32 {
        self.order.get(index).copied().unwrap_or(END)
    }

    /// Returns the index of a node; `None` for nodes that are not in the order, and for both ends.
    fn place(&self, node: u32) -> Option<usize> {
        let place = self.places.get(node as usize).copied()? as usize;
        (place > 0 && place + 1 < self.order.len()).then_some(place)
    }

    /// Returns the sum of a leg's lengths in both directions, in ticks.
    fn leg(&mut self, from: u32, to: u32) -> i64 {
        self.looked += 2;
        let leg = |from: u32, to: u32| i64::from(self.network.leg(from, to));
        match (from, to) {
            (START, _) | (_, END) => 2 * leg(from, to),
            (_, START) | (END, _) => 2 * leg(to, from),
            _ => leg(from, to) + leg(to, from),
        }
    }

    fn charge(&mut self, budget: &mut dyn Budget) {
        budget.charge(self.looked / LOOKS_PER_UNIT);
        self.looked %= LOOKS_PER_UNIT;
    }

    fn look_at(&mut self, node: u32) {
        if let Some(open) = self.is_open.get_mut(node as usize)
            && !*open
        {
            *open = true;
            self.open.push_back(node);
        }
    }

    /// Improves around the open nodes until none is left, or the units are used up.
    fn improve(&mut self, budget: &mut dyn Budget, until: u64) {
        while let Some(node) = self.open.pop_front() {
            if let Some(open) = self.is_open.get_mut(node as usize) {
                *open = false;
            }
            while self.reverse_at(node) || self.move_from(node) {}
            self.charge(budget);
            if budget.used() >= until || budget.exhausted() {
                self.open.clear();
                self.is_open.fill(false);
            }
        }
    }

    fn near(&self, node: u32, rank: usize) -> Option<u32> {
        self.network.near.get(node as usize)?.get(rank).copied().filter(|_| rank < NEAR)
    }

    /// Reverses a run such that `node` and one of its neighbours follow each other. Returns true if the path gets shorter.
    fn reverse_at(&mut self, node: u32) -> bool {
        for forward in [true, false] {
            let Some(place) = self.place(node) else { return false };
            let beside = self.at(if forward { place + 1 } else { place - 1 });
            let now = self.leg(node, beside);
            for rank in 0.. {
                let Some(other) = self.near(node, rank) else { break };
                let wanted = self.leg(node, other);
                if wanted >= now {
                    break;
                }
                let Some(there) = self.place(other) else { continue };
                let beyond = self.at(if forward { there + 1 } else { there - 1 });
                let gain = now + self.leg(other, beyond) - wanted - self.leg(beside, beyond);
                if gain > 0 {
                    let (low, high) = (place.min(there), place.max(there));
                    let run = if forward { low + 1..high + 1 } else { low..high };
                    if let Some(part) = self.order.get_mut(run.clone()) {
                        part.reverse();
                    }
                    self.settle(run, gain, [node, beside, other, beyond]);
                    return true;
                }
            }
        }
        false
    }

    /// Moves a run that begins or ends with `node` to one of its neighbours. Returns true if the path gets shorter.
    fn move_from(&mut self, node: u32) -> bool {
        for (count, leads) in (1..=RUN_MAX).flat_map(|count| [(count, true), (count, false)]) {
            let Some(place) = self.place(node) else { return false };
            let Some(first) = (if leads { Some(place) } else { (place + 1).checked_sub(count) }) else { continue };
            let last = first + count - 1;
            if first == 0 || last + 1 >= self.order.len() {
                continue;
            }
            let other_end = self.at(if leads { last } else { first });
            let (before, after) = (self.at(first - 1), self.at(last + 1));
            let saved = self.leg(before, self.at(first)) + self.leg(self.at(last), after) - self.leg(before, after);
            for rank in 0.. {
                let Some(other) = self.near(node, rank) else { break };
                let wanted = self.leg(node, other);
                if wanted >= saved {
                    break;
                }
                let Some(there) = self.place(other).filter(|there| !(first..=last).contains(there)) else { continue };
                // The run goes between `other` and one of its neighbours, with `node` next to `other`.
                for follows in [true, false] {
                    let gap = if follows { there } else { there - 1 };
                    if gap + 1 == first || gap == last {
                        continue;
                    }
                    let beyond = self.at(if follows { there + 1 } else { there - 1 });
                    let gain = saved - wanted - self.leg(other_end, beyond) + self.leg(other, beyond);
                    if gain > 0 {
                        let touched = self.move_run((first, last), gap, leads != follows);
                        self.settle(touched, gain, [node, other_end, before, after]);
                        self.look_at(other);
                        self.look_at(beyond);
                        return true;
                    }
                }
            }
        }
        false
    }

    /// Moves the nodes `first..=last` behind the node at `gap`, reversed if `turns`; returns the changed places.
    fn move_run(&mut self, (first, last): (usize, usize), gap: usize, turns: bool) -> std::ops::Range<usize> {
        let count = last + 1 - first;
        let (changed, run) = if gap > last {
            (first..gap + 1, gap + 1 - count..gap + 1)
        } else {
            (gap + 1..last + 1, gap + 1..gap + 1 + count)
        };
        if let Some(part) = self.order.get_mut(changed.clone()) {
            if gap > last { part.rotate_left(count) } else { part.rotate_right(count) }
        }
        if let Some(part) = self.order.get_mut(run).filter(|_| turns) {
            part.reverse();
        }
        changed
    }

    /// Updates places and length, and opens the nodes around which another improvement may exist.
    fn settle(&mut self, changed: std::ops::Range<usize>, gain: i64, touched: [u32; 4]) {
        self.looked += changed.len() as u64;
        self.length -= gain;
        for index in changed {
            let node = self.at(index);
            if let Some(place) = self.places.get_mut(node as usize) {
                *place = index as u32;
            }
        }
        touched.into_iter().for_each(|node| self.look_at(node));
    }

    /// Exchanges two runs that follow each other, at a random place.
    fn exchange_runs(&mut self, rng: &mut Generator) {
        let inner = self.order.len().saturating_sub(2);
        let most = EXCHANGED_MAX.min(inner / 3).max(1);
        let (one, two) = (1 + rng.below(most), 1 + rng.below(most));
        let first = 1 + rng.below((inner + 1).saturating_sub(one + two).max(1));
        let (middle, end) = (first + one, first + one + two);
        let (before, head, tail) = (self.at(first - 1), self.at(first), self.at(middle - 1));
        let (head_of_two, tail_of_two, after) = (self.at(middle), self.at(end - 1), self.at(end));
        let old = self.leg(before, head) + self.leg(tail, head_of_two) + self.leg(tail_of_two, after);
        let new = self.leg(before, head_of_two) + self.leg(tail_of_two, head) + self.leg(tail, after);
        if let Some(part) = self.order.get_mut(first..end) {
            part.rotate_left(one);
        }
        self.settle(first..end, old - new, [before, head, tail, head_of_two]);
        self.look_at(tail_of_two);
        self.look_at(after);
    }
}
