//! Repetition (TC)
//! What: makes an ended task pending again (`repeating`), and puts a fresh instance next to an enabled one (`responding`).
//! Runs: when a task ends, and when one is enabled.  Reads: Repetition clauses.  Writes: Task, wakes, monitors.
//! Bound: O(1) per instance; at most `REPETITIONS_PER_INSTANT_MAX` instances at one instant.
//! PDL: `repeating`, `responding`.  Paper: section IV, example 1.

use crate::control::cycle::Cycle;
use crate::control::tasks::instantiation::{self, Seed};
use crate::control::tasks::{binding, monitoring_clauses, procedure, termination};
use crate::control::transition::{Trigger, transition};
use crate::expression::evaluate;
use crate::monitoring::basic::event;
use crate::monitoring::combination::monitors;
use crate::monitoring::stimulus::Stimulus;
use crate::state::bindings::Bindings;
use crate::state::clause::{Clause, Level, MonitorId};
use crate::state::monitors::monitor::Window;
use crate::state::step_clauses::StepClauses;
use crate::state::task::Origin;
use crate::state::wake::Wake;
use apex_model::agent_limits::Limit;
use apex_model::because::{Because, Cause, Evidence};
use apex_model::evidence_list::EvidenceList;
use apex_model::expression::Expr;
use apex_model::procedure::Repetition;
use apex_model::task::{Outcome, TaskId};
use apex_model::time::Duration;
use apex_model::value::Value;

/// The span within which instants with repetitions are counted.
const SECOND: Duration = Duration(1_000_000_000);

/// Counts the instances of a task that begin at one instant, and the instants within a second at which instances begin.
///
/// # Errors
/// The cause if there are too many: the step is a loop that takes almost no time.
pub(crate) fn count_instance(cycle: &mut Cycle<'_>, id: TaskId) -> Result<(), Cause> {
    let (now, outside) = (cycle.now, cycle.agent.next.outside);
    let Some(task) = cycle.agent.task_mut(id) else { return Ok(()) };
    let extras = task.extras_mut();
    let first = extras.instances == 0 || extras.instant != now;
    if first {
        if extras.outside != outside || now - extras.counted_since >= SECOND {
            (extras.counted_since, extras.instants) = (now, 0);
        }
        extras.instants = extras.instants.saturating_add(1);
        extras.outside = outside;
    }
    extras.instances = if first { 1 } else { extras.instances.saturating_add(1) };
    extras.instant = now;
    let (instances, instants) = (u64::from(extras.instances), u64::from(extras.instants));
    let limits = &cycle.agent.limits;
    // A step that answers messages from outside begins an instance for each of them: a burst of messages is not a loop.
    if instances > limits.of(Limit::RepetitionsPerInstant).saturating_mul(cycle.agent.outside_messages_at(now)) {
        return Err(limits.reached(Limit::RepetitionsPerInstant));
    }
    if instants > limits.of(Limit::RepetitionsPerSecond) {
        return Err(limits.reached(Limit::RepetitionsPerSecond));
    }
    Ok(())
}

/// Prevents further repetitions of the task if a clause or an activity at the level of the step ends it, not only this instance.
pub(crate) fn forbid(cycle: &mut Cycle<'_>, id: TaskId, level: Level) {
    if level == Level::Step
        && let Some(task) = cycle.agent.task_mut(id)
    {
        task.extras_mut().repeats_no_more = true;
    }
}

fn condition(cycle: &Cycle<'_>, id: TaskId, expr: Option<&Expr>, default: bool) -> Result<bool, Because> {
    let Some(expr) = expr else { return Ok(default) };
    match evaluate(expr, &cycle.view(id, Level::Step)) {
        Ok(value) => Ok(value.is_true()),
        Err(error) => Err(Because::new(Cause::ExpressionFailed { message: error.message }, Some(error.place))),
    }
}

/// Returns true if `:while` and `:until` allow another instance.
fn is_allowed(cycle: &Cycle<'_>, id: TaskId, clause: &Repetition) -> Result<bool, Because> {
    Ok(condition(cycle, id, clause.while_true.as_ref(), true)? && !condition(cycle, id, clause.until.as_ref(), false)?)
}

