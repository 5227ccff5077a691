//! Upper bound on the profit of any route: Lagrangian relaxation over walks that may revisit targets, one multiplier per
//! target.
//!
//! Walks go through time buckets: travel times are rounded down to the bucket, and a walk may return to a target, except
//! directly from the next one. Every visit is charged the multiplier of its target, and each multiplier is refunded once.
//! For any multipliers, their sum plus the profit of the best walk bounds every route; subgradient steps improve them. Problems
//! of few targets are then solved exactly by labels from both ends (`proof`). If walks would take too long, a knapsack of the
//! shortest legs is the only bound.
//! Bound: O(iterations x nodes squared x buckets), within the units given.

mod knapsack;
mod label_completion;
mod labels;
mod latest_departures;
pub(crate) mod ng_sets;
mod pareto_front;
mod proof;
mod subgradient;
mod value_step;
mod walk_completion;
mod walks;

use crate::routing::network::Network;
use apex_planning::solver::Budget;
use proof::{MemorySizes, ProofSearch};
use value_step::ValueStep;
use walks::Walks;

/// Maximum number of subgradient steps.
const ROUNDS_MAX: u32 = 300;
/// Steps without a better bound after which their length is halved.
const PATIENCE: u32 = 6;
/// Share of the units that labels may take before walks are tried.
const LABELS_SHARE: f64 = 0.75;
/// Up to this many targets and from this many units on, a fine pass follows if the fast pass proves nothing. The fast pass takes
/// the given share of the units, at least the given number.
pub(crate) const FEW: usize = 40;
const FINE_UNITS_MIN: u64 = 600_000;
const FAST_SHARE: f64 = 0.05;
const FAST_UNITS: u64 = 450_000;
/// Share within which a bound and the profit of a route are equal: sums are summed in any order.
const SAME_SHARE: f64 = 1e-8;
/// Steps of the walk relaxation per unit of work.
const STEPS_PER_UNIT: u64 = 120;

/// Result of a bound search.
pub(crate) struct Proven {
    /// No route has more profit.
    pub(crate) bound: f64,
    /// The visits of a route with more profit than the incumbent, if the search found one.
    pub(crate) better: Option<Vec<u32>>,
}

/// Returns the least bound found within `units`. `incumbent` is the profit of a known route.
pub(crate) fn highest_value(network: &Network, incumbent: f64, units: u64, budget: &mut dyn Budget) -> Proven {
    let mut question = BoundSearch::new(network);
    question.answer(incumbent, units, budget);
    question.told()
}

/// Search for the least upper bound on the profit of routes; can be continued.
pub(crate) struct BoundSearch<'n> {
    network: &'n Network,
    value_step: ValueStep,
    bound: f64,
    /// Profit of the best known route, and its visits if this search found it.
    incumbent: f64,
    better: Option<Vec<u32>>,
    proof: Option<ProofSearch<'n>>,
    /// Units that did not suffice for the first labels under the present multipliers.
    too_few: u64,
}

