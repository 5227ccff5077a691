//! The independent checker: every plan passes it before the executive receives it, whatever planner or operator made
//! it.
//!
//! Its arithmetic is independent throughout (quadrature instead of closed forms, winding angles instead of crossing counts, vectors
//! instead of the wind triangle), so that it does not repeat a planner's mistake.
//! Bound: O(visits x targets) quadratures for surveillance; O(route length / 5 km x (zones + landing places)) else.

mod given_times;
mod single_visit;
mod surveillance;
mod turns;

use apex_model::problem::{Plan, Problem};

/// Returns the violations of `plan` as an answer to `problem`, one phrase each; empty if the plan may be used.
pub fn violations(problem: &Problem, plan: &Plan) -> Vec<String> {
    match (problem, plan) {
        (Problem::Surveillance(problem), Plan::Surveillance(plan)) => surveillance::violations(problem, plan),
        (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) => single_visit::violations(problem, plan),
        _ => vec!["answers another kind of problem".to_string()],
    }
}

/// Accepts or refuses a plan.
///
/// # Errors
/// One sentence with every violation.
pub fn accept(problem: &Problem, plan: &Plan) -> Result<(), String> {
    let found = violations(problem, plan);
    if found.is_empty() {
        return Ok(());
    }
    Err(format!("the plan of {} is not valid: it {}", plan.solver(), found.join("; ")))
}
