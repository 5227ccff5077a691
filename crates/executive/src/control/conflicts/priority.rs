//! Priority (TC)
//! What: computes the priority of a task at an instant, and bounds of it over a span of time.
//! Runs: contend phase.  Reads: priority clauses, ancestors, agent workload.  Writes: nothing.
//! Bound: O(depth) per task.
//! PDL: `priority`, section 9.  Paper: section III, priority of competitors.

use crate::control::conflicts::curve::RisingTerm;
use crate::control::conflicts::value_intervals::{self, Bounds};
use crate::control::cycle::Cycle;
use crate::expression::view::View;
use crate::expression::{EvalContext, evaluate};
use crate::state::agent::Agent;
use crate::state::clause::Level;
use crate::state::controller::MethodBinding;
use crate::state::step_clauses::StepClauses;
use crate::state::task::Task;
use apex_model::because::Strength;
use apex_model::expression::{Expr, ExprKind};
use apex_model::procedure::{PriorityClause, Step};
use apex_model::source::Place;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Added to the priority of an ongoing task that defends a resource, unless PDL states another cost.
pub(crate) const INTERRUPT_COST_DEFAULT: f64 = 0.1;

/// Returns the priority of `id` at `at`: the greatest of its clauses and of its ancestors that are not interrupted.
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

/// Returns the strength with which an ongoing task defends its resources.
pub(crate) fn defence(agent: &Agent, id: TaskId, at: Time) -> Strength {
    Strength { priority: priority(agent, id, at), interrupt_cost: interrupt_cost_at(agent, id, at) }
}

/// Returns the cost to interrupt the task. It is at least zero, because two equals would otherwise interrupt each other forever.
pub(crate) fn interrupt_cost_at(agent: &Agent, id: TaskId, at: Time) -> f64 {
    let selection = agent.task(id).and_then(|task| task.selection.as_ref());
    let at_choice = selection.map_or(INTERRUPT_COST_DEFAULT, |selection| selection.interrupt_cost);
    let cost = match cost_clause(agent, id) {
        Some((expr, level)) if !matches!(expr.kind, ExprKind::Constant(_)) => {
            number(expr, &View { agent, task: id, level, now: at }).unwrap_or(at_choice)
        }
        _ => at_choice,
    };
    cost.max(0.0)
}

