//! Binding (TC)
//! What: gives variables their values: `waitfor` results, `select`, `=>` results, `setq`.
//! Runs: enable phase, at the end of a task, and after a hook's forms.  Reads: expressions, task values.
//! Writes: task bindings, controllers' contexts, Decision.
//! Bound: O(variables of a context) per binding.  PDL: section 4, `=>` and `select`.  Paper: section IV, information dependencies.

use crate::control::cycle::Cycle;
use crate::control::memory_budget;
use crate::control::tasks::{instantiation, monitoring_clauses};
use crate::expression::evaluate;
use crate::expression::view::View;
use crate::monitoring::pattern_matching::match_pattern;
use crate::state::bindings::Bindings;
use crate::state::clause::Level;
use crate::state::controller::Controller;
use crate::state::step_clauses::StepClauses;
use crate::state::task::{Origin, StepRef};
use apex_forms::variables::of_expr;
use apex_model::because::{Because, Cause, Evidence};
use apex_model::effect::DecisionKind;
use apex_model::evidence_list::EvidenceList;
use apex_model::expression::Expr;
use apex_model::procedure::Step;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
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
    memory_budget::bound(cycle, id, &value, place);
    let because = Because { cause: Cause::Binding { clause: clause.into() }, place: Some(place), evidence };
    cycle.decide(Some(id), DecisionKind::Bound { variable: name.clone(), value }, because);
}

/// Returns the `select` clauses that the task itself evaluates. A failure handler inherits those of its step. In a `forall`, the step
/// evaluates the clauses that do not depend on the item, and each item evaluates the others.
fn own_selects(origin: Option<Origin>, step: &Step) -> Vec<&(Symbol, Expr)> {
    let item = step.forall.as_ref().map(|forall| &forall.0);
    let mut of_items: Vec<&Symbol> = item.into_iter().collect();
    let mut depends = Vec::with_capacity(step.select.len());
    for (name, expr) in &step.select {
        let mut of_item = false;
        of_expr(expr, &mut |variable| of_item |= of_items.contains(&variable));
        if of_item {
            of_items.push(name);
        }
        depends.push(of_item);
    }
    let wanted = match origin {
        Some(Origin::Step(_)) => false,
        Some(Origin::Item(_)) => true,
        Some(Origin::OnFailure(_) | Origin::Meanwhile(_) | Origin::Probe(_) | Origin::Initial) | None => {
            return Vec::new();
        }
    };
    step.select.iter().zip(depends).filter(|(_, of_item)| *of_item == wanted).map(|(select, _)| select).collect()
}

/// Evaluates the step's `select` clauses in order.
///
/// # Errors
/// Message and place of the first clause that cannot be evaluated.
pub(crate) fn select(cycle: &mut Cycle<'_>, id: TaskId) -> Result<(), (String, Place)> {
    if !cycle.has(id, StepClauses::SELECT) {
        return Ok(());
    }
    let Some(handle) = cycle.step_of(id) else { return Ok(()) };
    let Some(step) = handle.get() else { return Ok(()) };
    let own = own_selects(cycle.task(id).map(|task| task.origin), step);
    for (name, expr) in own {
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
    let (Some((bindings, place)), Some(parent)) =
        (fitting(cycle, id, value)?, cycle.task(id).and_then(|task| task.parent))
    else {
        return Ok(());
    };
    for (name, value) in bindings.iter() {
        set_in_context(cycle, parent, name, value.clone());
        let evidence = EvidenceList::one(Evidence::TaskEnd { task: id, at: cycle.now });
        decide(cycle, parent, (name, value.clone()), "=>", place, evidence);
    }
    cycle.work.priorities_changed = true;
    let waiting = waiting_for(cycle, parent, &bindings);
    if let Some((variable, _)) = bindings.iter().next() {
        instantiation::result_arrived(cycle, waiting, variable);
    }
    Ok(())
}

/// Returns the bindings of `value` by the pattern after the step's `=>`, with the step's position; `None` without a pattern.
///
/// # Errors
/// The cause when the value does not match.
pub(crate) fn fitting(cycle: &Cycle<'_>, id: TaskId, value: &Value) -> Result<Option<(Bindings, Place)>, Because> {
    if !cycle.has(id, StepClauses::RESULT) {
        return Ok(None);
    }
    // Items and handlers bind nothing in the procedure; their step does.
    let is_step = matches!(cycle.task(id).map(|task| task.origin), Some(Origin::Step(_)));
    let Some(handle) = cycle.step_of(id).filter(|_| is_step) else { return Ok(None) };
    let Some((pattern, place)) = handle.get().and_then(|step| Some((step.binds.as_ref()?, step.place))) else {
        return Ok(None);
    };
    // A new result replaces an earlier one of the same step, so the old value must not restrict the match.
    let blank = View { agent: cycle.agent, task: TaskId(u64::MAX), level: Level::Procedure, now: cycle.now };
    let mut bindings = Bindings::new();
    let matched = match_pattern(pattern, value, &mut bindings, &blank, place)
        .map_err(|error| Because::new(Cause::ExpressionFailed { message: error.message }, Some(error.place)))?;
    if matched {
        Ok(Some((bindings, place)))
    } else {
        Err(Because::new(Cause::ResultDoesNotFit { value: value.clone() }, Some(place)))
    }
}

fn set_in_context(cycle: &mut Cycle<'_>, parent: TaskId, name: &Symbol, value: Value) {
    let controller = cycle.agent.task_mut(parent).and_then(|task| task.controller.as_deref_mut());
    match controller {
        Some(Controller::Procedure(controller)) => controller.context.set(name.clone(), value),
        Some(Controller::Primitive(controller)) => controller.context.set(name.clone(), value),
        _ => {}
    }
}

/// Returns the current tasks of steps that wait for one of the variables.
fn waiting_for(cycle: &Cycle<'_>, parent: TaskId, bindings: &Bindings) -> Vec<TaskId> {
    let Some(Controller::Procedure(controller)) = cycle.task(parent).and_then(|task| task.controller.as_deref()) else {
        return Vec::new();
    };
    let Some(index) = cycle.agent.procedure_index(controller.procedure) else { return Vec::new() };
    let waits = |awaits: &[Symbol]| awaits.iter().any(|name| bindings.get(name).is_some());
    let steps = index.steps.iter().zip(&controller.current).filter(|(step, _)| waits(&step.awaits));
    steps.filter_map(|(_, task)| *task).collect()
}

/// Executes `(setq ?x value)`: changes the variable in the context that has it, or creates it in the context of the task.
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

/// Returns the nearest ancestor that runs a procedure.
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

/// Sets the task that the tag of a step names from now on.
pub(crate) fn set_current(cycle: &mut Cycle<'_>, parent: TaskId, step: StepRef, task: TaskId) {
    let controller = cycle.agent.task_mut(parent).and_then(|task| task.controller.as_deref_mut());
    if let Some(Controller::Procedure(controller)) = controller
        && let Some(slot) = controller.current.get_mut(step.step as usize)
    {
        let before = slot.replace(task);
        if let Some(before) = before.filter(|before| *before != task) {
            monitoring_clauses::tag_moved(cycle, before);
        }
    }
}
