//! Binding (TC)
//! What: gives variables their values: `waitfor` results, `select`, `=>` results, `setq`.
//! Runs: enable phase, at the end of a task, and after a hook's forms.  Reads: expressions, task values.
//! Writes: task bindings, controllers' contexts, Decision.
//! Bound: O(variables of a context) per binding.  PDL: section 4, `=>` and `select`.  Paper: section IV, information dependencies.

use crate::control::instantiation;
use crate::cycle::Cycle;
use crate::expression::evaluate;
use crate::monitoring::pattern_matching::match_pattern;
use crate::view::View;
use apex_model::because::{Because, Cause, Evidence};
use apex_model::bindings::Bindings;
use apex_model::clause::Level;
use apex_model::controller::Controller;
use apex_model::effect::DecisionKind;
use apex_model::evidence_list::EvidenceList;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::{StepRef, TaskId};
use apex_model::value::Value;

/// Binds `name` among the task's own variables.
pub(crate) fn bind_locally(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    (name, value): (&Symbol, Value),
    clause: &'static str,
    place: Place,
    evidence: EvidenceList,
) {
    if let Some(task) = cycle.agent.task_mut(id) {
        task.bindings.set(name.clone(), value.clone());
    }
    decide(cycle, id, (name, value), clause, place, evidence);
}

fn decide(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    (name, value): (&Symbol, Value),
    clause: &'static str,
    place: Place,
    evidence: EvidenceList,
) {
    let because = Because { cause: Cause::Binding { clause: clause.into() }, place: Some(place), evidence };
    cycle.decide(Some(id), DecisionKind::Bound { variable: name.clone(), value }, because);
}

/// Evaluates the step's `select` clauses in order.
///
/// # Errors
/// Message and place of the first clause that cannot be evaluated.
pub(crate) fn select(cycle: &mut Cycle<'_>, id: TaskId) -> Result<(), (String, Place)> {
    let Some(handle) = cycle.step_of(id) else { return Ok(()) };
    let Some(step) = handle.get() else { return Ok(()) };
    for (name, expr) in &step.select {
        let value = evaluate(expr, &cycle.view(id, Level::Step)).map_err(|error| (error.message, error.place))?;
        bind_locally(cycle, id, (name, value), "select", expr.place, EvidenceList::default());
    }
    Ok(())
}

/// Binds the value of an ended step in the context of its procedure, and wakes steps that waited for it.
///
/// # Errors
/// The cause when the value does not match the pattern after `=>`.
pub(crate) fn result(cycle: &mut Cycle<'_>, id: TaskId, value: &Value) -> Result<(), Because> {
    let Some(handle) = cycle.step_of(id) else { return Ok(()) };
    let Some(step) = handle.get() else { return Ok(()) };
    let (Some(pattern), Some(parent)) = (&step.binds, cycle.task(id).and_then(|task| task.parent)) else {
        return Ok(());
    };
    // A result replaces an earlier one of the same step, so the old value must not take part in the match.
    let blank = View { agent: cycle.agent, task: TaskId(u64::MAX), level: Level::Procedure, now: cycle.now };
    let mut bindings = Bindings::new();
    let matched = match_pattern(pattern, value, &mut bindings, &blank, step.place)
        .map_err(|error| Because::new(Cause::ExpressionFailed { message: error.message }, Some(error.place)))?;
    if !matched {
        return Err(Because::new(Cause::ResultDoesNotFit { value: value.clone() }, Some(step.place)));
    }
    for (name, value) in bindings.iter() {
        set_in_context(cycle, parent, name, value.clone());
        let evidence = EvidenceList::one(Evidence::TaskEnd { task: id, at: cycle.now });
        decide(cycle, parent, (name, value.clone()), "=>", step.place, evidence);
    }
    cycle.work.priorities_changed = true;
    let waiting = waiting_for(cycle, parent, &bindings);
    if let Some((variable, _)) = bindings.iter().next() {
        instantiation::result_arrived(cycle, waiting, variable);
    }
    Ok(())
}

fn set_in_context(cycle: &mut Cycle<'_>, parent: TaskId, name: &Symbol, value: Value) {
    let controller = cycle.agent.task_mut(parent).and_then(|task| task.controller.as_deref_mut());
    match controller {
        Some(Controller::Procedure(controller)) => controller.context.set(name.clone(), value),
        Some(Controller::Primitive(controller)) => controller.context.set(name.clone(), value),
        _ => {}
    }
}

/// Current tasks of steps that wait for one of the variables.
fn waiting_for(cycle: &Cycle<'_>, parent: TaskId, bindings: &Bindings) -> Vec<TaskId> {
    let Some(Controller::Procedure(controller)) = cycle.task(parent).and_then(|task| task.controller.as_deref()) else {
        return Vec::new();
    };
    let Some(index) = cycle.agent.procedure_index(controller.procedure) else { return Vec::new() };
    let waits = |awaits: &[Symbol]| awaits.iter().any(|name| bindings.get(name).is_some());
    let steps = index.steps.iter().zip(&controller.current).filter(|(step, _)| waits(&step.awaits));
    steps.filter_map(|(_, task)| *task).collect()
}

/// `(setq ?x value)`: changes the variable where it lives; a new one becomes the task's own.
pub(crate) fn assign(cycle: &mut Cycle<'_>, id: TaskId, level: Level, name: &Symbol, value: Value, place: Place) {
    let Some(task) = cycle.task(id) else { return };
    let own = matches!(task.controller.as_deref(), Some(Controller::Procedure(_) | Controller::Primitive(_)));
    if level == Level::Procedure && own {
        set_in_context(cycle, id, name, value.clone());
        decide(cycle, id, (name, value), "setq", place, EvidenceList::default());
    } else if task.bindings.get(name).is_some() {
        bind_locally(cycle, id, (name, value), "setq", place, EvidenceList::default());
    } else if let Some(parent) = procedure_above(cycle, id) {
        set_in_context(cycle, parent, name, value.clone());
        decide(cycle, parent, (name, value), "setq", place, EvidenceList::default());
        let mut bindings = Bindings::new();
        bindings.set(name.clone(), Value::nil());
        let waiting = waiting_for(cycle, parent, &bindings);
        instantiation::result_arrived(cycle, waiting, name);
    } else {
        bind_locally(cycle, id, (name, value), "setq", place, EvidenceList::default());
    }
    cycle.work.priorities_changed = true;
}

/// The nearest ancestor that runs a procedure.
fn procedure_above(cycle: &Cycle<'_>, id: TaskId) -> Option<TaskId> {
    let mut parent = cycle.task(id)?.parent;
    while let Some(above) = parent {
        let task = cycle.task(above)?;
        if let Some(Controller::Procedure(_)) = task.controller.as_deref() {
            return Some(above);
        }
        parent = task.parent;
    }
    None
}

/// The task that the tag of a step stands for from now on.
pub(crate) fn set_current(cycle: &mut Cycle<'_>, parent: TaskId, step: StepRef, task: TaskId) {
    let controller = cycle.agent.task_mut(parent).and_then(|task| task.controller.as_deref_mut());
    if let Some(Controller::Procedure(controller)) = controller
        && let Some(slot) = controller.current.get_mut(step.step as usize)
    {
        *slot = Some(task);
    }
}
