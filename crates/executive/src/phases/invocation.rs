//! Controller invocation (TC)
//! What: lets every task that became ongoing begin or continue its work.
//! Runs: act phase.  Reads: Selection.  Writes: Controller, Decision, effects.
//! Bound: O(1) per task in addition to what its controller does.  PDL: section 9.  Paper: section III, primitive and planner invocation.

use crate::control::cycle::Cycle;
use crate::control::tasks::{
    execution_conditions, interruption, monitoring_clauses, primitive, procedure, question, termination,
};
use crate::deliberation::{plan_adoption, planner_invocation};
use crate::phases::built_in;
use crate::planted;
use crate::planted::Bug;
use crate::state::clause::Clause;
use crate::state::controller::{Controller, MethodBinding};
use apex_model::because::Cause;
use apex_model::task::{TaskId, TaskState};

/// Executes the act phase.
pub(crate) fn act(cycle: &mut Cycle<'_>) {
    let resuming = if cycle.work.resuming.is_empty() { None } else { Some(std::mem::take(&mut cycle.work.resuming)) };
    for id in resuming.into_iter().flatten() {
        if cycle.state(id) == TaskState::Ongoing {
            go_on(cycle, id);
        }
        termination::settle(cycle);
    }
    for id in std::mem::take(&mut cycle.work.starting) {
        let Some(task) = cycle.task(id) else { continue };
        if task.state != TaskState::Ongoing {
            continue;
        }
        if task.controller.is_none() {
            begin(cycle, id);
        } else if interruption::may_start_over(cycle, id) {
            // Its monitors notice the resumption in the next round. Only then does it continue, unless `restart-when` starts it over.
            cycle.work.resuming.insert(id);
            interruption::hold_children(cycle, id);
            // An ongoing task passes its priority to interrupted tasks below it that claim already.
            interruption::inheritance_changed(cycle, id);
        } else {
            go_on(cycle, id);
        }
        termination::settle(cycle);
    }
}

fn begin(cycle: &mut Cycle<'_>, id: TaskId) {
    monitoring_clauses::unwatch(cycle, id, |clause, _| clause == Clause::SkipWhen);
    if !execution_conditions::begin(cycle, id) {
        return;
    }
    let begun = interruption::run_step_start(cycle, id).and_then(|()| interruption::watch_step_restart(cycle, id));
    if let Err(because) = begun {
        return termination::fail(cycle, id, because);
    }
    if cycle.state(id) != TaskState::Ongoing {
        return;
    }
    match take_way(cycle, id) {
        Some(MethodBinding::Procedure(reference, context)) => {
            procedure::start(cycle, id, reference, context, Cause::ParentStarted { parent: id });
        }
        Some(MethodBinding::Primitive(index, context)) => primitive::start(cycle, id, index, context),
        Some(MethodBinding::Items(items)) => procedure::start_items(cycle, id, &items),
        Some(MethodBinding::BuiltIn(which)) => built_in::start(cycle, id, which),
        Some(MethodBinding::Terminate) => built_in::terminate(cycle, id),
        Some(MethodBinding::Solver(solver)) => planner_invocation::start(cycle, id, solver),
        None => {}
    }
}

/// Returns the chosen method, which begins; the bindings of its index move from the selection into the controller.
fn take_way(cycle: &mut Cycle<'_>, id: TaskId) -> Option<MethodBinding> {
    let selection = cycle.agent.task_mut(id)?.selection.as_mut()?;
    selection.begun = true;
    Some(match &mut selection.way {
        MethodBinding::Procedure(reference, bindings) => MethodBinding::Procedure(*reference, std::mem::take(bindings)),
        MethodBinding::Primitive(index, bindings) => MethodBinding::Primitive(*index, std::mem::take(bindings)),
        MethodBinding::Items(items) => MethodBinding::Items(std::mem::take(items)),
        MethodBinding::BuiltIn(which) => MethodBinding::BuiltIn(*which),
        MethodBinding::Terminate => MethodBinding::Terminate,
        MethodBinding::Solver(solver) => MethodBinding::Solver(*solver),
    })
}

fn go_on(cycle: &mut Cycle<'_>, id: TaskId) {
    let (now, Some(task)) = (cycle.now, cycle.task(id)) else { return };
    let Some(controller) = task.controller.as_deref() else { return };
    let handling = matches!(controller, Controller::Handling(_));
    if !handling && !execution_conditions::go_on(cycle, id) {
        return;
    }
    let Some(controller) = cycle.task(id).and_then(|task| task.controller.as_deref()) else { return };
    match controller {
        // The task failed before it could begin: its handler is not a resumption.
        Controller::Handling(_) if cycle.task(id).is_some_and(|task| task.started_at == Some(now)) => {}
        Controller::Primitive(_) => {
            primitive::resume(cycle, id);
            interruption::run_step_hook(cycle, id, "on-resume", |hooks| &hooks.on_resume);
        }
        Controller::Planning(_) => {
            interruption::run_hooks(cycle, id, "on-resume", |hooks| &hooks.on_resume);
            plan_adoption::pursue_arrived(cycle, id);
        }
        Controller::Question(_) => {
            interruption::run_hooks(cycle, id, "on-resume", |hooks| &hooks.on_resume);
            question::resume(cycle, id);
        }
        Controller::Procedure(_) | Controller::Items(_) | Controller::Handling(_) | Controller::BuiltIn => {
            interruption::run_hooks(cycle, id, "on-resume", |hooks| &hooks.on_resume)
        }
    }
    if !planted::is(Bug::ChildrenStayBehind) {
        interruption::offer_children(cycle, id);
    }
    interruption::inheritance_changed(cycle, id);
}
