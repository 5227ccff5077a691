//! View of a task as plain data.

use crate::control::conflicts::priority::priority;
use crate::state::agent::Agent;
use crate::state::controller::MethodBinding;
use crate::state::task::{Origin, Task};
use apex_model::effect::Method;
use apex_model::source::Place;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::Time;
use apex_model::value::Value;
use serde::Serialize;

/// Description of a task for display.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaskView {
    /// Its number.
    pub id: TaskId,
    /// Task that created it; `None` for the root.
    pub parent: Option<TaskId>,
    /// Its step's tag, printed.
    pub tag: String,
    /// Its goal, with the known values of its variables.
    pub goal: Value,
    /// Its state.
    pub state: TaskState,
    /// Since when.
    pub since: Time,
    /// Creation of this instance.
    pub created_at: Time,
    /// Instant at which it first became ongoing.
    pub started_at: Option<Time>,
    /// True if a clause or an activity has suspended it: it claims nothing until it is resumed.
    pub suspended: bool,
    /// Its priority now.
    pub priority: f64,
    /// Added to the priority when the task defends its resources; `None` before the task has a method.
    pub interrupt_cost: Option<f64>,
    /// Names of the resources that it holds.
    pub resources: Vec<Value>,
    /// Names of the resources that it needs to be ongoing.
    pub needs: Vec<Value>,
    /// Method for its goal; `None` while pending or terminated.
    pub method: Option<Method>,
    /// Outcome.
    pub outcome: Option<Outcome>,
    /// Its step in PDL.
    pub place: Option<Place>,
    /// Nesting: the root has 0.
    pub depth: u32,
    /// Subtasks that a clause may still refer to, in order of creation.
    pub children: Vec<TaskId>,
}

/// Returns the task with this number, while a clause may still refer to it.
pub fn describe_task(agent: &Agent, task: TaskId) -> Option<TaskView> {
    agent.task(task).map(|found| view(agent, found))
}

/// Returns all tasks that have not ended, in order of creation.
pub fn agenda(agent: &Agent) -> Vec<TaskView> {
    agent.tasks.iter().filter(|(_, task)| !task.is_terminated()).map(|(_, task)| view(agent, task)).collect()
}

fn view(agent: &Agent, task: &Task) -> TaskView {
    let selection = task.selection.as_ref();
    let holds = |each: &&crate::state::resource::Resource| each.holders.iter().any(|holding| holding.task == task.id);
    let needs = selection.into_iter().flat_map(|selection| &selection.needs);
    let needs = needs.filter_map(|need| Some(agent.resources.get(need.resource)?.name.clone()));
    let step = task.step().and_then(|step| {
        let place = agent.procedure(step.procedure)?.steps.get(step.step as usize)?.place;
        Some(place)
    });
    TaskView {
        id: task.id,
        parent: task.parent,
        tag: agent.tag(task).to_string(),
        goal: goal(agent, task),
        state: task.state,
        since: task.since,
        created_at: task.created_at,
        started_at: task.started_at,
        suspended: task.suspended,
        priority: priority(agent, task.id, agent.now),
        interrupt_cost: selection.map(|selection| selection.interrupt_cost),
        resources: agent.resources.iter().map(|(_, each)| each).filter(holds).map(|each| each.name.clone()).collect(),
        needs: needs.collect(),
        method: selection.and_then(|selection| method(agent, &selection.way)),
        outcome: task.outcome.clone(),
        place: match task.origin {
            Origin::Probe(probing) => agent.probings.get(&probing).map(|probing| probing.place),
            _ => step,
        },
        depth: task.depth,
        children: task.controller.as_deref().map(crate::state::controller::Controller::children).unwrap_or_default(),
    }
}

fn method(agent: &Agent, way: &MethodBinding) -> Option<Method> {
    match way {
        MethodBinding::Procedure(reference, _) => agent.procedure(*reference).map(|each| Method::Procedure(each.place)),
        MethodBinding::Primitive(index, _) => {
            agent.library.primitives.get(*index as usize).map(|each| Method::Primitive(each.place))
        }
        MethodBinding::Solver(index) => {
            agent.library.solvers.get(*index as usize).map(|each| Method::Solver(each.name.clone()))
        }
        MethodBinding::Items(_) | MethodBinding::BuiltIn(_) | MethodBinding::Terminate => Some(Method::BuiltIn),
    }
}

/// Returns the goal with its variables filled in as far as they are known.
fn goal(agent: &Agent, task: &Task) -> Value {
    match (&task.selection, task.origin) {
        (Some(selection), _) => selection.goal.clone(),
        (None, Origin::Initial) => agent.initial_task.clone(),
        (None, _) => crate::control::tasks::goal::goal_in(agent, task.id, agent.now),
    }
}
