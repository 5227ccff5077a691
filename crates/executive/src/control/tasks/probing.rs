//! Probing (TC)
//! What: pursues the goals of `:probing` while their conditions are waited for: active sensing.
//! Runs: when a clause begins or ceases to be watched, when it was judged, and when nothing else is left to do at an instant.
//! Reads: Condition, Monitor.  Writes: Probing, Task, wakes, Decision.
//! Bound: O(1) per probe; at most one probe of a condition lives, and none begins twice at one instant.
//! PDL: `:probing`; decision 0028.  Paper: section IV, sources of information for monitors.

use crate::control::cycle::Cycle;
use crate::control::tasks::instantiation::{self, Seed};
use crate::control::tasks::{procedure, termination};
use crate::expression::arithmetic::duration;
use crate::expression::view::View;
use crate::expression::{EvaluationError, evaluate};
use crate::monitoring::combination::parts;
use crate::state::clause::{ClauseMonitor, Level, MonitorId};
use crate::state::controller::Controller;
use crate::state::probing::{Probing, ProbingId};
use crate::state::task::Origin;
use crate::state::wake::Wake;
use apex_model::because::{Because, Cause};
use apex_model::condition::{Condition, ConditionKind};
use apex_model::effect::DecisionKind;
use apex_model::expression::Expr;
use apex_model::probing::ProbingEnd;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Returns the probings of the condition, in written order.
///
/// # Errors
/// When an interval or a limit cannot be evaluated or is invalid.
pub(crate) fn of_condition(
    condition: &Condition,
    view: &View<'_>,
    waiting: TaskId,
    level: Level,
) -> Result<Vec<Probing>, EvaluationError> {
    let mut found = Vec::new();
    collect(condition, &mut |condition| {
        let ConditionKind::Probing { goal, interval, time_limit, count_limit, .. } = &condition.kind else {
            return Ok(());
        };
        found.push(Probing {
            waiting,
            level,
            place: condition.place,
            goal: goal.clone(),
            interval: span(interval, view)?,
            time_limit: time_limit.as_ref().map(|limit| span(limit, view)).transpose()?,
            count_limit: count_limit.as_ref().map(|limit| count(limit, view)).transpose()?,
            begun: 0,
            first_at: None,
            last_at: None,
            running: None,
            wake: None,
            end: None,
            forgotten: false,
        });
        Ok(())
    })?;
    Ok(found)
}

type Seen = Result<(), EvaluationError>;

fn collect(condition: &Condition, see: &mut dyn FnMut(&Condition) -> Seen) -> Seen {
    match &condition.kind {
        ConditionKind::Probing { condition: part, .. } => {
            see(condition)?;
            collect(part, see)
        }
        ConditionKind::And(parts, _) | ConditionKind::Or(parts, _) | ConditionKind::InOrder(parts, _) => {
            parts.iter().try_for_each(|part| collect(part, see))
        }
        ConditionKind::Allen { parts, .. } => parts.iter().try_for_each(|part| collect(part, see)),
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) => collect(part, see),
        ConditionKind::Measurement(_)
        | ConditionKind::Episode(_)
        | ConditionKind::Delay(..)
        | ConditionKind::Timestamp(..)
        | ConditionKind::Event { .. }
        | ConditionKind::TaskEnded(_)
        | ConditionKind::TaskState { .. }
        | ConditionKind::Function(_)
        | ConditionKind::Cyclic(_) => Ok(()),
    }
}

fn span(expr: &Expr, view: &View<'_>) -> Result<Duration, EvaluationError> {
    let value = evaluate(expr, view)?;
    let failed = |message: String| EvaluationError { message, place: expr.place };
    let span = duration(&value).map_err(failed)?;
    if span > Duration::ZERO {
        return Ok(span);
    }
    Err(failed(format!("`:probing` needs a duration greater than zero, found {value}; write a duration such as 10s")))
}

fn count(expr: &Expr, view: &View<'_>) -> Result<u64, EvaluationError> {
    let value = evaluate(expr, view)?;
    let count = match &value {
        Value::Integer(count) => u64::try_from(*count).ok().filter(|count| *count > 0),
        _ => None,
    };
    count.ok_or_else(|| EvaluationError {
        message: format!("`:count-limit` needs a whole number of probes, 1 or more, and got {value}"),
        place: expr.place,
    })
}

