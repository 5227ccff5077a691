//! A third party's planner in a separate program: the whole `apex` command, with one additional planner.

use apex_model::problem::{Plan, Problem};
use apex_planning::random::Generator;
use apex_planning::solver::{Environment, Solver};
use apex_planning::surveillance::scenario::Scenario;
use std::process::ExitCode;
use std::sync::Arc;

/// Plans a cycle through all targets, and swaps the positions of two targets as long as that lowers the cost.
struct Swaps;

impl Solver for Swaps {
    fn name(&self) -> &str {
        "swaps"
    }

    fn serves(&self, problem: &Problem) -> bool {
        matches!(problem, Problem::Surveillance(_))
    }

    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        let Problem::Surveillance(problem) = problem else {
            return Err("the solver `swaps` accepts surveillance problems only".to_string());
        };
        let scenario = Scenario::new(problem)?;
        let mut rng = Generator::new(environment.seed);
        let mut best = scenario.usable().to_vec();
        let mut least = f64::INFINITY;
        let mut tried = best.clone();
        loop {
            // Computing the cost of a cycle charges the budget.
            let cost = scenario.cycle_cost(&tried, environment.budget);
            if cost < least {
                (best, least) = (tried, cost);
                (environment.report)(&Plan::Surveillance(scenario.cycle_plan(self.name(), &best)));
            }
            if environment.budget.exhausted() || best.len() < 2 {
                return Ok(Plan::Surveillance(scenario.cycle_plan(self.name(), &best)));
            }
            tried = best.clone();
            tried.swap(rng.below(best.len()), rng.below(best.len()));
        }
    }
}

fn main() -> ExitCode {
    let mut planners = apex_solvers::shipped();
    match planners.add(Arc::new(Swaps)) {
        Ok(()) => apex_cli::main(std::env::args_os(), planners),
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}
