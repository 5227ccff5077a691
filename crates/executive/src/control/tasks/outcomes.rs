//! Outcomes between siblings (TC)
//! What: finds pending steps that wait for an outcome or a result that can no longer occur; they are skipped.
//! Runs: when a step has ended finally.  Reads: ProcedureIndex, Task.  Writes: nothing.
//! Bound: O(steps that name the outcome); O(steps) where a step with a result ends without success.
//! PDL: `(failed ?s)`, `(succeeded ?s)`, `(skipped ?s)`, `=>`.  Paper: section III, off-nominal conditions.

use crate::control::cycle::Cycle;
use crate::expression::EvalContext;
use crate::state::awaited_outcomes::missed;
use crate::state::clause::Level;
use crate::state::controller::Controller;
use crate::state::index::{ProcedureIndex, StepIndex};
use crate::state::task::{Origin, StepRef};
use apex_model::because::{Because, Cause};
use apex_model::symbol::Symbol;
use apex_model::task::{Outcome, TaskId, TaskState};

/// Returns true if a clause of the procedure or of another step names the failure of this step's task. The procedure then does not fail
/// with it.
pub(crate) fn is_awaited(cycle: &Cycle<'_>, child: TaskId) -> bool {
    let Some(Origin::Step(step)) = cycle.task(child).map(|task| task.origin) else { return false };
    let index = cycle.agent.procedure_index(step.procedure);
    index.and_then(|index| index.steps.get(step.step as usize)).is_some_and(|step| step.failure_awaited)
}

/// Returns the siblings that can no longer begin since the step's task has ended finally, each with the cause.
pub(crate) fn dependents(
    cycle: &Cycle<'_>,
    parent: TaskId,
    child: TaskId,
    outcome: &Outcome,
) -> Vec<(TaskId, Because)> {
    let Some(Origin::Step(step)) = cycle.task(child).map(|task| task.origin) else { return Vec::new() };
    let Some(index) = cycle.agent.procedure_index(step.procedure) else { return Vec::new() };
    let Some(known) = index.steps.get(step.step as usize) else { return Vec::new() };
    if known.outcome_waiters.is_empty() && known.produces.is_empty() || current(cycle, parent, step.step) != Some(child)
    {
        return Vec::new();
    }
    let waiters = known.outcome_waiters.iter();
    let mut found: Vec<(TaskId, Because)> =
        waiters.filter_map(|waiter| missed_outcome(cycle, index, (parent, *waiter))).collect();
    if !matches!(outcome, Outcome::Success(_)) && !known.produces.is_empty() {
        found.extend(users(cycle, index, parent, (child, step)));
    }
    found
}

/// Returns the task of a step of the procedure that `parent` runs.
fn current(cycle: &Cycle<'_>, parent: TaskId, step: u32) -> Option<TaskId> {
    match cycle.task(parent)?.controller.as_deref()? {
        Controller::Procedure(controller) => controller.current.get(step as usize).copied().flatten(),
        _ => None,
    }
}

/// Returns the step's task with the cause, if its `waitfor` can no longer hold.
fn missed_outcome(
    cycle: &Cycle<'_>,
    index: &ProcedureIndex,
    (parent, step): (TaskId, u32),
) -> Option<(TaskId, Because)> {
    let id = current(cycle, parent, step)?;
    let task = cycle.task(id).filter(|task| task.state == TaskState::Pending)?;
    let waits = task.held_back.by_condition || task.held_back.by_unknown;
    let condition = index.steps.get(step as usize)?.waitfor.as_ref().filter(|_| waits)?;
    let outcome_of = |tag: &Symbol| {
        let other = current(cycle, parent, *index.tags.get(tag)?)?;
        let outcome = cycle.task(other).filter(|task| task.is_terminated())?.outcome.as_ref()?;
        let again =
            matches!(outcome, Outcome::Success(_)) && cycle.work.ended.contains(&other) && cycle.may_repeat(other);
        (!again).then(|| (other, outcome.states()))
    };
    let (task, outcome) = missed(condition, &outcome_of)?;
    Some((id, Because::new(Cause::OutcomeMissed { task, outcome }, Some(condition.place))))
}

/// Returns the steps that use a result of `child`, with the cause, unless another step may still bind that result.
fn users(
    cycle: &Cycle<'_>,
    index: &ProcedureIndex,
    parent: TaskId,
    (child, step): (TaskId, StepRef),
) -> Vec<(TaskId, Because)> {
    let Some(known) = index.steps.get(step.step as usize) else { return Vec::new() };
    let steps = || (0_u32..).zip(&index.steps);
    let is_open = |number: u32| {
        let task = current(cycle, parent, number).and_then(|id| cycle.task(id));
        task.is_some_and(|task| !task.is_terminated())
    };
    let user = |(number, user): (u32, &StepIndex)| {
        let variable = user.awaits.iter().find(|name| known.produces.contains(name))?;
        let id = current(cycle, parent, number)?;
        let task = cycle.task(id).filter(|task| task.state == TaskState::Pending)?;
        let waits = task.held_back.by_result || task.held_back.by_predecessor;
        let missing = waits && cycle.view(id, Level::Step).variable(variable).is_none();
        let given = || steps().any(|(number, step)| step.produces.contains(variable) && is_open(number));
        let cause = Cause::ResultMissed { task: child, variable: variable.clone() };
        (missing && !given()).then(|| (id, Because::new(cause, cycle.place_of(id))))
    };
    steps().filter_map(user).collect()
}
