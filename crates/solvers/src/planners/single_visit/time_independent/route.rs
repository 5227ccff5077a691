//! A route with its timetable: the beginning of each visit, its latest beginning, and the end of the route for any beginning.
//!
//! If a visit begins at `begin`, the route ends at `max(begin + rest, waits)`: with three numbers per stop, one step decides whether a
//! visit fits between two stops and when the route would then end.

use crate::routing::network::{END, NO_WAY, Network, START};

/// A node of the route with its times in ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stop {
    pub(super) node: u32,
    /// Begin of the observation.
    pub(super) begin: i32,
    /// Latest beginning for which no later stop is too late.
    pub(super) latest: i32,
    /// Time from its beginning to the end of the route without waiting.
    pub(super) rest: i32,
    /// Earliest end of the route, because of waiting after this stop.
    pub(super) waits: i32,
}

/// Stops from start to end.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Route {
    pub(super) stops: Vec<Stop>,
    /// For each target: true if it is visited.
    pub(super) seen: Vec<bool>,
    /// For each node its position in the route, while it is in the route.
    places: Vec<u32>,
    pub(super) value: f64,
}

/// A position for a node, and the time that it takes there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct InsertionPoint {
    /// After the stop of this index.
    pub(super) after: usize,
    /// Delay of the next stop's beginning, in ticks.
    pub(super) shift: i32,
    /// Growth of the legs, the visit included, in ticks.
    pub(super) longer: i32,
    /// End of the route.
    pub(super) end: i32,
}

impl Route {
    /// Returns a route from the start directly to the end.
    pub(super) fn new(network: &Network) -> Route {
        Route::of(network, &[])
    }

    /// Returns the route of `visits` in order; a late stop has a `begin` after its `latest`.
    pub(super) fn of(network: &Network, visits: &[u32]) -> Route {
        let stop = |node| Stop { node, begin: 0, latest: 0, rest: 0, waits: 0 };
        let nodes = [START].into_iter().chain(visits.iter().copied()).chain([END]);
        let mut route = Route {
            stops: nodes.map(stop).collect(),
            seen: vec![false; network.targets],
            places: vec![0; network.nodes.len()],
            value: 0.0,
        };
        for node in visits {
            route.mark(network, *node, true);
        }
        route.forward(network, 1);
        route.backward(network, route.stops.len() - 1);
        route
    }

    /// Returns the visits in order.
    pub(super) fn visits(&self) -> impl Iterator<Item = u32> {
        let count = self.count();
        self.stops.iter().skip(1).take(count).map(|stop| stop.node)
    }

    /// Returns the number of visits.
    pub(super) fn count(&self) -> usize {
        self.stops.len().saturating_sub(2)
    }

    /// Returns the end of the route.
    pub(super) fn end(&self) -> i32 {
        self.stops.last().map_or(0, |stop| stop.begin)
    }

    /// Returns the time of all legs and visits without waiting, in ticks.
    pub(super) fn length(&self) -> i32 {
        self.stops.first().map_or(0, |stop| stop.rest)
    }

    /// Returns true if every visit is in time.
    pub(super) fn is_feasible(&self) -> bool {
        self.stops.iter().all(|stop| stop.begin <= stop.latest)
    }

    fn mark(&mut self, network: &Network, node: u32, seen: bool) {
        let node = network.node(node);
        if let Some(slot) = self.seen.get_mut(node.target as usize) {
            *slot = seen;
        }
        self.value += if seen { node.value } else { -node.value };
    }

    /// Returns true if the target of `node` is visited.
    #[inline(always)]
    pub(super) fn sees(&self, network: &Network, node: u32) -> bool {
        self.seen.get(network.node(node).target as usize).copied().unwrap_or(true)
    }

    /// Returns the position of `node`; `None` if it is not in the route.
    #[inline(always)]
    pub(super) fn index(&self, node: u32) -> Option<usize> {
        let index = self.places.get(node as usize).copied()? as usize;
        self.stops.get(index).filter(|stop| stop.node == node).map(|_| index)
    }

    /// Returns the end of the route with the stops `from..until` reversed, and the growth of its legs; `None` if a stop
    /// would be too late.
    pub(super) fn turned(&self, network: &Network, from: usize, until: usize) -> Option<(i32, i32)> {
        let (before, next) = (self.stops.get(from.checked_sub(1)?)?, self.stops.get(until)?);
        let (mut here, mut begin, mut legs) = (before.node, before.begin, 0);
        for stop in self.stops.get(from..until)?.iter().rev() {
            let leg = network.leg(here, stop.node);
            let node = network.node(stop.node);
            begin = (begin + leg).max(node.open);
            if begin > node.close {
                return None;
            }
            (here, legs) = (stop.node, legs + leg);
        }
        let leg = network.leg(here, next.node);
        let arrive = (begin + leg).max(network.node(next.node).open);
        if arrive > next.latest {
            return None;
        }
        Some(((arrive + next.rest).max(next.waits), legs + leg - (before.rest - next.rest)))
    }

