//! Primitive invocation (TC)
//! What: runs a primitive until it is complete: its forms, its clock, its commands and their answers.
//! Runs: act phase, on answers and wakes, at interruptions.  Reads: Primitive.  Writes: PrimitiveController, wakes, commands.
//! Bound: O(1) per call in addition to the evaluation of its forms.  PDL: section 5.  Paper: section III, primitive actions.

use crate::control::cycle::Cycle;
use crate::control::tasks::hooks::{self, CommandRequest};
use crate::control::tasks::termination;
use crate::expression::evaluate;
use crate::planted::{self, Bug};
use crate::state::bindings::Bindings;
use crate::state::clause::Level;
use crate::state::controller::{Controller, OpenCommand, PrimitiveController};
use crate::state::wake::Wake;
use apex_model::because::{Because, Cause};
use apex_model::effect::{CommandId, Effect};
use apex_model::event::{COMMAND_STATE, CommandProgress, StateVariable};
use apex_model::expression::Expr;
use apex_model::limits::{COMMAND_TIMEOUT_DEFAULT_S, UPDATE_INTERVAL_DEFAULT_MS};
use apex_model::procedure::Primitive;
use apex_model::symbol::Symbol;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::{Duration, NANOSECONDS_PER_SECOND};
use apex_model::value::Value;

fn controller<'c>(cycle: &'c mut Cycle<'_>, id: TaskId) -> Option<&'c mut PrimitiveController> {
    match cycle.agent.task_mut(id)?.controller.as_deref_mut()? {
        Controller::Primitive(controller) => Some(controller),
        _ => None,
    }
}

fn template<'a>(cycle: &mut Cycle<'a>, id: TaskId) -> Option<&'a Primitive> {
    let index = controller(cycle, id)?.primitive;
    cycle.library.primitives.get(index as usize).map(|primitive| &**primitive)
}

/// Begins the primitive as the task's controller.
pub(crate) fn start(cycle: &mut Cycle<'_>, id: TaskId, index: u32, context: Bindings) {
    let now = cycle.now;
    let library = cycle.library;
    let Some(primitive) = library.primitives.get(index as usize) else { return };
    if is_bare(primitive) {
        let because = Because::new(Cause::CompletedAtOnce, Some(primitive.place));
        return termination::end(cycle, id, Outcome::Success(Value::nil()), because);
    }
    let fresh =
        PrimitiveController { primitive: index, context, running_since: Some(now), ..PrimitiveController::default() };
    if let Some(task) = cycle.agent.task_mut(id) {
        task.controller = Some(Box::new(Controller::Primitive(fresh)));
    }
    if let Err(because) = begin(cycle, id, primitive) {
        termination::fail(cycle, id, because);
    }
}

/// Returns true if the primitive has no forms and nothing to wait for; it is then complete without a controller.
fn is_bare(primitive: &Primitive) -> bool {
    let Primitive { locals, hooks, on_completion, duration, update, returns, .. } = primitive;
    let forms = [&hooks.on_start, &hooks.on_end, &hooks.on_suspend, &hooks.on_resume, on_completion];
    locals.is_empty()
        && forms.into_iter().all(Vec::is_empty)
        && duration.is_none()
        && update.is_none()
        && returns.is_none()
}

fn begin(cycle: &mut Cycle<'_>, id: TaskId, primitive: &Primitive) -> Result<(), Because> {
    for (name, expr) in &primitive.locals {
        let value = value_of(cycle, id, expr)?;
        if let Some(controller) = controller(cycle, id) {
            controller.locals.set(name.clone(), value);
        }
    }
    let wants = hooks::run_forms(cycle, id, Level::Procedure, "on-start", &primitive.hooks.on_start)?;
    if cycle.state(id) != TaskState::Ongoing {
        return Ok(());
    }
    for CommandRequest { form, timeout, because } in wants.commands {
        send(cycle, id, form, timeout, because);
    }
    let duration = match &primitive.duration {
        Some(expr) => Some(span(cycle, id, expr)?),
        None => None,
    };
    let interval = match &primitive.update {
        Some((Some(expr), _)) => Some(positive(span(cycle, id, expr)?, expr)?),
        Some((None, _)) => Some(Duration(UPDATE_INTERVAL_DEFAULT_MS * (NANOSECONDS_PER_SECOND / 1000))),
        None => None,
    };
    if let Some(controller) = controller(cycle, id) {
        controller.duration = duration;
        controller.update_interval = interval;
        controller.update_left = interval.unwrap_or_default();
    }
    if let Some(value) = wants.completed {
        complete(cycle, id, Cause::CompletedByForm, Some(value));
    } else {
        run_clock(cycle, id);
    }
    Ok(())
}

