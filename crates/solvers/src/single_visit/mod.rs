//! The single-visit planner: a subset of targets in the best order and way, for the highest mission score (paper, II.B).
//!
//! Greedy insertion by gain per time, then local search (insert, replace, relocate, exchange, turn round, other
//! manoeuvre, wait for a better time, drop), then ruin and re-insertion from the best plan until nothing new has come for
//! a while or the budget is exhausted. Everything is judged by [`schedule`], which knows wind, airspace, light, windows,
//! order, fuel and endurance.
//! Bound: none but the budget. A leg evaluated is two units of work, preparing a way some hundreds.

mod explain;
mod moves;
mod plan;
pub mod schedule;
mod search;
mod steady;
mod travel;

#[cfg(test)]
pub(crate) mod examples;

use apex_model::problem::{Plan, Problem};
use apex_model::solver::{Environment, Solver};

/// The planner.
#[derive(Clone, Copy, Debug, Default)]
pub struct SingleVisit;

impl Solver for SingleVisit {
    fn name(&self) -> &'static str {
        "single-visit"
    }

    fn serves(&self, problem: &Problem) -> bool {
        matches!(problem, Problem::SingleVisit(_))
    }

    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        let Problem::SingleVisit(problem) = problem else {
            return Err("single-visit plans missions of single visits only.".to_string());
        };
        let mut schedule = schedule::Schedule::new(problem)?;
        let troubles = explain::alone(&mut schedule);
        if troubles.iter().all(Option::is_some) {
            return Err(explain::nothing_feasible(problem, &troubles));
        }
        let best = search::run(&mut schedule, &troubles, environment);
        plan::plan_of(&mut schedule, self.name(), &best, &troubles, explain::left_out).map(Plan::SingleVisit)
    }
}

#[cfg(test)]
mod tests;