/// Handles the final end of a step that could have been repeated: conditions that wait for its end are notified.
pub(crate) fn ended_for_good(cycle: &mut Cycle<'_>, id: TaskId, outcome: &Outcome) {
    if matches!(outcome, Outcome::Success(_)) && cycle.may_repeat(id) && !cycle.agent.interests.ignore_task(id) {
        let before = MonitorId(cycle.agent.next.monitor);
        cycle.work.stimuli.push(Stimulus::TaskEnded { task: id, outcome: outcome.states(), at: cycle.now, before });
    }
}

/// Makes the ended task pending again if its step repeats. Returns false if the task has ended finally.
pub(crate) fn repeat(cycle: &mut Cycle<'_>, id: TaskId, outcome: &Outcome) -> bool {
    let Some(task) = cycle.task(id) else { return false };
    if !task.clauses.has(StepClauses::REPETITION) {
        return false;
    }
    let over = task.extras.as_ref().is_some_and(|extras| extras.repeats_no_more);
    if over || !matches!(task.origin, Origin::Step(_)) || !matches!(outcome, Outcome::Success(_)) {
        return false;
    }
    let Some(handle) = cycle.step_of(id) else { return false };
    let Some(clause) = handle.get().and_then(|step| step.repeating.as_ref()) else { return false };
    let again = match again(cycle, id, clause) {
        Ok(Some(again)) => again,
        Ok(None) => return false,
        Err(because) => {
            fail_parent(cycle, id, because);
            return true;
        }
    };
    if let Err(cause) = count_instance(cycle, id) {
        let place = cycle.place_of(id);
        fail_parent(cycle, id, Because::new(cause, place));
        return true;
    }
    begin(cycle, id, &again);
    true
}

/// Beginning of a repetition.
struct Again {
    /// True if the new instance does not wait for its conditions.
    skip: bool,
    /// Minimum time from the start of one instance to the start of the next.
    interval: Option<Duration>,
}

/// Returns how the ended task begins again; `None` if it does not.
///
/// # Errors
/// The cause when an option of the clause cannot be evaluated.
fn again(cycle: &Cycle<'_>, id: TaskId, clause: &Repetition) -> Result<Option<Again>, Because> {
    if !is_allowed(cycle, id, clause)? {
        return Ok(None);
    }
    let skip = clause.enabled.is_some() && condition(cycle, id, clause.enabled.as_ref(), false)?;
    let interval = clause.minimum_interval.as_ref().map(|expr| span(cycle, id, expr)).transpose()?;
    // Priorities evaluate the recovery later; it is evaluated here to find errors.
    clause.recovery.as_ref().map(|expr| span(cycle, id, expr)).transpose()?;
    Ok(Some(Again { skip, interval }))
}

fn report(cycle: &mut Cycle<'_>, id: TaskId, because: Because) {
    let message = because.cause.text();
    cycle.decide(Some(id), apex_model::effect::DecisionKind::Trouble { message }, because);
}

/// Fails the procedure of a repetition if its condition cannot be evaluated or its loop takes no time.
fn fail_parent(cycle: &mut Cycle<'_>, id: TaskId, because: Because) {
    report(cycle, id, because.clone());
    if let Some(parent) = cycle.task(id).and_then(|task| task.parent) {
        termination::fail(cycle, parent, because);
    }
}

fn begin(cycle: &mut Cycle<'_>, id: TaskId, again: &Again) {
    let now = cycle.now;
    let started = cycle.task(id).and_then(|task| task.started_at);
    let &Again { skip, interval } = again;
    let because = Because::new(Cause::Repetition, cycle.place_of(id));
    transition(cycle, id, Trigger::Repeated, None, because);
    let Some(task) = cycle.agent.task_mut(id) else { return };
    task.created_at = now;
    if let Some(extras) = &mut task.extras {
        extras.first_created = None;
    }
    task.started_at = None;
    task.held_back = task.held_back.of_turn();
    if !skip {
        task.bindings = Bindings::new();
    }
    let extras = task.extras_mut();
    extras.ended_before = Some(now);
    extras.worked = Duration::ZERO;
    let next_start = interval.zip(started).map(|(interval, started)| started + interval);
    if let Some(at) = next_start.filter(|at| *at > now) {
        let wake = cycle.agent.wakes.schedule(at, Wake::MinimumInterval(id));
        if let Some(task) = cycle.agent.task_mut(id) {
            task.held_back.by_interval = true;
            task.extras_mut().wake = Some(wake);
        }
    }
    if skip {
        cycle.work.freed.insert(id, Cause::RepeatedEnabled);
        instantiation::offer(cycle, id);
    } else {
        instantiation::arm(cycle, id);
    }
}

