//! Rounds of ruin and recreation with cooling.

use super::network::Network;
use super::recreate::Recreation;
use super::route::Route;
use super::ruin::ruin;
use crate::random::Generator;
use apex_model::solver::Budget;

/// Places looked at for one unit of work, which is about a microsecond.
const PLACES_PER_UNIT: u64 = 150;
/// Work of an iteration whatever its size.
const UNITS_PER_ITERATION: u64 = 1;

/// A search in progress.
pub(super) struct Annealing<'n> {
    network: &'n Network,
    chance: Generator,
    recreation: Recreation,
    /// How easily each node is reached: one over the mean way to its nearest neighbours.
    ease: Vec<f64>,
    /// What a tick of flight counts beside its cost, so that of equal routes the shorter is kept.
    thrift: f64,
}

/// How long a round is and how it cools.
#[derive(Clone, Copy, Debug)]
pub(super) struct Round {
    pub(super) iterations: u64,
    /// Temperatures in units of value.
    pub(super) hot: f64,
    pub(super) cold: f64,
}

impl<'n> Annealing<'n> {
    pub(super) fn new(network: &'n Network, seed: u64) -> Annealing<'n> {
        let ease = (0..network.nodes.len() as u32).map(|node| ease(network, node)).collect();
        let values: f64 = network.nodes.iter().map(|node| node.value).sum();
        // All of the time is worth a tenth of a mean visit.
        let mean = values / network.visits().len().max(1) as f64;
        let thrift = 0.3 * mean / f64::from(network.limit().max(1));
        Annealing { network, chance: Generator::new(seed), recreation: Recreation::default(), ease, thrift }
    }

    /// Benefits minus costs.
    pub(super) fn score(&self, route: &Route) -> f64 {
        route.value - self.network.cost_per_tick * f64::from(route.end())
    }

    fn energy(&self, route: &Route) -> f64 {
        self.score(route) - self.thrift * f64::from(route.length())
    }

    /// A route by insertion alone.
    pub(super) fn first(&mut self, budget: &mut dyn Budget) -> Route {
        let mut route = Route::new(self.network);
        self.fill(&mut route, budget);
        route
    }

    /// Inserts what fits.
    pub(super) fn fill(&mut self, route: &mut Route, budget: &mut dyn Budget) {
        let missing = self.network.visits();
        let looked = self.recreation.run(self.network, route, missing, &self.ease, &mut self.chance);
        budget.charge(UNITS_PER_ITERATION + looked / PLACES_PER_UNIT);
    }

    /// One round from `start`: the best route that it saw.
    pub(super) fn round(&mut self, start: &Route, round: Round, budget: &mut dyn Budget) -> Route {
        let mut current = start.clone();
        let mut best = start.clone();
        let (mut now, mut highest) = (self.energy(&current), self.energy(&best));
        let cooling = libm::pow(round.cold / round.hot, 1.0 / round.iterations.max(1) as f64);
        let mut heat = round.hot;
        for _ in 0..round.iterations {
            if budget.exhausted() {
                break;
            }
            heat *= cooling;
            let mut next = current.clone();
            ruin(self.network, &mut next, &mut self.chance);
            self.fill(&mut next, budget);
            let energy = self.energy(&next);
            if energy > now + heat * libm::log(self.chance.unit().max(1e-12)) {
                (current, now) = (next, energy);
                if now > highest {
                    (best, highest) = (current.clone(), now);
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
