//! Goals of tasks (TC)
//! What: states the goal of a task, with the present values of its variables.
//! Runs: when a task is created or described, and in the choose phase.
//! Reads: Task, Procedure, variables.
//! Writes: nothing.
//! Bound: O(size of the goal).
//! PDL: steps and their activities, section 3.
//! Paper: section III.

use crate::control::cycle::Cycle;
use crate::expression::view::View;
use crate::expression::{EvalContext, expression_as_known, instantiate_partially};
use crate::state::agent::Agent;
use crate::state::clause::Level;
use crate::state::task::Origin;
use apex_model::expression::Expr;
use apex_model::procedure::{Activity, Step};
use apex_model::task::TaskId;
use apex_model::time::Time;
use apex_model::value::Value;

/// Returns the activity that the task pursues: its step's, or the step's `on-failure`.
pub(crate) fn activity_of(origin: Option<Origin>, step: &Step) -> &Activity {
    match (origin, &step.on_failure) {
        (Some(Origin::OnFailure(_)), Some(activity)) => activity,
        _ => &step.activity,
    }
}

/// Returns the task's goal with the present bindings; unbound variables stay as they are written.
pub(crate) fn goal_as_known(cycle: &Cycle<'_>, id: TaskId) -> Value {
    goal_in(cycle.agent, id, cycle.now)
}

/// Returns the goal of the `on-failure` of the task's step.
pub(crate) fn handler_goal(cycle: &Cycle<'_>, id: TaskId) -> Value {
    let origin = cycle.task(id).map(|task| task.origin);
    let Some(Origin::Step(step)) = origin else { return Value::nil() };
    let view = cycle.view(id, Level::Step);
    let template = cycle.agent.procedure(step.procedure).and_then(|each| each.steps.get(step.step as usize));
    let handler = template.and_then(|step| step.on_failure.as_ref());
    handler.map_or_else(Value::nil, |activity| activity_as_value(activity, &view))
}

/// Returns the task's goal, outside of a cycle.
pub(crate) fn goal_in(agent: &Agent, id: TaskId, now: Time) -> Value {
    let Some(task) = agent.task(id) else { return Value::nil() };
    if let Some(selection) = &task.selection {
        return selection.goal.clone();
    }
    let view = View { agent, task: id, level: Level::Step, now };
    let goal = match task.origin {
        Origin::Initial => Some(agent.initial_task.clone()),
        Origin::Meanwhile(solver) => {
            let declared = agent.library.solvers.get(solver as usize).and_then(|solver| solver.meanwhile.as_ref());
            declared.map(|goal| instantiate_partially(goal, &view))
        }
        Origin::Probe(probing) => {
            agent.probings.get(&probing).map(|probing| instantiate_partially(&probing.goal, &view))
        }
        Origin::Step(step) | Origin::Item(step) | Origin::OnFailure(step) => {
            let template = agent.procedure(step.procedure).and_then(|each| each.steps.get(step.step as usize));
            template.map(|step| activity_as_value(activity_of(Some(task.origin), step), &view))
        }
    };
    goal.unwrap_or_else(Value::nil)
}

/// Returns an activity in the notation of PDL.
pub(crate) fn activity_as_value(activity: &Activity, context: &dyn EvalContext) -> Value {
    match activity {
        Activity::Goal(template) => instantiate_partially(template, context),
        Activity::Terminate { task, outcome, value } => {
            let known = |expr: &Expr| expression_as_known(expr, context);
            let parts = [task, outcome].into_iter().flatten().map(|expr| known(expr));
            let words = [Value::symbol("terminate")].into_iter().chain(parts);
            let value = value.iter().flat_map(|value| [Value::symbol(">>"), known(value)]);
            Value::list(words.chain(value))
        }
        Activity::BuiltIn(which, arguments) => {
            let arguments = arguments.iter().map(|argument| expression_as_known(argument, context));
            let (words, keywords) = which.words();
            let plain = arguments.len() - keywords.len().min(arguments.len());
            let options = keywords.iter().zip(arguments.clone().skip(plain)).filter(|(_, value)| value.is_true());
            let options = options.flat_map(|(keyword, value)| [Value::symbol(keyword), value]);
            let words = words.iter().map(|word| Value::symbol(word));
            Value::list(words.chain(arguments.take(plain)).chain(options))
        }
    }
}
