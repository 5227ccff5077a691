//! Priority (TC)
//! What: computes how important a task is now, and when a rising priority overtakes another one.
//! Runs: contend phase.  Reads: priority clauses, ancestors, agent workload.  Writes: nothing.
//! Bound: O(depth) per task; crossings by bisection in at most 64 + 64 evaluations.
//! PDL: `priority`, section 9.  Paper: section III, priority of competitors.

use crate::cycle::Cycle;
use crate::expression::{Surroundings, evaluate};
use crate::view::View;
use apex_model::agent::Agent;
use apex_model::because::Strength;
use apex_model::clause::Level;
use apex_model::expression::{Expr, ExprKind};
use apex_model::procedure::{PriorityClause, Step};
use apex_model::source::Place;
use apex_model::task::{Task, TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Workload of the agent, 1 to 9: how much urgency counts against importance.
const WORKLOAD: f64 = 5.0;
/// Added to the priority of an ongoing task when it defends a resource, where nothing else is stated.
pub(crate) const INTERRUPT_COST_DEFAULT: f64 = 0.1;
/// Instants looked at when both priorities move.
const GRID: i64 = 64;

/// The priority of `id` at `at`: the greatest of its own clauses and of its ancestors that are not interrupted.
pub(crate) fn priority(agent: &Agent, id: TaskId, at: Time) -> f64 {
    let mut greatest: Option<f64> = None;
    let mut next = Some(id);
    while let Some(task) = next.and_then(|id| agent.task(id)) {
        if (task.id == id || task.state != TaskState::Interrupted)
            && let Some(own) = own_priority(agent, task, at)
        {
            greatest = Some(greatest.map_or(own, |before| before.max(own)));
        }
        next = task.parent;
    }
    greatest.unwrap_or(0.0)
}

/// What an ongoing task defends its resources with.
pub(crate) fn defence(agent: &Agent, id: TaskId, at: Time) -> Strength {
    let selection = agent.task(id).and_then(|task| task.selection.as_ref());
    let interrupt_cost = selection.map_or(INTERRUPT_COST_DEFAULT, |selection| selection.interrupt_cost);
    Strength { priority: priority(agent, id, at), interrupt_cost }
}

fn own_priority(agent: &Agent, task: &Task, at: Time) -> Option<f64> {
    let step = task.step()?;
    if !matches!(task.origin, apex_model::task::Origin::Step(_)) {
        return None;
    }
    let template = agent.procedure(step.procedure)?.steps.get(step.step as usize)?;
    if template.priority.is_empty() {
        return None;
    }
    let view = View { agent, task: task.id, level: Level::Step, now: at };
    let recovered = recovery(agent, task, at);
    let values = template.priority.iter().filter_map(|clause| clause_priority(clause, task, &view, at));
    values.map(|value| recovered * value).reduce(f64::max)
}

/// What is wrong with the step's priority clauses and its rank as they stand now: they count as absent, and that must
/// be said.
pub(crate) fn troubles(cycle: &Cycle<'_>, id: TaskId, step: &Step) -> Vec<(String, Place)> {
    let view = cycle.view(id, Level::Step);
    let trouble = |(what, expr): (&str, &Expr)| match evaluate(expr, &view) {
        Ok(value) if value.as_number().is_some_and(|(number, _)| number.is_finite()) => None,
        Ok(value) => Some((format!("its {what} is {value}, which is no number"), expr.place)),
        Err(error) => Some((format!("its {what} has no value: {}", error.message), error.place)),
    };
    let priorities = step.priority.iter().flat_map(|clause| match clause {
        PriorityClause::Number(expr) => vec![expr],
        PriorityClause::UrgencyImportance(urgency, importance) => vec![urgency, importance],
    });
    let priorities = priorities.map(|expr| ("priority", expr));
    priorities.chain(step.rank.iter().map(|expr| ("rank", &**expr))).filter_map(trouble).collect()
}

/// A clause that cannot be evaluated counts as absent; [`troubles`] has said so.
fn clause_priority(clause: &PriorityClause, task: &Task, view: &View<'_>, at: Time) -> Option<f64> {
    match clause {
        PriorityClause::Number(expr) => number(expr, view),
        PriorityClause::UrgencyImportance(urgency, importance) => {
            let urgency = urgency_at(number(urgency, view)?, created(task), at);
            Some(combined(urgency, number(importance, view)?.clamp(0.0, 10.0)))
        }
    }
}

fn number(expr: &Expr, view: &View<'_>) -> Option<f64> {
    let value = match &expr.kind {
        ExprKind::Constant(value) => value.clone(),
        _ => evaluate(expr, view).ok()?,
    };
    value.as_number().map(|(number, _)| number).filter(|number| number.is_finite())
}

/// When the task was made; to start over makes no new one.
fn created(task: &Task) -> Time {
    task.extras.as_ref().and_then(|extras| extras.first_created).unwrap_or(task.created_at)
}

/// The instant at which a task of this urgency at creation must be done.
fn deadline(urgency: f64, created_at: Time) -> Time {
    created_at + Duration::from_seconds(libm::exp2(9.0 - urgency.clamp(0.0, 10.0)))
}

/// Urgency rises as the deadline nears, and is 10 from half a second before it on.
fn urgency_at(urgency: f64, created_at: Time, at: Time) -> f64 {
    let left = (deadline(urgency, created_at) - at).seconds();
    if left <= 0.5 { 10.0 } else { (9.0 - libm::log2(left)).clamp(0.0, 10.0) }
}

fn combined(urgency: f64, importance: f64) -> f64 {
    (importance * WORKLOAD * (1.0 - 1.0 / (1.0 + urgency))
        + urgency * (10.0 - WORKLOAD) * (1.0 - 1.0 / (1.0 + importance)))
        / 9.0
}

/// The recovered fraction of a repeated task's priority.
fn recovery(agent: &Agent, task: &Task, at: Time) -> f64 {
    match recovery_span(agent, task) {
        Some((ended, span)) if span > Duration::ZERO => ((at - ended).seconds() / span.seconds()).clamp(0.0, 1.0),
        _ => 1.0,
    }
}

fn recovery_span(agent: &Agent, task: &Task) -> Option<(Time, Duration)> {
    let ended = task.extras.as_ref()?.ended_before?;
    let step = task.step()?;
    let template = agent.procedure(step.procedure)?.steps.get(step.step as usize)?;
    let expr = template.repeating.as_ref()?.recovery.as_ref()?;
    let view = View { agent, task: task.id, level: Level::Step, now: agent.now };
    match evaluate(expr, &view).ok()? {
        Value::Duration(span) => Some((ended, span)),
        _ => None,
    }
}

/// When the priorities of the task and its ancestors stop rising by themselves; none when they stand still already.
pub(crate) fn rises_until(agent: &Agent, id: TaskId, now: Time) -> Option<Time> {
    let mut latest: Option<Time> = None;
    let mut next = Some(id);
    while let Some(task) = next.and_then(|id| agent.task(id)) {
        let template = task.step().and_then(|step| agent.procedure(step.procedure)?.steps.get(step.step as usize));
        let view = View { agent, task: task.id, level: Level::Step, now };
        for clause in template.into_iter().flat_map(|step| &step.priority) {
            if let PriorityClause::UrgencyImportance(urgency, _) = clause
                && let Some(urgency) = number(urgency, &view)
            {
                latest = latest.max(Some(deadline(urgency, created(task))));
            }
        }
        if template.is_some_and(|step| !step.priority.is_empty())
            && let Some((ended, span)) = recovery_span(agent, task)
        {
            latest = latest.max(Some(ended + span));
        }
        next = task.parent;
    }
    latest.filter(|latest| *latest > now)
}

/// True when the priority of the task or of an ancestor may depend on what is measured.
pub(crate) fn reads_histories(agent: &Agent, id: TaskId) -> bool {
    let mut next = Some(id);
    while let Some(task) = next.and_then(|id| agent.task(id)) {
        let template = task.step().and_then(|step| agent.procedure(step.procedure)?.steps.get(step.step as usize));
        let mut exprs = template.into_iter().flat_map(|step| &step.priority).filter_map(|clause| match clause {
            PriorityClause::Number(expr) => Some(expr),
            PriorityClause::UrgencyImportance(..) => None,
        });
        if exprs.any(|expr| !matches!(expr.kind, ExprKind::Constant(_) | ExprKind::Variable { .. })) {
            return true;
        }
        next = task.parent;
    }
    false
}

/// The first instant after `now`, and not after `until`, at which `challenger` would beat the defence of `holder`.
pub(crate) fn crossing(
    cycle: &Cycle<'_>,
    challenger: TaskId,
    holder: TaskId,
    holds: bool,
    until: Time,
) -> Option<Time> {
    let agent: &Agent = cycle.agent;
    let ahead = |at: Time| {
        let defended = if holds { defence(agent, holder, at).total() } else { priority(agent, holder, at) };
        priority(agent, challenger, at) > defended
    };
    let now = cycle.now;
    let step = ((until - now).0 / GRID).max(1);
    let mut before = now;
    for index in 1..=GRID {
        let at = if index == GRID { until } else { now + Duration(step.saturating_mul(index)) };
        if ahead(at) {
            return Some(first_after(before, at, &ahead));
        }
        before = at;
    }
    None
}

/// The least instant in `(low, high]` at which `holds` is true, which is true at `high`.
fn first_after(mut low: Time, mut high: Time, holds: &dyn Fn(Time) -> bool) -> Time {
    while (high - low).0 > 1 {
        let middle = low + Duration((high - low).0 / 2);
        if holds(middle) { high = middle } else { low = middle }
    }
    high
}

/// The rank of a task among its siblings, if it has one.
pub(crate) fn rank(agent: &Agent, id: TaskId, now: Time) -> Option<f64> {
    let task = agent.task(id)?;
    let apex_model::task::Origin::Step(step) = task.origin else { return None };
    let procedure = agent.procedure(step.procedure)?;
    let template = procedure.steps.get(step.step as usize)?;
    if let Some(expr) = &template.rank {
        return number(expr, &View { agent, task: id, level: Level::Step, now });
    }
    let written = f64::from(step.step) + 1.0;
    match procedure.kind {
        apex_model::procedure::ProcedureKind::Ranked | apex_model::procedure::ProcedureKind::SoftSequential => {
            Some(written)
        }
        apex_model::procedure::ProcedureKind::Concurrent | apex_model::procedure::ProcedureKind::Sequential => None,
    }
}

/// The value of an `interrupt-cost` clause.
///
/// # Errors
/// A message when it is no number.
pub(crate) fn interrupt_cost(expr: &Expr, surroundings: &dyn Surroundings) -> Result<f64, String> {
    let value = evaluate(expr, surroundings).map_err(|error| error.message)?;
    let number = value.as_number().map(|(number, _)| number);
    number.ok_or_else(|| format!("{value} is no interrupt cost; write a number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn urgency_begins_as_stated_and_reaches_ten() {
        let created = Time::from_seconds(100.0);
        assert!((urgency_at(5.0, created, created) - 5.0).abs() < 1e-9);
        assert!((urgency_at(5.0, created, created + Duration::from_seconds(8.0)) - (9.0 - 3.0)).abs() < 1e-9);
        assert_eq!(urgency_at(5.0, created, created + Duration::from_seconds(16.0)), 10.0);
        assert_eq!(urgency_at(5.0, created, created + Duration::from_seconds(60.0)), 10.0);
    }

    #[test]
    fn the_documented_formula() {
        // I = U = 9, S = 5: (9*5*0.9 + 9*5*0.9) / 9 = 9.
        assert!((combined(9.0, 9.0) - 9.0).abs() < 1e-12);
        assert_eq!(combined(0.0, 0.0), 0.0);
    }

    #[test]
    fn the_first_instant_is_found_exactly() {
        assert_eq!(first_after(Time(0), Time(1_000_000), &|at| at.0 >= 31_337), Time(31_337));
    }
}