fn own_priority(agent: &Agent, task: &Task, at: Time) -> Option<f64> {
    if !task.clauses.has(StepClauses::CONTENTION) {
        return None;
    }
    let step = task.step()?;
    if !matches!(task.origin, crate::state::task::Origin::Step(_)) {
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

/// Returns the present errors of the step's priority clauses and rank. A clause with an error counts as absent, and each error must be
/// reported.
pub(crate) fn troubles(cycle: &Cycle<'_>, id: TaskId, step: &Step) -> Vec<(String, Place)> {
    let view = cycle.view(id, Level::Step);
    let trouble = |(what, expr): (&str, &Expr)| match evaluate(expr, &view) {
        Ok(value) if value.as_number().is_some_and(|(number, _)| number.is_finite()) => None,
        Ok(value) => Some((format!("its {what} is {value}, which is not a number"), expr.place)),
        Err(error) => Some((format!("its {what} has no value: {}", error.message), error.place)),
    };
    let priorities = step.priority.iter().flat_map(|clause| match clause {
        PriorityClause::Number(expr) => vec![expr],
        PriorityClause::UrgencyImportance(urgency, importance) => vec![urgency, importance],
    });
    let priorities = priorities.map(|expr| ("priority", expr));
    priorities.chain(step.rank.iter().map(|expr| ("rank", &**expr))).filter_map(trouble).collect()
}

/// Returns the priority that a clause states; `None` if it cannot be evaluated, which [`troubles`] has reported.
fn clause_priority(clause: &PriorityClause, task: &Task, view: &View<'_>, at: Time) -> Option<f64> {
    match clause {
        PriorityClause::Number(expr) => number(expr, view),
        PriorityClause::UrgencyImportance(urgency, importance) => {
            let urgency = urgency_at(number(urgency, view)?, created(task), at);
            let importance = number(importance, view)?.clamp(0.0, 10.0);
            Some(combined(urgency, importance, view.agent.workload))
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

/// Returns the instant of the task's creation, which a restart does not change.
fn created(task: &Task) -> Time {
    task.extras.as_ref().and_then(|extras| extras.first_created).unwrap_or(task.created_at)
}

/// Returns the deadline of a task that had this urgency at its creation.
fn deadline(urgency: f64, created_at: Time) -> Time {
    created_at + Duration::from_seconds(libm::exp2(9.0 - urgency.clamp(0.0, 10.0)))
}

/// Returns the urgency at `at`: it rises towards the deadline, and is 10 from half a second before it.
fn urgency_at(urgency: f64, created_at: Time, at: Time) -> f64 {
    urgency_before(deadline(urgency, created_at), at)
}

fn urgency_before(due: Time, at: Time) -> f64 {
    let left = (due - at).seconds();
    if left <= 0.5 { 10.0 } else { (9.0 - libm::log2(left)).clamp(0.0, 10.0) }
}

/// Combines urgency and importance into a priority; a higher workload (1 to 9) gives more weight to importance.
fn combined(urgency: f64, importance: f64, workload: f64) -> f64 {
    (importance * workload * (1.0 - 1.0 / (1.0 + urgency))
        + urgency * (10.0 - workload) * (1.0 - 1.0 / (1.0 + importance)))
        / 9.0
}

/// Returns the recovered fraction of a repeated task's priority.
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

/// Returns true if an arithmetic expression reads a variable; `None` if its value depends on anything but variables and constants.
pub(crate) fn reads_variable(expr: &Expr) -> Option<bool> {
    const ARITHMETIC: [&str; 7] = ["+", "-", "*", "/", "min", "max", "abs"];
    match &expr.kind {
        ExprKind::Constant(_) => Some(false),
        ExprKind::Variable { .. } => Some(true),
        ExprKind::Call { function, arguments } if ARITHMETIC.iter().any(|name| function.is(name)) => {
            arguments.iter().try_fold(false, |reads, argument| Some(reads | reads_variable(argument)?))
        }
        _ => None,
    }
}

/// Returns true if measurements or states of tasks may change what the task brings into a conflict.
pub(crate) fn reads_inputs(agent: &Agent, id: TaskId) -> bool {
    let computed = |expr: &Expr| reads_variable(expr).is_none();
    cost_clause(agent, id).is_some_and(|(expr, _)| computed(expr))
        || clauses_above(agent, id).any(|(_, clause)| match clause {
            PriorityClause::Number(expr) => computed(expr),
            PriorityClause::UrgencyImportance(urgency, importance) => computed(urgency) || computed(importance),
        })
}

/// Returns true if the passing of time changes what the task brings into a conflict.
pub(crate) fn moves(agent: &Agent, id: TaskId) -> bool {
    cost_moves(agent, id)
        || clauses_above(agent, id).any(|(task, clause)| match clause {
            _ if recovery_span(agent, task).is_some() => true,
            PriorityClause::Number(expr) => value_intervals::moves(expr, &agent.library),
            PriorityClause::UrgencyImportance(..) => true,
        })
}

/// Returns true if the passing of time changes the interrupt cost of the task.
pub(crate) fn cost_moves(agent: &Agent, id: TaskId) -> bool {
    cost_clause(agent, id).is_some_and(|(expr, _)| value_intervals::moves(expr, &agent.library))
}

/// Returns the priority clauses of the task and of its ancestors.
fn clauses_above(agent: &Agent, id: TaskId) -> impl Iterator<Item = (&Task, &PriorityClause)> {
    let family = std::iter::successors(agent.task(id), |task| agent.task(task.parent?));
    family.flat_map(|task| {
        let step = task.step().filter(|_| matches!(task.origin, crate::state::task::Origin::Step(_)));
        let template = step.and_then(|step| agent.procedure(step.procedure)?.steps.get(step.step as usize));
        template.into_iter().flat_map(|step| &step.priority).map(move |clause| (task, clause))
    })
}

/// Returns the clauses of the task, and those of its ancestors that are not interrupted.
pub(crate) fn clauses_that_count(agent: &Agent, id: TaskId) -> impl Iterator<Item = (&Task, &PriorityClause)> {
    clauses_above(agent, id).filter(move |(task, _)| task.id == id || task.state != TaskState::Interrupted)
}

/// Change of a priority clause while only time passes.
pub(crate) enum PriorityChange {
    /// The clause has no number.
    Absent,
    /// The value is constant.
    Steady(f64),
    /// The value rises with its urgency until that is 10.
    Rising(RisingTerm),
    /// The value changes in another way; [`clause_bounds`] gives bounds.
    Other,
}

/// Returns the change of the clause from `now` on.
pub(crate) fn kind(agent: &Agent, task: &Task, clause: &PriorityClause, now: Time) -> PriorityChange {
    let parts: &[&Expr] = match clause {
        PriorityClause::Number(expr) => &[expr],
        PriorityClause::UrgencyImportance(urgency, importance) => &[urgency, importance],
    };
    if recovery(agent, task, now) < 1.0 || parts.iter().any(|expr| value_intervals::moves(expr, &agent.library)) {
        return PriorityChange::Other;
    }
    let view = View { agent, task: task.id, level: Level::Step, now };
    let found = match clause {
        PriorityClause::Number(expr) => number(expr, &view).map(PriorityChange::Steady),
        PriorityClause::UrgencyImportance(urgency, importance) => {
            number(urgency, &view).zip(number(importance, &view)).map(|(urgency, importance)| {
                let (due, importance) = (deadline(urgency, created(task)), importance.clamp(0.0, 10.0));
                PriorityChange::Rising(RisingTerm { importance, due })
            })
        }
    };
    found.unwrap_or(PriorityChange::Absent)
}

/// Returns the value at `at` of a priority that rises with its urgency.
pub(crate) fn risen(agent: &Agent, rise: RisingTerm, at: Time) -> f64 {
    combined(urgency_before(rise.due, at), rise.importance, agent.workload)
}

/// Returns bounds of the interrupt cost of the task between two instants.
pub(crate) fn cost_bounds(agent: &Agent, id: TaskId, from: Time, to: Time) -> Bounds {
    let cost = match cost_clause(agent, id) {
        Some((expr, level)) if value_intervals::moves(expr, &agent.library) => {
            value_intervals::bounds(expr, &View { agent, task: id, level, now: from }, to)
        }
        _ => {
            let cost = interrupt_cost_at(agent, id, from);
            Some(Bounds { low: cost, high: cost })
        }
    };
    cost.map_or(Bounds::ANY, |cost| cost.greater(Bounds { low: 0.0, high: 0.0 }))
}

/// Returns bounds of the priority that a clause states between two instants. Urgency and recovery never decrease, so their values at both
/// instants are their bounds.
pub(crate) fn clause_bounds(
    agent: &Agent,
    task: &Task,
    clause: &PriorityClause,
    from: Time,
    to: Time,
) -> Option<Bounds> {
    let view = View { agent, task: task.id, level: Level::Step, now: from };
    let value = match clause {
        PriorityClause::Number(expr) => value_intervals::bounds(expr, &view, to)?,
        PriorityClause::UrgencyImportance(urgency, importance) => {
            let (urgency, importance) =
                (value_intervals::bounds(urgency, &view, to)?, value_intervals::bounds(importance, &view, to)?);
            let at = |urgency: f64, importance: f64, at: Time| {
                let urgency = urgency_at(urgency.clamp(0.0, 10.0), created(task), at);
                combined(urgency, importance.clamp(0.0, 10.0), agent.workload)
            };
            Bounds { low: at(urgency.low, importance.low, from), high: at(urgency.high, importance.high, to) }
        }
    };
    let (first, last) = (recovery(agent, task, from), recovery(agent, task, to));
    if first == 1.0 {
        return Some(value);
    }
    Some(Bounds::of(&[first * value.low, first * value.high, last * value.low, last * value.high]))
}

/// Returns the `interrupt-cost` clause that counts for the task: that of its step, otherwise that of its procedure.
pub(crate) fn cost_clause(agent: &Agent, id: TaskId) -> Option<(&Expr, Level)> {
    let task = agent.task(id)?;
    let stated = task.selection.is_some() && task.clauses.has(StepClauses::CONTENTION);
    if let (crate::state::task::Origin::Step(step), true) = (task.origin, stated)
        && let Some(expr) = agent.procedure(step.procedure)?.steps.get(step.step as usize)?.interrupt_cost.as_deref()
    {
        return Some((expr, Level::Step));
    }
    match &task.selection.as_ref()?.way {
        MethodBinding::Procedure(reference, _) => {
            agent.procedure(*reference)?.interrupt_cost.as_ref().map(|expr| (expr, Level::Procedure))
        }
        MethodBinding::Primitive(..)
        | MethodBinding::Items(_)
        | MethodBinding::BuiltIn(_)
        | MethodBinding::Terminate
        | MethodBinding::Solver(_) => None,
    }
}

/// Returns the rank of a task among its siblings, if it has one.
pub(crate) fn rank(agent: &Agent, id: TaskId, now: Time) -> Option<f64> {
    let task = agent.task(id).filter(|task| task.clauses.has(StepClauses::RANK))?;
    let crate::state::task::Origin::Step(step) = task.origin else { return None };
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

/// Returns true if the task or one of its ancestors has a rank.
pub(crate) fn is_ranked(agent: &Agent, id: TaskId) -> bool {
    let mut family = std::iter::successors(agent.task(id), |task| agent.task(task.parent?));
    family.any(|task| rank(agent, task.id, agent.now).is_some())
}

/// Returns the value of an `interrupt-cost` clause.
///
/// # Errors
/// A message if it is not a number.
pub(crate) fn interrupt_cost(expr: &Expr, context: &dyn EvalContext) -> Result<f64, String> {
    let value = evaluate(expr, context).map_err(|error| error.message)?;
    let number = value.as_number().map(|(number, _)| number);
    number.ok_or_else(|| format!("{value} is not an interrupt cost; write a number"))
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
        assert!((combined(9.0, 9.0, 5.0) - 9.0).abs() < 1e-12);
        assert_eq!(combined(0.0, 0.0, 5.0), 0.0);
    }
}
