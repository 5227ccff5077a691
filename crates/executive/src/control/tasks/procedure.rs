//! Controllers of procedures and items (TC)
//! What: instantiates a procedure's context and steps, orders the steps, and decides when the procedure is complete.
//! Runs: act phase, and at the end of each step.  Reads: Procedure.  Writes: ProcedureController, ItemsController.
//! Bound: O(steps) at the start and for all ends of steps together, in addition to the tasks that they free.
//! PDL: section 3, `forall`.  Paper: section III, instantiation of new controllers.

use crate::control::cycle::Cycle;
use crate::control::tasks::instantiation::{self, Seed};
use crate::control::tasks::{binding, hooks, interruption, termination};
use crate::expression::instantiate;
use crate::state::bindings::Bindings;
use crate::state::children::Children;
use crate::state::clause::Level;
use crate::state::controller::{Controller, ItemsController, ProcedureController};
use crate::state::histories::event_log::OpenEventLog;
use crate::state::histories::history::OpenLog;
use crate::state::task::{Origin, ProcedureRef, StepRef};
use apex_model::agent_limits::Limit;
use apex_model::because::{Because, Cause};
use apex_model::event::StateVariable;
use apex_model::procedure::{Procedure, ProcedureKind};
use apex_model::symbol::Symbol;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use smallvec::smallvec;
use std::sync::Arc;

/// Begins an instance of the procedure as the task's controller.
pub(crate) fn start(cycle: &mut Cycle<'_>, id: TaskId, reference: ProcedureRef, context: Bindings, cause: Cause) {
    let Some(procedure) = cycle.agent.procedure(reference).cloned() else { return };
    if let ProcedureRef::Generated(number) = reference
        && let Some(generated) = cycle.agent.generated.get_mut(number)
    {
        generated.users += 1;
    }
    let controller = ProcedureController {
        procedure: reference,
        context,
        current: smallvec![None; procedure.steps.len()],
        children: Children::default(),
        open: 0,
        turn: 0,
        rounds: 0,
        instant: Time::BEGINNING,
    };
    if let Some(task) = cycle.agent.task_mut(id) {
        task.controller = Some(Box::new(Controller::Procedure(controller)));
    }
    open_logs(cycle, id, &procedure);
    let begun = hooks::run_needed(cycle, id, Level::Procedure, "on-start", &procedure.hooks.on_start)
        .and_then(|()| interruption::watch_procedure(cycle, id, &procedure.transitions));
    if let Err(because) = begun {
        termination::fail(cycle, id, because);
        return;
    }
    instantiate_steps(cycle, id, reference, &procedure, cause);
}

fn open_logs(cycle: &mut Cycle<'_>, id: TaskId, procedure: &Procedure) {
    for policy in &procedure.log {
        let value = match instantiate(&policy.subject, &cycle.view(id, Level::Procedure)) {
            Ok(value) => value,
            Err(error) => {
                cycle.trouble(Some(id), error.message, Some(error.place));
                continue;
            }
        };
        let spacing = policy.frequency_limit.unwrap_or(Duration::ZERO);
        let time = policy.time_limit.unwrap_or(Duration::MAX);
        let count = policy.count_limit.unwrap_or(u64::MAX);
        let histories = &mut cycle.agent.histories;
        let number = match (first_word(&value), state_variable(&value)) {
            (Some(head), _) => histories.open_event_log(OpenEventLog { head, spacing, time, count }),
            (None, Some(variable)) => histories.open_log(OpenLog { variable, spacing, time, count }),
            (None, None) => {
                let message = format!(
                    "(log {value}) names no state variable and no messages; write (ATTRIBUTE OBJECT) or (:events WORD)"
                );
                cycle.trouble(Some(id), message, Some(procedure.place));
                continue;
            }
        };
        if let Some(task) = cycle.agent.task_mut(id) {
            task.extras_mut().logs.push(number);
        }
    }
}

/// Returns the first word of the messages that `(:events WORD)` means.
fn first_word(value: &Value) -> Option<Symbol> {
    match value.as_list()? {
        [keyword, word] if keyword.as_symbol()?.is(":events") => word.as_symbol().cloned(),
        _ => None,
    }
}

fn state_variable(value: &Value) -> Option<StateVariable> {
    let (first, rest) = value.as_list()?.split_first()?;
    let attribute = first.as_symbol().filter(|attribute| !attribute.is(":events"))?;
    let object = match rest {
        [one] => one.clone(),
        several => Value::list(several.iter().cloned()),
    };
    Some(StateVariable::new(attribute.clone(), object))
}

