//! What no route can be worth more than: walks that may see a target again, with a price on every visit.
//!
//! Routes are relaxed to walks through time: a walk may come back to a target, though not at once from the next, and times
//! are rounded down to the bucket they lie in. A price on each target, to be paid at every visit and given back once, keeps
//! walks from coming back: whatever the prices, `prices + best walk` bounds every route (a Lagrange relaxation), and prices
//! are moved towards what the best walk visits too often. Few targets are then settled by labels that remember where they
//! have been, from both ends (`proof`). Where walks would take too long, a knapsack of the shortest legs is all there is.
//! Bound: O(rounds x nodes squared x buckets), within the units given.

mod completion;
mod front;
mod grain;
mod knapsack;
mod labels;
mod late;
mod memory;
mod prices;
mod proof;
mod rest;
mod walks;

use super::network::Network;
use apex_model::solver::Budget;
use grain::Grain;
use walks::Walks;

/// Rounds of prices.
const ROUNDS_MAX: u32 = 300;
/// Rounds without a better bound after which steps are halved.
const PATIENCE: u32 = 6;
/// Units of work for prices of walks where labels follow.
const WALK_UNITS_MAX_OF_FEW: u64 = 100_000;
/// Steps of a walk that are looked at for one unit of work.
const STEPS_PER_UNIT: u64 = 120;

/// What is known of the most that a route can be worth.
pub(super) struct Proven {
    /// No route is worth more.
    pub(super) bound: f64,
    /// The visits of a route that is worth more than what was reached, if one was found on the way.
    pub(super) better: Option<Vec<u32>>,
}

/// The least bound found within `units`. `reached` is what some route is worth.
pub(super) fn highest_value(network: &Network, reached: f64, units: u64, budget: &mut dyn Budget) -> Proven {
    let until = budget.used().saturating_add(units);
    let grain = Grain::new(network);
    let settled = |bound: f64| Proven { bound: grain.below(bound).max(reached), better: None };
    let quick = knapsack::bound(network);
    if grain.below(quick) <= reached {
        return settled(quick);
    }
    let few = network.targets <= memory::TARGETS_MAX;
    // Where labels can settle it, prices need not be the best.
    let for_prices = if few { (units / 4).min(WALK_UNITS_MAX_OF_FEW) } else { units };
    let walks = Walks::new(network, for_prices.saturating_mul(STEPS_PER_UNIT) / 40);
    let (best, prices) = match walks {
        Some(mut walks) => best_prices(network, &mut walks, (quick, reached), (for_prices, grain), budget),
        None => (quick, vec![0.0; network.targets]),
    };
    if !few || grain.below(best) <= reached || budget.exhausted() {
        return settled(best);
    }
    let Proven { bound, better } = proof::best(network, prices, (best, reached), (until, budget));
    Proven { bound: grain.below(bound).max(reached), better }
}

/// Moves prices for `units`: the least bound, and the prices that it was found with.
fn best_prices(
    network: &Network,
    walks: &mut Walks,
    (mut best, reached): (f64, f64),
    (units, grain): (u64, Grain),
    budget: &mut dyn Budget,
) -> (f64, Vec<f64>) {
    let until = budget.used().saturating_add(units);
    let mut prices = vec![0.0; network.targets];
    let mut kept = prices.clone();
    let (mut share, mut stale) = (1.0, 0);
    for _ in 0..ROUNDS_MAX {
        if budget.used() >= until || budget.exhausted() {
            break;
        }
        let (value, steps) = walks.best(network, &prices);
        budget.charge(1 + steps / STEPS_PER_UNIT);
        let bound = value + prices.iter().sum::<f64>();
        if bound < best - 1e-6 * best.abs() {
            (best, stale) = (bound, 0);
            kept.clone_from(&prices);
            if grain.below(best) <= reached {
                break;
            }
        } else {
            stale += 1;
            if stale >= PATIENCE {
                (share, stale) = (0.5 * share, 0);
            }
        }
        if !step(&mut prices, walks.counts(), share * (bound - reached).max(0.0)) {
            break;
        }
    }
    (best, kept)
}

/// Moves prices along what a walk visits too often or not at all; false where there is nowhere to go.
fn step(prices: &mut [f64], counts: &[u32], gap: f64) -> bool {
    let over = |price: f64, count: u32| if count == 0 && price <= 0.0 { 0.0 } else { f64::from(count) - 1.0 };
    let norm: f64 = prices.iter().zip(counts).map(|(price, count)| over(*price, *count) * over(*price, *count)).sum();
    if norm <= 0.0 || gap <= 0.0 {
        return false;
    }
    for (price, count) in prices.iter_mut().zip(counts) {
        *price = (*price + gap / norm * over(*price, *count)).max(0.0);
    }
    true
}

/// What a visit of each node is worth after its price.
fn worths(network: &Network, prices: &[f64]) -> Vec<f64> {
    let price = |target: u32| prices.get(target as usize).copied().unwrap_or(0.0);
    network.nodes.iter().map(|node| node.value - price(node.target)).collect()
}

#[cfg(test)]
mod tests;
