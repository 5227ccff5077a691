//! Recording (TC)
//! What: records the events of the instant in histories, passes answers to controllers, and handles due wakes.
//! Runs: record phase.  Reads: Batch, WakeQueue.  Writes: Histories, stimuli, controllers.
//! Bound: O(events of the instant).  PDL: none.  Paper: section III, sources of information for monitors.

use crate::control::cycle::{Cycle, SelfMessage};
use crate::control::tasks::{monitoring_clauses, primitive, probing, question, repetition, termination};
use crate::deliberation::plan_adoption;
use crate::monitoring::derivation::{self, Changed, Surroundings};
use crate::monitoring::memory::histories::{self, Recording};
use crate::monitoring::stimulus::Stimulus;
use crate::state::histories::history::Occurrence;
use crate::state::wake::Wake;
use apex_model::agent_limits::Limit;
use apex_model::because::{Because, Cause};
use apex_model::effect::DecisionKind;
use apex_model::event::{Event, EventKind, Message, StateVariable, measured};
use apex_model::time::Time;
use apex_model::value::Value;

fn arrival(cycle: &mut Cycle<'_>) -> u64 {
    let number = cycle.agent.next.arrival;
    cycle.agent.next.arrival += 1;
    number
}

/// Records the events of the instant: first all that can be measured or heard, then the answers to controllers.
pub(crate) fn record(cycle: &mut Cycle<'_>, events: &[Event]) {
    count_outside(cycle, events);
    if events.len() > 1 {
        cycle.work.stimuli.reserve(events.len());
    }
    for event in events {
        match &event.kind {
            EventKind::Measurement(variable, value) => measurement(cycle, variable.clone(), value.clone(), event.at),
            EventKind::Occurrence(form) => {
                recording_lost(cycle, form);
                occurrence(cycle, form.clone(), event.at);
            }
            EventKind::CommandAcknowledged(..)
            | EventKind::CommandProgressed(..)
            | EventKind::SolverReported(..)
            | EventKind::OperatorAnswered(..)
            | EventKind::Stop(_)
            | EventKind::Woken => {}
            EventKind::Told(_, Message::Occurrence(form)) => occurrence(cycle, form.clone(), event.at),
            EventKind::Told(_, Message::Measurement(variable, value)) => {
                measurement(cycle, variable.clone(), value.clone(), event.at);
            }
        }
    }
    cycle.work.repetition = derive(cycle);
    for event in events {
        match &event.kind {
            EventKind::CommandAcknowledged(command, answer) => primitive::answered(cycle, *command, answer),
            EventKind::CommandProgressed(command, progress) => primitive::progressed(cycle, *command, *progress),
            EventKind::SolverReported(request, report) => plan_adoption::reported(cycle, *request, report),
            EventKind::OperatorAnswered(question, answer) => question::answered(cycle, *question, answer),
            EventKind::Stop(reason) => termination::stop(cycle, reason),
            EventKind::Measurement(..) | EventKind::Occurrence(_) | EventKind::Told(..) | EventKind::Woken => {}
        }
        termination::settle(cycle);
    }
}

/// Reports that the flight is no longer recorded; the runtime has sent this message.
fn recording_lost(cycle: &mut Cycle<'_>, form: &Value) {
    let Some([head, reason]) = form.as_list() else { return };
    if head.as_symbol().is_some_and(|word| word.is("recording-lost")) {
        let reason = if let Value::Text(text) = reason { text.to_string() } else { reason.to_string() };
        cycle.trouble_of(None, Cause::RecordingLost { reason }, None);
    }
}

/// Counts the messages from outside at this instant: a burst of messages is not a loop.
fn count_outside(cycle: &mut Cycle<'_>, events: &[Event]) {
    let counts = |event: &&Event| matches!(event.kind, EventKind::Measurement(..) | EventKind::Occurrence(_));
    let count = events.iter().filter(counts).count();
    if count == 0 {
        return;
    }
    let (now, added) = (cycle.now, count as u64);
    let burst = &mut cycle.agent.burst;
    let is_same_instant = burst.0 == now;
    *burst = if is_same_instant { (now, burst.1.saturating_add(added)) } else { (now, added) };
    cycle.agent.next.outside = cycle.agent.next.outside.saturating_add(added);
    let messages = events.iter().filter(|event| matches!(event.kind, EventKind::Occurrence(_))).count();
    cycle.agent.histories.expect_events(messages, is_same_instant);
}

/// Records the messages and samples that the agent sent to itself in the preceding round.
pub(crate) fn record_said(cycle: &mut Cycle<'_>) {
    let now = cycle.now;
    cycle.agent.published.clear();
    let repetition = cycle.work.repetition.take();
    if let Some(samples) = repetition.filter(|_| cycle.work.said.is_empty()) {
        // Nothing was recorded since the variables of this instant were derived.
        cycle.agent.next.arrival += samples;
        return;
    }
    for said in std::mem::take(&mut cycle.work.said) {
        match said {
            SelfMessage::Occurrence(form) => occurrence(cycle, form, now),
            SelfMessage::Measurement(variable, value) => measurement(cycle, variable, value, now),
        }
    }
    derive(cycle);
}

