//! Conditions that tasks watch, and bindings of their variables, as plain data.

use crate::control::tasks::episode_index_tasks;
use crate::expression::view::View;
pub use crate::monitoring::combination::condition_tree::ConditionNode;
use crate::monitoring::combination::monitors;
use crate::state::agent::Agent;
use crate::state::bindings::Bindings;
use crate::state::controller::{Controller, MethodBinding};
use crate::state::task::Task;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::value::Value;

/// A clause with a condition that a task watches.
#[derive(Clone, Debug, PartialEq)]
pub struct WatchedClause {
    /// The task.
    pub task: TaskId,
    /// The clause's name in PDL: `waitfor`, `restart-when`.
    pub clause: &'static str,
    /// Its condition with the present state of each part.
    pub condition: ConditionNode,
}

/// Returns the conditions that living tasks watch now, in order of the tasks' creation; with `task`, those of that task alone.
pub fn watched(agent: &Agent, task: Option<TaskId>) -> Vec<WatchedClause> {
    let chosen = |each: &Task| task.is_none_or(|task| task == each.id) && !each.is_terminated();
    let tasks = agent.tasks.iter().map(|(_, task)| task).filter(|each| chosen(each));
    tasks.flat_map(|task| clauses(agent, task)).collect()
}

fn clauses(agent: &Agent, task: &Task) -> Vec<WatchedClause> {
    let watches = task.monitors.iter().filter_map(|id| Some((*id, agent.watches.get(id.0)?)));
    let clause = |(id, watch)| {
        let watch: &crate::state::clause::ClauseMonitor = watch;
        let view = View { agent, task: task.id, level: watch.level, now: agent.now };
        let condition = monitors::condition_tree(&episode_index_tasks::as_told(agent, id, watch), &view);
        WatchedClause { task: task.id, clause: watch.clause.word(), condition }
    };
    watches.map(clause).collect()
}

/// Returns the variables of a task with their present values, without `?`: those of its step, then those of the procedure that it
/// executes. Empty for an unknown task.
pub fn bindings(agent: &Agent, task: TaskId) -> Vec<(Symbol, Value)> {
    let Some(task) = agent.task(task) else { return Vec::new() };
    let inner: Option<&Bindings> = match task.controller.as_deref() {
        Some(Controller::Procedure(controller)) => Some(&controller.context),
        Some(Controller::Primitive(controller)) => Some(&controller.context),
        _ => match task.selection.as_ref().map(|selection| &selection.way) {
            Some(MethodBinding::Procedure(_, bindings) | MethodBinding::Primitive(_, bindings)) => Some(bindings),
            _ => None,
        },
    };
    let all = task.bindings.iter().chain(inner.into_iter().flat_map(Bindings::iter));
    all.map(|(name, value)| (name.clone(), value.clone())).collect()
}
