//! People who plan: their visits as a planner's, and how they hear that they plan better (paper, section V.C).

use super::deliberator::Means;
use super::news::News;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::sync::Arc;

/// Who plans for people.
const HUMAN: &str = "human";

/// The means with the visits that a person wants as one more planner, if `solver` asks for it.
///
/// # Errors
/// A sentence: nobody has said what to visit.
pub(super) fn means(means: &Means, solver: Option<&str>, news: &News) -> Result<Means, String> {
    let mut means = means.clone();
    if solver != Some(HUMAN) || means.planners.find(HUMAN).is_some() {
        return Ok(means);
    }
    let visits =
        news.visits().ok_or("nobody has said what to visit, by the event (planned-by-people ([repeat] TARGET ..))")?;
    let mut planners = means.planners.as_ref().clone();
    planners.add(Arc::new(visits.clone()))?;
    means.planners = Arc::new(planners);
    Ok(means)
}

/// The first step of a plan where people plan better: `library/aerial-observation.pdl` says it to who listens.
pub(super) fn step(goal: &Value, summary: &str) -> (Symbol, Value) {
    let words = [Value::symbol("say"), Value::symbol("that"), Value::symbol("people"), Value::symbol("plan")];
    let rest = [goal.clone(), Value::symbol("better"), Value::symbol("than"), Value::text(summary)];
    (Symbol::new("people"), Value::list(words.into_iter().chain(rest)))
}
