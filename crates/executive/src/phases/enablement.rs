//! Task enablement (TC)
//! What: acts on clauses that became true, and enables pending tasks without remaining preconditions.
//! Runs: enable phase.  Reads: firings, Task.  Writes: Task bindings and state, Decision.
//! Bound: O(firings + ready tasks) per round.  PDL: `waitfor`, section 9.  Paper: section III, task enablement.

use crate::control::cycle::{Cycle, Firing, in_order};
use crate::control::tasks::{
    binding, execution_conditions, instantiation, interruption, monitoring_clauses, repetition, restart, termination,
};
use crate::control::transition::{Trigger, transition};
use crate::planted;
use crate::planted::Bug;
use crate::state::clause::Clause;
use crate::state::controller::Controller;
use crate::state::monitors::monitor::Satisfaction;
use crate::state::task::Origin;
use apex_model::because::{Because, Cause};
use apex_model::effect::DecisionKind;
use apex_model::evidence_list::EvidenceList;
use apex_model::procedure::ProcedureKind;
use apex_model::source::Place;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::value::Value;

/// Returns the rank of a clause. Ends come first, so that no task is started only to be cut: exits, skips, ends; then restarts,
/// suspensions and enablements.
fn order(clause: Clause) -> u8 {
    match clause {
        Clause::ExitWhen => 0,
        Clause::SkipWhen => 1,
        Clause::EndWhen => 2,
        Clause::RestartWhen => 3,
        Clause::SuspendWhen => 4,
        Clause::SuspendUntil => 5,
        Clause::ResumeWhen => 6,
        Clause::Waitfor => 7,
    }
}

/// Executes the enable phase.
pub(crate) fn enable(cycle: &mut Cycle<'_>) {
    execution_conditions::judge_invariants(cycle);
    fire_all(cycle);
    cycle.work.evidence.sort_by_key(|(task, _)| *task);
    for id in in_order(&mut cycle.work.ready) {
        let free = cycle.task(id).is_some_and(|task| task.state == TaskState::Pending && task.held_back.is_free());
        if free {
            enable_task(cycle, id);
            termination::settle(cycle);
        }
    }
    cycle.work.evidence.clear();
    if !cycle.work.freed.is_empty() {
        cycle.work.freed.clear();
    }
    // A task whose suspension became true while it was pending does not begin.
    fire_all(cycle);
}

fn fire_all(cycle: &mut Cycle<'_>) {
    if cycle.work.firings.is_empty() {
        return;
    }
    let mut firings = std::mem::take(&mut cycle.work.firings);
    firings.sort_by_key(|firing| (order(firing.clause), firing.task, firing.monitor));
    for firing in firings {
        if cycle.agent.watches.contains(firing.monitor.0) {
            fire(cycle, firing);
            termination::settle(cycle);
        }
    }
}

fn fire(cycle: &mut Cycle<'_>, firing: Firing) {
    if !monitoring_clauses::still_holds(cycle, &firing) {
        return;
    }
    let Firing { task: id, clause, level, monitor, satisfaction, answered, place } = firing;
    let Some(task) = cycle.task(id) else { return };
    let watched_from = cycle.agent.watches.get(monitor.0).map(|watch| watch.monitor.window.start);
    let state = task.state;
    if !cycle.agent.listening.is_empty() {
        repetition::answer(cycle, id, &satisfaction.evidence);
    }
    if clause == Clause::Waitfor && repetition::is_known(cycle, id, &satisfaction.bindings) {
        repetition::wait_for_new(cycle, id, answered);
        return;
    }
    if let Some(task) = cycle.agent.task_mut(id) {
        task.after_sequence = task.after_sequence.max(answered);
    }
    let cause = Cause::ConditionSatisfied { clause: clause.word().into() };
    let kind = DecisionKind::Satisfied { clause: clause.word().into(), interval: satisfaction.interval };
    let evidence = satisfaction.evidence.clone();
    cycle.decide(Some(id), kind, Because { cause: cause.clone(), place: Some(place), evidence });
    monitoring_clauses::unwatch(cycle, id, |each, at| each == clause && at == level);
    if clause == Clause::Waitfor {
        repetition::listen(cycle, id, &satisfaction.evidence);
        return preconditions_hold(cycle, id, satisfaction, place);
    }
    // A fact may have held before the clause was watched.
    let end = satisfaction.interval.1.max(watched_from.unwrap_or(satisfaction.interval.1));
    let after = interruption::window_after(cycle, end, answered);
    let because = Because { cause, place: Some(place), evidence: satisfaction.evidence };
    match clause {
        Clause::Waitfor => {}
        Clause::EndWhen if state == TaskState::Interrupted && planted::is(Bug::DeafWhileInterrupted) => {}
        Clause::EndWhen => {
            repetition::forbid(cycle, id, level);
            termination::end(cycle, id, Outcome::Success(Value::nil()), because);
        }
        Clause::SkipWhen => match state {
            TaskState::Pending | TaskState::Enabled => termination::end(cycle, id, Outcome::Skipped, because),
            TaskState::Ongoing | TaskState::Interrupted | TaskState::Terminated => {}
        },
        Clause::ExitWhen => {
            let begun = matches!(state, TaskState::Ongoing | TaskState::Interrupted);
            termination::end(cycle, id, if begun { Outcome::Exited } else { Outcome::Skipped }, because);
        }
        Clause::RestartWhen => match state {
            TaskState::Ongoing | TaskState::Interrupted => restart::restart(cycle, id, because),
            TaskState::Pending | TaskState::Enabled | TaskState::Terminated => {}
        },
        Clause::SuspendWhen => {
            // Events that the suspension itself causes may end it.
            interruption::watch_resumption(cycle, id, level, after);
            interruption::suspend(cycle, id, because);
        }
        Clause::SuspendUntil | Clause::ResumeWhen => {
            interruption::resume(cycle, id, &because);
            interruption::watch_suspension(cycle, id, after);
        }
    }
}

