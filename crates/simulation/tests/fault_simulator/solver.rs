//! A planner that fails: with an error, with an empty message, by a panic, and once by never answering. Every fifth call it plans.
//!
//! Plans that are wrong, and planners that take memory or crash their process, are cases of `crates/cli/tests/third_party.rs` and
//! `solver_programs.rs`.

use apex_mission::deliberation::PlanningResources;
use apex_model::problem::{Plan, Problem};
use apex_planning::solver::{Environment, Solver};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Wall time after which a planner that hangs is abandoned: far longer than the other planners take, so that it applies only to that one.
const TIMEOUT: Duration = Duration::from_secs(2);

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

    #[allow(clippy::disallowed_methods, reason = "a planner that hangs spends real time")]
    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        match self.calls.fetch_add(1, Ordering::Relaxed) {
            // Once in a flight it hangs, in a call that its watcher can end.
            3 => loop {
                std::thread::sleep(Duration::from_millis(10));
                environment.budget.charge(0);
            },
            call if call % 5 == 0 => Err("it has no idea".to_string()),
            call if call % 5 == 1 => panic!("it breaks on purpose"),
            call if call % 5 == 2 => Err(String::new()),
            _ => self.good.solve(problem, environment),
        }
    }
}

/// Returns the planners that ship with Apex, and one that fails. Each flight has a separate one, so that flights do not influence each
/// other.
pub(crate) fn means() -> PlanningResources {
    let mut registry = apex_solvers::shipped();
    let good = registry.find("nearest-neighbour").cloned().unwrap();
    registry.add(Arc::new(Faulty { good, calls: AtomicU64::new(0) })).unwrap();
    PlanningResources { timeout: TIMEOUT, ..PlanningResources::of(&Arc::new(registry)) }
}
