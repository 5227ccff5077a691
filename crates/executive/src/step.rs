//! The step: the only entry point. It processes the input instant by instant, in phases of fixed order.
//!
//! Every instant up to the batch's `now` at which an event or a wake occurs is one cycle: record -> notice -> enable -> choose -> contend
//! -> commit -> act, repeated until nothing changes. So the decisions depend neither on the division of events into batches nor on how
//! often time was advanced.

use crate::control::conflicts::{deadlock, resources};
use crate::control::cycle::{Cycle, Work};
use crate::control::tasks::instantiation::{self, Seed};
use crate::control::tasks::{execution_conditions, monitoring_clauses, probing, termination};
use crate::phases::{contention, enablement, invariants, invocation, recording, selection};
use crate::state::agent::Agent;
use crate::state::bindings::Bindings;
use crate::state::task::Origin;
use apex_model::agent_limits::Limit;
use apex_model::because::{Because, Cause};
use apex_model::effect::{DecisionKind, Effect};
use apex_model::event::{Batch, Event};
use apex_model::task::TaskId;
use apex_model::time::Time;

/// Number of rounds after which the executive ends one more task, at an instant that has exceeded its limit of rounds.
const LIVELOCK_ROUNDS_MAX: u64 = 100;
/// Number of tasks that may be ended at one instant because they never come to rest, before the whole agent is ended.
const LIVELOCK_TASKS_MAX: u32 = 100;

/// Advances `agent` to `batch.now` with the batch's events; returns the effects in order.
pub fn step(agent: &mut Agent, batch: &Batch) -> Vec<Effect> {
    if agent.is_finished() {
        return Vec::new();
    }
    let (library, index) = (agent.library.clone(), agent.index.clone());
    let before = agent.now;
    let effects = Vec::new();
    let first_task = agent.next.task;
    let mut cycle =
        Cycle { agent, library: &library, index: &index, now: before, first_task, effects, work: Work::default() };
    let mut events = batch.events.as_slice();
    while let Some(instant) = next_instant(&cycle, events, batch.now) {
        let count = events.iter().take_while(|event| instant_of(event, &cycle, batch.now) <= instant).count();
        let (present, later) = events.split_at_checked(count).unwrap_or((events, &[]));
        events = later;
        cycle.now = instant;
        cycle.agent.now = instant;
        work_through(&mut cycle, present);
        if cycle.agent.is_finished() {
            break;
        }
    }
    let effects = cycle.effects;
    agent.now = agent.now.max(batch.now);
    effects
}

/// Returns the instant at which an event takes effect: the instant of the event, but never in the past, nor after the batch.
fn instant_of(event: &Event, cycle: &Cycle<'_>, now: Time) -> Time {
    event.at.max(cycle.agent.now).min(now)
}

/// Returns the next instant with an event or a wake, up to `now`; events are in order of arrival.
fn next_instant(cycle: &Cycle<'_>, events: &[Event], now: Time) -> Option<Time> {
    let event = events.first().map(|event| instant_of(event, cycle, now));
    let begin = (!cycle.agent.started).then_some(now);
    let wake = cycle.agent.wakes.first().map(|(key, _)| key.at.max(cycle.agent.now)).filter(|at| *at <= now);
    [event, begin, wake].into_iter().flatten().min()
}

fn work_through(cycle: &mut Cycle<'_>, events: &[Event]) {
    if !cycle.agent.started {
        cycle.agent.started = true;
        begin(cycle);
    }
    recording::record(cycle, events);
    if is_quiet(cycle, events) {
        cycle.work.stimuli.clear();
        return;
    }
    recording::wake(cycle);
    let mut restless = 0;
    let mut rounds = 0;
    while !cycle.work.is_done() && !cycle.agent.is_finished() {
        rounds += u64::from(!cycle.work.made_progress(cycle.agent.next.task));
        if rounds > if restless == 0 { cascade_rounds(cycle) } else { LIVELOCK_ROUNDS_MAX } {
            rounds = 0;
            restless += 1;
            end_restless(cycle, restless > LIVELOCK_TASKS_MAX);
            continue;
        }
        recording::record_said(cycle);
        execution_conditions::notice(cycle);
        monitoring_clauses::notice(cycle);
        enablement::enable(cycle);
        termination::fail_beyond_budget(cycle);
        selection::choose(cycle);
        let arbitration = contention::contend(cycle);
        contention::commit(cycle, arbitration);
        termination::settle(cycle);
        invocation::act(cycle);
        recording::wake(cycle);
        probing::pursue(cycle);
    }
    if !cycle.work.refused.is_empty() {
        deadlock::look(cycle);
    }
    cycle.work.end_instant();
    invariants::check(cycle.agent);
}

/// Returns the number of rounds that this instant may take: the limit, once for each message that arrives from outside at this instant.
fn cascade_rounds(cycle: &Cycle<'_>) -> u64 {
    cycle.agent.limits.of(Limit::CascadeRounds).saturating_mul(cycle.agent.outside_messages_at(cycle.now))
}

/// Returns true if the only event of this instant is a sample that affects no monitor, as for most samples.
fn is_quiet(cycle: &Cycle<'_>, events: &[Event]) -> bool {
    matches!(events, [_])
        && matches!(cycle.work.stimuli.as_slice(), [only] if monitoring_clauses::is_unheard(cycle, only))
        && cycle.agent.wakes.first().is_none_or(|(key, _)| key.at > cycle.now)
        && cycle.work.has_only_stimuli()
        && !execution_conditions::concern(cycle)
}

/// Makes the root task.
fn begin(cycle: &mut Cycle<'_>) {
    let seed = Seed {
        parent: None,
        origin: Origin::Initial,
        bindings: Bindings::new(),
        by_predecessor: false,
        after_sequence: None,
        cause: Cause::InitialTask,
    };
    if let Ok(root) = instantiation::create(cycle, seed) {
        instantiation::arm(cycle, root);
        resources::tell_levels(cycle, root);
    }
}

/// Ends a task that keeps the instant from ending, and reports that.
fn end_restless(cycle: &mut Cycle<'_>, everything: bool) {
    let work = &cycle.work;
    let lists = [&work.starting, &work.claims, &work.enabled, &work.ready];
    let task = lists.iter().find_map(|list| list.first().copied()).or_else(|| watched(cycle));
    let cause = cycle.agent.limits.reached(Limit::CascadeRounds);
    let place = task.and_then(|task| cycle.place_of(task));
    let because = Because::new(cause, place);
    let message = "this instant does not end: tasks keep causing one another without time passing".to_string();
    cycle.decide(task, DecisionKind::Trouble { message }, because.clone());
    match task {
        Some(task) if !everything => {
            termination::fail(cycle, task, because);
            termination::settle(cycle);
        }
        _ => cycle.work = Work::default(),
    }
}

/// Returns a task whose monitor is about to be judged or receives a stimulus.
fn watched(cycle: &Cycle<'_>) -> Option<TaskId> {
    let firing = cycle.work.firings.first().map(|firing| firing.task);
    let touched = || cycle.work.touched.first().and_then(|id| cycle.agent.watches.get(id.0)).map(|watch| watch.task);
    firing.or_else(touched)
}
