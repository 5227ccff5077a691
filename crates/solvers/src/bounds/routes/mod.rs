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
pub(crate) mod memory;
mod prices;
mod proof;
mod rest;
mod walks;

use crate::planners::single_visit::steady::network::Network;
use apex_planning::solver::Budget;
use grain::Grain;
use proof::Proof;
use walks::Walks;

/// Rounds of prices.
const ROUNDS_MAX: u32 = 300;
/// Rounds without a better bound after which steps are halved.
const PATIENCE: u32 = 6;
/// Share of the units that labels may take before walks are asked.
const LABELS_SHARE: f64 = 0.75;
/// So few targets are settled with care where a hurry was not enough, and with so many units: those left by the hurry, which
/// takes this share of them, or as many.
pub(crate) const FEW: usize = 40;
const CARE_UNITS_MIN: u64 = 600_000;
const HURRY_SHARE: f64 = 0.05;
const HURRY_UNITS: u64 = 450_000;
/// Steps of a walk that are looked at for one unit of work.
const STEPS_PER_UNIT: u64 = 120;

/// What is known of the most that a route can be worth.
pub(crate) struct Proven {
    /// No route is worth more.
    pub(crate) bound: f64,
    /// The visits of a route that is worth more than what was reached, if one was found on the way.
    pub(crate) better: Option<Vec<u32>>,
}

/// The least bound found within `units`. `reached` is what some route is worth.
pub(crate) fn highest_value(network: &Network, reached: f64, units: u64, budget: &mut dyn Budget) -> Proven {
    let mut question = Question::new(network);
    question.answer(reached, units, budget);
    question.told()
}

/// The question what routes are worth at most, on its way to an answer.
pub(crate) struct Question<'n> {
    network: &'n Network,
    grain: Grain,
    bound: f64,
    /// What some route is worth, and that route where the question's own work has found it.
    reached: f64,
    better: Option<Vec<u32>>,
    proof: Option<Proof<'n>>,
    /// Units that were not enough for the first labels under the prices known.
    too_few: u64,
}

impl<'n> Question<'n> {
    pub(crate) fn new(network: &'n Network) -> Question<'n> {
        Question {
            network,
            grain: Grain::new(network),
            bound: knapsack::bound(network),
            reached: f64::NEG_INFINITY,
            better: None,
            proof: None,
            too_few: 0,
        }
    }

    /// Takes what was found, and forgets the better route.
    pub(crate) fn told(&mut self) -> Proven {
        Proven { bound: self.grain.below(self.bound).max(self.reached), better: self.better.take() }
    }

    /// Is no route worth more than what is reached?
    fn is_settled(&self) -> bool {
        self.grain.below(self.bound) <= self.reached
    }

    /// Asks labels alone, for `units`: often they settle it soon, else they hardly begin. `reached` is what some route is
    /// worth.
    pub(crate) fn ask_labels(&mut self, reached: f64, units: u64, budget: &mut dyn Budget) {
        self.reached = self.reached.max(reached);
        self.label(budget.used().saturating_add(units), budget);
    }

    /// Asks labels and walks, for `units`: in a hurry, and what few targets leave open with care.
    pub(crate) fn answer(&mut self, reached: f64, units: u64, budget: &mut dyn Budget) {
        let until = budget.used().saturating_add(units);
        self.reached = self.reached.max(reached);
        if self.network.targets > FEW || units < CARE_UNITS_MIN {
            self.hurry(units, budget);
            return;
        }
        let prices = self.hurry(HURRY_UNITS.max((HURRY_SHARE * units as f64) as u64), budget);
        if let Some(proof) = &mut self.proof {
            proof.begin_with_care(prices);
        }
        self.too_few = 0;
        self.label(until, budget);
    }

    /// Asks labels, for most of `units`, then walks; and labels again, under the prices that walks have found, where they took
    /// too long before. Tells those prices.
    fn hurry(&mut self, units: u64, budget: &mut dyn Budget) -> Option<Vec<f64>> {
        let until = budget.used().saturating_add(units);
        let may_be_labelled = self.network.targets <= memory::TARGETS_MAX;
        if may_be_labelled {
            self.label(budget.used().saturating_add((LABELS_SHARE * units as f64) as u64), budget);
        }
        let left = until.saturating_sub(budget.used());
        let prices = self.walk(if may_be_labelled { left / 2 } else { left }, budget);
        if let Some((proof, prices)) = self.proof.as_mut().zip(prices.clone()).filter(|_| self.too_few > 0) {
            proof.begin_with(prices);
            self.too_few = 0;
        }
        self.label(until, budget);
        prices
    }

    /// Asks walks, for `units`: the prices that they have found, if they could begin.
    fn walk(&mut self, units: u64, budget: &mut dyn Budget) -> Option<Vec<f64>> {
        if self.is_settled() || budget.exhausted() {
            return None;
        }
        let mut walks = Walks::new(self.network, units.saturating_mul(STEPS_PER_UNIT) / 40)?;
        let known = (self.bound, self.reached);
        let (bound, prices) = best_prices(self.network, &mut walks, known, (units, self.grain), budget);
        self.bound = self.bound.min(bound);
        Some(prices)
    }

    fn label(&mut self, until: u64, budget: &mut dyn Budget) {
        let units = until.saturating_sub(budget.used());
        if self.is_settled() || units <= self.too_few || budget.exhausted() {
            return;
        }
        if self.proof.is_none() {
            let needed = Proof::units_to_begin(self.network);
            if needed > units / 4 {
                return;
            }
            budget.charge(needed);
            self.proof = Proof::new(self.network, self.bound);
        }
        let Some(proof) = &mut self.proof else { return };
        if !proof.run(self.reached, until, budget) {
            self.too_few = units;
        }
        let Proven { bound, better } = proof.known();
        self.bound = self.bound.min(*bound);
        if let Some(route) = better {
            self.reached = proof::value_of(self.network, route).map_or(self.reached, |value| value.max(self.reached));
            self.better = Some(route.clone());
        }
    }
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