/// Handles a `waitfor` that became true: the task gets its bindings.
fn preconditions_hold(cycle: &mut Cycle<'_>, id: TaskId, satisfaction: Satisfaction, place: Place) {
    for (name, value) in satisfaction.bindings.iter() {
        let evidence = satisfaction.evidence.clone();
        binding::bind_locally(cycle, id, (name, value.clone()), "waitfor", place, evidence);
    }
    cycle.work.evidence.push((id, satisfaction.evidence));
    if let Some(task) = cycle.agent.task_mut(id) {
        task.held_back.by_condition = false;
    }
    instantiation::offer(cycle, id);
}

/// Returns the last cause that freed the pending task: the reason for its enablement now and not before.
fn freed(cycle: &mut Cycle<'_>, id: TaskId) -> Because {
    let place = cycle.place_of(id);
    if let Some(evidence) = evidence_of(cycle, id) {
        return Because { cause: Cause::PreconditionsSatisfied, place, evidence };
    }
    let cause = cycle.work.freed.remove(&id).or_else(|| predecessor(cycle, id)).unwrap_or(Cause::NoPreconditions);
    Because::new(cause, place)
}

/// Returns the evidence that last satisfied the task's `waitfor`.
fn evidence_of(cycle: &Cycle<'_>, id: TaskId) -> Option<EvidenceList> {
    let list = &cycle.work.evidence;
    let after = list.partition_point(|(task, _)| *task <= id);
    list.get(after.checked_sub(1)?).filter(|(task, _)| *task == id).map(|(_, evidence)| evidence.clone())
}

/// Returns the last step before the task's in a sequence, apart from those that ended before their turn, if it has ended now.
fn predecessor(cycle: &Cycle<'_>, id: TaskId) -> Option<Cause> {
    let task = cycle.task(id)?;
    let Origin::Step(step) = task.origin else { return None };
    if task.extras.as_ref().is_some_and(|extras| extras.ended_before.is_some()) {
        return None;
    }
    if cycle.agent.procedure(step.procedure)?.kind != ProcedureKind::Sequential {
        return None;
    }
    let Controller::Procedure(controller) = cycle.task(task.parent?)?.controller.as_deref()? else { return None };
    let before = controller.current.get(..step.step as usize)?.iter().rev();
    let mut tasks = before.map_while(|id| cycle.task((*id)?));
    let last = tasks.find(|each| each.started_at.is_some() || each.since == cycle.now)?;
    let ended = last.is_terminated() && last.since == cycle.now;
    ended.then_some(Cause::PredecessorEnded { predecessor: last.id })
}

fn enable_task(cycle: &mut Cycle<'_>, id: TaskId) {
    let because = freed(cycle, id);
    transition(cycle, id, Trigger::Satisfied, None, because);
    repetition::respond(cycle, id);
    let bound = binding::select(cycle, id)
        .map_err(|(message, place)| Because::new(Cause::ExpressionFailed { message }, Some(place)));
    match bound.and_then(|()| interruption::watch_step_suspension(cycle, id)) {
        Ok(()) => cycle.work.enabled.push(id),
        Err(because) => termination::fail(cycle, id, because),
    }
}