impl<'n> BoundSearch<'n> {
    pub(crate) fn new(network: &'n Network) -> BoundSearch<'n> {
        BoundSearch {
            network,
            value_step: ValueStep::new(network),
            bound: knapsack::bound(network),
            incumbent: f64::NEG_INFINITY,
            better: None,
            proof: None,
            too_few: 0,
        }
    }

    /// Returns the bound, and takes the better route out.
    pub(crate) fn told(&mut self) -> Proven {
        let bound = self.value_step.below(self.bound);
        // A rounding error is removed; a bound that is truly below a known route is a contradiction and is not hidden.
        let is_same = bound < self.incumbent && self.incumbent - bound <= SAME_SHARE * (1.0 + self.incumbent.abs());
        Proven { bound: if is_same { self.incumbent } else { bound }, better: self.better.take() }
    }

    /// Returns true if no route has more profit than the incumbent.
    fn is_settled(&self) -> bool {
        self.value_step.below(self.bound) <= self.incumbent
    }

    /// Runs labels alone for `units`: they often solve the problem early, or fail at once. `incumbent` is the profit of a known route.
    pub(crate) fn ask_labels(&mut self, incumbent: f64, units: u64, budget: &mut dyn Budget) {
        self.incumbent = self.incumbent.max(incumbent);
        self.label(budget.used().saturating_add(units), budget);
    }

    /// Runs labels and walks for `units`: a fast pass, then a fine pass for few targets if the fast pass proves nothing.
    pub(crate) fn answer(&mut self, incumbent: f64, units: u64, budget: &mut dyn Budget) {
        let until = budget.used().saturating_add(units);
        self.incumbent = self.incumbent.max(incumbent);
        if self.network.targets > FEW || units < FINE_UNITS_MIN {
            self.fast_pass(units, budget);
            return;
        }
        let multipliers = self.fast_pass(FAST_UNITS.max((FAST_SHARE * units as f64) as u64), budget);
        if let Some(proof) = &mut self.proof {
            proof.restart_fine(multipliers);
        }
        self.too_few = 0;
        self.label(until, budget);
    }

    /// Runs labels for most of `units`, then walks; if the first labels took too long, labels again under the multipliers of the
    /// walks. Returns these multipliers.
    fn fast_pass(&mut self, units: u64, budget: &mut dyn Budget) -> Option<Vec<f64>> {
        let until = budget.used().saturating_add(units);
        let may_be_labelled = self.network.targets <= ng_sets::TARGETS_MAX;
        if may_be_labelled {
            self.label(budget.used().saturating_add((LABELS_SHARE * units as f64) as u64), budget);
        }
        let left = until.saturating_sub(budget.used());
        let multipliers = self.walk(if may_be_labelled { left / 2 } else { left }, budget);
        if let Some((proof, multipliers)) = self.proof.as_mut().zip(multipliers.clone()).filter(|_| self.too_few > 0) {
            proof.begin_with(multipliers);
            self.too_few = 0;
        }
        self.label(until, budget);
        multipliers
    }

    /// Runs walks for `units`. Returns their multipliers; `None` if walks could not begin.
    fn walk(&mut self, units: u64, budget: &mut dyn Budget) -> Option<Vec<f64>> {
        if self.is_settled() || budget.exhausted() {
            return None;
        }
        let mut walks = Walks::new(self.network, units.saturating_mul(STEPS_PER_UNIT) / 40)?;
        let known = (self.bound, self.incumbent);
        let (bound, multipliers) = best_multipliers(self.network, &mut walks, known, (units, self.value_step), budget);
        self.bound = self.bound.min(bound);
        Some(multipliers)
    }

    fn label(&mut self, until: u64, budget: &mut dyn Budget) {
        let units = until.saturating_sub(budget.used());
        if self.is_settled() || units <= self.too_few || budget.exhausted() {
            return;
        }
        if self.proof.is_none() {
            let needed = ProofSearch::units_to_begin(self.network);
            if needed > units / 4 {
                return;
            }
            budget.charge(needed);
            self.proof = ProofSearch::new(self.network, self.bound, MemorySizes::SHIPPED);
        }
        let Some(proof) = &mut self.proof else { return };
        if !proof.run(self.incumbent, until, budget) {
            self.too_few = units;
        }
        let Proven { bound, better } = proof.known();
        self.bound = self.bound.min(*bound);
        if let Some(route) = better {
            self.incumbent =
                proof::value_of(self.network, route).map_or(self.incumbent, |value| value.max(self.incumbent));
            self.better = Some(route.clone());
        }
    }
}

/// Improves multipliers for `units` by subgradient steps. Returns the least bound and its multipliers.
fn best_multipliers(
    network: &Network,
    walks: &mut Walks,
    (mut best, incumbent): (f64, f64),
    (units, value_step): (u64, ValueStep),
    budget: &mut dyn Budget,
) -> (f64, Vec<f64>) {
    let until = budget.used().saturating_add(units);
    let mut multipliers = vec![0.0; network.targets];
    let mut kept = multipliers.clone();
    let (mut share, mut stale) = (1.0, 0);
    for _ in 0..ROUNDS_MAX {
        if budget.used() >= until || budget.exhausted() {
            break;
        }
        let (value, steps) = walks.best(network, &multipliers);
        budget.charge(1 + steps / STEPS_PER_UNIT);
        let bound = value + multipliers.iter().sum::<f64>();
        if bound < best - 1e-6 * best.abs() {
            (best, stale) = (bound, 0);
            kept.clone_from(&multipliers);
            if value_step.below(best) <= incumbent {
                break;
            }
        } else {
            stale += 1;
            if stale >= PATIENCE {
                (share, stale) = (0.5 * share, 0);
            }
        }
        if !step(&mut multipliers, walks.counts(), share * (bound - incumbent).max(0.0)) {
            break;
        }
    }
    (best, kept)
}

/// Moves multipliers along the subgradient: up for targets visited too often, down for targets not visited. Returns false if
/// the subgradient is zero.
fn step(multipliers: &mut [f64], counts: &[u32], gap: f64) -> bool {
    let over = |price: f64, count: u32| if count == 0 && price <= 0.0 { 0.0 } else { f64::from(count) - 1.0 };
    let norm: f64 =
        multipliers.iter().zip(counts).map(|(price, count)| over(*price, *count) * over(*price, *count)).sum();
    if norm <= 0.0 || gap <= 0.0 {
        return false;
    }
    for (price, count) in multipliers.iter_mut().zip(counts) {
        *price = (*price + gap / norm * over(*price, *count)).max(0.0);
    }
    true
}

/// Returns the reduced profit of a visit of each node: its value less the multiplier of its target.
fn reduced_profits(network: &Network, multipliers: &[f64]) -> Vec<f64> {
    let price = |target: u32| multipliers.get(target as usize).copied().unwrap_or(0.0);
    network.nodes.iter().map(|node| node.value - price(node.target)).collect()
}

#[cfg(test)]
mod tests;
