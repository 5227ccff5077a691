//! Nearest neighbour: a cycle through every reachable target; each visit is followed by the nearest target not in the cycle yet.
//!
//! The simplest planner and the baseline of the others. Bound: O(n^2).

use apex_model::problem::{Plan, Problem};
use apex_planning::solver::{Environment, Solver};
use apex_planning::surveillance::scenario::Scenario;
use apex_planning::tour::nearest::cycle_from;

/// The planner.
#[derive(Clone, Copy, Debug, Default)]
pub struct NearestNeighbour;

impl Solver for NearestNeighbour {
    fn name(&self) -> &'static str {
        "nearest-neighbour"
    }

    fn serves(&self, problem: &Problem) -> bool {
        matches!(problem, Problem::Surveillance(_))
    }

    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        let Problem::Surveillance(problem) = problem else {
            return Err("the solver `nearest-neighbour` accepts surveillance problems only".to_string());
        };
        let scenario = Scenario::new(problem)?;
        let cycle = cycle_from(&scenario, None, scenario.usable(), environment.budget);
        let plan = Plan::Surveillance(scenario.cycle_plan(self.name(), &cycle));
        scenario.charge(0, environment.budget);
        (environment.report)(&plan);
        Ok(plan)
    }
}
