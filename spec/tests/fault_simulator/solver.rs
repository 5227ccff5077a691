//! A planner that fails in every way that a planner can: error, panic, plan of another problem, budget exceeded.

use apex_model::problem::{Plan, Problem};
use apex_planning::registry::Registry;
use apex_planning::solver::{Environment, Solver};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

struct Faulty {
    good: Arc<dyn Solver>,
    calls: AtomicU64,
}

impl Solver for Faulty {
    fn name(&self) -> &str {
        "faulty"
    }

    fn serves(&self, problem: &Problem) -> bool {
        self.good.serves(problem)
    }

    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        match self.calls.fetch_add(1, Ordering::Relaxed) % 4 {
            0 => Err("it has no idea".to_string()),
            1 => panic!("it breaks on purpose"),
            2 => Err(String::new()),
            _ => self.good.solve(problem, environment),
        }
    }
}

/// The planners that ship, and one that fails.
pub(crate) fn planners() -> Arc<Registry> {
    let mut registry = apex_solvers::shipped();
    let good = registry.find("nearest-neighbour").cloned().unwrap();
    registry.add(Arc::new(Faulty { good, calls: AtomicU64::new(0) })).unwrap();
    Arc::new(registry)
}