/// Computes the samples of derived variables from those recorded since the monitors were last notified. Returns the number of samples that
/// doing so once more would record, if that changed nothing else.
fn derive(cycle: &mut Cycle<'_>) -> Option<u64> {
    let (library, index) = (cycle.library, &cycle.index.variables);
    if index.ranked().is_empty() {
        return Some(0);
    }
    let changed = cycle.work.stimuli.iter().filter_map(|stimulus| match stimulus {
        Stimulus::Sample { variable, at, .. } if !index.readers(&variable.attribute).is_empty() => {
            Some(Changed { variable: variable.clone(), at: *at })
        }
        _ => None,
    });
    let changed: Vec<Changed> = changed.collect();
    if changed.is_empty() {
        return Some(0);
    }
    let agent = &mut *cycle.agent;
    let surroundings = Surroundings { library, index, host: &agent.host, agent: &agent.name, limits: &agent.limits };
    let next = &mut agent.next.arrival;
    let mut arrival = || {
        let number = *next;
        *next += 1;
        number
    };
    let derived = derivation::derive(changed, &mut agent.histories, &surroundings, &mut arrival);
    let repetition = derivation::repetition(&derived, &agent.histories);
    for derived in derived {
        note(cycle, derived.recording);
    }
    repetition
}

fn occurrence(cycle: &mut Cycle<'_>, form: Value, at: Time) {
    if let Some((variable, value)) = measured(&form) {
        return measurement(cycle, variable, value, at);
    }
    let number = arrival(cycle);
    let remembered = cycle.agent.histories.events_cover(cycle.now);
    if !cycle.agent.listening.is_empty() {
        hear(cycle, Occurrence { at, sequence: number, form: form.clone() });
    }
    let (stimulus, overflows) = histories::record_event(&mut cycle.agent.histories, form, at, number);
    cycle.work.stimuli.push(stimulus);
    if overflows {
        let message = histories::overflow_of_messages(&cycle.agent.limits);
        overflow(cycle, Limit::EventHistory, message);
    }
    if remembered && !cycle.agent.histories.events_cover(cycle.now) {
        forgets(cycle);
    }
}

/// Keeps the message for repeating steps that are busy.
fn hear(cycle: &mut Cycle<'_>, message: Occurrence) {
    let burst = usize::try_from(cycle.agent.outside_messages_at(cycle.now)).unwrap_or(usize::MAX);
    let most = cycle.agent.limits.count(Limit::MonitorResults).saturating_add(burst);
    for task in cycle.agent.listening.hear(&message, most) {
        let message = format!(
            "more than {most} messages wait for this repeating step, which is busy: the oldest are dropped; answer faster, \
             use `responding`, or state `:missed-messages drop`"
        );
        let cause = cycle.agent.limits.reached(Limit::MonitorResults);
        let place = cycle.place_of(task);
        cycle.decide(Some(task), DecisionKind::Trouble { message }, Because::new(cause, place));
    }
}

/// Reports once for each instant that messages of it are dropped: a monitor that begins later does not receive them. This can end a loop
/// without time whose tasks send messages.
fn forgets(cycle: &mut Cycle<'_>) {
    let most = cycle.agent.limits.of(Limit::EventHistory);
    let message = format!(
        "more than {most} messages at this instant: the oldest of them are forgotten, tasks created now do not \
         receive them; look for tasks that keep causing one another without time passing, or send fewer messages at once"
    );
    overflow(cycle, Limit::EventHistory, message);
}

fn overflow(cycle: &mut Cycle<'_>, limit: Limit, message: String) {
    let cause = cycle.agent.limits.reached(limit);
    cycle.decide(None, DecisionKind::Trouble { message }, Because::new(cause, None));
}

fn measurement(cycle: &mut Cycle<'_>, variable: StateVariable, value: Value, at: Time) {
    let number = arrival(cycle);
    let index = &cycle.index.variables;
    let recording = histories::record_sample(&mut cycle.agent.histories, index, variable, value, at, number);
    note(cycle, recording);
}

fn note(cycle: &mut Cycle<'_>, recording: Recording) {
    if let Some(Stimulus::Sample { variable, .. }) = recording.stimulus.as_ref().filter(|_| recording.overflows) {
        let message = histories::overflow_of_samples(variable, &cycle.agent.limits);
        overflow(cycle, Limit::HistorySamples, message);
    }
    cycle.work.stimuli.extend(recording.stimulus);
    if let Some(message) = recording.trouble {
        cycle.trouble_of(None, Cause::InputRefused { message }, None);
    }
}

/// Handles all wakes that are due now.
pub(crate) fn wake(cycle: &mut Cycle<'_>) {
    while let Some(wake) = cycle.agent.wakes.take_due(cycle.now) {
        match wake {
            Wake::Duration(task) => primitive::duration_over(cycle, task),
            Wake::Update(task) => primitive::update(cycle, task),
            Wake::CommandTimeout(command) => primitive::timed_out(cycle, command),
            Wake::Monitor(monitor) => monitoring_clauses::woken(cycle, monitor),
            Wake::MinimumInterval(task) => repetition::interval_over(cycle, task),
            Wake::Probing(monitor) => probing::woken(cycle, monitor),
            Wake::PriorityCrossing(task) => {
                if let Some(extras) = cycle.agent.task_mut(task).and_then(|task| task.extras.as_mut()) {
                    extras.crossing = None;
                }
                cycle.work.priorities_changed = true;
            }
            Wake::Question(question) => question::time_over(cycle, question),
            Wake::SolveTimeout(request) => plan_adoption::timed_out(cycle, request),
        }
        termination::settle(cycle);
    }
}