fn span(cycle: &Cycle<'_>, id: TaskId, expr: &Expr) -> Result<Duration, Because> {
    let failed = |message: String, place| Because::new(Cause::ExpressionFailed { message }, Some(place));
    let value = evaluate(expr, &cycle.view(id, Level::Step)).map_err(|error| failed(error.message, error.place))?;
    let span = crate::expression::arithmetic::duration(&value)
        .map_err(|_| failed(format!("{value} is not a span of time; write a duration such as 10s"), expr.place))?;
    if span < Duration::ZERO {
        let message = format!("a span of {span} is negative; write zero or more, for example `(max 0s ..)`");
        return Err(failed(message, expr.place));
    }
    Ok(span)
}

/// Handles the end of the least interval between two instances.
pub(crate) fn interval_over(cycle: &mut Cycle<'_>, id: TaskId) {
    if let Some(task) = cycle.agent.task_mut(id) {
        task.held_back.by_interval = false;
        task.extras_mut().wake = None;
    }
    if cycle.task(id).is_some_and(|task| task.held_back.is_free()) {
        cycle.work.freed.insert(id, Cause::IntervalElapsed);
    }
    instantiation::offer(cycle, id);
}

/// Starts to keep messages for the `waitfor` of a repeating step that becomes busy; its next repetitions answer them.
pub(crate) fn listen(cycle: &mut Cycle<'_>, id: TaskId, evidence: &EvidenceList) {
    if !cycle.may_repeat(id) {
        return;
    }
    let Some(handle) = cycle.step_of(id) else { return };
    let Some(step) = handle.get().filter(|step| step.repeating.as_ref().is_some_and(|clause| !clause.drop_missed))
    else {
        return;
    };
    let mut patterns = Vec::new();
    step.waitfor.iter().for_each(|condition| event::patterns(condition, &mut patterns));
    if patterns.is_empty() {
        return;
    }
    let now = cycle.now;
    let message = |evidence: &Evidence| match evidence {
        Evidence::Event { at, sequence, .. } => Some((*at, *sequence)),
        _ => None,
    };
    let answered = evidence.iter().filter_map(message).max();
    let agent = &mut *cycle.agent;
    let after = agent.task(id).and_then(|task| task.after_sequence);
    let interests = patterns.into_iter().map(event::interest);
    let of_now = agent.histories.events_from(now).filter(|message| after.is_none_or(|after| message.sequence > after));
    agent.listening.begin(id, interests, answered, of_now);
}

/// Marks the evidence of a clause as answered, also for the ancestors of the task: a message that ended one instance does not begin the
/// next.
pub(crate) fn answer(cycle: &mut Cycle<'_>, id: TaskId, evidence: &EvidenceList) {
    let agent = &mut *cycle.agent;
    let mut next = Some(id);
    while let Some(task) = next.and_then(|each| agent.task(each)) {
        let each = task.id;
        next = task.parent;
        if !agent.listening.knows(each) {
            continue;
        }
        for evidence in evidence.iter() {
            if let Evidence::Event { sequence, .. } = evidence {
                agent.listening.answered(each, *sequence);
            }
        }
    }
}

/// Delivers the kept messages to the monitor of a `waitfor` that is watched again.
pub(crate) fn give_waiting_messages(cycle: &mut Cycle<'_>, id: TaskId, monitor: MonitorId) {
    if !cycle.agent.listening.knows(id) {
        return;
    }
    let heard = cycle.agent.listening.end(id);
    if heard.is_empty() {
        return;
    }
    let Some(mut watch) = cycle.agent.watches.lift(monitor.0) else { return };
    monitors::hear(&mut watch.monitor, &heard, &cycle.view(id, Level::Step));
    cycle.agent.watches.put(monitor.0, watch);
}

