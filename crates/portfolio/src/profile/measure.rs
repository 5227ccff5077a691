//! Costs of a planner on one mission at each budget.

use super::file::rounded;
use crate::cell::Cell;
use apex_model::problem::{Plan, Problem};
use apex_planning::checker;
use apex_planning::solver::{Budget, Environment, Solver, WorkBudget};

/// Costs and work of one planner on one mission.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Expected costs, by budget.
    pub costs: Vec<f64>,
    /// Work units used over all budgets.
    pub used: u64,
}

/// Runs `solver` on mission `number` of `cell` with each of `budgets` (work units). The independent checker must accept every plan.
///
/// # Errors
/// An error message if the planner finds no plan, or an invalid one.
pub fn mission(cell: &Cell, number: u64, solver: &dyn Solver, budgets: &[u64]) -> Result<Measured, String> {
    let problem = Problem::Surveillance(cell.mission(number));
    let mut measured = Measured::default();
    for units in budgets {
        let (cost, used) = cost(&problem, number, solver, *units)
            .map_err(|why| format!("{} on mission {cell}@{number} with {units} units: {why}", solver.name()))?;
        measured.costs.push(rounded(cost));
        measured.used += used;
    }
    Ok(measured)
}

/// Returns the expected cost of the plan of `solver`, and the work it took.
pub(super) fn cost(problem: &Problem, seed: u64, solver: &dyn Solver, units: u64) -> Result<(f64, u64), String> {
    let mut budget = WorkBudget::new(units);
    let plan =
        solver.solve(problem, &mut Environment { seed, budget: &mut budget, report: &mut |_| {}, previous: None })?;
    checker::accept(problem, &plan)?;
    match plan {
        Plan::Surveillance(plan) if plan.expected_cost > 0.0 => Ok((plan.expected_cost, budget.used())),
        Plan::Surveillance(plan) => Err(format!("an expected cost of {} cannot be compared", plan.expected_cost)),
        Plan::SingleVisit(_) => Err("it answered with a plan of single visits".to_string()),
    }
}