/// Makes the tasks of all steps, then arms them: tags may occur in the conditions of earlier steps.
fn instantiate_steps(cycle: &mut Cycle<'_>, id: TaskId, reference: ProcedureRef, procedure: &Procedure, cause: Cause) {
    let index = cycle.agent.procedure_index(reference).cloned();
    let mut created = Vec::with_capacity(procedure.steps.len());
    for step in 0..procedure.steps.len() {
        let step_ref = StepRef { procedure: reference, step: u32::try_from(step).unwrap_or(u32::MAX) };
        let seed = Seed {
            parent: Some(id),
            origin: Origin::Step(step_ref),
            bindings: Bindings::new(),
            by_predecessor: procedure.kind == ProcedureKind::Sequential && step > 0,
            after_sequence: None,
            cause: cause.clone(),
        };
        let child = match instantiation::create(cycle, seed) {
            Ok(child) => child,
            Err(cause) => return termination::fail(cycle, id, Because::new(cause, Some(procedure.place))),
        };
        let counts = index.as_ref().and_then(|index| index.steps.get(step)).is_some_and(|step| step.counts);
        adopt(cycle, id, child, counts);
        binding::set_current(cycle, id, step_ref, child);
        created.push(child);
    }
    for child in created {
        instantiation::arm(cycle, child);
    }
    complete_when_done(cycle, id, None);
}

/// Makes `child` a child of the procedure that `parent` runs.
pub(crate) fn adopt(cycle: &mut Cycle<'_>, parent: TaskId, child: TaskId, counts: bool) {
    if let Some(Controller::Procedure(controller)) = controller(cycle, parent) {
        controller.children.insert(child);
        controller.open += u32::from(counts);
    }
}

/// Removes `child`, which has ended, from the children of its parent.
pub(crate) fn disown(cycle: &mut Cycle<'_>, parent: TaskId, child: TaskId) {
    if let Some(Controller::Procedure(controller)) = controller(cycle, parent) {
        controller.children.remove(child);
    }
}

fn controller<'c>(cycle: &'c mut Cycle<'_>, id: TaskId) -> Option<&'c mut Controller> {
    cycle.agent.task_mut(id)?.controller.as_deref_mut()
}

/// Handles the final end of a step: the next step in turn is freed, or the procedure is complete.
pub(crate) fn step_ended(cycle: &mut Cycle<'_>, id: TaskId, child: TaskId) {
    let Some(Origin::Step(step)) = cycle.task(child).map(|task| task.origin) else { return };
    let index = cycle.agent.procedure_index(step.procedure);
    let counts = index.and_then(|index| index.steps.get(step.step as usize)).is_none_or(|step| step.counts);
    let sequential =
        cycle.agent.procedure(step.procedure).is_some_and(|procedure| procedure.kind == ProcedureKind::Sequential);
    // A step that has ended before its turn waits no longer, and is passed when its turn comes.
    if let Some(task) = cycle.agent.task_mut(child) {
        task.held_back.by_predecessor = false;
    }
    let Some(Controller::Procedure(controller)) = controller(cycle, id) else { return };
    controller.open = controller.open.saturating_sub(u32::from(counts));
    let is_current = controller.current.get(step.step as usize) == Some(&Some(child));
    if !is_current {
        controller.children.remove(child);
        cycle.agent.tasks.remove(child.0);
    }
    if sequential {
        pass_turn(cycle, id, step.step);
    }
    complete_when_done(cycle, id, Some(child));
}

/// Frees the first step of a sequence that has not ended, if `ended` is the step whose turn it was. Each step is passed once.
fn pass_turn(cycle: &mut Cycle<'_>, id: TaskId, ended: u32) {
    let Some(Controller::Procedure(controller)) = controller(cycle, id) else { return };
    if controller.turn != ended {
        return;
    }
    let next = loop {
        let Some(Controller::Procedure(controller)) = self::controller(cycle, id) else { return };
        controller.turn = controller.turn.saturating_add(1);
        let Some(next) = controller.current.get(controller.turn as usize).copied().flatten() else { return };
        if cycle.task(next).is_some_and(|task| task.held_back.by_predecessor) {
            break next;
        }
    };
    if let Some(task) = cycle.agent.task_mut(next) {
        task.held_back.by_predecessor = false;
    }
    instantiation::offer(cycle, next);
}

/// Ends the procedure when no task remains that it must wait for; a repeatable plan begins again instead.
fn complete_when_done(cycle: &mut Cycle<'_>, id: TaskId, last: Option<TaskId>) {
    if !matches!(cycle.state(id), TaskState::Ongoing | TaskState::Interrupted) {
        return;
    }
    let now = cycle.now;
    let Some(Controller::Procedure(controller)) = controller(cycle, id) else { return };
    if controller.open > 0 {
        return;
    }
    let reference = controller.procedure;
    if cycle.agent.procedure(reference).is_some_and(|procedure| ends_by_condition(procedure)) {
        return;
    }
    if let ProcedureRef::Generated(number) = reference
        && cycle.agent.generated.get(number).is_some_and(|generated| generated.repeat)
    {
        return begin_again(cycle, id, reference, now);
    }
    let because = Because::new(Cause::StepsEnded { last }, cycle.place_of(id));
    termination::end(cycle, id, Outcome::Success(Value::nil()), because);
}

