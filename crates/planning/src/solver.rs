//! The solver contract: the input and output of a planner (paper, sections IV and V).
//!
//! A solver runs concurrently with the executive. It receives random numbers, a budget and a channel for its best plan so far as
//! arguments. It answers with a [`Plan`], which an independent checker validates before the executive receives it.

use apex_model::problem::{Plan, Problem};
use apex_model::time::Duration;

/// Time that one unit of a solver's work represents, in flights, in budgets and in the profile table.
///
/// Measured on one core of a loaded server: all planners take 0.5 to 1.3 microseconds a unit, for 10 to 1,000 targets
/// (`docs/reference/planning-speed.md`; `make bench-units` measures it again). A slower computer completes fewer units in a second of
/// flight: its budgets should be smaller, or its plans are late.
pub const WORK_UNIT: Duration = Duration(1_000);

/// Returns the work units in `time`; at least one.
pub fn units_in(time: Duration) -> u64 {
    u64::try_from(time.0 / WORK_UNIT.0).unwrap_or(0).max(1)
}

/// Returns the time that `units` of work represent.
pub fn time_of(units: u64) -> Duration {
    Duration(WORK_UNIT.0.saturating_mul(i64::try_from(units).unwrap_or(i64::MAX)))
}

/// Powers that a solver may use.
pub struct Environment<'a> {
    /// Seed for the solver's own generator; equal seed and budget give an equal plan.
    pub seed: u64,
    /// Work allowed. Counted in the solver's work units in simulation and replay, by the clock in flight.
    pub budget: &'a mut dyn Budget,
    /// Receives every better plan as soon as it is found.
    pub report: &'a mut dyn FnMut(&Plan),
    /// The plan that is being flown, or the best plan for the problem before it changed: a starting point that the solver may ignore.
    pub previous: Option<&'a Plan>,
}

/// Permission to continue.
pub trait Budget {
    /// Charges `units` of work.
    fn charge(&mut self, units: u64);
    /// Returns true when the solver must return its best plan now.
    fn exhausted(&self) -> bool;
    /// Returns the units charged so far.
    fn used(&self) -> u64;
    /// Returns the remaining units; `None` if a clock decides. An annealing planner derives its temperatures from them.
    fn left(&self) -> Option<u64> {
        None
    }
    /// Returns true if the answer is no longer required: the solver must end at once, even without a plan.
    fn is_stopped(&self) -> bool {
        false
    }
    /// Returns the limits of the machine for the solver.
    fn machine(&self) -> MachineLimits {
        MachineLimits::default()
    }
}

/// Limits of the machine for a solver. They are far off: the budget in work units decides before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MachineLimits {
    /// Bytes of memory; `None` if the caller states no limit.
    pub memory_bytes: Option<u64>,
    /// Wall time until the solver is stopped; `None` if the caller states no limit.
    pub timeout: Option<std::time::Duration>,
}

/// A budget of a fixed number of work units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorkBudget {
    /// Number of units allowed.
    pub allowed: u64,
    /// Number of units charged.
    pub used: u64,
}

impl WorkBudget {
    /// Returns a fresh budget of `allowed` units.
    pub fn new(allowed: u64) -> WorkBudget {
        WorkBudget { allowed, used: 0 }
    }
}

impl Budget for WorkBudget {
    fn charge(&mut self, units: u64) {
        self.used = self.used.saturating_add(units);
    }
    fn exhausted(&self) -> bool {
        self.used >= self.allowed
    }
    fn used(&self) -> u64 {
        self.used
    }
    fn left(&self) -> Option<u64> {
        Some(self.allowed.saturating_sub(self.used))
    }
}

/// A planner. Third parties implement this.
pub trait Solver: Send + Sync {
    /// Returns the name in profile tables, records and `(solver NAME ..)` forms.
    fn name(&self) -> &str;

    /// Returns true if it can plan for problems of this kind.
    fn serves(&self, problem: &Problem) -> bool;

    /// Plans. Returns when done or when the budget is exhausted.
    ///
    /// # Errors
    /// An error message for operators if no feasible plan exists or the problem is invalid.
    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String>;
}