/// Begins the probing of a clause that is now watched: the first probes begin when no other work remains at this instant.
pub(crate) fn begin(cycle: &mut Cycle<'_>, monitor: MonitorId, probings: Vec<Probing>) {
    for (part, probing) in (0..).zip(probings) {
        let id = ProbingId { monitor, part };
        cycle.agent.probings.insert(id, probing);
        cycle.work.probings.push(id);
    }
}

fn ids(cycle: &Cycle<'_>, monitor: MonitorId) -> Vec<ProbingId> {
    match cycle.agent.probings.is_empty() {
        true => Vec::new(),
        false => cycle.agent.probings_of(monitor).map(|(id, _)| id).collect(),
    }
}

/// Stops the probes of conditions that hold after a judgement.
pub(crate) fn judged(cycle: &mut Cycle<'_>, monitor: MonitorId, watch: &ClauseMonitor, satisfied: bool) {
    for id in ids(cycle, monitor) {
        let Some(probing) = cycle.agent.probings.get(&id).filter(|probing| probing.end.is_none()) else { continue };
        let view = View { agent: cycle.agent, task: watch.task, level: watch.level, now: cycle.now };
        if satisfied || parts::holds(&watch.monitor, probing.place, &view) {
            end(cycle, id, ProbingEnd::Satisfied);
        }
    }
}

/// Ends the probes of a clause that is no longer watched.
pub(crate) fn not_awaited(cycle: &mut Cycle<'_>, monitor: MonitorId) {
    for id in ids(cycle, monitor) {
        end(cycle, id, ProbingEnd::NotAwaited);
        let Some(probing) = cycle.agent.probings.get_mut(&id) else { continue };
        probing.forgotten = true;
        if probing.running.is_none() {
            cycle.agent.probings.remove(&id);
        }
    }
}

/// Handles a probe that is due, or the end of the time for probing.
pub(crate) fn woken(cycle: &mut Cycle<'_>, monitor: MonitorId) {
    for id in ids(cycle, monitor) {
        let now = cycle.now;
        let Some(probing) = cycle.agent.probings.get_mut(&id) else { continue };
        if probing.wake.is_some_and(|wake| wake.at <= now) {
            probing.wake = None;
            cycle.work.probings.push(id);
        }
    }
}

/// Ends probing: no further probe begins, and a running probe is cut unless it ends before the instant is over.
fn end(cycle: &mut Cycle<'_>, id: ProbingId, reason: ProbingEnd) {
    let Some(probing) = cycle.agent.probings.get_mut(&id) else { return };
    probing.end.get_or_insert(reason);
    if let Some(wake) = probing.wake.take() {
        cycle.agent.wakes.cancel(wake);
    }
    cycle.work.probings.push(id);
}

/// Stops probing because a limit is reached, and reports that. The waiting task continues to wait.
fn stop(cycle: &mut Cycle<'_>, id: ProbingId, reason: ProbingEnd) {
    end(cycle, id, reason);
    let Some(probing) = cycle.agent.probings.get(&id) else { return };
    let (waiting, place) = (probing.waiting, Some(probing.place));
    let because = Because::new(Cause::ProbingStopped { waiting, probes: probing.begun, reason }, place);
    let message = because.cause.text();
    cycle.decide(Some(waiting), DecisionKind::Trouble { message }, because);
}

/// Handles the end of a probe: the probe is removed, because no clause can refer to it any longer, and the next probe may begin.
pub(crate) fn ended(cycle: &mut Cycle<'_>, id: ProbingId, host: TaskId, probe: TaskId) {
    procedure::disown(cycle, host, probe);
    cycle.agent.tasks.remove(probe.0);
    let Some(probing) = cycle.agent.probings.get_mut(&id) else { return };
    probing.running = probing.running.filter(|running| *running != probe);
    if probing.forgotten && probing.running.is_none() {
        cycle.agent.probings.remove(&id);
    } else if probing.end.is_none() {
        cycle.work.probings.push(id);
    }
}

/// Begins and ends probes when no other work remains at this instant. Measurements of a probe that ended are then noticed before the next
/// one begins, and a probe that is about to end is not cut.
pub(crate) fn pursue(cycle: &mut Cycle<'_>) {
    if cycle.work.probings.is_empty() || !cycle.work.has_only_probings() {
        return;
    }
    let mut list = std::mem::take(&mut cycle.work.probings);
    list.sort_unstable();
    list.dedup();
    for id in list {
        look(cycle, id);
        termination::settle(cycle);
    }
}

