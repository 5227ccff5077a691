//! Task termination (TC)
//! What: ends tasks with their subtrees, passes values to parents, and lets parents react: next step, completion, failure.
//! Runs: enable, commit and act phases; parents react before anything else continues.
//! Reads: Task, Controller.  Writes: Task, ResourceTable, contexts, Decision.
//! Bound: O(size of the subtree) per end.  PDL: sections 4 and 9.  Paper: section III, task termination.

use crate::control::conflicts::resources;
use crate::control::cycle::Cycle;
use crate::control::tasks::{
    binding, failure, interruption, monitoring_clauses, outcomes, primitive, probing, procedure, question, reasons,
    repetition,
};
use crate::control::transition::{Trigger, transition};
use crate::state::controller::Controller;
use crate::state::task::{Origin, ProcedureRef};
use apex_model::agent_limits::Limit;
use apex_model::because::{Because, Cause};
use apex_model::effect::Effect;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::value::Value;

/// Ends the task with its subtree.
pub(crate) fn end(cycle: &mut Cycle<'_>, id: TaskId, outcome: Outcome, because: Because) {
    if cycle.state(id) == TaskState::Terminated {
        return;
    }
    let (mut outcome, mut because) = (outcome, because);
    if let Outcome::Success(value) = &outcome
        && let Err(misfit) = binding::fitting(cycle, id, value)
    {
        if failure::handle(cycle, id, &misfit) {
            return;
        }
        (outcome, because) = (Outcome::Failure, misfit);
    }
    let cut = Because::new(Cause::ParentEnded { parent: id }, because.place);
    end_children(cycle, id, &cut);
    primitive::withdraw_commands(cycle, id, "its task ended");
    monitoring_clauses::unwatch(cycle, id, |_, _| true);
    if let Outcome::Success(value) = &outcome
        && let Err(misfit) = binding::result(cycle, id, &value.clone())
    {
        (outcome, because) = (Outcome::Failure, misfit);
    }
    if cycle.task(id).is_some_and(|task| task.started_at.is_some()) {
        interruption::run_hooks(cycle, id, "on-end", |hooks| &hooks.on_end);
    }
    if cycle.state(id) == TaskState::Terminated {
        return;
    }
    let how = if outcome == Outcome::Cut { resources::Release::Unused } else { resources::at_the_end(cycle, id) };
    resources::release(cycle, id, how);
    dismantle(cycle, id, "its task ended");
    transition(cycle, id, Trigger::Ended, Some(outcome), because);
    forget_wakes(cycle, id);
    cycle.agent.set_suspended(id, false);
    let Some(task) = cycle.agent.task_mut(id) else { return };
    task.selection = None;
    // Resources held for its steps were released with the others: a repetition begins without them.
    if let Some(extras) = &mut task.extras {
        extras.held.clear();
    }
    let (parent, answered) = (task.parent, task.after_sequence);
    if let Some(parent) = parent.and_then(|parent| cycle.agent.task_mut(parent)) {
        parent.after_sequence = parent.after_sequence.max(answered);
    }
    cycle.work.ended.push_back(id);
}

/// Ends the living children and removes all of them: no clause can refer to them any longer.
pub(crate) fn end_children(cycle: &mut Cycle<'_>, id: TaskId, because: &Because) {
    let children = cycle.task(id).and_then(|task| task.controller.as_deref()).map(Controller::children);
    for child in children.unwrap_or_default() {
        end(cycle, child, Outcome::Cut, because.clone());
        cycle.agent.listening.forget(child);
        cycle.agent.tasks.remove(child.0);
    }
}

/// Removes the controller and everything that it has scheduled or requested.
pub(crate) fn dismantle(cycle: &mut Cycle<'_>, id: TaskId, reason: &str) {
    primitive::withdraw_commands(cycle, id, reason);
    question::withdraw(cycle, id, reason);
    cycle.agent.guards.remove(id);
    let Some(controller) = cycle.agent.task_mut(id).and_then(|task| task.controller.take()) else { return };
    match *controller {
        Controller::Procedure(controller) => {
            if let ProcedureRef::Generated(number) = controller.procedure {
                release_generated(cycle, number);
            }
            close_logs(cycle, id);
        }
        Controller::Primitive(controller) => {
            for wake in [controller.end, controller.update].into_iter().flatten() {
                cycle.agent.wakes.cancel(wake);
            }
        }
        Controller::Planning(controller) => {
            if let Some(wake) = controller.wake {
                cycle.agent.wakes.cancel(wake);
            }
            if cycle.agent.requests.remove(&controller.request).is_some() {
                cycle.effects.push(Effect::CancelSolve(controller.request));
            }
        }
        Controller::Items(_) | Controller::Handling(_) | Controller::Question(_) | Controller::BuiltIn => {}
    }
}

fn release_generated(cycle: &mut Cycle<'_>, number: u64) {
    let Some(generated) = cycle.agent.generated.get_mut(number) else { return };
    generated.users = generated.users.saturating_sub(1);
    if generated.users == 0 && !generated.current {
        cycle.agent.generated.remove(number);
    }
}

fn close_logs(cycle: &mut Cycle<'_>, id: TaskId) {
    let logs = cycle.agent.task_mut(id).and_then(|task| task.extras.as_mut());
    for log in logs.map(|extras| std::mem::take(&mut extras.logs)).unwrap_or_default() {
        cycle.agent.histories.close_log(log);
    }
}

