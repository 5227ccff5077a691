//! Built-in activities (TC)
//! What: executes `terminate`, `reset`, `suspend`, `resume`, `print`, `inform`, `ask` and the other built-ins.
//! Runs: act phase.  Reads: arguments.  Writes: tasks named by the arguments, effects.
//! Bound: O(1) in addition to the subtree concerned.  PDL: section 4, built-in activities.  Paper: section III.

use crate::control::conflicts::resources;
use crate::control::cycle::Cycle;
use crate::control::tasks::goal::activity_of;
use crate::control::tasks::{interruption, messaging, question, repetition, restart, termination};
use crate::deliberation::planner_invocation;
use crate::expression::{evaluate, printed};
use crate::state::clause::Level;
use crate::state::controller::Controller;
use apex_model::because::{Because, Cause};
use apex_model::effect::Effect;
use apex_model::expression::Expr;
use apex_model::procedure::{Activity, BuiltInActivity};
use apex_model::source::Place;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::value::Value;

fn evaluated(cycle: &Cycle<'_>, id: TaskId, expr: &Expr) -> Result<Value, Because> {
    evaluate(expr, &cycle.view(id, Level::Step))
        .map_err(|error| Because::new(Cause::ExpressionFailed { message: error.message }, Some(error.place)))
}

/// Returns the position of the last argument, for errors about it; the default position without arguments.
fn place(arguments: &[Expr]) -> Place {
    arguments.last().map(|argument| argument.place).unwrap_or_default()
}

/// Returns the task that an argument names.
fn task_argument(value: &Value, expr: &Expr) -> Result<TaskId, Because> {
    match value {
        Value::Task(task) => Ok(*task),
        other => {
            let message = format!("{other} is not a task; name a step by its tag, such as ?s1");
            Err(Because::new(Cause::ExpressionFailed { message }, Some(expr.place)))
        }
    }
}

/// Carries out a built-in activity.
pub(crate) fn start(cycle: &mut Cycle<'_>, id: TaskId, which: BuiltInActivity) {
    if let Some(task) = cycle.agent.task_mut(id) {
        task.controller = Some(Box::new(Controller::BuiltIn));
    }
    let Some(handle) = cycle.step_of(id) else { return };
    let origin = cycle.task(id).map(|task| task.origin);
    let Some(Activity::BuiltIn(_, arguments)) = handle.get().map(|step| activity_of(origin, step)) else {
        return;
    };
    match carry_out(cycle, id, which, arguments) {
        Ok(Some(value)) => done(cycle, id, which.word(), value),
        Ok(None) => {}
        Err(because) => termination::fail(cycle, id, because),
    }
}

fn done(cycle: &mut Cycle<'_>, id: TaskId, activity: &'static str, value: Value) {
    if cycle.state(id) == TaskState::Ongoing {
        let because = Because::new(Cause::BuiltInDone { activity: activity.into() }, cycle.place_of(id));
        termination::end(cycle, id, Outcome::Success(value), because);
    }
}

/// Executes the activity; a returned value means that it is complete at once.
fn carry_out(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    which: BuiltInActivity,
    arguments: &[Expr],
) -> Result<Option<Value>, Because> {
    let mut values = Vec::with_capacity(arguments.len());
    for argument in arguments {
        values.push(evaluated(cycle, id, argument)?);
    }
    let first = || values.first().cloned().unwrap_or_else(Value::nil);
    match which {
        BuiltInActivity::Print => cycle.effects.push(Effect::Print { task: id, text: printed(&values) }),
        BuiltInActivity::Inform => messaging::inform(cycle, id, first(), values.get(1), place(arguments))?,
        BuiltInActivity::Cogevent => messaging::cogevent(cycle, id, first(), values.get(1), place(arguments))?,
        BuiltInActivity::Reset | BuiltInActivity::Suspend | BuiltInActivity::Resume | BuiltInActivity::Reprioritize => {
            let Some(argument) = arguments.first() else { return Ok(Some(Value::nil())) };
            let task = task_argument(&first(), argument)?;
            on_task(cycle, id, which, task);
        }
        BuiltInActivity::HoldResource => hand_to_parent(cycle, id),
        BuiltInActivity::ReleaseResource => release_of_parent(cycle, id, &values),
        BuiltInActivity::EndApplication => {
            let reason = values.first().cloned().filter(Value::is_true);
            termination::end_application(cycle, id, reason);
        }
        BuiltInActivity::AskOperator => {
            question::ask(cycle, id, &values, place(arguments))?;
            return Ok(None);
        }
        BuiltInActivity::Plan => {
            planner_invocation::plan(cycle, id, &values)?;
            return Ok(None);
        }
    }
    Ok(Some(Value::nil()))
}

fn on_task(cycle: &mut Cycle<'_>, id: TaskId, which: BuiltInActivity, task: TaskId) {
    let because = |activity: &'static str| {
        Because::new(Cause::Activity { by: id, activity: activity.into() }, cycle.place_of(id))
    };
    match which {
        BuiltInActivity::Reset => {
            let because = because("reset");
            restart::restart(cycle, task, because);
        }
        BuiltInActivity::Suspend => {
            let because = because("suspend");
            interruption::suspend(cycle, task, because);
        }
        BuiltInActivity::Resume => {
            let because = because("resume");
            interruption::resume(cycle, task, &because);
            let window = interruption::window_from_here(cycle);
            interruption::watch_suspension(cycle, task, window);
        }
        _ => cycle.work.priorities_changed = true,
    }
}

