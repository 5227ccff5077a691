//! Restart (TC)
//! What: makes a task start over: its children end, its controller is removed, its preconditions and suspension stay.
//! Runs: enable phase (`restart-when`), act phase (`reset`).  Reads: Task.  Writes: Task, ResourceTable, monitors.
//! Bound: O(size of the subtree).  PDL: `restart-when`, `(reset TASK)`, section 9.  Paper: section III, camera procedure.

use crate::control::conflicts::resources;
use crate::control::cycle::Cycle;
use crate::control::tasks::{interruption, repetition, termination};
use crate::control::transition::{Trigger, transition};
use apex_model::because::{Because, Cause};
use apex_model::task::{TaskId, TaskState};

/// Starts the task over. End actions do not run: the work has not ended.
pub(crate) fn restart(cycle: &mut Cycle<'_>, id: TaskId, because: Because) {
    if !matches!(cycle.state(id), TaskState::Ongoing | TaskState::Interrupted) {
        return;
    }
    if let Err(cause) = repetition::count_instance(cycle, id) {
        termination::fail(cycle, id, Because::new(cause, because.place));
        return;
    }
    let cut = Because::new(Cause::ParentRestarted { parent: id }, because.place);
    termination::end_children(cycle, id, &cut);
    termination::dismantle(cycle, id, "its task starts over");
    resources::release(cycle, id, resources::Release::Unused);
    interruption::forget_clauses(cycle, id);
    transition(cycle, id, Trigger::Restarted, None, because);
    let now = cycle.now;
    let newest = cycle.agent.next.arrival.checked_sub(1);
    if let Some(task) = cycle.agent.task_mut(id) {
        // Earlier arrivals belong to the work that is started over: they cannot cause another restart.
        task.after_sequence = task.after_sequence.max(newest);
        task.started_at = None;
        let created = std::mem::replace(&mut task.created_at, now);
        task.selection = None;
        task.held_back = task.held_back.of_turn();
        if let Some(extras) = &mut task.extras {
            extras.worked = apex_model::time::Duration::ZERO;
            extras.held.clear();
            extras.first_created.get_or_insert(created);
        }
    }
    cycle.work.freed.insert(id, Cause::StartsOver);
    cycle.work.ready.push(id);
}
