//! Hooks (TC)
//! What: evaluates the forms of `on-start`, `on-end` and the other hooks, and executes the actions that they request.
//! Runs: act phase, at ends, interruptions and resumptions.  Reads: forms, variables.  Writes: effects, variables.
//! Bound: by the limits of evaluation.  PDL: `on-start`, `on-end`, `on-suspend`, `on-resume`, `update`, section 6.
//! Paper: section III, code embedded in the `on-enablement` clause.

use crate::control::conflicts::resources;
use crate::control::cycle::Cycle;
use crate::control::tasks::{binding, messaging, primitive, termination};
use crate::expression::{Action, run};
use crate::state::bindings::Bindings;
use crate::state::clause::Level;
use crate::state::controller::Controller;
use apex_model::because::{Because, Cause};
use apex_model::effect::{DecisionKind, Effect};
use apex_model::expression::Expr;
use apex_model::task::TaskId;
use apex_model::time::Duration;
use apex_model::value::Value;

/// Requests of a primitive's forms for the primitive itself.
#[derive(Default)]
pub(crate) struct HookRequests {
    /// `(complete [value])`.
    pub(crate) completed: Option<Value>,
    /// `(command FORM)`s in order.
    pub(crate) commands: Vec<CommandRequest>,
}

/// A command that a form requests.
pub(crate) struct CommandRequest {
    /// The form, with every variable replaced by its value.
    pub(crate) form: Value,
    /// Time limit for the answer; `None`: the default.
    pub(crate) timeout: Option<Duration>,
    /// Cause of the command: the clause and source position of the form.
    pub(crate) because: Because,
}

/// Runs a hook of a task that begins or completes. The task does not wait for the answers to the commands of the hook.
///
/// # Errors
/// The cause of the task's failure if a form cannot be evaluated.
pub(crate) fn run_needed(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    level: Level,
    clause: &'static str,
    forms: &[Expr],
) -> Result<(), Because> {
    let wants = run_forms(cycle, id, level, clause, forms)?;
    for CommandRequest { form, timeout, because } in wants.commands {
        primitive::command(cycle, id, form, timeout, because);
    }
    Ok(())
}

/// Runs a hook of a task that stops or ends. The outcome of the task is decided already, so errors are only reported.
pub(crate) fn run_hook(cycle: &mut Cycle<'_>, id: TaskId, level: Level, clause: &'static str, forms: &[Expr]) {
    if let Err(because) = run_needed(cycle, id, level, clause, forms) {
        let message = because.cause.text();
        cycle.decide(Some(id), DecisionKind::Trouble { message }, because);
    }
}

/// Evaluates forms, executes their messages and publications at once, and returns the requests for the primitive itself.
///
/// # Errors
/// The cause if a form cannot be evaluated; actions of earlier forms are executed.
pub(crate) fn run_forms(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    level: Level,
    clause: &'static str,
    forms: &[Expr],
) -> Result<HookRequests, Because> {
    if forms.is_empty() {
        return Ok(HookRequests::default());
    }
    let mut locals = take_locals(cycle, id);
    let mut actions = Vec::new();
    let result = run(forms, &cycle.view(id, level), &mut locals, &mut actions);
    put_locals(cycle, id, locals);
    let mut wants = HookRequests::default();
    let place = forms.first().map(|form| form.place).unwrap_or_default();
    let mut unsaid: Option<Because> = None;
    for action in actions {
        let mut said = |told: Result<(), Because>| unsaid = unsaid.take().or(told.err());
        match action {
            Action::Inform(form, router) => said(messaging::inform(cycle, id, form, router.as_ref(), place)),
            Action::Print(text) => cycle.effects.push(Effect::Print { task: id, text }),
            Action::Command { form, timeout, place } => {
                let because = Because::new(Cause::FormRan { clause: clause.into() }, Some(place));
                wants.commands.push(CommandRequest { form, timeout, because });
            }
            Action::Publish { variable, value, router, place } => {
                let because = Because::new(Cause::FormRan { clause: clause.into() }, Some(place));
                said(messaging::publish(cycle, id, (variable, value), router.as_ref(), because));
            }
            Action::Replenish { resource, amount, place } => {
                let because = Because::new(Cause::FormRan { clause: clause.into() }, Some(place));
                said(resources::replenish(cycle, id, &resource, amount.as_ref(), because));
            }
            Action::Complete(value) => wants.completed = Some(value),
            Action::SetTaskVariable(name, value) => binding::assign(cycle, id, level, &name, value, place),
            Action::Cogevent(form, agent) => said(messaging::cogevent(cycle, id, form, agent.as_ref(), place)),
            Action::EndApplication(reason) => termination::end_application(cycle, id, reason),
        }
    }
    match result {
        Ok(_) => unsaid.map_or(Ok(wants), Err),
        Err(error) => Err(Because::new(Cause::ExpressionFailed { message: error.message }, Some(error.place))),
    }
}

fn primitive_locals<'c>(cycle: &'c mut Cycle<'_>, id: TaskId) -> Option<&'c mut Bindings> {
    match cycle.agent.task_mut(id)?.controller.as_deref_mut()? {
        Controller::Primitive(controller) => Some(&mut controller.locals),
        _ => None,
    }
}

fn take_locals(cycle: &mut Cycle<'_>, id: TaskId) -> Bindings {
    primitive_locals(cycle, id).map(|locals| locals.clone()).unwrap_or_default()
}

fn put_locals(cycle: &mut Cycle<'_>, id: TaskId, locals: Bindings) {
    if let Some(slot) = primitive_locals(cycle, id) {
        *slot = locals;
    }
}
