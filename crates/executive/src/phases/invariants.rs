//! Invariants (TC)
//! What: asserts the invariants of tasks and resources between instants.
//! Runs: after every instant, in builds with assertions.  Reads: Agent.  Writes: nothing.
//! Bound: O(tasks), and only for agents small enough that this is cheap.  PDL: section 9.  Paper: section III.

use crate::control::conflicts::competition::related;
use crate::state::agent::Agent;
use apex_model::task::TaskState;

/// Larger agents are not checked: the check must not change how fast a test flight is.
const TASKS_CHECKED_MAX: usize = 200;

/// Checks that no resource is held twice, that ongoing tasks have what they need, and that ended tasks have no living children.
pub(crate) fn check(agent: &Agent) {
    if !cfg!(debug_assertions) || agent.tasks.len() > TASKS_CHECKED_MAX {
        return;
    }
    let suspended = agent.tasks.iter().filter(|(_, task)| task.suspended).count() as u64;
    debug_assert_eq!(agent.suspended, suspended, "the count of suspended tasks is wrong");
    for (_, resource) in agent.resources.iter() {
        for (index, holding) in resource.holders.iter().enumerate() {
            let state = agent.task(holding.task).map(|task| task.state);
            debug_assert_eq!(
                state,
                Some(TaskState::Ongoing),
                "{} holds {} without working",
                holding.task,
                resource.name
            );
            let clash = resource.holders.iter().skip(index + 1).any(|other| {
                other.amount + holding.amount > resource.total + 1e-6 && !related(agent, other.task, holding.task)
            });
            debug_assert!(!clash, "{} is held twice", resource.name);
        }
    }
    for (_, task) in agent.tasks.iter() {
        let needs = task.selection.iter().flat_map(|selection| &selection.needs);
        let lacks = |need: &crate::state::resource::Need| {
            let resource = agent.resources.get(need.resource);
            resource.is_some_and(|resource| resource.holders.iter().all(|holding| holding.task != task.id))
        };
        debug_assert!(
            task.state != TaskState::Ongoing || !needs.clone().any(lacks),
            "{} works without all of its profile",
            task.id
        );
        let parent = task.parent.and_then(|parent| agent.task(parent));
        let orphan = parent.is_some_and(|parent| parent.is_terminated()) && !task.is_terminated();
        debug_assert!(!orphan, "{} lives although its parent ended", task.id);
    }
}
