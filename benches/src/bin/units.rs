//! Time per unit of work: every planner of surveillance and of single visits, from 10 to 1,000 targets. A unit
//! represents a microsecond (`apex_planning::solver::WORK_UNIT`); the aim is between half of one and two.
//!
//! `units [UNITS]` prints a row for each planner and number of targets. The time is processor time of this thread, so that other load on
//! the machine has little influence.
#![allow(clippy::print_stdout, reason = "it prints its measurements")]
#![allow(clippy::expect_used, reason = "a figure that cannot be had must stop the measurement")]

use apex_model::problem::{Plan, Problem};
use apex_planning::solver::{Environment, WorkBudget};
use apex_portfolio::formats::{self, generate};

const COUNTS: [usize; 5] = [10, 30, 100, 300, 1_000];
/// Default number of units.
const UNITS: u64 = 300_000;

fn main() {
    let units = std::env::args().nth(1).map_or(UNITS, |word| word.parse().expect("a number of units"));
    println!("{:<18} {:>7} {:>9} {:>9} {:>8}  value", "planner", "targets", "used", "cpu_us", "us/unit");
    for count in COUNTS {
        let cell = format!("medium-uniform-uniform-{count}-uniform").parse::<apex_portfolio::cell::Cell>();
        measure(count, &Problem::Surveillance(cell.expect("a cell").mission(0)), units);
        let text = generate::oplib(count + 1, 0.5, 1);
        measure(
            count,
            &Problem::SingleVisit(formats::read("op", &text).expect("a generated problem can be read").problem),
            units,
        );
    }
}

fn measure(count: usize, problem: &Problem, units: u64) {
    for solver in apex_solvers::solvers().iter().filter(|solver| solver.serves(problem)) {
        let mut budget = WorkBudget::new(units);
        let begin_s = cpu_s();
        let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
        let plan = solver.solve(problem, &mut environment).expect("a plan");
        let took_us = 1e6 * (cpu_s() - begin_s);
        let value = match &plan {
            Plan::Surveillance(plan) => plan.expected_cost,
            Plan::SingleVisit(plan) => plan.benefits,
        };
        let (name, used) = (solver.name(), budget.used);
        println!("{name:<18} {count:>7} {used:>9} {took_us:>9.0} {:>8.2}  {value:.3}", took_us / used as f64);
    }
}

/// Returns the time that this thread has spent on a processor.
fn cpu_s() -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    told.split_whitespace().next().and_then(|word| word.parse::<f64>().ok()).unwrap_or(f64::NAN) * 1e-9
}