fn value_of(cycle: &Cycle<'_>, id: TaskId, expr: &Expr) -> Result<Value, Because> {
    evaluate(expr, &cycle.view(id, Level::Procedure))
        .map_err(|error| Because::new(Cause::ExpressionFailed { message: error.message }, Some(error.place)))
}

fn span(cycle: &Cycle<'_>, id: TaskId, expr: &Expr) -> Result<Duration, Because> {
    match value_of(cycle, id, expr)? {
        Value::Duration(span) if span < Duration::ZERO => {
            let message = format!("a duration of {span} is negative; write zero or more, for example `(max 0s ..)`");
            Err(Because::new(Cause::ExpressionFailed { message }, Some(expr.place)))
        }
        Value::Duration(span) => Ok(span),
        Value::Integer(0) => Ok(Duration::ZERO),
        other => {
            let message = format!("{other} is not a span of time; write a duration such as 10s");
            Err(Because::new(Cause::ExpressionFailed { message }, Some(expr.place)))
        }
    }
}

fn positive(interval: Duration, expr: &Expr) -> Result<Duration, Because> {
    if interval > Duration::ZERO {
        return Ok(interval);
    }
    let message = format!("time would not pass with an update every {interval}; write an interval above zero");
    Err(Because::new(Cause::ExpressionFailed { message }, Some(expr.place)))
}

/// Schedules the rest of the duration and update interval; a primitive with nothing to wait for is complete.
fn run_clock(cycle: &mut Cycle<'_>, id: TaskId) {
    let now = cycle.now;
    let Some(state) = controller(cycle, id) else { return };
    state.running_since = Some(now);
    let (duration, worked, commanded) = (state.duration, state.worked, state.commanded);
    let update = state.update_interval.map(|_| now + state.update_left);
    match duration {
        Some(duration) if duration <= worked => {
            return complete(cycle, id, Cause::DurationElapsed { duration }, None);
        }
        None if update.is_none() && !commanded => return complete(cycle, id, Cause::CompletedAtOnce, None),
        Some(_) | None => {}
    }
    let end = duration.map(|duration| cycle.agent.wakes.schedule(now + (duration - worked), Wake::Duration(id)));
    let update = update.map(|at| cycle.agent.wakes.schedule(at, Wake::Update(id)));
    if let Some(state) = controller(cycle, id) {
        state.end = end;
        state.update = update;
    }
}

/// Sends a command for the primitive; its answer is awaited.
fn send(cycle: &mut Cycle<'_>, id: TaskId, form: Value, timeout: Option<Duration>, because: Because) {
    let command = command(cycle, id, form, timeout, because);
    if let Some(state) = controller(cycle, id) {
        state.commands.push(command);
        state.commanded = true;
    }
}

/// Sends a command. If no task waits for its answer, its failure is only reported.
pub(crate) fn command(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    form: Value,
    timeout: Option<Duration>,
    because: Because,
) -> CommandId {
    let default = Duration(COMMAND_TIMEOUT_DEFAULT_S.saturating_mul(NANOSECONDS_PER_SECOND));
    let patience = timeout.unwrap_or(default);
    let command = CommandId(cycle.agent.next.command);
    cycle.agent.next.command += 1;
    let now = cycle.now;
    let timeout = cycle.agent.wakes.schedule(now + patience, Wake::CommandTimeout(command));
    let open = OpenCommand { task: id, form: form.clone(), sent_at: now, patience, timeout };
    cycle.agent.commands.insert(command, open);
    cycle.effects.push(Effect::Command { command, task: id, form, because });
    tell_state(cycle, id, command, "sent");
    command
}

