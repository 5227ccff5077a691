//! Task state transition control (TC)
//! What: holds the only table of states and causes, and the only function that changes a task's state.
//! Runs: whenever another service moves a task.  Reads: Task.  Writes: Task state, Decision, stimuli for monitors.
//! Bound: O(1) per transition, O(log n) in the number of watched tasks.  PDL: section 9.  Paper: section III.

use crate::control::cycle::Cycle;
use crate::monitoring::stimulus::Stimulus;
use crate::state::clause::MonitorId;
use apex_model::because::{Because, Cause};
use apex_model::effect::DecisionKind;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::Duration;

/// Causes of decisions that move a task from state to state, by their effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trigger {
    /// The preconditions hold.
    Satisfied,
    /// All resources are granted, or none is needed.
    Granted,
    /// A resource was lost to another task.
    Outranked,
    /// A clause, an activity or an ancestor suspends it.
    Suspended,
    /// A clause or an activity makes it start over.
    Restarted,
    /// Its step repeats.
    Repeated,
    /// The task completes, fails or is cut.
    Ended,
}

/// A pair of state and trigger that must not occur; its occurrence is a bug of Apex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Illegal;

/// Returns the state after `trigger`, by the table of `pdl.md`, Conflicts. Every pair is listed.
pub(crate) fn successor(state: TaskState, trigger: Trigger) -> Result<TaskState, Illegal> {
    use TaskState::{Enabled, Interrupted, Ongoing, Pending, Terminated};
    match (state, trigger) {
        (Pending, Trigger::Satisfied) => Ok(Enabled),
        (Enabled, Trigger::Granted) => Ok(Ongoing),
        (Ongoing, Trigger::Outranked) => Ok(Interrupted),
        (Ongoing, Trigger::Suspended) => Ok(Interrupted),
        (Interrupted, Trigger::Granted) => Ok(Ongoing),
        (Ongoing, Trigger::Restarted) => Ok(Pending),
        (Interrupted, Trigger::Restarted) => Ok(Pending),
        (Terminated, Trigger::Repeated) => Ok(Pending),
        (Pending, Trigger::Ended) => Ok(Terminated),
        (Enabled, Trigger::Ended) => Ok(Terminated),
        (Ongoing, Trigger::Ended) => Ok(Terminated),
        (Interrupted, Trigger::Ended) => Ok(Terminated),

        (
            Pending,
            Trigger::Granted | Trigger::Outranked | Trigger::Suspended | Trigger::Restarted | Trigger::Repeated,
        ) => Err(Illegal),
        (
            Enabled,
            Trigger::Satisfied | Trigger::Outranked | Trigger::Suspended | Trigger::Restarted | Trigger::Repeated,
        ) => Err(Illegal),
        (Ongoing, Trigger::Satisfied | Trigger::Granted | Trigger::Repeated) => Err(Illegal),
        (Interrupted, Trigger::Satisfied | Trigger::Outranked | Trigger::Suspended | Trigger::Repeated) => Err(Illegal),
        (
            Terminated,
            Trigger::Satisfied
            | Trigger::Granted
            | Trigger::Outranked
            | Trigger::Suspended
            | Trigger::Restarted
            | Trigger::Ended,
        ) => Err(Illegal),
    }
}

/// Changes the state of `id` by `trigger`, with `because` as cause. Returns false if the task does not exist or the pair is illegal.
pub(crate) fn transition(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    trigger: Trigger,
    outcome: Option<Outcome>,
    because: Because,
) -> bool {
    let now = cycle.now;
    let Some(task) = cycle.agent.task_mut(id) else { return false };
    let from = task.state;
    let Ok(to) = successor(from, trigger) else {
        debug_assert!(false, "{id}: {trigger:?} in state {from}");
        let message = format!("{id} is {from} and cannot take {trigger:?}");
        cycle.trouble_of(Some(id), Cause::ExecutiveFault { message }, because.place);
        return false;
    };
    let stretch = now - task.since;
    if from == TaskState::Ongoing && stretch > Duration::ZERO {
        let extras = task.extras_mut();
        extras.worked = extras.worked + stretch;
    }
    if to == TaskState::Ongoing && task.started_at.is_none() {
        task.started_at = Some(now);
    }
    if from == TaskState::Ongoing {
        cycle.work.resuming.remove(&id);
    }
    cycle.work.priorities_changed |= !cycle.agent.unsteady.is_empty();
    let may_repeat = matches!(outcome, Some(Outcome::Success(_))) && cycle.may_repeat(id);
    let Some(task) = cycle.agent.task_mut(id) else { return false };
    let again = matches!(trigger, Trigger::Repeated | Trigger::Restarted);
    task.state = to;
    task.since = now;
    task.outcome.clone_from(&outcome);
    cycle.work.balance.again |= again;
    cycle.work.states_changed |= cycle.agent.guards.read_states();
    cycle.work.balance.ends |= to == TaskState::Terminated;
    let states = outcome.as_ref().map_or(&[] as &[&str], Outcome::states);
    cycle.decide(Some(id), DecisionKind::Transition { from, to, outcome }, because);
    if !cycle.agent.interests.ignore_task(id) {
        let before = MonitorId(cycle.agent.next.monitor);
        cycle.work.stimuli.push(Stimulus::TaskState { task: id, from, state: to, at: now, before });
        // For a step that repeats, only the reaction of its parent decides whether this is its final end.
        if to == TaskState::Terminated && !may_repeat {
            let outcome = states;
            cycle.work.stimuli.push(Stimulus::TaskEnded { task: id, outcome, at: now, before });
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use TaskState::{Enabled, Interrupted, Ongoing, Pending, Terminated};

    #[test]
    fn twelve_pairs_are_legal_and_no_more() {
        let states = [Pending, Enabled, Ongoing, Interrupted, Terminated];
        let triggers = [
            Trigger::Satisfied,
            Trigger::Granted,
            Trigger::Outranked,
            Trigger::Suspended,
            Trigger::Restarted,
            Trigger::Repeated,
            Trigger::Ended,
        ];
        let legal = states.iter().flat_map(|state| triggers.iter().map(move |trigger| successor(*state, *trigger)));
        assert_eq!(legal.filter(Result::is_ok).count(), 12);
    }

    #[test]
    fn an_ended_task_comes_back_only_by_repetition() {
        assert_eq!(successor(Terminated, Trigger::Repeated), Ok(Pending));
        assert_eq!(successor(Terminated, Trigger::Restarted), Err(Illegal));
    }
}