fn look(cycle: &mut Cycle<'_>, id: ProbingId) {
    let now = cycle.now;
    let Some(probing) = cycle.agent.probings.get(&id) else { return };
    if let Some(reason) = probing.end {
        return cut(cycle, id, reason);
    }
    if let Some(limit) = probing.time_limit.filter(|_| probing.deadline().is_some_and(|at| at <= now)) {
        return stop(cycle, id, ProbingEnd::TimeLimit(limit));
    }
    if probing.running.is_some() {
        return;
    }
    if let Some(limit) = probing.count_limit.filter(|limit| probing.begun >= *limit) {
        return stop(cycle, id, ProbingEnd::CountLimit(limit));
    }
    if probing.next_at(now) <= now {
        probe(cycle, id);
    }
    schedule(cycle, id);
}

/// Ends a running probe and removes ended ones, because no clause can refer to them any longer.
fn cut(cycle: &mut Cycle<'_>, id: ProbingId, reason: ProbingEnd) {
    let Some(probing) = cycle.agent.probings.get(&id) else { return };
    let cause = Cause::ProbingStopped { waiting: probing.waiting, probes: probing.begun, reason };
    let because = Because::new(cause, Some(probing.place));
    let forgotten = probing.forgotten;
    if let Some(running) = probing.running {
        termination::end(cycle, running, Outcome::Cut, because);
        termination::settle(cycle);
    }
    if forgotten {
        cycle.agent.probings.remove(&id);
    }
}

/// Returns the task whose procedure contains the clause: the probes are its children.
fn host(cycle: &Cycle<'_>, probing: &Probing) -> Option<TaskId> {
    let host = match probing.level {
        Level::Step => cycle.task(probing.waiting)?.parent?,
        Level::Procedure => probing.waiting,
    };
    let task = cycle.task(host).filter(|task| task.state != TaskState::Terminated)?;
    matches!(task.controller.as_deref(), Some(Controller::Procedure(_))).then_some(host)
}

/// Begins a probe.
fn probe(cycle: &mut Cycle<'_>, id: ProbingId) {
    let now = cycle.now;
    let Some(probing) = cycle.agent.probings.get(&id) else { return };
    let Some(host) = host(cycle, probing) else { return };
    let (waiting, place, level) = (probing.waiting, probing.place, probing.level);
    // Variables that the waiting task itself has bound may occur in the goal, as in its other clauses.
    let own = cycle.task(waiting).filter(|_| level == Level::Step).map(|task| task.bindings.clone());
    let seed = Seed {
        parent: Some(host),
        origin: Origin::Probe(id),
        bindings: own.unwrap_or_default(),
        by_predecessor: false,
        after_sequence: None,
        cause: Cause::Probes { waiting, number: probing.begun + 1, limit: probing.count_limit },
    };
    let created = instantiation::create(cycle, seed);
    let Some(probing) = cycle.agent.probings.get_mut(&id) else { return };
    // Also set if the limits admit no probe now: the next attempt follows after the interval.
    probing.last_at = Some(now);
    probing.first_at.get_or_insert(now);
    match created {
        Ok(probe) => {
            probing.begun += 1;
            probing.running = Some(probe);
            procedure::adopt(cycle, host, probe, false);
            instantiation::arm(cycle, probe);
        }
        Err(cause) => cycle.trouble_of(Some(waiting), cause, Some(place)),
    }
}

/// Schedules the wake for the next probe or for the end of the time limit, whichever comes first.
fn schedule(cycle: &mut Cycle<'_>, id: ProbingId) {
    let now = cycle.now;
    let Some(probing) = cycle.agent.probings.get_mut(&id).filter(|probing| probing.end.is_none()) else { return };
    let next = Some(probing.next_at(now)).filter(|at| probing.running.is_none() && *at > now);
    let at: Option<Time> = [next, probing.deadline()].into_iter().flatten().min();
    if probing.wake.map(|wake| wake.at) == at {
        return;
    }
    if let Some(wake) = probing.wake.take() {
        cycle.agent.wakes.cancel(wake);
    }
    probing.wake = at.map(|at| cycle.agent.wakes.schedule(at, Wake::Probing(id.monitor)));
}
