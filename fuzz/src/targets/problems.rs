//! Planning problems and plans, as `apex plan PROBLEM --plan FILE` reads them: one line of JSON each.
//!
//! Properties: a problem that is accepted can be written and read back, and a check of any plan for it ends with a list of violations.

use crate::planted;
use apex_mission::plan::input::PlanInput;
use apex_mission::plan::problem_file;
use apex_model::problem::{Plan, Problem};
use apex_planning::checker;

/// Runs the target.
pub(crate) fn run(bytes: &[u8]) {
    let Some(text) = super::text(bytes) else { return };
    let (problem, plan) = text.split_once('\n').unwrap_or((text, ""));
    let Ok(input) = PlanInput::of_json(problem, "fuzz.json") else { return };
    let written = problem_file::write(&input.problem);
    let again = PlanInput::of_json(&written, "fuzz.json").map(|again| problem_file::write(&again.problem));
    assert!(again.is_ok_and(|again| again == written), "a problem that is written is read differently");
    let Ok(plan) = serde_json::from_str::<Plan>(plan) else { return };
    let violations = checker::violations(&input.problem, &plan);
    if planted::ARE_IN {
        // The bug: every target of the plan is assumed to be in the problem.
        let known = names(&input.problem);
        for target in plan.targets() {
            let number = known.iter().take_while(|name| **name != target).count();
            let _ = known[number];
        }
    }
    assert!(violations.iter().all(|violation| !violation.is_empty()), "a violation without a text");
}

fn names(problem: &Problem) -> Vec<&str> {
    match problem {
        Problem::Surveillance(problem) => problem.targets.iter().map(|target| target.name.as_str()).collect(),
        Problem::SingleVisit(problem) => problem.targets.iter().map(|target| target.name.as_str()).collect(),
    }
}
