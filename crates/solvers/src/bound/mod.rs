//! Proven lower bounds on the expected cost of ignorance (paper, section II.A; ours beyond it): no plan costs less.
//!
//! Two ways, the greater value counts. [`price`] puts a price on time and lets every target answer to it alone: some
//! microseconds, weak where targets lie in groups. [`absences`] is a linear program over how often each leg is flown, in which
//! groups of targets are unobserved together while the vehicle is elsewhere: some tenths of a second for 16 targets.
//! Each bound brings its proof, whose value [`verified`] computes again without the solver that found it.

pub mod absences;
mod groups;
pub mod price;
mod program;
pub mod tour;

use apex_model::problem::{Plan, Problem, SurveillanceProblem};
use std::borrow::Cow;

/// A bound with what proves it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// No plan costs less.
    pub expected_cost: f64,
    /// What proves it.
    pub proof: Proof,
}

/// What proves a bound.
#[derive(Clone, Debug, PartialEq)]
pub enum Proof {
    /// Expected cost that one more second of flight would save at the least.
    PricePerSecond(f64),
    /// Multipliers of the rows of the program of absences.
    Absences(absences::Multipliers),
}

/// States in a plan of surveillance how good any plan could be, where the plan does not say so itself or claims less, by
/// the price of time: quickly, as in flight. Plans of single visits bring their bounds.
pub fn state(problem: &Problem, plan: &mut Plan) {
    state_at_least(problem, plan, |problem| price::expected_cost(&at_best_departures(problem)).expected_cost);
}

/// As [`state`], by the best bound that is known here; of single visits too.
pub fn prove(problem: &Problem, plan: &mut Plan) {
    if let (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) = (problem, &mut *plan) {
        crate::single_visit::prove(problem, plan);
    }
    state_at_least(problem, plan, |problem| expected_cost(problem).expected_cost);
}

fn state_at_least(problem: &Problem, plan: &mut Plan, bound: impl FnOnce(&SurveillanceProblem) -> f64) {
    if let (Problem::Surveillance(problem), Plan::Surveillance(plan)) = (problem, plan) {
        let found = bound(problem).min(plan.expected_cost);
        plan.expected_cost_bound = Some(plan.expected_cost_bound.map_or(found, |claimed| claimed.max(found)));
    }
}

/// The best bound found. `problem` makes sense (`validate::surveillance`).
pub fn expected_cost(problem: &SurveillanceProblem) -> Bound {
    let problem = &*at_best_departures(problem);
    let of_price = price::expected_cost(problem);
    let by_price = Bound { expected_cost: of_price.expected_cost, proof: Proof::PricePerSecond(of_price.price_per_s) };
    match absences::expected_cost(problem) {
        Some((expected_cost, multipliers)) if expected_cost > by_price.expected_cost => {
            Bound { expected_cost, proof: Proof::Absences(multipliers) }
        }
        _ => by_price,
    }
}

/// The problem with the least time of each leg over all departures. Its plans are more than those of the problem: a slow leg
/// is a quick one and a wait, which no bound here forbids.
fn at_best_departures(problem: &SurveillanceProblem) -> Cow<'_, SurveillanceProblem> {
    if problem.travel.is_constant() {
        return Cow::Borrowed(problem);
    }
    Cow::Owned(SurveillanceProblem { travel: problem.travel.least(), ..problem.clone() })
}

/// What the proof proves for `problem`, computed anew: any numbers prove something, good ones much.
pub fn verified(problem: &SurveillanceProblem, proof: &Proof) -> f64 {
    let problem = &*at_best_departures(problem);
    match proof {
        Proof::PricePerSecond(price_per_s) => price::at_price(problem, *price_per_s),
        Proof::Absences(multipliers) => absences::verified(problem, multipliers),
    }
}

#[cfg(test)]
mod tests;