/// Returns true for a concurrent procedure with an `end-when`, which alone decides when the procedure is complete; the end of its steps
/// does not.
fn ends_by_condition(procedure: &Procedure) -> bool {
    procedure.kind == ProcedureKind::Concurrent && procedure.transitions.end_when.is_some()
}

fn begin_again(cycle: &mut Cycle<'_>, id: TaskId, reference: ProcedureRef, now: Time) {
    let Some(procedure) = cycle.agent.procedure(reference).map(Arc::clone) else { return };
    let Some(Controller::Procedure(controller)) = controller(cycle, id) else { return };
    controller.rounds = if controller.instant == now { controller.rounds + 1 } else { 1 };
    controller.instant = now;
    let rounds = u64::from(controller.rounds);
    if rounds > cycle.agent.limits.of(Limit::RepetitionsPerInstant) {
        let cause = cycle.agent.limits.reached(Limit::RepetitionsPerInstant);
        return termination::fail(cycle, id, Because::new(cause, Some(procedure.place)));
    }
    let cause = Cause::PlanBegunAgain { parent: id };
    let ended = Because::new(cause.clone(), Some(procedure.place));
    termination::end_children(cycle, id, &ended);
    if let Some(Controller::Procedure(controller)) = self::controller(cycle, id) {
        controller.children.clear();
        controller.current = smallvec![None; procedure.steps.len()];
        controller.turn = 0;
    }
    instantiate_steps(cycle, id, reference, &procedure, cause);
}

/// Makes one child per item of a `forall`; an empty list completes at once.
pub(crate) fn start_items(cycle: &mut Cycle<'_>, id: TaskId, items: &[Value]) {
    let Some(step_ref) = cycle.task(id).and_then(|task| task.step()) else { return };
    let name = cycle.step_of(id).and_then(|handle| handle.get()?.forall.as_ref().map(|forall| forall.0.clone()));
    let count = items.len() as u64;
    let controller = ItemsController { children: Children::default(), open: count, items: count };
    if let Some(task) = cycle.agent.task_mut(id) {
        task.controller = Some(Box::new(Controller::Items(controller)));
    }
    let mut created = Vec::with_capacity(items.len());
    for item in items {
        let mut bindings = Bindings::new();
        if let Some(name) = &name {
            bindings.set(name.clone(), item.clone());
        }
        let cause = Cause::ItemOf { parent: id };
        let origin = Origin::Item(step_ref);
        let seed = Seed { parent: Some(id), origin, bindings, by_predecessor: false, after_sequence: None, cause };
        match instantiation::create(cycle, seed) {
            Ok(child) => {
                if let Some(Controller::Items(controller)) = self::controller(cycle, id) {
                    controller.children.insert(child);
                }
                created.push(child);
            }
            Err(cause) => {
                let place = cycle.place_of(id);
                return termination::fail(cycle, id, Because::new(cause, place));
            }
        }
    }
    for child in created {
        instantiation::arm(cycle, child);
    }
    if items.is_empty() {
        items_done(cycle, id, 0, None);
    }
}

/// Handles the end of an item's task: the task is removed, because no clause can refer to it. The last one completes the `forall`.
pub(crate) fn item_ended(cycle: &mut Cycle<'_>, id: TaskId, child: TaskId) {
    let Some(Controller::Items(controller)) = controller(cycle, id) else { return };
    controller.open = controller.open.saturating_sub(1);
    controller.children.remove(child);
    let (open, items) = (controller.open, controller.items);
    cycle.agent.tasks.remove(child.0);
    if open == 0 {
        items_done(cycle, id, items, Some(child));
    }
}

fn items_done(cycle: &mut Cycle<'_>, id: TaskId, items: u64, last: Option<TaskId>) {
    let because = Because::new(Cause::ItemsEnded { items, last }, cycle.place_of(id));
    termination::end(cycle, id, Outcome::Success(Value::nil()), because);
}

/// Handles the end of the work that a task does until its plan arrives: the plan is still awaited.
pub(crate) fn meanwhile_ended(cycle: &mut Cycle<'_>, id: TaskId, child: TaskId) {
    if let Some(Controller::Planning(controller)) = controller(cycle, id) {
        controller.meanwhile = None;
        cycle.agent.tasks.remove(child.0);
    }
}
