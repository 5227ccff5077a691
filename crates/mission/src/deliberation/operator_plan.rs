//! Planner that returns the operator's visits, and the message that operators plan better (paper, section V.C).

use super::solve::PlanningResources;
use crate::situation::OperatorPlan;
use apex_model::planned::PlannedActivity;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use apex_solvers::planners::human::Human;
use std::sync::Arc;

/// Name of the planner that returns the operator's visits.
pub(crate) const HUMAN: &str = "human";

/// Returns the planners extended by one that returns the operator's visits, if `solver` requests it.
///
/// # Errors
/// An error message if the operator has not named visits.
pub(super) fn means(
    means: &PlanningResources,
    solver: Option<&str>,
    plan: Option<&OperatorPlan>,
) -> Result<PlanningResources, String> {
    let mut means = means.clone();
    if solver != Some(HUMAN) || means.planners.find(HUMAN).is_some() {
        return Ok(means);
    }
    let plan = plan.ok_or("no event (planned-by-people ([repeat] TARGET ..)) has named the targets")?;
    let mut planners = means.planners.as_ref().clone();
    planners.add(Arc::new(Human { visits: plan.visits.clone(), repeat: plan.repeat }))?;
    means.planners = Arc::new(planners);
    Ok(means)
}

/// Returns the first step of a plan for a problem that operators plan better: it sends a message that `library/aerial-observation.pdl`
/// handles.
pub(super) fn step(goal: &Value, summary: &str) -> (Symbol, PlannedActivity) {
    let words = [Value::symbol("say"), Value::symbol("that"), Value::symbol("people"), Value::symbol("plan")];
    let rest = [goal.clone(), Value::symbol("better"), Value::symbol("than"), Value::text(summary)];
    (Symbol::new("people"), PlannedActivity::Goal(Value::list(words.into_iter().chain(rest))))
}
