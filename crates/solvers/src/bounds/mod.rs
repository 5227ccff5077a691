//! Proven lower bounds on the expected cost of ignorance (paper, section II.A; the bounds are an addition to it): no plan costs less.
//!
//! Three methods exist, and the greatest bound counts. [`price`] puts a price on time and lets every target respond to it independently:
//! some microseconds; weak if targets are clustered. [`revisit_gaps`] is a linear program over the number of times each leg is flown, in
//! which groups of targets are unobserved together while the vehicle is elsewhere: some tenths of a second for 16 targets. [`age_grid`]
//! is a dynamic program backwards in time over a grid of the ages of all targets, for few targets and flights that never wait: a second
//! or two, and tight. The first two bound all flights. Each bound has a certificate whose value [`verified`] computes again without the
//! solver that found it.

pub mod age_grid;
mod contradiction;
mod least;
pub mod price;
mod rates;
pub mod revisit_gaps;
pub(crate) mod routes;
pub mod tour;

pub use contradiction::Contradiction;

use apex_model::problem::{Plan, Problem, SurveillanceProblem};
use apex_planning::meter::Meter;
use apex_planning::solver::WorkBudget;
use std::borrow::Cow;

/// A bound with its certificate.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// No plan costs less; with a proof by [`Proof::AgeGrid`], no plan that never waits costs less.
    pub expected_cost: f64,
    /// Proof of the bound.
    pub proof: Proof,
}

/// Proof of a bound.
#[derive(Clone, Debug, PartialEq)]
pub enum Proof {
    /// Least expected cost that one more second of flight would save.
    PricePerSecond(f64),
    /// Multipliers of the rows of the linear program in [`revisit_gaps`].
    RevisitGaps(revisit_gaps::Multipliers),
    /// All flights that never wait were evaluated backwards over a grid of ages with this resolution.
    AgeGrid(age_grid::horizon::GridResolution),
}

/// Adds a bound to a surveillance plan, by the price of time, if the plan has none or a weaker one; fast enough for flights. Single-visit
/// plans contain their bounds already.
///
/// # Errors
/// [`Contradiction`] if the bound contradicts the plan, which then states no bound.
pub fn state(problem: &Problem, plan: &mut Plan) -> Result<(), Contradiction> {
    state_at_least(problem, plan, |problem| price::expected_cost(&simplified(problem)).expected_cost)
}

/// Stores `bound` in a surveillance plan, unless the plan has a greater one.
///
/// # Errors
/// Like [`state`].
pub(crate) fn state_at_least(
    problem: &Problem,
    plan: &mut Plan,
    bound: impl FnOnce(&SurveillanceProblem) -> f64,
) -> Result<(), Contradiction> {
    if let (Problem::Surveillance(problem), Plan::Surveillance(plan)) = (problem, &mut *plan) {
        let found = bound(problem);
        plan.expected_cost_bound = Some(plan.expected_cost_bound.map_or(found, |claimed| claimed.max(found)));
    }
    contradiction::check(problem, plan)
}

/// Returns the best bound found for plans that never wait. `problem` must be valid (`validate::surveillance`).
pub fn expected_cost_without_waiting(problem: &SurveillanceProblem) -> Bound {
    expected_cost_without_waiting_within(problem, &mut Meter::new(&mut WorkBudget::new(u64::MAX)))
}

/// Like [`expected_cost_without_waiting`], within the budget of `meter`.
pub fn expected_cost_without_waiting_within(problem: &SurveillanceProblem, meter: &mut Meter<'_>) -> Bound {
    let of_all = expected_cost_within(problem, meter);
    match age_grid::horizon::expected_cost(&rates::held(problem), meter) {
        Some((expected_cost, look)) if expected_cost > of_all.expected_cost => {
            Bound { expected_cost, proof: Proof::AgeGrid(look) }
        }
        _ => of_all,
    }
}

/// Returns the best bound found for all plans. `problem` must be valid (`validate::surveillance`).
pub fn expected_cost(problem: &SurveillanceProblem) -> Bound {
    expected_cost_within(problem, &mut Meter::new(&mut WorkBudget::new(u64::MAX)))
}

/// Like [`expected_cost`], within the budget of `meter`. If rates change before the horizon, each counts at its least value, and the
/// meter reports that the bound is incomplete.
pub fn expected_cost_within(problem: &SurveillanceProblem, meter: &mut Meter<'_>) -> Bound {
    let problem = &*simplified(problem);
    if rates::change(problem) {
        // Every rate counts at its least value: a proof that uses the changes does not exist.
        meter.cut();
    }
    let of_price = price::expected_cost(problem);
    meter.spend(price::TARGET_NS * problem.targets.len() as f64);
    let by_price = Bound { expected_cost: of_price.expected_cost, proof: Proof::PricePerSecond(of_price.price_per_s) };
    match revisit_gaps::expected_cost(problem, meter) {
        Some((expected_cost, multipliers)) if expected_cost > by_price.expected_cost => {
            Bound { expected_cost, proof: Proof::RevisitGaps(multipliers) }
        }
        _ => by_price,
    }
}

/// Returns the problem with the least time of each leg over all departures, and with the rates up to the horizon. It admits all plans of
/// the original problem: a slow leg is a fast one followed by a wait, which no bound here forbids.
fn simplified(problem: &SurveillanceProblem) -> Cow<'_, SurveillanceProblem> {
    let held = rates::held(problem);
    if problem.travel.is_constant() {
        return held;
    }
    Cow::Owned(SurveillanceProblem { travel: problem.travel.least(), ..held.into_owned() })
}

/// Returns the bound that the certificate proves for `problem`, computed again: arbitrary numbers prove a valid but weak bound.
pub fn verified(problem: &SurveillanceProblem, proof: &Proof) -> f64 {
    let quickest = &*simplified(problem);
    match proof {
        Proof::PricePerSecond(price_per_s) => price::at_price(quickest, *price_per_s),
        Proof::RevisitGaps(multipliers) => revisit_gaps::verified(quickest, multipliers),
        Proof::AgeGrid(look) => age_grid::horizon::expected_cost_at(&rates::held(problem), *look).unwrap_or(0.0),
    }
}

#[cfg(test)]
mod tests;
