//! `apex plan --plan FILE`: reads, evaluates and checks a plan that was drawn or edited by hand, like any other.

use super::input::PlanInput;
use crate::deliberation::{Deliberation, PLAN_VISITS_MAX};
use crate::error::{MissionError, MissionResult};
use crate::files::read_text;
use apex_model::problem::Plan;
use apex_planning::checker;
use apex_planning::solver::{Environment, WorkBudget, units_in};
use apex_solvers::planners::human::brought;
use serde::Deserialize;
use std::path::Path;

/// Maximum number of violations that are listed; a plan may violate a rule with every visit.
const BROKEN_NAMED_MAX: usize = 20;

/// Reads the plan in `file` for the input.
///
/// # Errors
/// A file without a plan, or with one for another problem; if times are kept, every violated rule.
pub fn import(file: &Path, retime: bool, input: &PlanInput) -> MissionResult<Deliberation> {
    let place = file.display().to_string();
    let plan = read(file, &place)?;
    let not_for = |reason: String| {
        MissionError::planning(format!("the plan in {place} is not a plan for {}", input.name))
            .because(reason)
            .help("name the problem that it was made for; `apex plan PROBLEM --problem` prints its targets")
    };
    let visits = plan.targets().len();
    if visits > PLAN_VISITS_MAX {
        return Err(not_for(format!("it has {visits} visits, more than {PLAN_VISITS_MAX}")));
    }
    let mut budget = WorkBudget::new(units_in(input.budget));
    let (plan, times) = if retime {
        let mut environment =
            Environment { seed: input.seed, budget: &mut budget, report: &mut |_| {}, previous: None };
        (brought::retimed(&input.problem, &plan, &mut environment), "computed again")
    } else {
        (brought::scored(&input.problem, &plan), "as they are")
    };
    let plan = plan.map_err(not_for)?;
    let broken = checker::violations(&input.problem, &plan);
    if !broken.is_empty() {
        return Err(breaks(&place, &broken));
    }
    let reason = format!("read from {place}, its times {times}");
    Ok(Deliberation {
        problem: input.problem.clone(),
        whole: None,
        plan,
        reason,
        work: budget.used,
        cpu_s: None,
        from: None,
        people_plan_better: false,
    })
}

fn breaks(place: &str, broken: &[String]) -> MissionError {
    let (count, rules) = (broken.len(), if broken.len() == 1 { "rule" } else { "rules" });
    let mut named: Vec<String> = broken.iter().take(BROKEN_NAMED_MAX).map(|rule| format!("it {rule}")).collect();
    let more = count.saturating_sub(BROKEN_NAMED_MAX);
    if more > 0 {
        named.push(format!("and {more} more"));
    }
    MissionError::planning(format!("the plan in {place} breaks {count} {rules}"))
        .because(named.join("\n  "))
        .help("correct the times of these visits, or add `--retime` to keep their order and compute the times again")
}

/// The plan in the output of `apex plan --json`; other members are ignored.
#[derive(Deserialize)]
struct PlanFile {
    plan: Plan,
}

/// Returns the plan of a whole answer, or a plan alone.
fn read(file: &Path, place: &str) -> MissionResult<Plan> {
    let text = read_text(file)?;
    let is_answer = serde_json::from_str::<serde_json::Value>(&text).is_ok_and(|value| value.get("plan").is_some());
    let plan = match is_answer {
        true => serde_json::from_str::<PlanFile>(&text).map(|answer| answer.plan),
        false => serde_json::from_str::<Plan>(&text),
    };
    plan.map_err(|error| {
        MissionError::planning("this is not a plan").at(format!("{place}:{}:{}", error.line(), error.column()))
            .because(error)
            .help("give the output of `apex plan PROBLEM --json`, or its member `plan`; docs/reference/schema/plan.schema.json describes them")
    })
}
