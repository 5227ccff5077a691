//! Failure handling (TC)
//! What: pursues a step's `on-failure` goal when the step fails; the step ends as that goal ends. A suspended step stays suspended.
//! Runs: when a task fails, and when its handler ends.  Reads: Step.  Writes: Task, HandlingController, Decision.
//! Bound: O(size of the failed subtree).  PDL: `on-failure`.  Paper: section III, off-nominal conditions.

use crate::control::conflicts::{competition, resources};
use crate::control::cycle::Cycle;
use crate::control::tasks::instantiation::{self, Seed};
use crate::control::tasks::{interruption, outcomes, primitive, reasons, termination};
use crate::control::transition::{Trigger, transition};
use crate::state::bindings::Bindings;
use crate::state::controller::{Controller, HandlingController};
use crate::state::task::Origin;
use apex_model::because::{Because, Cause};
use apex_model::effect::DecisionKind;
use apex_model::task::{Outcome, TaskId, TaskState};

/// Starts the `on-failure` goal of the task's step. Returns false if there is none, or if it is being pursued already.
pub(crate) fn handle(cycle: &mut Cycle<'_>, id: TaskId, because: &Because) -> bool {
    let Some(task) = cycle.task(id) else { return false };
    let Origin::Step(step) = task.origin else { return false };
    if task.is_terminated() || matches!(task.controller.as_deref(), Some(Controller::Handling(_))) {
        return false;
    }
    if !has_handler(cycle, id) {
        return false;
    }
    let cut = Because::new(Cause::ParentFailed { parent: id }, because.place);
    termination::end_children(cycle, id, &cut);
    primitive::withdraw_commands(cycle, id, "its task failed");
    // The failed work has ended, and the trace reports it; the step continues with its handler.
    interruption::run_inner_hook(cycle, id, "on-end", |hooks| &hooks.on_end);
    if cycle.state(id) == TaskState::Terminated {
        return true;
    }
    termination::dismantle(cycle, id, "its task failed");
    interruption::forget_clauses(cycle, id);
    let seed = Seed {
        parent: Some(id),
        origin: Origin::OnFailure(step),
        bindings: Bindings::new(),
        by_predecessor: false,
        after_sequence: None,
        cause: Cause::HandlesFailure { of: id },
    };
    let message = reasons::of_handled(cycle, id, because);
    cycle.decide(Some(id), DecisionKind::Trouble { message }, because.clone());
    let Ok(handler) = instantiation::create(cycle, seed) else { return false };
    let handling = Because::new(Cause::FailureHandled { by: handler }, because.place);
    if let Some(task) = cycle.agent.task_mut(id) {
        task.controller = Some(Box::new(Controller::Handling(HandlingController { handler })));
    }
    if cycle.state(id) == TaskState::Pending {
        // The task failed before it could begin. The handler is its work now and waits for nothing.
        if let Some(task) = cycle.agent.task_mut(id) {
            task.held_back = task.held_back.of_turn();
        }
        transition(cycle, id, Trigger::Satisfied, None, handling.clone());
    }
    if cycle.state(id) != TaskState::Ongoing {
        claim_nothing(cycle, id);
        if competition::is_eligible(cycle.agent, id) {
            transition(cycle, id, Trigger::Granted, None, handling);
        }
    } else {
        // Depletable amounts that the failed work used are consumed, and the handler claims its own; all other resources are kept for it.
        let how = resources::at_the_end(cycle, id);
        resources::release_depletables(cycle, id, how);
    }
    instantiation::arm(cycle, handler);
    true
}

/// Returns true if the step of the task has an `on-failure` goal.
fn has_handler(cycle: &Cycle<'_>, id: TaskId) -> bool {
    cycle.step_of(id).is_some_and(|handle| handle.get().is_some_and(|step| step.on_failure.is_some()))
}

/// Returns true if a failure of the task does not reach the root task: its step or a step above it has an `on-failure` goal that is not
/// pursued yet, or a clause names the failure of one of these tasks. Bound: O(depth of the task).
pub(crate) fn is_handled(cycle: &Cycle<'_>, id: TaskId) -> bool {
    let mut next = Some(id);
    while let Some((id, task)) = next.and_then(|id| Some((id, cycle.task(id)?))) {
        let is_handling = matches!(task.controller.as_deref(), Some(Controller::Handling(_)));
        let is_probe = matches!(task.origin, Origin::Probe(_));
        let has_handler = matches!(task.origin, Origin::Step(_)) && !is_handling && has_handler(cycle, id);
        if is_probe || has_handler || outcomes::is_awaited(cycle, id) {
            return true;
        }
        next = task.parent;
    }
    false
}

/// Releases all holdings and needs of failed work; the handler claims for itself.
fn claim_nothing(cycle: &mut Cycle<'_>, id: TaskId) {
    resources::release(cycle, id, resources::Release::Unused);
    let Some(task) = cycle.agent.task_mut(id) else { return };
    if let Some(selection) = &mut task.selection {
        selection.needs.clear();
    }
    if let Some(extras) = &mut task.extras {
        extras.held.clear();
    }
}

/// Handles the end of the failure handler: the step ends in the same way.
pub(crate) fn handled(cycle: &mut Cycle<'_>, id: TaskId, handler: TaskId, outcome: &Outcome) {
    let place = cycle.place_of(id);
    match outcome {
        Outcome::Failure | Outcome::PreconditionFailed | Outcome::InvariantViolated => {
            let because = Because::new(Cause::ChildFailed { child: handler }, place);
            termination::end(cycle, id, Outcome::Failure, because);
        }
        Outcome::Success(_) | Outcome::Cut | Outcome::Skipped | Outcome::Exited => {
            let because = Because::new(Cause::HandlerEnded { handler }, place);
            termination::end(cycle, id, outcome.clone(), because);
        }
    }
}
