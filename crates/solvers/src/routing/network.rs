//! A problem whose travel times are equal for every departure, in whole ticks: nodes, legs, windows, neighbours.
//!
//! A node is a target with one of its manoeuvres in one of its windows. Ticks are integers, so that times summed in different orders are
//! equal, and they are rounded such that a route feasible in ticks is feasible in seconds.

use super::flown_legs;
use super::schedule::Schedule;
use apex_model::problem::{Light, SingleVisitProblem, SingleVisitTarget, TimeWindow, TravelTimes, UNREACHABLE_S};
use apex_planning::meter::Meter;
use apex_planning::solver::Budget;

/// The node where every route begins.
pub(crate) const START: u32 = 0;
/// The node where every route ends.
pub(crate) const END: u32 = 1;
/// The first node that is a visit.
pub(crate) const FIRST: u32 = 2;
/// Ticks of a leg that cannot be flown: the sum of three of them still fits into 32 bits.
pub(crate) const NO_WAY: i32 = 1 << 29;
/// Ticks of the longest flight: with a leg in addition they still fit into 32 bits.
const TICKS_MAX: f64 = (1_u32 << 27) as f64;
/// More nodes than this are left to the general search: the table of legs would not fit.
const NODES_MAX: usize = 6_000;
/// Longest flight whose ticks are at most a millisecond; longer flights use a more precise computation.
const FINE_SPAN_S: f64 = 1e-3 * TICKS_MAX;
/// Two times that differ by less than this share of a tick are equal.
const SAME_TICKS: f64 = 1e-6;
/// Greatest number of nodes in missions that are flown around zones: every pair of nodes has a separate path.
const FLOWN_NODES_MAX: usize = 400;
/// Number of neighbours of a node in each direction.
const NEIGHBOURS: usize = 24;

/// One way to visit one target: a manoeuvre in a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) target: u32,
    pub(crate) manoeuvre: u32,
    /// First and last tick at which the visit may begin.
    pub(crate) open: i32,
    pub(crate) close: i32,
    pub(crate) value: f64,
}

/// The problem in ticks.
pub(crate) struct Network {
    pub(crate) nodes: Vec<Node>,
    pub(crate) targets: usize,
    legs: Vec<i32>,
    /// The nodes before their windows were narrowed to the times that can be reached.
    wide: Vec<Node>,
    /// For each node those nearest in travel time, in either direction, nearest first; empty until they are computed.
    pub(crate) near: Vec<Vec<u32>>,
    /// Length of a tick.
    pub(crate) tick_s: f64,
    /// Cost of each tick of flight.
    pub(crate) cost_per_tick: f64,
}

impl Network {
    /// Returns the network of a problem; `None` if paths, order, timing or costs need the general search, or finding the paths would take
    /// more than half of the budget.
    pub(crate) fn new(schedule: &mut Schedule<'_>, usable: &[usize], budget: &mut dyn Budget) -> Option<Network> {
        let problem = schedule.problem;
        if !serves(schedule) {
            return None;
        }
        let span_s = span_s(schedule);
        let tick_s = tick_s(span_s)?;
        let mut nodes = terminal_nodes(floor_ticks(span_s, tick_s));
        for index in usable {
            let Some(target) = problem.targets.get(*index) else { continue };
            for (manoeuvre, data) in target.manoeuvres.iter().enumerate() {
                let value = target.gain(data.quality.product());
                if !lines_are_free(schedule, *index, manoeuvre) {
                    continue;
                }
                for window in schedule.windows(*index, manoeuvre).to_vec() {
                    let (open, close) = (window.from_s - problem.start_s, window.until_s - problem.start_s);
                    let close = libm::floor((close / tick_s).min(TICKS_MAX) + SAME_TICKS) as i32;
                    let open = ceil_ticks(open.max(0.0).min(span_s + 1.0), tick_s);
                    if open <= close {
                        let (target, manoeuvre) = (*index as u32, manoeuvre as u32);
                        nodes.push(Node { target, manoeuvre, open, close, value });
                    }
                }
            }
        }
        if nodes.len() > NODES_MAX {
            return None;
        }
        let legs = match &problem.travel {
            Some(travel) => legs(problem, travel, &nodes, tick_s),
            None => {
                if nodes.len() > FLOWN_NODES_MAX {
                    return None;
                }
                flown_legs::legs(schedule, &nodes, tick_s, flown_legs::Times::Now, budget)?
            }
        };
        let cost_per_tick = schedule.delay_cost(problem.start_s, problem.start_s + 3600.0) / 3600.0 * tick_s;
        Some(Network::tightened(nodes, legs, problem.targets.len(), (tick_s, cost_per_tick)))
    }

