//! Reasons as text (TC)
//! What: words for the end of the application and for a handled failure, which name goals instead of tasks.
//! Runs: at the end of the application, and when a failure is handled.
//! Reads: the effects of the step so far, Task.  Writes: nothing.
//! Bound: O(effects of the step) for each failure from the task down to the first one.
//! PDL: `end-application`, `on-failure`.  Paper: section III, off-nominal conditions.

use crate::control::cycle::Cycle;
use crate::control::tasks::goal::{goal_as_known, handler_goal};
use apex_model::because::{Because, Cause, Evidence};
use apex_model::effect::{Decision, DecisionKind, Effect};
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::value::Value;

/// A longer goal is shown by its first words alone.
const GOAL_CHARACTERS_MAX: usize = 120;
/// Maximum number of failures from a task down to the first one.
const DEPTH_MAX: usize = 1_000;

/// Returns the words for an end of the application that `by` caused without a text: the procedure with the step, and what the step waited
/// for.
pub(super) fn of_end(cycle: &Cycle<'_>, by: TaskId) -> String {
    let parent = cycle.task(by).and_then(|task| task.parent);
    let actor = goal_text(cycle, parent.unwrap_or(by));
    let enabled = latest(cycle, by, |kind| matches!(kind, DecisionKind::Transition { to: TaskState::Enabled, .. }));
    let mut evidence = enabled.map(|decision| evidence_words(cycle, &decision.because)).unwrap_or_default();
    if evidence.is_empty() {
        // A step of a sequence begins at the end of the step before it.
        evidence.extend(parent.and_then(|parent| latest_end(cycle, parent)));
    }
    match evidence.as_slice() {
        [] => format!("{actor} ended the application"),
        facts => format!("{actor} ended the application: {}", facts.join(", ")),
    }
}

/// Returns the words for a failure of `id` that its `on-failure` handles: the reason is that of the first failure below.
pub(super) fn of_handled(cycle: &Cycle<'_>, id: TaskId, because: &Because) -> String {
    let mut first = because;
    for _ in 0..DEPTH_MAX {
        let Cause::ChildFailed { child } = first.cause else { break };
        let Some(below) = latest(cycle, child, is_failure) else { break };
        first = &below.because;
    }
    let reason = words(cycle, first);
    let handler = shown(&handler_goal(cycle, id));
    format!("{} failed: {reason}; {handler} handles it", goal_text(cycle, id))
}

/// Returns the cause and its evidence as text without numbers of commands and requests.
fn words(cycle: &Cycle<'_>, because: &Because) -> String {
    let told = match &because.cause {
        Cause::CommandFailed { reason, .. } => format!("its command failed: {reason}"),
        Cause::CommandTimedOut { patience, .. } => format!("its command was not answered within {patience}"),
        Cause::SolverFailed { reason, .. } => format!("there is no plan: {reason}"),
        Cause::SolverTimedOut { patience, .. } => format!("the solver did not answer within {patience}"),
        _ => return because.text_at(&|place| cycle.agent.describe_place(place)),
    };
    match because.place {
        Some(place) => format!("{told}; from {}", cycle.agent.describe_place(place)),
        None => told,
    }
}

fn is_failure(kind: &DecisionKind) -> bool {
    let DecisionKind::Transition { to: TaskState::Terminated, outcome, .. } = kind else { return false };
    outcome.as_ref().is_some_and(Outcome::is_failure)
}

/// Returns the latest decision of the step on the task that `is_wanted` accepts.
fn latest<'c>(cycle: &'c Cycle<'_>, id: TaskId, is_wanted: impl Fn(&DecisionKind) -> bool) -> Option<&'c Decision> {
    cycle.effects.iter().rev().find_map(|effect| match effect {
        Effect::Decided(decision) if decision.task == Some(id) && is_wanted(&decision.kind) => Some(decision),
        _ => None,
    })
}

/// Returns the evidence as text; ended tasks are named by their goals.
fn evidence_words(cycle: &Cycle<'_>, because: &Because) -> Vec<String> {
    let words = |evidence: &Evidence| match evidence {
        Evidence::TaskEnd { task, .. } => Some(match cycle.task(*task) {
            Some(task) => ended(cycle, task.id, task.outcome.as_ref()),
            None => "the step before it has ended".to_string(),
        }),
        Evidence::TaskState { .. } => None,
        other => Some(other.text()),
    };
    because.evidence.iter().filter_map(words).collect()
}

/// Returns words for the latest end of a subtask of `parent` in this step.
fn latest_end(cycle: &Cycle<'_>, parent: TaskId) -> Option<String> {
    cycle.effects.iter().rev().find_map(|effect| {
        let Effect::Decided(Decision { task: Some(id), kind, .. }) = effect else { return None };
        let DecisionKind::Transition { to: TaskState::Terminated, outcome, .. } = kind else { return None };
        let task = cycle.task(*id).filter(|task| task.parent == Some(parent))?;
        Some(ended(cycle, task.id, outcome.as_ref()))
    })
}

fn ended(cycle: &Cycle<'_>, id: TaskId, outcome: Option<&Outcome>) -> String {
    let goal = goal_text(cycle, id);
    match outcome {
        Some(Outcome::Success(_)) => format!("{goal} is done"),
        None => format!("{goal} has ended"),
        Some(outcome) if outcome.is_failure() => format!("{goal} failed"),
        Some(outcome) => format!("{goal} has ended ({})", outcome.word()),
    }
}

fn goal_text(cycle: &Cycle<'_>, id: TaskId) -> String {
    shown(&goal_as_known(cycle, id))
}

/// Returns a goal as text; of a long one the words before its first list.
fn shown(goal: &Value) -> String {
    let whole = goal.to_string();
    if whole.chars().count() <= GOAL_CHARACTERS_MAX {
        return whole;
    }
    let words = goal.as_list().unwrap_or_default().iter().take_while(|item| item.as_symbol().is_some());
    let words: Vec<String> = words.map(ToString::to_string).collect();
    format!("({} ..)", words.join(" "))
}
