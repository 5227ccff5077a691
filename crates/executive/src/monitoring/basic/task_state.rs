//! Task conditions (M&I)
//! What: detects that a task has ended, perhaps with a required outcome, or has entered a state.
//! Runs: on transitions of the task; once on the task as it is when the monitor is made.
//! Reads: evaluation context.
//! Writes: the task parts of a monitor.
//! Bound: O(1) per transition.
//! PDL: `?s1`, `(end ?s1)`, `(state ?s1 = S)`, `(failed ?s1)`.
//! Paper: section III, monitors check events of internal mechanisms.

use crate::expression::{EvalContext, evaluate};
use crate::monitoring::part::{ConditionFaults, PartContext, remember};
use crate::monitoring::pattern_matching::match_pattern;
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{Interest, Keep, Monitor, PartKind, Satisfaction, TaskEndedPart, TaskStatePart};
use apex_model::because::Evidence;
use apex_model::evidence_list::EvidenceList;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::task::{OUTCOME_STATES, TaskId, TaskState};
use apex_model::time::Time;
use apex_model::value::Value;

/// Determines the task of the condition, and whether it has ended already.
pub(crate) fn advance_ended(part: &mut TaskEndedPart, context: &dyn EvalContext) {
    if let Some(Value::Task(task)) = context.variable(&part.variable) {
        if part.task != Some(task) {
            part.task = Some(task);
            part.ended = None;
        }
        if part.ended.is_none() && part.standing {
            part.ended = context.task_end(task);
        }
    }
}

/// Processes the end of a task.
pub(crate) fn notice_ended(part: &mut TaskEndedPart, task: TaskId, at: Time) {
    if part.task == Some(task) && part.ended.is_none() {
        part.ended = Some(at);
    }
}

/// Returns the result of a wait for a task's end.
pub(crate) fn ended_result(part: &TaskEndedPart) -> Option<Satisfaction> {
    let (task, at) = part.task.zip(part.ended)?;
    let evidence = EvidenceList::one(Evidence::TaskEnd { task, at });
    Some(Satisfaction { interval: (at, at), recognised_at: at, bindings: Bindings::new(), evidence })
}

/// Determines the task of the condition. Its present state counts if the part includes it, or if the tag names another task now.
pub(crate) fn advance_state(
    part: &mut TaskStatePart,
    site: PartContext,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    let Ok(Value::Task(task)) = evaluate(&part.expression, context) else { return };
    if part.task == Some(task) {
        return;
    }
    let another = part.task.replace(task).is_some();
    part.settled.clear();
    if (part.standing || another)
        && let Some(state) = context.task_state(task)
    {
        note(part, site, task, state.word(), context.now(), context, troubles);
        if state == TaskState::Terminated && names_outcome(part) {
            for word in context.task_outcome(task).unwrap_or_default() {
                note(part, site, task, word, context.now(), context, troubles);
            }
        }
    }
}

/// Returns true if the condition names an outcome: outcomes count only then, because a variable in the place of the state is bound to a state.
fn names_outcome(part: &TaskStatePart) -> bool {
    matches!(&part.state, Pattern::Literal(Value::Symbol(name)) if OUTCOME_STATES.contains(&name.folded()))
}

/// Processes the final end of a task with its outcome, which stays a fact.
pub(crate) fn notice_outcome(
    part: &mut TaskStatePart,
    site: PartContext,
    (task, outcome, at): (TaskId, &'static [&'static str], Time),
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if part.task != Some(task) || at < site.window.start || !names_outcome(part) {
        return;
    }
    for word in outcome {
        note(part, site, task, word, at, context, troubles);
    }
}

/// Processes a change of a task's state.
pub(crate) fn notice_state(
    part: &mut TaskStatePart,
    site: PartContext,
    (task, from, state, at): (TaskId, TaskState, TaskState, Time),
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if part.task != Some(task) || at < site.window.start {
        return;
    }
    note(part, site, task, state.word(), at, context, troubles);
    if from == TaskState::Interrupted && state == TaskState::Ongoing {
        note(part, site, task, "resumed", at, context, troubles);
    }
}

fn note(
    part: &mut TaskStatePart,
    site: PartContext,
    task: TaskId,
    word: &str,
    at: Time,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if site.keep == Keep::First && !part.settled.is_empty() {
        return;
    }
    let (mut bindings, value) = (Bindings::new(), Value::symbol(word));
    match match_pattern(&part.state, &value, &mut bindings, context, site.place) {
        Ok(true) => {
            let evidence = EvidenceList::one(Evidence::TaskState { task, state: value, at });
            remember(
                &mut part.settled,
                Satisfaction { interval: (at, at), recognised_at: at, bindings, evidence },
                site,
                troubles,
            );
        }
        Ok(false) => {}
        Err(error) => troubles.add(error),
    }
}

/// Returns the only interest of a monitor that waits for one task's end or state; `None` for all other monitors.
pub(crate) fn sole_interest(monitor: &Monitor) -> Option<Interest> {
    match &monitor.root.kind {
        PartKind::TaskEnded(leaf) => Some(interest(leaf.task)),
        PartKind::TaskState(leaf) => Some(interest(leaf.task)),
        _ => None,
    }
}

/// Returns the interest in transitions of `task`; in those of all tasks if it is not known yet.
pub(crate) fn interest(task: Option<TaskId>) -> Interest {
    task.map_or(Interest::AnyTask, Interest::Task)
}

/// Returns the name by which a wait for a task's end is explained.
pub(crate) fn ended_words(variable: &Symbol) -> String {
    format!("(end ?{variable})")
}
