//! Monitors (M&I)
//! What: makes the monitor of a condition, passes it stimuli, and returns its verdict, its next wake and its unmet parts.
//! Runs: when a clause begins to be watched, in the notice phase, and when a monitor is judged.
//! Reads: Condition, evaluation context.
//! Writes: Monitor.
//! Bound: as the services of its parts; linear in the condition.
//! PDL: all conditions.
//! Paper: section IV, creating monitors from PDL specifications.

use crate::expression::{EvalContext, EvaluationError};
use crate::monitoring::basic::event;
use crate::monitoring::combination::condition_tree;
use crate::monitoring::combination::dispatch::{advance, notice_part, wake_of};
use crate::monitoring::combination::{conjunction_firsts, creation, logic, unmet as unmet_parts};
use crate::monitoring::part::{ConditionFaults, Truth, site};
use crate::monitoring::stimulus::Stimulus;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::monitoring::wake::WakeReason;
use crate::state::histories::history::Occurrence;
use crate::state::monitors::monitor::{
    ConditionFault, Keep, Monitor, Part, PartKind, Satisfaction, Unmet, Verdict, Window,
};
use apex_model::condition::Condition;
use apex_model::time::Time;

/// Makes the monitor of `condition` and looks back over the remembered data since the window's start. An earlier end of a task and its
/// present state count too.
///
/// # Errors
/// When an expression that must be known now (a duration, a gap) cannot be evaluated.
pub(crate) fn create(
    condition: &Condition,
    window: Window,
    context: &dyn EvalContext,
) -> Result<Monitor, EvaluationError> {
    made(condition, window, (Keep::First, true), context)
}

/// Like [`create`], for a monitor that considers only future changes of tasks' states, and no present states.
///
/// # Errors
/// Like [`create`].
pub(crate) fn create_for_changes(
    condition: &Condition,
    window: Window,
    context: &dyn EvalContext,
) -> Result<Monitor, EvaluationError> {
    made(condition, window, (Keep::First, false), context)
}

/// Like [`create`], for a monitor that remembers the results that `keep` selects until they are collected.
///
/// # Errors
/// Like [`create`].
pub(crate) fn create_keeping(
    condition: &Condition,
    window: Window,
    keep: Keep,
    context: &dyn EvalContext,
) -> Result<Monitor, EvaluationError> {
    made(condition, window, (keep, true), context)
}

fn made(
    condition: &Condition,
    window: Window,
    manner: (Keep, bool),
    context: &dyn EvalContext,
) -> Result<Monitor, EvaluationError> {
    let mut root = creation::tree(condition, window, manner, context)?;
    let mut troubles = ConditionFaults::none(context);
    creation::backfill(&mut root, context, &mut troubles);
    let mut monitor = Monitor { created_at: context.now(), window, root, asked_at: context.now(), notes: None };
    troubles.tell(&mut monitor);
    Ok(monitor)
}

/// Passes a stimulus to `monitor`. A stimulus in which it has no interest changes nothing.
pub(crate) fn notice(monitor: &mut Monitor, stimulus: &Stimulus, context: &dyn EvalContext) {
    let mut troubles = ConditionFaults::none(context);
    notice_part(&mut monitor.root, stimulus, context, &mut troubles);
    troubles.tell(monitor);
}

/// Passes messages from before its window to `monitor`; the parts that it combines may answer them.
pub(crate) fn hear(monitor: &mut Monitor, heard: &[Occurrence], context: &dyn EvalContext) {
    let mut troubles = ConditionFaults::none(context);
    hear_part(&mut monitor.root, heard, context, &mut troubles);
    troubles.tell(monitor);
}

fn hear_part(part: &mut Part, heard: &[Occurrence], context: &dyn EvalContext, troubles: &mut ConditionFaults) {
    let site = site(part);
    match &mut part.kind {
        PartKind::Event(leaf) => event::hear(leaf, site, heard, context, troubles),
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => {
            composite.parts.iter_mut().for_each(|part| hear_part(part, heard, context, troubles));
        }
        _ => {}
    }
}

/// Determines again which tasks the monitor refers to, because a tag names another task now.
pub(crate) fn look_for_tasks(monitor: &mut Monitor, context: &dyn EvalContext) {
    let mut troubles = ConditionFaults::none(context);
    advance(&mut monitor.root, context, &mut troubles);
    troubles.tell(monitor);
}

/// Returns the verdict on the condition at `context.now()`, after all stimuli of the instant were processed.
pub(crate) fn verdict(monitor: &mut Monitor, context: &dyn EvalContext) -> Verdict {
    let mut query = VerdictQuery::new(context);
    advance(&mut monitor.root, context, &mut query.troubles);
    conjunction_firsts::sweep(&mut monitor.root, None, context);
    let truth = logic::truth(&monitor.root, &mut query);
    let best = match truth {
        Truth::True => logic::first_result(&monitor.root, &mut query),
        Truth::False | Truth::Unknown => None,
    };
    monitor.asked_at = query.now;
    if query.wake.is_some() || monitor.notes.is_some() {
        monitor.notes.get_or_insert_default().delay_over_at = query.wake;
    }
    let created_at = monitor.created_at;
    query.troubles.tell(monitor);
    match (best, truth) {
        (Some(best), _) => {
            Verdict::Satisfied(Satisfaction { recognised_at: best.recognised_at.max(created_at), ..best })
        }
        (None, Truth::Unknown) => Verdict::Unknown,
        (None, Truth::True | Truth::False) => Verdict::NotSatisfied,
    }
}

/// Returns the first instant after the last `verdict` at which time alone can change the verdict, with the reason.
pub(crate) fn next_wake(monitor: &Monitor) -> Option<(Time, WakeReason)> {
    let after = monitor.asked_at;
    let delay = monitor.notes.as_ref().and_then(|notes| notes.delay_over_at).filter(|at| *at > after);
    wake_of(&monitor.root, after).into_iter().chain(delay.map(|at| (at, WakeReason::Foreseen))).min()
}

/// Returns the parts that do not hold, with the present state of each.
pub(crate) fn unmet(monitor: &Monitor, context: &dyn EvalContext) -> Vec<Unmet> {
    let mut query = VerdictQuery::new(context);
    let mut list = Vec::new();
    unmet_parts::collect(&monitor.root, &mut query, &mut list);
    list
}

/// Returns the whole condition as a tree, with the present state of each part.
pub(crate) fn condition_tree(monitor: &Monitor, context: &dyn EvalContext) -> condition_tree::ConditionNode {
    condition_tree::tree(&monitor.root, &mut VerdictQuery::new(context))
}

/// Takes the errors that occurred in verdicts since the last call; the caller reports them as faults.
pub(crate) fn take_troubles(monitor: &mut Monitor) -> Vec<ConditionFault> {
    monitor.notes.as_mut().map(|notes| std::mem::take(&mut notes.troubles)).unwrap_or_default()
}