    /// Returns a network in which every vehicle is at least as fast as in the problem: each path at its best departure, each value at its
    /// best time, and no order, for a bound on the value of any plan. `None` if there are too many nodes, or the budget is too small to
    /// find the paths.
    pub(crate) fn relaxed(schedule: &mut Schedule<'_>, usable: &[usize], meter: &mut Meter<'_>) -> Option<Network> {
        let problem = schedule.problem;
        let span_s = span_s(schedule);
        let tick_s = tick_s(span_s)?;
        let mut nodes = terminal_nodes(floor_ticks(span_s, tick_s).saturating_add(1));
        for index in usable.iter().copied() {
            let Some(target) = problem.targets.get(index) else { continue };
            let timing = target.timing.iter().map(|(_, factor)| *factor).reduce(f64::max).unwrap_or(1.0);
            for (manoeuvre, data) in target.manoeuvres.iter().enumerate() {
                let value = target.gain(data.quality.product() * timing);
                for window in schedule.windows(index, manoeuvre).to_vec() {
                    let (open, close) = (window.from_s - problem.start_s, window.until_s - problem.start_s);
                    let open = floor_ticks(open.clamp(0.0, span_s + 1.0), tick_s);
                    let close = floor_ticks(close.clamp(-1.0, span_s + 1.0), tick_s).saturating_add(1);
                    if open <= close {
                        nodes.push(Node { target: index as u32, manoeuvre: manoeuvre as u32, open, close, value });
                    }
                }
            }
        }
        if nodes.len() > FLOWN_NODES_MAX {
            return None;
        }
        let Some(legs) = flown_legs::legs(schedule, &nodes, tick_s, flown_legs::Times::Least, meter.budget()) else {
            meter.cut();
            return None;
        };
        Some(Network::tightened(nodes, legs, problem.targets.len(), (tick_s, 0.0)))
    }

    /// Returns true if every visit can begin at once.
    pub(crate) fn is_always_open(&self) -> bool {
        self.wide.iter().skip(FIRST as usize).all(|node| node.open <= 0)
    }

    fn tightened(nodes: Vec<Node>, legs: Vec<i32>, targets: usize, (tick_s, cost_per_tick): (f64, f64)) -> Network {
        let mut network =
            Network { targets, wide: nodes.clone(), nodes, legs, near: Vec::new(), tick_s, cost_per_tick };
        network.tighten();
        network
    }

    /// Returns a network with the same nodes that admits every route of the problem, for bounds: if times are not whole ticks, those of
    /// this network are rounded against the vehicle, and a route may be missed by a part of a tick. `None` if all times are whole.
    pub(crate) fn lowered(&self, problem: &SingleVisitProblem, limit_s: f64) -> Option<Network> {
        if is_whole(problem, limit_s, self.tick_s) {
            return None;
        }
        let lower = |ticks: &i32| if *ticks >= NO_WAY { *ticks } else { (ticks - 1).max(0) };
        let wider = |node: &Node| Node { open: lower(&node.open), close: node.close.saturating_add(1), ..*node };
        let mut nodes: Vec<Node> = self.wide.iter().map(wider).collect();
        // The beginning of the flight is fixed.
        if let Some(start) = nodes.get_mut(START as usize) {
            start.close = 0;
        }
        let legs = self.legs.iter().map(lower).collect();
        Some(Network::tightened(nodes, legs, self.targets, (self.tick_s, self.cost_per_tick)))
    }

    /// Returns a network of given nodes and legs.
    #[cfg(test)]
    pub(crate) fn given(nodes: Vec<Node>, legs: Vec<i32>, targets: usize) -> Network {
        Network::tightened(nodes, legs, targets, (1.0, 0.0))
    }

    /// Returns the ticks from the beginning of the visit `from` to the arrival at `to`.
    #[inline(always)]
    pub(crate) fn leg(&self, from: u32, to: u32) -> i32 {
        self.legs.get(from as usize * self.nodes.len() + to as usize).copied().unwrap_or(NO_WAY)
    }

