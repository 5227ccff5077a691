//! Proven lower bounds on the expected cost of ignorance (paper, section II.A; ours beyond it): no plan costs less.
//!
//! Three ways, the greatest value counts. [`price`] puts a price on time and lets every target answer to it alone: some
//! microseconds, weak where targets lie in groups. [`absences`] is a linear program over how often each leg is flown, in which
//! groups of targets are unobserved together while the vehicle is elsewhere: some tenths of a second for 16 targets.
//! [`ages`] goes backwards in time over a grid of the ages of all targets, which are few, and bounds flights that never wait: a
//! second or two, and near to the best. The others bound all flights.
//! Each bound brings its proof, whose value [`verified`] computes again without the solver that found it.

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

/// A bound with what proves it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// No plan costs less; with a proof by ages, none that never waits.
    pub expected_cost: f64,
    /// Proof of the bound.
    pub proof: Proof,
}

/// Proof of a bound.
#[derive(Clone, Debug, PartialEq)]
pub enum Proof {
    /// Least expected cost that one more second of flight would save.
    PricePerSecond(f64),
    /// Multipliers of the rows of the program of absences.
    RevisitGaps(revisit_gaps::Multipliers),
    /// All flights that never wait were evaluated backwards over a grid of ages with this resolution.
    AgeGrid(age_grid::horizon::GridResolution),
}

/// States in a plan of surveillance a bound of any plan, where the plan has none or claims less, by the price of time:
/// in little time, as in flight. Plans of single visits bring their bounds.
///
/// # Errors
/// The bound contradicts the plan, which then states none.
pub fn state(problem: &Problem, plan: &mut Plan) -> Result<(), Contradiction> {
    state_at_least(problem, plan, |problem| price::expected_cost(&simplified(problem)).expected_cost)
}

/// States `bound` in a plan of surveillance, unless the plan claims a greater one.
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

/// Returns the best bound found of plans that never wait. `problem` makes sense (`validate::surveillance`).
pub fn expected_cost_without_waiting(problem: &SurveillanceProblem) -> Bound {
    expected_cost_without_waiting_within(problem, &mut Meter::new(&mut WorkBudget::new(u64::MAX)))
}

/// Like [`expected_cost_without_waiting`], with what the budget is enough for.
pub fn expected_cost_without_waiting_within(problem: &SurveillanceProblem, meter: &mut Meter<'_>) -> Bound {
    let of_all = expected_cost_within(problem, meter);
    match age_grid::horizon::expected_cost(&rates::held(problem), meter) {
        Some((expected_cost, look)) if expected_cost > of_all.expected_cost => {
            Bound { expected_cost, proof: Proof::AgeGrid(look) }
        }
        _ => of_all,
    }
}

/// Returns the best bound found of all plans. `problem` makes sense (`validate::surveillance`).
pub fn expected_cost(problem: &SurveillanceProblem) -> Bound {
    expected_cost_within(problem, &mut Meter::new(&mut WorkBudget::new(u64::MAX)))
}

/// Like [`expected_cost`], with what the budget is enough for. The meter says that something was left undone where rates change before
/// the horizon: each counts at its least.
pub fn expected_cost_within(problem: &SurveillanceProblem, meter: &mut Meter<'_>) -> Bound {
    let problem = &*simplified(problem);
    if rates::change(problem) {
        // Every rate counts at its least: what changes would prove more is left undone.
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

/// Returns the problem with the least time of each leg over all departures, and with the rates that hold until the horizon. Its plans are
/// more than those of the problem: a slow leg is a fast one and a wait, which no bound here forbids.
fn simplified(problem: &SurveillanceProblem) -> Cow<'_, SurveillanceProblem> {
    let held = rates::held(problem);
    if problem.travel.is_constant() {
        return held;
    }
    Cow::Owned(SurveillanceProblem { travel: problem.travel.least(), ..held.into_owned() })
}

/// Returns what the proof proves for `problem`, computed again: any numbers prove something, good ones much.
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
