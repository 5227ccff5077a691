//! Proofs of the quality of a given plan, by the methods of planners and of bounds: a planner knows the bound of the plan that it made.

use crate::bounds::{Contradiction, expected_cost_within, expected_cost_without_waiting_within, state_at_least};
use crate::planners::single_visit;
use apex_model::problem::{Plan, Problem, SurveillancePlan, SurveillanceProblem};
use apex_planning::meter::Meter;
use apex_planning::surveillance::scenario::Scenario;

/// A visit that ends later than possible by less than this many seconds does not wait.
const WAIT_S: f64 = 1e-6;

/// Adds to a plan the best bound that the budget of `meter` permits: for surveillance a lower bound on the expected cost (of plans that
/// never wait, if this one never waits), for single visits an upper bound on the benefits. A better bound in the plan is kept. The meter
/// reports the work, and whether a greater budget would prove more.
///
/// # Errors
/// [`Contradiction`] if a bound contradicts the plan, which then states no bound.
pub fn prove(problem: &Problem, plan: &mut Plan, meter: &mut Meter<'_>) -> Result<(), Contradiction> {
    if let (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) = (problem, &mut *plan) {
        single_visit::prove(problem, plan, meter);
    }
    let waits = match (problem, &*plan) {
        (Problem::Surveillance(problem), Plan::Surveillance(plan)) => waits(problem, plan),
        _ => false,
    };
    let best = |problem: &SurveillanceProblem| match waits {
        true => expected_cost_within(problem, meter).expected_cost,
        false => expected_cost_without_waiting_within(problem, meter).expected_cost,
    };
    state_at_least(problem, plan, best)
}

/// Returns true if a visit of the plan begins or ends later than necessary, or if the plan cannot be flown with its times.
fn waits(problem: &SurveillanceProblem, plan: &SurveillancePlan) -> bool {
    let index = |name: &String| problem.targets.iter().position(|target| target.name == *name);
    let tour: Option<Vec<usize>> = plan.visits.iter().map(|visit| index(&visit.target)).collect();
    let Some((scenario, tour)) = Scenario::new(problem).ok().zip(tour) else { return true };
    let mut stops = Vec::new();
    scenario.fly(tour, |stop| stops.push(stop));
    let late = plan.visits.iter().zip(&stops).any(|(visit, stop)| visit.end_s > stop.end_s + WAIT_S);
    late || stops.len() != plan.visits.len()
}
