//! Annealing runs of ruin and recreate.

use super::recreate::Recreation;
use super::route::Route;
use super::ruin::ruin;
use super::turn;
use crate::routing::network::Network;
use apex_planning::random::Generator;
use apex_planning::solver::Budget;

/// Examined positions per unit of work, which is about a microsecond.
const LOOKS_PER_UNIT: u64 = 230;
/// Fixed work of an iteration, in examined positions: random choices, and copies and timetables of this many stops.
const LOOKS_PER_ITERATION: u64 = 60;
const LOOKS_PER_STOP: u64 = 2;
/// Weight of the total time, as a share of a mean visit, so that of equal routes the shorter one is kept.
const THRIFT: f64 = 0.3;
/// Share of all values within which scores are equal.
const SAME_SHARE: f64 = 1e-10;
/// Iterations at one temperature.
const STEP: u64 = 32;
/// Number of missing nodes above which only those near the removed ones are inserted again.
pub(super) const ALL_MISSING_MAX: usize = 160;
/// Number of reversals that are tried for each ruin, with few targets and with many.
const TURNS: u32 = 1;
const TURNS_OF_MANY: u32 = 6;
/// Neighbours of each visit taken out that are tried.
const TRIED_NEAR: usize = 8;

/// A search in progress.
pub(super) struct Annealing<'n> {
    network: &'n Network,
    rng: Generator,
    recreation: Recreation,
    /// Examined positions that are not charged yet.
    looked: u64,
    gone: Vec<u32>,
    missing: Vec<u32>,
    /// Ease of reaching each node: the reciprocal of the mean path to its nearest neighbours.
    ease: Vec<f64>,
    /// Weight of a tick of flight in addition to its cost, so that of equal routes the shorter one is kept.
    thrift: f64,
    /// Scores that differ by no more than this are equal: sums are summed in any order.
    same: f64,
}

/// Length and temperatures of a round.
#[derive(Clone, Copy, Debug)]
pub(super) struct Round {
    /// Units of work.
    pub(super) units: u64,
    /// Temperatures in units of value.
    pub(super) hot: f64,
    pub(super) cold: f64,
}

impl<'n> Annealing<'n> {
    pub(super) fn new(network: &'n Network, seed: u64) -> Annealing<'n> {
        let ease = (0..network.nodes.len() as u32).map(|node| ease(network, node)).collect();
        let values: f64 = network.nodes.iter().map(|node| node.value).sum();
        let mean = values / network.visits().len().max(1) as f64;
        let thrift = THRIFT * mean / f64::from(network.limit().max(1));
        Annealing {
            network,
            rng: Generator::new(seed),
            recreation: Recreation::default(),
            looked: 0,
            gone: Vec::new(),
            missing: Vec::new(),
            ease,
            thrift,
            same: SAME_SHARE * values,
        }
    }

    /// Returns benefits minus costs.
    pub(super) fn score(&self, route: &Route) -> f64 {
        route.value - self.network.cost_per_tick * f64::from(route.end())
    }

    /// Returns true if `route` has a higher score than `other`, or the same score and is shorter.
    pub(super) fn is_better(&self, route: &Route, other: &Route) -> bool {
        let more = self.score(route) - self.score(other);
        more > self.same || more > -self.same && route.length() < other.length()
    }

    fn energy(&self, route: &Route) -> f64 {
        self.score(route) - self.thrift * f64::from(route.length())
    }

    /// Returns a route by insertion alone.
    pub(super) fn first(&mut self, budget: &mut dyn Budget) -> Route {
        let mut route = Route::new(self.network);
        self.fill_all(&mut route, budget);
        route
    }

    /// Inserts all missing nodes that fit and are worthwhile.
    pub(super) fn fill_all(&mut self, route: &mut Route, budget: &mut dyn Budget) {
        self.missing.clear();
        self.missing.extend(self.network.visits());
        self.fill(route, false, budget);
    }

    /// Inserts missing nodes that fit.
    fn fill(&mut self, route: &mut Route, may_be_generous: bool, budget: &mut dyn Budget) {
        let looked =
            self.recreation.run(self.network, route, &self.missing, &self.ease, may_be_generous, &mut self.rng);
        self.looked += looked + LOOKS_PER_ITERATION + LOOKS_PER_STOP * route.stops.len() as u64;
        budget.charge(self.looked / LOOKS_PER_UNIT);
        self.looked %= LOOKS_PER_UNIT;
    }

    /// Chooses the nodes that may be inserted after others were removed.
    fn choose_missing(&mut self, route: &Route) {
        self.missing.clear();
        let visits = self.network.visits();
        if visits.len() <= ALL_MISSING_MAX {
            let mut bits = 1;
            for node in visits {
                // One random bit per node; a leading bit marks when all bits are used.
                if bits == 1 {
                    bits = self.rng.bits() | 1 << 63;
                }
                let chosen = bits & 1 == 0;
                bits >>= 1;
                if !route.sees(self.network, node) && (chosen || self.gone.contains(&node)) {
                    self.missing.push(node);
                }
            }
            return;
        }
        for node in &self.gone {
            let near = self.network.near.get(*node as usize).into_iter().flatten().take(TRIED_NEAR);
            self.missing.extend([*node].into_iter().chain(near.copied()));
        }
        for _ in 0..2 {
            self.missing.push(visits.start + self.rng.below(visits.len()) as u32);
        }
        self.missing.retain(|node| !route.sees(self.network, *node));
        self.missing.sort_unstable();
        self.missing.dedup();
    }

    /// Runs one round from `start`; returns the best route found in it.
    pub(super) fn round(&mut self, start: &Route, round: Round, budget: &mut dyn Budget) -> Route {
        let mut current = start.clone();
        let mut best = start.clone();
        let mut next = start.clone();
        let mut now = self.energy(&current);
        let begin = budget.used();
        let mut heat = round.hot;
        let turns = if self.network.visits().len() <= ALL_MISSING_MAX { TURNS } else { TURNS_OF_MANY };
        for iteration in 0_u64.. {
            if iteration % STEP == 0 {
                let share = (budget.used() - begin) as f64 / round.units.max(1) as f64;
                if share >= 1.0 || budget.exhausted() {
                    break;
                }
                heat = round.hot * libm::pow(round.cold / round.hot, share);
            }
            for _ in 0..turns {
                let accept = heat * libm::log(self.rng.unit().max(1e-12));
                let price = self.thrift;
                let timed = turn::try_one(self.network, &mut current, price, accept, &mut self.rng);
                // With few targets a run is short, and the work of an iteration covers it.
                if turns > TURNS {
                    self.looked += timed;
                }
                now = self.energy(&current);
            }
            next.clone_from(&current);
            ruin(self.network, &mut next, &mut self.gone, &mut self.rng);
            self.choose_missing(&next);
            self.fill(&mut next, true, budget);
            let energy = self.energy(&next);
            if energy > now + heat * libm::log(self.rng.unit().max(1e-12)) {
                std::mem::swap(&mut current, &mut next);
                now = energy;
                if self.is_better(&current, &best) {
                    best.clone_from(&current);
                }
            }
        }
        best
    }
}

fn ease(network: &Network, node: u32) -> f64 {
    let near = network.near.get(node as usize).map_or(&[][..], Vec::as_slice);
    let ways = near.iter().take(6).map(|other| f64::from(network.leg(node, *other)));
    let count = near.len().clamp(1, 6) as f64;
    1.0 / (1.0 + ways.sum::<f64>() / count)
}