    #[inline(always)]
    pub(crate) fn node(&self, node: u32) -> Node {
        const NOWHERE: Node = Node { target: 0, manoeuvre: 0, open: 0, close: -1, value: 0.0 };
        self.nodes.get(node as usize).copied().unwrap_or(NOWHERE)
    }

    /// Returns the last tick at which a route may end.
    pub(crate) fn limit(&self) -> i32 {
        self.node(END).close
    }

    /// Returns all nodes that are visits.
    pub(crate) fn visits(&self) -> std::ops::Range<u32> {
        FIRST..self.nodes.len() as u32
    }

    /// Opens windows at the earliest arrival and closes them at the last departure that reaches the end, over other nodes if that is
    /// faster, as with rounded or given times.
    fn tighten(&mut self) {
        let (first, rest) = self.quickest();
        let limit = self.limit();
        for ((node, first), rest) in self.nodes.iter_mut().zip(first).zip(rest).skip(FIRST as usize) {
            node.open = node.open.max(first.min(NO_WAY));
            node.close = node.close.min(limit - rest);
        }
    }

    /// Returns for each node the least ticks from the start and to the end. All legs are examined once; afterwards only those of nodes
    /// for which a shorter time was found.
    fn quickest(&self) -> (Vec<i32>, Vec<i32>) {
        let count = self.nodes.len();
        let mut first: Vec<i32> = self.legs.get(..count).unwrap_or_default().to_vec();
        let mut rest: Vec<i32> = (0..count as u32).map(|node| self.leg(node, END)).collect();
        let (direct_first, direct_rest) = (first.clone(), rest.clone());
        for (node, row) in self.legs.chunks_exact(count).enumerate().skip(FIRST as usize) {
            let least = quicker_over(row, first.get(node).copied().unwrap_or(NO_WAY), &mut first, &rest);
            if let Some(own) = rest.get_mut(node) {
                *own = least.min(*own);
            }
        }
        let (mut heads, mut tails) = (changed(&direct_first, &first), changed(&direct_rest, &rest));
        while !(heads.is_empty() && tails.is_empty()) {
            let (old_first, old_rest) = (first.clone(), rest.clone());
            for node in &heads {
                let row = self.legs.get(node * count..(node + 1) * count).unwrap_or_default();
                quicker_over(row, first.get(*node).copied().unwrap_or(NO_WAY), &mut first, &[]);
            }
            for (node, own) in rest.iter_mut().enumerate().skip(FIRST as usize) {
                let over = |tail: &usize| Some(self.leg(node as u32, *tail as u32) + old_rest.get(*tail)?);
                *own = tails.iter().filter_map(over).fold(*own, i32::min);
            }
            (heads, tails) = (changed(&old_first, &first), changed(&old_rest, &rest));
        }
        (first, rest)
    }

    /// Returns the same network with its ends exchanged: routes are flown backwards, and times count from the end. The window of a visit
    /// is mirrored accordingly.
    pub(crate) fn turned(&self) -> Network {
        let count = self.nodes.len();
        let other = |node: usize| match node as u32 {
            START => END as usize,
            END => START as usize,
            _ => node,
        };
        let limit = self.limit();
        let turned = |node: &Node| Node { open: limit - node.close, close: limit - node.open, ..*node };
        let nodes =
            terminal_nodes(limit).into_iter().chain(self.nodes.iter().skip(FIRST as usize).map(turned)).collect();
        let leg = |index: usize| self.leg(other(index % count) as u32, other(index / count) as u32);
        let legs = (0..count * count).map(leg).collect();
        Network { wide: Vec::new(), nodes, targets: self.targets, legs, near: Vec::new(), ..*self }
    }

    /// Computes every node's neighbours: the search that improves plans needs them, the repair of plans does not.
    pub(crate) fn find_neighbours(&mut self) {
        let of = |node: u32| {
            let mut all: Vec<(i32, u32)> = self
                .visits()
                .filter(|other| *other != node)
                .map(|other| (self.leg(node, other).min(self.leg(other, node)), other))
                .collect();
            if all.len() > NEIGHBOURS {
                all.select_nth_unstable(NEIGHBOURS);
                all.truncate(NEIGHBOURS);
            }
            all.sort_unstable();
            all.into_iter().map(|(_, other)| other).collect()
        };
        self.near = (0..self.nodes.len() as u32).map(of).collect();
    }
}