/// Returns the values of the `:for-new` variables, when the step has any.
fn combination(cycle: &Cycle<'_>, id: TaskId, bindings: &Bindings) -> Option<Vec<Value>> {
    if !cycle.has(id, StepClauses::REPETITION) {
        return None;
    }
    let handle = cycle.step_of(id)?;
    let step = handle.get()?;
    let clause = step.responding.as_ref().or(step.repeating.as_ref())?;
    if clause.for_new.is_empty() {
        return None;
    }
    let values = clause.for_new.iter().map(|name| bindings.get(name).cloned().unwrap_or_else(Value::nil));
    Some(values.collect())
}

/// Returns true if this combination of `:for-new` variables was answered before; otherwise records it as answered.
pub(crate) fn is_known(cycle: &mut Cycle<'_>, id: TaskId, bindings: &Bindings) -> bool {
    let Some(combination) = combination(cycle, id, bindings) else { return false };
    cycle.agent.task_mut(id).is_some_and(|task| !task.extras_mut().answered.insert(combination))
}

/// Continues to wait for a combination that was not answered before.
pub(crate) fn wait_for_new(cycle: &mut Cycle<'_>, id: TaskId, answered: Option<u64>) {
    let Some(task) = cycle.agent.task_mut(id) else { return };
    task.after_sequence = task.after_sequence.max(answered);
    let window = Window { start: cycle.now, after_sequence: task.after_sequence };
    monitoring_clauses::unwatch(cycle, id, |clause, _| clause == Clause::Waitfor);
    let Some(step) = cycle.task(id).and_then(|task| task.step()) else { return };
    let index = cycle.agent.procedure_index(step.procedure).cloned();
    let condition = index.and_then(|index| index.steps.get(step.step as usize)?.waitfor.clone());
    let Some(condition) = condition else { return };
    match monitoring_clauses::watch(cycle, id, Clause::Waitfor, Level::Step, &condition, window, true) {
        Ok(monitor) => give_waiting_messages(cycle, id, monitor),
        Err(error) => {
            let cause = Cause::ExpressionFailed { message: error.message };
            termination::fail(cycle, id, Because::new(cause, Some(error.place)));
        }
    }
}

/// Creates a fresh instance next to the task of a responding step that was enabled.
pub(crate) fn respond(cycle: &mut Cycle<'_>, id: TaskId) {
    let Some(task) = cycle.task(id).filter(|task| task.clauses.has(StepClauses::REPETITION)) else { return };
    let (Origin::Step(step), Some(parent), answered) = (task.origin, task.parent, task.after_sequence) else { return };
    let Some(handle) = cycle.step_of(id) else { return };
    let Some(clause) = handle.get().and_then(|step| step.responding.as_ref()) else { return };
    binding::set_current(cycle, parent, step, id);
    match is_allowed(cycle, id, clause) {
        Ok(true) => {}
        Ok(false) => return,
        Err(because) => return fail_parent(cycle, id, because),
    }
    if let Err(cause) = count_instance(cycle, id) {
        let place = cycle.place_of(id);
        return fail_parent(cycle, id, Because::new(cause, place));
    }
    let seed = Seed {
        parent: Some(parent),
        origin: Origin::Step(step),
        bindings: Bindings::new(),
        by_predecessor: false,
        after_sequence: answered,
        cause: Cause::Responding { answered: id },
    };
    let fresh = match instantiation::create(cycle, seed) {
        Ok(fresh) => fresh,
        Err(cause) => {
            let place = cycle.place_of(id);
            return fail_parent(cycle, id, Because::new(cause, place));
        }
    };
    let index = cycle.agent.procedure_index(step.procedure).cloned();
    let counts = index.and_then(|index| index.steps.get(step.step as usize).map(|step| step.counts)).unwrap_or(false);
    procedure::adopt(cycle, parent, fresh, counts);
    let before = cycle.agent.task_mut(id).map(|task| {
        let extras = task.extras_mut();
        let counts = (extras.instances, extras.instant, extras.counted_since, extras.instants, extras.outside);
        (std::mem::take(&mut extras.answered), counts)
    });
    if let (Some((answered, counts)), Some(task)) = (before, cycle.agent.task_mut(fresh)) {
        let extras = task.extras_mut();
        extras.answered = answered;
        (extras.instances, extras.instant, extras.counted_since, extras.instants, extras.outside) = counts;
    }
    instantiation::arm(cycle, fresh);
}