/// Passes the resources granted to `(hold-resource ..)` to the procedure: its steps share them.
fn hand_to_parent(cycle: &mut Cycle<'_>, id: TaskId) {
    let needs = resources::needs_of(cycle, id);
    let Some(parent) = cycle.task(id).and_then(|task| task.parent) else { return };
    resources::release(cycle, id, resources::Release::Unused);
    if let Some(selection) = cycle.agent.task_mut(id).and_then(|task| task.selection.as_mut()) {
        selection.needs.clear();
    }
    let held = resources::needs_of(cycle, parent);
    for need in needs.iter().filter(|need| held.iter().all(|each| each.resource != need.resource)) {
        resources::take(cycle, parent, &[*need]);
        if let Some(task) = cycle.agent.task_mut(parent) {
            task.extras_mut().held.push(*need);
        }
    }
}

fn release_of_parent(cycle: &mut Cycle<'_>, id: TaskId, names: &[Value]) {
    let Some(parent) = cycle.task(id).and_then(|task| task.parent) else { return };
    let library = cycle.library;
    let parts = names.iter().filter_map(Value::as_symbol).flat_map(|name| library.parts_of(name));
    let parts: Vec<Value> = parts.map(|part| Value::Symbol(part.clone())).collect();
    for name in names.iter().chain(&parts) {
        let Some(resource) = cycle.agent.resources.find(name) else { continue };
        let Some(extras) = cycle.agent.task_mut(parent).and_then(|task| task.extras.as_mut()) else { continue };
        let before = extras.held.len();
        extras.held.retain(|need| need.resource != resource);
        if extras.held.len() < before {
            resources::release_one(cycle, parent, resource, resources::Release::Used);
        }
    }
}

/// Executes `(terminate [task] [outcome] [>> value])`: ends the named task; without a name, the procedure of the step.
pub(crate) fn terminate(cycle: &mut Cycle<'_>, id: TaskId) {
    if let Some(task) = cycle.agent.task_mut(id) {
        task.controller = Some(Box::new(Controller::BuiltIn));
    }
    let target = match terminate_target(cycle, id) {
        Ok(target) => target,
        Err(because) => return termination::fail(cycle, id, because),
    };
    let (place, answered) = (cycle.place_of(id), cycle.task(id).and_then(|task| task.after_sequence));
    done(cycle, id, "terminate", Value::nil());
    let Some((target, outcome, explicit)) = target else { return };
    let because = Because::new(Cause::Activity { by: id, activity: "terminate".into() }, place);
    if explicit {
        repetition::forbid(cycle, target, Level::Step);
    }
    if let Some(task) = cycle.agent.task_mut(target) {
        task.after_sequence = task.after_sequence.max(answered);
    }
    if outcome == Outcome::Failure {
        termination::fail(cycle, target, because);
    } else {
        termination::end(cycle, target, outcome, because);
    }
}

type TaskToEnd = Option<(TaskId, Outcome, bool)>;

fn terminate_target(cycle: &Cycle<'_>, id: TaskId) -> Result<TaskToEnd, Because> {
    let Some(handle) = cycle.step_of(id) else { return Ok(None) };
    let origin = cycle.task(id).map(|task| task.origin);
    let Some(Activity::Terminate { task, outcome, value }) = handle.get().map(|step| activity_of(origin, step)) else {
        return Ok(None);
    };
    let target = match task {
        Some(expr) => Some(task_argument(&evaluated(cycle, id, expr)?, expr)?),
        None => procedure_of(cycle, id),
    };
    let value = match value {
        Some(expr) => evaluated(cycle, id, expr)?,
        None => Value::nil(),
    };
    let outcome = match outcome {
        Some(expr) => outcome_named(&evaluated(cycle, id, expr)?, value),
        None if task.is_some() && !value.is_true() => Outcome::Cut,
        None => Outcome::Success(value),
    };
    Ok(target.map(|target| (target, outcome, task.is_some())))
}

/// Returns the task whose procedure contains the step, above items and failure handlers.
fn procedure_of(cycle: &Cycle<'_>, id: TaskId) -> Option<TaskId> {
    let mut parent = cycle.task(id)?.parent?;
    loop {
        let task = cycle.task(parent)?;
        match task.controller.as_deref() {
            Some(Controller::Items(_) | Controller::Handling(_)) => parent = task.parent?,
            _ => return Some(parent),
        }
    }
}

fn outcome_named(name: &Value, value: Value) -> Outcome {
    let is = |words: &[&str]| name.as_symbol().is_some_and(|symbol| words.iter().any(|word| symbol.is(word)));
    if is(&["failure", "fail", "failed"]) {
        Outcome::Failure
    } else if is(&["cut", "abort", "aborted"]) {
        Outcome::Cut
    } else {
        Outcome::Success(value)
    }
}
