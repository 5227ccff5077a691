//! How good a plan is, and how good any could be.

use apex_model::problem::{Plan, Problem};

/// Gap below which rounding is all that is left.
const OPTIMAL: f64 = 1e-6;

/// A plan's value beside what is proven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proof {
    /// What the plan collects; of surveillance its expected cost, of a tour its length: there less is better.
    pub value: f64,
    /// No plan does better; none where no bound is known.
    pub bound: Option<f64>,
    /// How far apart the two are, as a share of the greater one.
    pub gap: Option<f64>,
    /// Is it proven that no plan is better? Of a single visit with costs it is not, for the bound does not know them.
    pub proven_optimal: bool,
}

/// What is known of `plan`; `tour` where the shortest of all tours was asked for.
pub fn of(problem: &Problem, plan: &Plan, tour: bool) -> Proof {
    let (value, bound, costly) = match (problem, plan) {
        (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) if tour && plan.left_out.is_empty() => {
            let travel = problem.travel.as_ref();
            (plan.costs, travel.map(|travel| apex_solvers::bound::tour::shortest(travel, plan.costs)), false)
        }
        (_, Plan::SingleVisit(plan)) => (plan.benefits, plan.benefits_bound, plan.costs > 0.0),
        (_, Plan::Surveillance(plan)) => (plan.expected_cost, plan.expected_cost_bound, false),
    };
    let gap = bound.map(|bound| {
        let greater = value.abs().max(bound.abs());
        if greater > 0.0 { (value - bound).abs() / greater } else { 0.0 }
    });
    Proof { value, bound, gap, proven_optimal: gap.is_some_and(|gap| gap < OPTIMAL) && !costly }
}
