//! The search where ways take the same time at every departure: rounds of ruin and recreation over a timetable.
//!
//! Whether a visit fits between two others, and when the route then ends, is told by three numbers a stop; so an insertion
//! is priced in a step, however long the route. Rounds of cooling follow each other, each longer than the one before and
//! from the best route so far or from a new one.
//! Bound: none but the budget; equal seed and budget give an equal route.

mod annealing;
mod network;
mod recreate;
mod route;
mod ruin;

#[cfg(test)]
mod tests;

use super::schedule::{Choice, Schedule};
use annealing::{Annealing, Round};
use apex_model::solver::Environment;
use network::Network;
use route::Route;

/// Iterations of the first round; each has half as many again as the one before.
const ROUND_ITERATIONS: u64 = 3_000;
/// Rounds in a row without gain after which the search ends.
const STALE_ROUNDS_MAX: u32 = 30;

/// The best order found within the budget; none where the problem needs the general search.
///
/// `tell` hears of each better order.
pub(super) fn run(schedule: &Schedule<'_>, usable: &[usize], environment: &mut Environment<'_>) -> Option<Vec<Choice>> {
    let network = Network::new(schedule, usable)?;
    let budget = &mut *environment.budget;
    let mut annealing = Annealing::new(&network, environment.seed);
    let mut best = annealing.first(budget);
    let mean = network.nodes.iter().map(|node| node.value).sum::<f64>() / network.visits().len().max(1) as f64;
    let (mut iterations, mut stale) = (ROUND_ITERATIONS, 0);
    while stale < STALE_ROUNDS_MAX && !budget.exhausted() {
        stale += 1;
        let start = if stale % 3 == 2 { annealing.first(budget) } else { best.clone() };
        let round = Round { iterations, hot: 0.5 * mean, cold: 0.01 * mean };
        let found = annealing.round(&start, round, budget);
        if annealing.score(&found) > annealing.score(&best) + 1e-9 {
            stale = 0;
            best = found;
        }
        iterations += iterations / 2;
    }
    Some(choices(&network, &best))
}

fn choices(network: &Network, route: &Route) -> Vec<Choice> {
    let choice = |node: u32| {
        let node = network.node(node);
        Choice { target: node.target as usize, manoeuvre: node.manoeuvre as usize, not_before_s: f64::NEG_INFINITY }
    };
    route.visits().map(choice).collect()
}