    /// Reverses the stops `from..until`.
    pub(super) fn turn(&mut self, network: &Network, from: usize, until: usize) {
        if let Some(part) = self.stops.get_mut(from..until) {
            part.reverse();
        }
        self.forward(network, from);
        self.backward(network, until.saturating_sub(1));
    }

    /// Returns the insertion of `node` between stop `after` and the next; `None` if it does not fit.
    #[inline(always)]
    pub(super) fn place(
        &self,
        network: &Network,
        node: u32,
        open: i32,
        close: i32,
        after: usize,
    ) -> Option<InsertionPoint> {
        Route::between(network, node, (open, close), (self.stops.get(after)?, self.stops.get(after + 1)?), after)
    }

    /// Like `place`, between two stops of which the first has index `after`.
    #[inline(always)]
    pub(super) fn between(
        network: &Network,
        node: u32,
        (open, close): (i32, i32),
        (before, next): (&Stop, &Stop),
        after: usize,
    ) -> Option<InsertionPoint> {
        let (to, from) = (network.leg(before.node, node), network.leg(node, next.node));
        let begin = (before.begin + to).max(open);
        let arrive = begin + from;
        if begin > close || arrive > next.latest {
            return None;
        }
        let arrive = arrive.max(network.node(next.node).open);
        let end = (arrive + next.rest).max(next.waits);
        let longer = to + from - (before.rest - next.rest);
        Some(InsertionPoint { after, shift: arrive - next.begin, longer, end })
    }

    /// Puts `node` after stop `after`.
    pub(super) fn insert(&mut self, network: &Network, node: u32, after: usize) {
        let at = (after + 1).min(self.stops.len());
        self.stops.insert(at, Stop { node, begin: 0, latest: 0, rest: 0, waits: 0 });
        self.mark(network, node, true);
        self.forward(network, at);
        self.backward(network, at);
    }

    /// Removes the stops `from..until`.
    pub(super) fn remove(&mut self, network: &Network, from: usize, until: usize) {
        let (from, until) = (from.max(1), until.min(self.stops.len() - 1));
        if from >= until {
            return;
        }
        let gone: Vec<Stop> = self.stops.drain(from..until).collect();
        for stop in gone {
            self.mark(network, stop.node, false);
        }
        self.forward(network, from);
        self.backward(network, from - 1);
    }

    /// Keeps the stops for which `keep` returns true; the ends stay.
    pub(super) fn retain(&mut self, network: &Network, keep: impl Fn(u32) -> bool) {
        let mut kept = std::mem::take(&mut self.stops);
        kept.retain(|stop| {
            let stays = stop.node == START || stop.node == END || keep(stop.node);
            if !stays {
                self.mark(network, stop.node, false);
            }
            stays
        });
        self.stops = kept;
        self.forward(network, 1);
        self.backward(network, self.stops.len() - 1);
    }

    /// Computes the beginnings of the stops from `at` on.
    fn forward(&mut self, network: &Network, at: usize) {
        let mut before = match at.checked_sub(1).and_then(|before| self.stops.get(before)) {
            Some(before) => *before,
            None => return,
        };
        for (index, stop) in self.stops.iter_mut().enumerate().skip(at) {
            if let Some(place) = self.places.get_mut(stop.node as usize) {
                *place = index as u32;
            }
            let arrive = before.begin + network.leg(before.node, stop.node);
            stop.begin = arrive.max(network.node(stop.node).open).min(NO_WAY);
            before = *stop;
        }
    }

    /// Computes the latest beginnings and ends for any beginning, from stop `at` back to the start.
    fn backward(&mut self, network: &Network, at: usize) {
        let last = self.stops.len() - 1;
        let mut after = self.stops.get(at + 1).copied();
        for stop in self.stops.iter_mut().take(at.min(last) + 1).rev() {
            let node = network.node(stop.node);
            match after {
                None => (stop.latest, stop.rest, stop.waits) = (node.close, 0, -NO_WAY),
                Some(after) => {
                    let leg = network.leg(stop.node, after.node);
                    stop.latest = node.close.min(after.latest.saturating_sub(leg));
                    stop.rest = (after.rest + leg).min(NO_WAY);
                    stop.waits = after.waits.max(network.node(after.node).open + after.rest);
                }
            }
            after = Some(*stop);
        }
    }
}