fn forget_wakes(cycle: &mut Cycle<'_>, id: TaskId) {
    let Some(extras) = cycle.agent.task_mut(id).and_then(|task| task.extras.as_mut()) else { return };
    for wake in [extras.wake.take(), extras.crossing.take()].into_iter().flatten() {
        cycle.agent.wakes.cancel(wake);
    }
}

/// Handles the failure of a task: its `on-failure` goal handles it, or the task ends with failure.
pub(crate) fn fail(cycle: &mut Cycle<'_>, id: TaskId, because: Because) {
    fail_as(cycle, id, Outcome::Failure, because);
}

/// Like [`fail`], with the kind of failure.
pub(crate) fn fail_as(cycle: &mut Cycle<'_>, id: TaskId, outcome: Outcome, because: Because) {
    if cycle.state(id) != TaskState::Terminated && !failure::handle(cycle, id, &because) {
        end(cycle, id, outcome, because);
    }
}

/// Fails the tasks that exceeded the memory budget of their agent.
pub(crate) fn fail_beyond_budget(cycle: &mut Cycle<'_>) {
    for (id, place) in std::mem::take(&mut cycle.work.over_budget) {
        let cause = cycle.agent.limits.reached(Limit::MemoryMebibytes);
        fail(cycle, id, Because::new(cause, Some(place)));
    }
}

/// Lets the parents of ended tasks react, in order.
pub(crate) fn settle(cycle: &mut Cycle<'_>) {
    while let Some(id) = cycle.work.ended.pop_front() {
        let Some(task) = cycle.task(id) else { continue };
        if task.state != TaskState::Terminated {
            continue;
        }
        match task.parent {
            Some(parent) => react(cycle, parent, id),
            None => finish(cycle, id),
        }
    }
}

fn react(cycle: &mut Cycle<'_>, parent: TaskId, child: TaskId) {
    let Some((origin, outcome)) = cycle.task(child).and_then(|task| Some((task.origin, task.outcome.clone()?))) else {
        return;
    };
    if let Origin::Probe(id) = origin {
        return probing::ended(cycle, id, parent, child);
    }
    let failed = outcome.is_failure() && !outcomes::is_awaited(cycle, child);
    let because = Because::new(Cause::ChildFailed { child }, cycle.place_of(child));
    match cycle.task(parent).and_then(|task| task.controller.as_deref()) {
        Some(Controller::Procedure(_)) if failed => fail(cycle, parent, because),
        Some(Controller::Procedure(_)) => {
            if !repetition::repeat(cycle, child, &outcome) {
                cycle.agent.listening.forget(child);
                repetition::ended_for_good(cycle, child, &outcome);
                for (dependent, because) in outcomes::dependents(cycle, parent, child, &outcome) {
                    end(cycle, dependent, Outcome::Skipped, because);
                }
                procedure::step_ended(cycle, parent, child);
            }
        }
        Some(Controller::Items(_)) if failed => fail(cycle, parent, because),
        Some(Controller::Items(_)) => procedure::item_ended(cycle, parent, child),
        Some(Controller::Handling(_)) => failure::handled(cycle, parent, child, &outcome),
        Some(Controller::Planning(_)) => procedure::meanwhile_ended(cycle, parent, child),
        Some(Controller::Primitive(_) | Controller::Question(_) | Controller::BuiltIn) | None => {}
    }
}

/// Ends the application, because the root task ended.
fn finish(cycle: &mut Cycle<'_>, root: TaskId) {
    let reason = match cycle.task(root).and_then(|task| task.outcome.as_ref()) {
        Some(Outcome::Success(value)) if value.is_true() => format!("the initial task is done: {value}"),
        Some(Outcome::Success(_)) => "the initial task is done".to_string(),
        Some(Outcome::Failure | Outcome::PreconditionFailed | Outcome::InvariantViolated) => {
            "the initial task failed".to_string()
        }
        Some(Outcome::Exited) => "the initial task exited".to_string(),
        Some(Outcome::Cut | Outcome::Skipped) | None => "the application was ended".to_string(),
    };
    if cycle.agent.finished.is_none() {
        cycle.agent.finished = Some(reason.clone());
        cycle.effects.push(match cycle.library.has_several_agents() {
            true => Effect::AgentEnded { reason },
            false => Effect::EndApplication { reason },
        });
    }
}

/// Executes `(end-application)`: cuts the root task with all of its subtasks.
pub(crate) fn end_application(cycle: &mut Cycle<'_>, by: TaskId, reason: Option<Value>) {
    let words = match reason {
        Some(Value::Text(text)) => text.to_string(),
        Some(other) => other.to_string(),
        None => reasons::of_end(cycle, by),
    };
    let because = Because::new(Cause::ApplicationEnded { by }, cycle.place_of(by));
    if cut_all(cycle, &words, because) {
        cycle.effects.push(Effect::EndApplication { reason: words });
    }
}

/// Ends the application for a reason from outside this agent: cuts all tasks.
pub(crate) fn stop(cycle: &mut Cycle<'_>, reason: &str) {
    let because = Because::new(Cause::Stopped { reason: reason.to_string() }, None);
    cut_all(cycle, reason, because);
}

/// Cuts the root task with everything below it; returns false if the agent has ended already.
fn cut_all(cycle: &mut Cycle<'_>, reason: &str, because: Because) -> bool {
    if cycle.agent.finished.is_some() {
        return false;
    }
    cycle.agent.finished = Some(reason.to_string());
    let root = cycle.agent.tasks.iter().next().map(|(_, task)| task.id);
    if let Some(root) = root {
        end(cycle, root, Outcome::Cut, because);
    }
    cycle.work.ended.clear();
    true
}
