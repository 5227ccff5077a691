//! How good a plan is, and how good any could be.

use crate::deliberation::Deliberation;
use apex_model::problem::{Plan, Problem};
use apex_model::time::Duration;
use apex_planning::meter::Meter;
use apex_planning::solver::{WorkBudget, units_in};
use apex_solvers::bounds as bound;
use apex_solvers::bounds::age_grid::cycles::{self, WithoutEnd};

/// Budget of a proof if none is given: enough for all methods with four targets (about 3 s), five (7 s), 16 (1 s) and 24 (6 s);
/// with more targets some methods are skipped.
pub const BUDGET_DEFAULT: Duration = Duration(10_000_000_000);

/// Gap below which rounding is all that is left.
const OPTIMAL: f64 = 1e-6;

/// Value of a plan, and the proven bound.
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

/// What was proven of a plan, and at what price.
#[derive(Clone, Debug, PartialEq)]
pub struct Proven {
    /// How good the plan is, and how good any could be.
    pub proof: Proof,
    /// Value of the plan's cycle if it is flown without end.
    pub without_end: Option<WithoutEnd>,
    /// Units of work that it took.
    pub work: u64,
    /// Was everything tried that would have been with a greater budget?
    pub complete: bool,
}

/// Proves within `budget` how good any plan could be, and states it in the plan; `tour` where the shortest of all tours was asked for.
/// In flight the fast bound suffices; on the ground the user asks for a proof.
pub fn prove(solved: &mut Deliberation, tour: bool, budget: Duration) -> Proven {
    let mut budget = WorkBudget::new(if budget > Duration::ZERO { units_in(budget) } else { 0 });
    let mut meter = Meter::new(&mut budget);
    apex_solvers::prove(&solved.problem, &mut solved.plan, &mut meter);
    let proof = of(&solved.problem, &solved.plan, tour, &mut meter);
    let without_end = cycles::of_plan(&solved.problem, &solved.plan, &mut meter);
    Proven { proof, without_end, work: meter.used(), complete: meter.is_complete() }
}

/// What is known of `plan`; `tour` where the shortest of all tours was asked for.
fn of(problem: &Problem, plan: &Plan, tour: bool, meter: &mut Meter<'_>) -> Proof {
    let (value, bound, costly) = match (problem, plan) {
        (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) if tour && plan.left_out.is_empty() => {
            let travel = problem.travel.as_ref();
            (plan.costs, travel.map(|travel| bound::tour::shortest(travel, plan.costs, meter)), false)
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
