//! Memory budget (TC)
//! What: counts the bytes of tasks, monitors, decisions of the instant, bound values and histories, and rejects what exceeds the budget.
//! Runs: when a task is made or a variable bound.  Reads: Task, Watch, bindings, histories.  Writes: MemoryCount, Decision.
//! Bound: O(1); O(size of the agent) each time that large values have taken another 1/32 of the budget.  PDL: `:limits (:memory-mebibytes N)`.
//! Paper: none.

use crate::control::cycle::Cycle;
use crate::state::agent::Agent;
use crate::state::bindings::Bindings;
use crate::state::controller::{Controller, MethodBinding};
use crate::state::histories::history::Sample;
use crate::state::memory_count::MemoryCount;
use apex_model::agent_limits::Limit;
use apex_model::because::Cause;
use apex_model::effect::Effect;
use apex_model::source::Place;
use apex_model::task::TaskId;
use apex_model::value::Value;

/// Number of bytes of a task that waits, with its controller, its selection and its entries in tables: as `benches` measure it.
const TASK_BYTES: u64 = 640;
/// Number of bytes of a monitor with its parts and interests.
const WATCH_BYTES: u64 = 400;
/// Number of bytes of a decision with its values, until the runtime has taken it.
const EFFECT_BYTES: u64 = size_of::<Effect>() as u64 + 150;
/// Number of decisions about a new task within its first instant: created, enabled, selected, ongoing, ended.
const DECISIONS_OF_A_NEW_TASK: u64 = 5;
/// Values of fewer bytes are counted as part of their task.
const LARGE_VALUE_BYTES: u64 = 4_096;
/// Everything is counted again when large values have taken this part of the budget since the last count.
const RECOUNT_PART: u64 = 32;

fn budget(agent: &Agent) -> u64 {
    agent.limits.of(Limit::MemoryMebibytes) << 20
}

/// Returns the bytes of everything that is counted by number: tasks, monitors and decisions.
fn numbered(cycle: &Cycle<'_>) -> u64 {
    let agent = &*cycle.agent;
    // The decisions about a new task count when it is made: rejecting them later would be too late.
    let made = agent.next.task.saturating_sub(cycle.first_task) * DECISIONS_OF_A_NEW_TASK;
    let effects = made.max(cycle.effects.len() as u64);
    agent.tasks.len() as u64 * TASK_BYTES + agent.watches.len() as u64 * WATCH_BYTES + effects * EFFECT_BYTES
}

/// Checks that there is memory for one more task.
///
/// # Errors
/// The cause, if the budget is used up.
pub(crate) fn room_for_task(cycle: &mut Cycle<'_>) -> Result<(), Cause> {
    if is_within(cycle, TASK_BYTES + DECISIONS_OF_A_NEW_TASK * EFFECT_BYTES) {
        Ok(())
    } else {
        Err(cycle.agent.limits.reached(Limit::MemoryMebibytes))
    }
}

fn is_within(cycle: &mut Cycle<'_>, more: u64) -> bool {
    let budget = budget(cycle.agent);
    let memory = cycle.agent.memory;
    if numbered(cycle) + memory.counted + memory.since + more <= budget {
        return true;
    }
    if memory.since > 0 {
        cycle.agent.memory = MemoryCount { counted: count(cycle.agent), since: 0 };
    }
    numbered(cycle) + cycle.agent.memory.counted + more <= budget
}

/// Records that a variable of the task was bound to `value`. A task that exceeds the memory budget fails before it continues.
pub(crate) fn bound(cycle: &mut Cycle<'_>, id: TaskId, value: &Value, place: Place) {
    let bytes = value_bytes(value);
    if bytes < LARGE_VALUE_BYTES {
        return;
    }
    cycle.agent.memory.since += bytes;
    if cycle.agent.memory.since > budget(cycle.agent) / RECOUNT_PART && !is_within(cycle, 0) {
        cycle.work.over_budget.push((id, place));
    }
    if cycle.agent.memory.since > budget(cycle.agent) / RECOUNT_PART {
        cycle.agent.memory = MemoryCount { counted: count(cycle.agent), since: 0 };
    }
}

/// Returns the bytes of large values and samples; a value counts once for each holder.
fn count(agent: &Agent) -> u64 {
    let values: u64 = agent
        .tasks
        .iter()
        .map(|(_, task)| {
            let own = bindings_bytes(&task.bindings);
            let chosen = task.selection.as_ref().map_or(0, |selection| match &selection.way {
                MethodBinding::Procedure(_, bindings) | MethodBinding::Primitive(_, bindings) => {
                    bindings_bytes(bindings)
                }
                MethodBinding::Items(items) => items.iter().map(value_bytes).sum(),
                MethodBinding::BuiltIn(_) | MethodBinding::Terminate | MethodBinding::Solver(_) => 0,
            });
            let held = match task.controller.as_deref() {
                Some(Controller::Procedure(controller)) => bindings_bytes(&controller.context),
                Some(Controller::Primitive(controller)) => {
                    bindings_bytes(&controller.context) + bindings_bytes(&controller.locals)
                }
                _ => 0,
            };
            own + chosen + held
        })
        .sum();
    values + agent.histories.sample_count() as u64 * size_of::<Sample>() as u64
}

fn bindings_bytes(bindings: &Bindings) -> u64 {
    bindings.iter().map(|(_, value)| value_bytes(value)).filter(|bytes| *bytes >= LARGE_VALUE_BYTES).sum()
}

/// Returns the bytes of a value with everything in it; 0 for a value stored inside its holder.
fn value_bytes(value: &Value) -> u64 {
    match value {
        Value::Text(text) => text.len() as u64,
        Value::List(items) => {
            let own = std::mem::size_of_val(&**items) as u64;
            own + items.iter().map(value_bytes).sum::<u64>()
        }
        Value::Integer(_)
        | Value::Real(_)
        | Value::Quantity(_)
        | Value::Duration(_)
        | Value::Time(_)
        | Value::Symbol(_)
        | Value::Interval(..)
        | Value::Task(_)
        | Value::Closure(_) => 0,
    }
}
