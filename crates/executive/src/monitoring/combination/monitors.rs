//! Monitors (M&I)
//! What: makes the monitor of a condition, feeds it and asks it: for its verdict, its next wake, what does not hold.
//! Runs: when a clause begins to be watched, in the notice phase, and when a monitor is judged.
//! Reads: Condition, surroundings.
//! Writes: Monitor.
//! Bound: as the services of its parts; linear in the condition.
//! PDL: all conditions.
//! Paper: section IV, creating monitors from PDL specifications.

use crate::expression::{EvaluationError, Surroundings};
use crate::monitoring::asking::Asking;
use crate::monitoring::combination::dispatch::{advance, notice_part, wake_of};
use crate::monitoring::combination::{creation, logic, unmet as unmet_parts};
use crate::monitoring::part::{Troubles, Truth};
use crate::monitoring::stimulus::Stimulus;
use crate::monitoring::wake::WakeReason;
use crate::state::monitors::monitor::{Keep, Monitor, Satisfaction, Trouble, Unmet, Verdict, Window};
use apex_model::condition::Condition;
use apex_model::time::Time;

/// Makes the monitor of `condition` and looks back over what is remembered since the window's start. That a task has
/// ended, or the state in which it is, counts also where it did so before.
///
/// # Errors
/// When an expression that must be known now (a duration, a gap) cannot be evaluated.
pub(crate) fn create(
    condition: &Condition,
    window: Window,
    surroundings: &dyn Surroundings,
) -> Result<Monitor, EvaluationError> {
    made(condition, window, (Keep::First, true), surroundings)
}

/// As [`create`], for a monitor of which only changes of tasks' states count from now on, not those that stand.
///
/// # Errors
/// As [`create`].
pub(crate) fn create_for_changes(
    condition: &Condition,
    window: Window,
    surroundings: &dyn Surroundings,
) -> Result<Monitor, EvaluationError> {
    made(condition, window, (Keep::First, false), surroundings)
}

/// As [`create`], for a monitor that remembers what `keep` says until it is harvested.
///
/// # Errors
/// As [`create`].
pub(crate) fn create_keeping(
    condition: &Condition,
    window: Window,
    keep: Keep,
    surroundings: &dyn Surroundings,
) -> Result<Monitor, EvaluationError> {
    made(condition, window, (keep, true), surroundings)
}

fn made(
    condition: &Condition,
    window: Window,
    manner: (Keep, bool),
    surroundings: &dyn Surroundings,
) -> Result<Monitor, EvaluationError> {
    let mut root = creation::tree(condition, window, manner, surroundings)?;
    let mut troubles = Troubles::default();
    creation::look_back(&mut root, surroundings, &mut troubles);
    let mut monitor =
        Monitor { created_at: surroundings.now(), window, root, asked_at: surroundings.now(), notes: None };
    troubles.tell(&mut monitor);
    Ok(monitor)
}

/// Tells `monitor` what happened. Stimuli it has no interest in change nothing.
pub(crate) fn notice(monitor: &mut Monitor, stimulus: &Stimulus, surroundings: &dyn Surroundings) {
    let mut troubles = Troubles::default();
    notice_part(&mut monitor.root, stimulus, surroundings, &mut troubles);
    troubles.tell(monitor);
}

/// Finds out again which tasks the monitor is about: a tag stands for another one now.
pub(crate) fn look_for_tasks(monitor: &mut Monitor, surroundings: &dyn Surroundings) {
    let mut troubles = Troubles::default();
    advance(&mut monitor.root, surroundings, &mut troubles);
    troubles.tell(monitor);
}

/// Is the condition true at `surroundings.now()`? Asked after all stimuli of the instant were noticed.
pub(crate) fn verdict(monitor: &mut Monitor, surroundings: &dyn Surroundings) -> Verdict {
    let mut asking = Asking::new(surroundings);
    advance(&mut monitor.root, surroundings, &mut asking.troubles);
    let truth = logic::truth(&monitor.root, &mut asking);
    let best = match truth {
        Truth::True => logic::first_result(&monitor.root, &mut asking),
        Truth::False | Truth::Unknown => None,
    };
    monitor.asked_at = asking.now;
    if asking.wake.is_some() || monitor.notes.is_some() {
        monitor.notes.get_or_insert_default().delay_over_at = asking.wake;
    }
    let created_at = monitor.created_at;
    asking.troubles.tell(monitor);
    match (best, truth) {
        (Some(best), _) => {
            Verdict::Satisfied(Satisfaction { recognised_at: best.recognised_at.max(created_at), ..best })
        }
        (None, Truth::Unknown) => Verdict::Unknown,
        (None, Truth::True | Truth::False) => Verdict::NotSatisfied,
    }
}

/// When the verdict can change by time alone, strictly after the last `verdict`, and why.
pub(crate) fn next_wake(monitor: &Monitor) -> Option<(Time, WakeReason)> {
    let after = monitor.asked_at;
    let delay = monitor.notes.as_ref().and_then(|notes| notes.delay_over_at).filter(|at| *at > after);
    wake_of(&monitor.root, after).into_iter().chain(delay.map(|at| (at, WakeReason::Foreseen))).min()
}

/// The parts that do not hold, with what is known about each.
pub(crate) fn unmet(monitor: &Monitor, surroundings: &dyn Surroundings) -> Vec<Unmet> {
    let mut asking = Asking::new(surroundings);
    let mut list = Vec::new();
    unmet_parts::collect(&monitor.root, &mut asking, &mut list);
    list
}

/// Errors met while judging since the last call: to be reported as trouble.
pub(crate) fn take_troubles(monitor: &mut Monitor) -> Vec<Trouble> {
    monitor.notes.as_mut().map(|notes| std::mem::take(&mut notes.troubles)).unwrap_or_default()
}