/// Publishes the state of a command as `(command-state TASK)`, where the program names that.
fn tell_state(cycle: &mut Cycle<'_>, id: TaskId, command: CommandId, state: &str) {
    if !cycle.index.names_command_states {
        return;
    }
    let variable = StateVariable::new(Symbol::new(COMMAND_STATE), Value::Task(id));
    let because = Because::new(Cause::CommandMoved { command }, cycle.place_of(id));
    cycle.publish_own(id, (variable, Value::symbol(state)), because);
}

/// Handles a progress report of the vehicle about a command.
pub(crate) fn progressed(cycle: &mut Cycle<'_>, command: CommandId, progress: CommandProgress) {
    match cycle.agent.commands.get(&command).map(|open| open.task) {
        Some(id) => tell_state(cycle, id, command, progress.word()),
        None if command.0 >= cycle.agent.next.command => {
            cycle.trouble_of(None, Cause::StrayAnswer { to: format!("command {}", command.0) }, None);
        }
        None => {}
    }
}

/// Completes the primitive: `on-completion`, then its value, then its end.
pub(crate) fn complete(cycle: &mut Cycle<'_>, id: TaskId, cause: Cause, value: Option<Value>) {
    let Some(primitive) = template(cycle, id) else { return };
    let place = Some(primitive.place);
    if let Err(because) = hooks::run_needed(cycle, id, Level::Procedure, "on-completion", &primitive.on_completion) {
        return termination::fail(cycle, id, because);
    }
    if cycle.state(id) == TaskState::Terminated {
        return;
    }
    let value = match &primitive.returns {
        Some(expr) => match value_of(cycle, id, expr) {
            Ok(value) => value,
            Err(because) => return termination::fail(cycle, id, because),
        },
        None => value.or_else(|| controller(cycle, id)?.answer.take()).unwrap_or_else(Value::nil),
    };
    termination::end(cycle, id, Outcome::Success(value), Because::new(cause, place));
}

/// Handles the end of the primitive's duration.
pub(crate) fn duration_over(cycle: &mut Cycle<'_>, id: TaskId) {
    let Some(state) = controller(cycle, id) else { return };
    state.end = None;
    let duration = state.duration.unwrap_or_default();
    complete(cycle, id, Cause::DurationElapsed { duration }, None);
}

/// Runs the update forms, which are due.
pub(crate) fn update(cycle: &mut Cycle<'_>, id: TaskId) {
    let now = cycle.now;
    let Some(primitive) = template(cycle, id) else { return };
    let Some(state) = controller(cycle, id) else { return };
    state.update = None;
    let interval = state.update_interval.unwrap_or_default();
    let Some((_, forms)) = &primitive.update else { return };
    let wants = match hooks::run_forms(cycle, id, Level::Procedure, "update", forms) {
        Ok(wants) => wants,
        Err(because) => return termination::fail(cycle, id, because),
    };
    for CommandRequest { form, timeout, because } in wants.commands {
        send(cycle, id, form, timeout, because);
    }
    if let Some(value) = wants.completed {
        return complete(cycle, id, Cause::CompletedByForm, Some(value));
    }
    if cycle.state(id) == TaskState::Ongoing && controller(cycle, id).is_some() {
        let next = cycle.agent.wakes.schedule(now + interval, Wake::Update(id));
        if let Some(state) = controller(cycle, id) {
            state.update = Some(next);
        }
    }
}

/// Handles the vehicle's answer to a command.
pub(crate) fn answered(cycle: &mut Cycle<'_>, command: CommandId, answer: &Result<Value, String>) {
    if !cycle.agent.commands.contains_key(&command) {
        // A late answer to a withdrawn command is ignored; an answer to a command that was never sent is reported.
        if command.0 >= cycle.agent.next.command {
            cycle.trouble_of(None, Cause::StrayAnswer { to: format!("command {}", command.0) }, None);
        }
        return;
    }
    let answer = answer.as_ref().map_err(|reason| Cause::CommandFailed { command, reason: reason.clone() });
    settle(cycle, command, answer.cloned());
}

