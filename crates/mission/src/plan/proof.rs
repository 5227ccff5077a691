//! Value of a plan, and an upper bound on that of any plan.

use crate::deliberation::Deliberation;
use crate::error::{MissionError, MissionResult};
use apex_model::problem::{Plan, Problem};
use apex_model::time::Duration;
use apex_planning::meter::Meter;
use apex_planning::solver::{WorkBudget, units_in};
use apex_solvers::bounds::age_grid::cycles::{self, WithoutEnd};
use apex_solvers::bounds::{self as bound, Contradiction};

/// Default budget of a proof: enough for all methods with four targets (about 3 s), five (7 s), 16 (1 s) and 24 (6 s); with more targets
/// some methods are skipped.
pub const BUDGET_DEFAULT: Duration = Duration(10_000_000_000);

/// A smaller gap consists of rounding errors alone.
const OPTIMAL: f64 = 1e-6;

/// Value of a plan, and the proven bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proof {
    /// Collected value of the plan; of surveillance its expected cost, of a tour its length: there less is better.
    pub value: f64,
    /// Bound that no plan exceeds; `None` if it is unknown.
    pub bound: Option<f64>,
    /// Difference of value and bound, as a share of the greater one.
    pub gap: Option<f64>,
    /// True if it is proven that no plan is better. Never true for single visits with costs, because the bound ignores costs.
    pub proven_optimal: bool,
}

/// Proven bound of a plan, with its cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Proven {
    /// Value of the plan, and bound on that of any plan.
    pub proof: Proof,
    /// Value of the plan's cycle as an endless flight.
    pub without_end: Option<WithoutEnd>,
    /// Used units of work.
    pub work: u64,
    /// True if a greater budget would not have changed the result.
    pub complete: bool,
}

/// Returns the error with its evidence: the problem and the plan as JSON, to be read again by `apex plan PROBLEM --plan PLAN`.
fn internal_error(contradiction: &Contradiction) -> MissionError {
    let Contradiction { problem, plan, .. } = contradiction;
    let evidence = serde_json::json!({ "problem": problem, "plan": plan });
    MissionError::planning(contradiction.to_string())
        .because("the plan is better than its bound, which is proven for all plans")
        .help(format!("report it with this evidence: {evidence}"))
}

/// Computes within `budget` a bound on the value of any plan, and stores it in the plan; `tour` if the benchmark requires a shortest
/// tour. In flight the fast bound suffices; before the flight a user requests a proof.
///
/// # Errors
/// An internal error if the plan is better than the bound that is proven.
pub fn prove(solved: &mut Deliberation, tour: bool, budget: Duration) -> MissionResult<Proven> {
    let mut budget = WorkBudget::new(if budget > Duration::ZERO { units_in(budget) } else { 0 });
    let mut meter = Meter::new(&mut budget);
    let all = solved.whole.as_ref().unwrap_or(&solved.problem);
    apex_solvers::prove(all, &mut solved.plan, &mut meter).map_err(|found| internal_error(&found))?;
    let proof = of(all, &solved.plan, tour, &mut meter).map_err(|found| internal_error(&found))?;
    let without_end = cycles::of_plan(&solved.problem, &solved.plan, &mut meter);
    Ok(Proven { proof, without_end, work: meter.used(), complete: meter.is_complete() })
}

/// Returns the proof of `plan`; `tour` for a shortest tour through all nodes.
fn of(problem: &Problem, plan: &Plan, tour: bool, meter: &mut Meter<'_>) -> Result<Proof, Contradiction> {
    let (value, bound, costly) = match (problem, plan) {
        (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) if tour && plan.left_out.is_empty() => {
            let travel = problem.travel.as_ref();
            (plan.costs, travel.map(|travel| bound::tour::shortest(travel, plan.costs, meter)), None)
        }
        (_, Plan::SingleVisit(plan)) => (plan.benefits, plan.benefits_bound, Some(plan.costs > 0.0)),
        (_, Plan::Surveillance(plan)) => (plan.expected_cost, plan.expected_cost_bound, None),
    };
    let less_is_better = costly.is_none();
    let contradiction = bound.and_then(|bound| Contradiction::found(problem, plan, (value, bound), less_is_better));
    if let Some(contradiction) = contradiction {
        return Err(contradiction);
    }
    // A rounding error must not put the bound on the wrong side of the value.
    let bound = bound.map(|bound| if less_is_better { bound.min(value) } else { bound.max(value) });
    let gap = bound.map(|bound| {
        let greater = value.abs().max(bound.abs());
        if greater > 0.0 { (value - bound).abs() / greater } else { 0.0 }
    });
    Ok(Proof { value, bound, gap, proven_optimal: gap.is_some_and(|gap| gap < OPTIMAL) && costly != Some(true) })
}