/// Lowers the least times in `first` by the legs of a node that is reached after `own` ticks. Returns the least time over these legs to
/// the end, with `rest` as remaining times.
fn quicker_over(row: &[i32], own: i32, first: &mut [i32], rest: &[i32]) -> i32 {
    for (first, leg) in first.iter_mut().zip(row) {
        *first = (own + leg).min(*first);
    }
    row.iter().zip(rest).skip(FIRST as usize).map(|(leg, rest)| leg + rest).fold(NO_WAY, i32::min)
}

/// Returns the nodes whose time has decreased.
fn changed(before: &[i32], now: &[i32]) -> Vec<usize> {
    let both = before.iter().zip(now).enumerate().skip(FIRST as usize);
    both.filter(|(_, (before, now))| now < before).map(|(node, _)| node).collect()
}

/// Returns true if the manoeuvre's lines may be flown at all times; the constraints do not change with time.
fn lines_are_free(schedule: &mut Schedule<'_>, target: usize, manoeuvre: usize) -> bool {
    let problem = schedule.problem;
    let flown = problem.travel.is_none() && !(problem.zones.is_empty() && problem.landing_distance_m_max.is_none());
    !flown || schedule.travel.lines_trouble(target, manoeuvre, problem.start_s, schedule.limit_s).is_none()
}

/// Returns true if order, timing, costs and paths permit this network.
pub(crate) fn serves(schedule: &Schedule<'_>) -> bool {
    let problem = schedule.problem;
    let timed = problem.targets.iter().any(|target| !target.timing.is_empty());
    let risky = problem.failure.probability_per_hour != 0.0;
    !timed && !risky && problem.precedence.is_empty() && schedule.travel.is_steady(schedule.limit_s)
}

/// Returns the greatest duration of a flight. If that would make the ticks coarse, and times are given, returns the duration of a flight
/// that waits only for windows to open.
fn span_s(schedule: &Schedule<'_>) -> f64 {
    let problem = schedule.problem;
    let span_s = schedule.limit_s - problem.start_s;
    let Some(travel) = problem.travel.as_ref().filter(|travel| span_s > FINE_SPAN_S && travel.is_constant()) else {
        return span_s;
    };
    let longest_s = |times: &mut dyn Iterator<Item = f64>| times.filter(|it| *it < UNREACHABLE_S).fold(0.0, f64::max);
    let stay_s = |target: usize| {
        let manoeuvres = problem.targets.get(target).map_or(&[][..], |target| &target.manoeuvres);
        longest_s(&mut manoeuvres.iter().map(|manoeuvre| manoeuvre.duration_s))
    };
    let into_s = |to: usize| {
        let from = travel.between_s.iter().filter_map(|row| row.get(to).copied());
        longest_s(&mut from.chain([travel.start_to(to)])) + stay_s(to)
    };
    let opens_s = problem.targets.iter().flat_map(|target| &target.windows).map(|window| window.from_s);
    let waits_s = longest_s(&mut opens_s.map(|from_s| from_s - problem.start_s));
    let flown_s: f64 = (0..problem.targets.len()).map(into_s).sum();
    let home_s = if problem.base.is_some() { longest_s(&mut travel.to_base_s.iter().copied()) } else { 0.0 };
    span_s.min(waits_s + flown_s + home_s + 1.0)
}

/// Returns true if all given times are whole ticks. Those of computed paths never are.
fn is_whole(problem: &SingleVisitProblem, limit_s: f64, tick_s: f64) -> bool {
    let Some(travel) = &problem.travel else { return false };
    let is_whole = |time_s: f64| {
        let ticks = time_s / tick_s;
        ticks.abs() >= TICKS_MAX || (ticks - libm::round(ticks)).abs() <= SAME_TICKS
    };
    let ends =
        |window: &TimeWindow| is_whole(window.from_s - problem.start_s) && is_whole(window.until_s - problem.start_s);
    let of_target = |target: &SingleVisitTarget| {
        target.light == Light::Any
            && target.windows.iter().all(ends)
            && target.manoeuvres.iter().all(|manoeuvre| is_whole(manoeuvre.duration_s))
    };
    let mut times = travel.from_start_s.iter().chain(&travel.to_base_s).chain(travel.between_s.iter().flatten());
    is_whole(limit_s - problem.start_s)
        && problem.targets.iter().all(of_target)
        && times.all(|time_s| is_whole(*time_s))
}