/// Settles a command that has its answer, or has failed.
fn settle(cycle: &mut Cycle<'_>, command: CommandId, answer: Result<Value, Cause>) {
    let Some(open) = cycle.agent.commands.remove(&command) else { return };
    cycle.agent.wakes.cancel(open.timeout);
    let id = open.task;
    let state = match &answer {
        Ok(_) => "done",
        Err(Cause::CommandTimedOut { .. }) => "timed-out",
        Err(_) => "failed",
    };
    tell_state(cycle, id, command, state);
    let Some(state) = controller(cycle, id).filter(|state| state.commands.contains(&command)) else {
        if let Err(cause) = answer {
            let place = cycle.place_of(id);
            cycle.trouble_of(Some(id), cause, place);
        }
        return;
    };
    state.commands.retain(|each| *each != command);
    match answer {
        Ok(value) => {
            state.answer = Some(value);
            if state.commands.is_empty() && state.duration.is_none() {
                complete(cycle, id, Cause::CommandAcknowledged { command }, None);
            }
        }
        Err(cause) => {
            let place = template(cycle, id).map(|primitive| primitive.place);
            termination::fail(cycle, id, Because::new(cause, place));
        }
    }
}

/// Handles the timeout of a command: the command has failed, and the vehicle is requested to stop it.
pub(crate) fn timed_out(cycle: &mut Cycle<'_>, command: CommandId) {
    let Some(open) = cycle.agent.commands.get(&command) else { return };
    let patience = open.patience;
    cycle.effects.push(Effect::WithdrawCommand { command, reason: format!("no answer within {patience}") });
    settle(cycle, command, Err(Cause::CommandTimedOut { command, patience }));
}

/// Takes back the commands that have no answer yet. Returns their forms and timeouts.
pub(crate) fn withdraw_commands(cycle: &mut Cycle<'_>, id: TaskId, reason: &str) -> Vec<(Value, Duration)> {
    let commands = controller(cycle, id).map(|state| std::mem::take(&mut state.commands)).unwrap_or_default();
    let mut withdrawn = Vec::new();
    for command in commands {
        if let Some(open) = cycle.agent.commands.remove(&command) {
            cycle.agent.wakes.cancel(open.timeout);
            cycle.effects.push(Effect::WithdrawCommand { command, reason: reason.to_string() });
            tell_state(cycle, id, command, "withdrawn");
            withdrawn.push((open.form, open.patience));
        }
    }
    withdrawn
}

/// Stops the primitive's clock and takes its commands back.
pub(crate) fn pause(cycle: &mut Cycle<'_>, id: TaskId) {
    let now = cycle.now;
    let withdrawn = withdraw_commands(cycle, id, "its task was interrupted");
    let Some(state) = controller(cycle, id) else { return };
    state.withdrawn = withdrawn;
    if let Some(since) = state.running_since.take() {
        let before = if planted::is(Bug::ClockStartsOver) { now } else { since };
        state.worked = state.worked + (now - before);
    }
    let (end, update) = (state.end.take(), state.update.take());
    if let Some(update) = update {
        state.update_left = update.at - now;
    }
    for wake in [end, update].into_iter().flatten() {
        cycle.agent.wakes.cancel(wake);
    }
}

/// Lets the primitive continue: its clock runs, `on-resume` runs, and commands are sent again unless it sent others.
pub(crate) fn resume(cycle: &mut Cycle<'_>, id: TaskId) {
    let Some(primitive) = template(cycle, id) else { return };
    let wants = match hooks::run_forms(cycle, id, Level::Procedure, "on-resume", &primitive.hooks.on_resume) {
        Ok(wants) => wants,
        Err(because) => return termination::fail(cycle, id, because),
    };
    if cycle.state(id) != TaskState::Ongoing {
        return;
    }
    let Some(state) = controller(cycle, id) else { return };
    let again = std::mem::take(&mut state.withdrawn);
    if let Some(value) = wants.completed {
        return complete(cycle, id, Cause::CompletedByForm, Some(value));
    }
    if wants.commands.is_empty() {
        for (form, patience) in again {
            let because = Because::new(Cause::SentAgain, Some(primitive.place));
            send(cycle, id, form, Some(patience), because);
        }
    }
    for CommandRequest { form, timeout, because } in wants.commands {
        send(cycle, id, form, timeout, because);
    }
    run_clock(cycle, id);
}