fn terminal_nodes(limit: i32) -> Vec<Node> {
    let terminal = |close| Node { target: u32::MAX, manoeuvre: 0, open: 0, close, value: 0.0 };
    vec![terminal(0), terminal(limit)]
}

/// Returns the finest power of ten of a second in which the flight has not too many ticks.
fn tick_s(span_s: f64) -> Option<f64> {
    let mut tick_s = 1e-6;
    while span_s / tick_s > TICKS_MAX {
        tick_s *= 10.0;
        if tick_s > 1e9 {
            return None;
        }
    }
    Some(tick_s)
}

/// Rounds up to ticks. A million legs are rounded before the first plan, so no library function is called.
#[inline(always)]
pub(crate) fn ceil_ticks(time_s: f64, tick_s: f64) -> i32 {
    ceil(time_s / tick_s)
}

/// Rounds up by additions and comparisons only, so that the compiler can vectorise it: adding and subtracting a large number rounds to
/// the nearest integer, which is in the last bits of the sum.
#[inline(always)]
fn ceil(ticks: f64) -> i32 {
    const ROUND: f64 = 6_755_399_441_055_744.0;
    let ticks = ticks.min(f64::from(NO_WAY)) - SAME_TICKS;
    let nearest = (ticks + ROUND) - ROUND;
    let above = nearest + if nearest < ticks { 1.0 } else { 0.0 };
    (above + ROUND).to_bits() as i32
}

pub(crate) fn floor_ticks(time_s: f64, tick_s: f64) -> i32 {
    libm::floor((time_s / tick_s).min(f64::from(NO_WAY))) as i32
}

/// Returns the table of legs; each includes the visit at its beginning.
fn legs(problem: &SingleVisitProblem, travel: &TravelTimes, nodes: &[Node], tick_s: f64) -> Vec<i32> {
    let duration_s = |node: &Node| {
        let target = problem.targets.get(node.target as usize);
        let manoeuvre = target.and_then(|target| target.manoeuvres.get(node.manoeuvre as usize));
        manoeuvre.map_or(0.0, |manoeuvre| manoeuvre.duration_s)
    };
    // Ticks are powers of ten: most divide a second, and multiplying is faster than dividing.
    let ticks_per_s = if tick_s < 1.0 { libm::round(1.0 / tick_s) } else { 1.0 / tick_s };
    let mut legs = vec![NO_WAY; nodes.len() * nodes.len()];
    let count = nodes.len();
    let targets: Vec<usize> = nodes.iter().skip(FIRST as usize).map(|node| node.target as usize).collect();
    // If every target is one node, in order, its ticks are copied unchanged.
    let in_order = targets.iter().enumerate().all(|(index, target)| index == *target);
    let mut ticks: Vec<i32> = Vec::new();
    for (from, data) in nodes.iter().enumerate() {
        let stay_s = if from >= FIRST as usize { duration_s(data) } else { 0.0 };
        let Some(row) = legs.get_mut(from * count..(from + 1) * count) else { continue };
        let times = match from as u32 {
            START => Some(&travel.from_start_s),
            END => None,
            _ => travel.between_s.get(data.target as usize),
        };
        let Some(times) = times else { continue };
        ticks.clear();
        ticks.extend(times.iter().map(|time_s| ceil((stay_s + time_s) * ticks_per_s)));
        if let Some(own) = ticks.get_mut(data.target as usize) {
            *own = NO_WAY;
        }
        let visits = row.get_mut(FIRST as usize..).unwrap_or_default();
        match ticks.get(..visits.len()).filter(|_| in_order) {
            Some(ticks) => visits.copy_from_slice(ticks),
            None => {
                for (slot, target) in visits.iter_mut().zip(&targets) {
                    *slot = ticks.get(*target).copied().unwrap_or(NO_WAY);
                }
            }
        }
        let home_s = match (from as u32, problem.base) {
            (START, _) | (_, None) => Some(0.0),
            _ => travel.to_base_s.get(data.target as usize).copied(),
        };
        if let Some((slot, home_s)) = row.get_mut(END as usize).zip(home_s) {
            *slot = ceil_ticks(stay_s + home_s, tick_s);
        }
    }
    legs
}
