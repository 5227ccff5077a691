//! A flight: agents, vehicle, solvers, observers and the clock between two instants. The mission loop and the protocol for external
//! simulators advance it.

mod answers;
mod ordered;
mod outside;
mod resume;
mod waiting;

pub(crate) use resume::OpenAnswer;

use crate::agent_group::{AgentGroup, Numbering};
use crate::authority::AuthorityBoard;
use crate::error::RunError;
use crate::input_stream::InputStream;
use crate::limits::{LATENESS_REPORTED_MIN, STEPS_PER_INSTANT_MAX};
use crate::live::LiveSources;
use crate::outbox;
use crate::pacing::Pacer;
use crate::pool::{Arrival, SolverPool};
use crate::ports::{Deliberator, Input, Observer, SolverQueue, Vehicle};
use crate::run_settings::{Control, EndReason, Lateness, RunEnd, RunSettings, ScriptedAnswer};
use answers::AnswerBook;
use apex_executive::Agent;
use apex_model::effect::{Effect, SolveRequest};
use apex_model::event::{Batch, EventKind};
use apex_model::time::{Duration, Time};
use std::sync::mpsc::Receiver;
use std::time::Instant;

/// Type of the executive's step function, as a value so that tests can replace it.
pub(crate) type StepFunction = fn(&mut Agent, &Batch) -> Vec<Effect>;

/// Everything that a run consists of.
pub(crate) struct Flight<'a, 'o> {
    step: StepFunction,
    group: AgentGroup<'a>,
    vehicle: &'a mut dyn Vehicle,
    deliberator: &'a mut dyn Deliberator,
    observers: &'a mut [&'o mut dyn Observer],
    pacer: Pacer,
    /// Inputs, the latest first, so that the next one is popped off the end.
    scheduled: Vec<Input>,
    stream: Option<InputStream>,
    answers: Vec<ScriptedAnswer>,
    controls: Option<Receiver<Control>>,
    live: Option<HeardSources>,
    /// Wall time at which observers have written out last.
    flushed_at: Instant,
    authority: AuthorityBoard,
    /// True while an outside source may still send more than `stop`.
    expecting: bool,
    until: Time,
    poll: Option<Duration>,
    hold_for_solvers: bool,
    /// The pace that the agents know, at least 1.
    known_pace: f64,
    /// True if a step is under way: the run pauses after the next instant with a visible effect.
    stepping: bool,
    pool: SolverPool,
    answered: AnswerBook,
    now: Time,
    steps_at_now: u64,
    /// True before the first instant.
    is_new: bool,
    end: RunEnd,
}

/// The live sources of a flight; dropping it informs their readers that the flight is over.
struct HeardSources(LiveSources);

impl Drop for HeardSources {
    fn drop(&mut self) {
        self.0.close();
    }
}

/// Result of waiting for an instant.
enum Waited {
    Reached(Time),
    /// Solvers have answered, or no outside source remains: the next instant must be computed again.
    Changed,
    /// An operator requests the end of the run at this instant.
    Stop(Time),
}

impl<'a, 'o> Flight<'a, 'o> {
    /// Returns a flight that has not begun.
    pub(crate) fn new(
        step: StepFunction,
        agents: &'a mut [Agent],
        vehicle: &'a mut dyn Vehicle,
        deliberator: &'a mut dyn Deliberator,
        observers: &'a mut [&'o mut dyn Observer],
        queue: Box<dyn SolverQueue>,
        options: RunSettings,
    ) -> Result<Flight<'a, 'o>, RunError> {
        let pacer = Pacer::new(options.pace, Time::ZERO, options.clock).map_err(RunError::Options)?;
        let mut scheduled = options.inputs;
        // Inputs of one instant keep their order: sorted stably first, then reversed for popping.
        scheduled.sort_by_key(|input| input.at);
        scheduled.reverse();
        let group = AgentGroup::new(agents);
        scheduled.iter().try_for_each(|input| group.check(input))?;
        for agent in options.stream.iter().flat_map(InputStream::agents) {
            group.check(&Input { agent: Some(agent.clone()), ..Input::new(Time::ZERO, EventKind::Woken) })?;
        }
        let late = Lateness::default();
        Ok(Flight {
            step,
            group,
            vehicle,
            deliberator,
            observers,
            pacer,
            scheduled,
            stream: options.stream,
            answers: options.answers,
            controls: options.controls,
            live: options.live.map(HeardSources),
            flushed_at: Instant::now(),
            authority: options.authority,
            expecting: true,
            until: options.until,
            poll: options.poll,
            hold_for_solvers: options.hold_for_solvers,
            known_pace: 1.0,
            stepping: false,
            pool: SolverPool::new(queue),
            answered: AnswerBook::default(),
            now: Time::ZERO,
            steps_at_now: 0,
            is_new: true,
            end: RunEnd {
                at: Time::ZERO,
                reason: EndReason::Quiescent,
                steps: 0,
                events: 0,
                effects: 0,
                late,
                unused: Vec::new(),
            },
        })
    }

    /// Runs the flight until it ends; returns the reason.
    pub(crate) fn run(&mut self) -> Result<EndReason, RunError> {
        if std::mem::take(&mut self.is_new) {
            self.tell_pace(Time::ZERO)?;
            if let Some(reason) = self.live_instant(Time::ZERO, true)? {
                return Ok(reason);
            }
        }
        loop {
            if let Some(reason) = self.group.finish() {
                return Ok(self.group.ended(reason));
            }
            let Some(instant) = self.next_instant() else { return Ok(EndReason::Quiescent) };
            let beyond = instant > self.until;
            match self.wait(instant.min(self.until))? {
                Waited::Stop(at) => {
                    self.now = at;
                    self.stop_all(None, &EndReason::Stopped.text())?;
                    return Ok(EndReason::Stopped);
                }
                Waited::Changed => {}
                Waited::Reached(at) if beyond && at >= self.until && self.group.is_idle() => {
                    self.now = self.now.max(self.until);
                    return Ok(EndReason::Until);
                }
                Waited::Reached(at) => {
                    self.watch_lateness(at)?;
                    if let Some(reason) = self.live_instant(at, false)? {
                        return Ok(reason);
                    }
                }
            }
        }
    }

    /// Lets the observers store everything up to now permanently.
    pub(crate) fn flush(&mut self, now: Time) -> Result<(), RunError> {
        self.each_observer(now, |observer| observer.flush())
    }

    /// Ends everything cleanly, from outside.
    pub(crate) fn stop(&mut self) -> Result<(), RunError> {
        self.stop_all(None, &EndReason::Stopped.text())
    }

    /// Records that the instant is stepped later than its wall time; reports it when the delay grows.
    fn watch_lateness(&mut self, at: Time) -> Result<(), RunError> {
        let late = self.pacer.lateness(at);
        if late < LATENESS_REPORTED_MIN {
            return Ok(());
        }
        self.end.late.steps += 1;
        if late > self.end.late.worst * 2 {
            let milliseconds = late.as_millis();
            let text = format!("the step of {at} came {milliseconds} ms late: the computer does not keep up");
            self.each_observer(at, |observer| observer.note(at, &text))?;
        }
        self.end.late.worst = self.end.late.worst.max(late);
        Ok(())
    }

    /// Returns the next instant at which something happens, never before now; `None` if no further event can occur.
    fn next_instant(&self) -> Option<Time> {
        let report = self.vehicle.next_report();
        let poll = self.poll.filter(|_| report.is_none()).map(|poll| self.now + poll.max(Duration(1)));
        let wake = self.group.next_wake();
        let scheduled = self.scheduled.last().map(|input| input.at);
        let has_live = || self.live.as_ref().is_some_and(|live| live.0.has_waiting());
        let people = self.controls.is_some() && self.pacer.is_paced() && (self.expecting || has_live());
        let listening = (people || self.pool.is_expecting()).then_some(Time::END);
        let streamed = self.stream.as_ref().and_then(InputStream::next_at);
        let all = [report, poll, wake, self.pool.next_due(), scheduled, streamed, listening];
        all.into_iter().flatten().min().map(|at| at.max(self.now))
    }

    /// Collects the answers of solvers; returns true if there was one. Without a pace it waits for all of them.
    fn fetch_answers(&mut self, instant: Time) -> Result<bool, RunError> {
        let now = self.pacer.now(self.now, instant);
        if self.pool.is_waiting() && !self.pacer.is_paced() {
            // A solver may take minutes: steps are committed before the wait.
            self.flush(now)?;
        }
        let Some(notes) = self.pool.collect(now, !self.pacer.is_paced()) else { return Ok(false) };
        self.show_answers(now)?;
        for text in notes {
            self.each_observer(now, |observer| observer.note(now, &text))?;
        }
        Ok(true)
    }

    /// Executes everything at one instant. Returns `Some` if the run is over.
    fn live_instant(&mut self, at: Time, first: bool) -> Result<Option<EndReason>, RunError> {
        if at > self.now {
            self.steps_at_now = 0;
            self.group.new_instant();
        }
        self.now = at;
        let cause = self.collect()?;
        let mut forced = first;
        loop {
            let mut anything = false;
            for index in 0..self.group.len() {
                let batch = match self.group.take(index, self.now) {
                    Some(batch) => batch,
                    None if forced => Batch { now: self.now, events: Vec::new() },
                    None => continue,
                };
                anything = true;
                if let Some(reason) = self.execute(index, &batch)? {
                    self.stop_all(Some(index), &reason)?;
                    return Ok(Some(self.group.ended(reason)));
                }
            }
            forced = false;
            self.group.end_round(self.now)?;
            if !anything {
                return Ok(None);
            }
            self.steps_at_now += 1;
            if self.steps_at_now > STEPS_PER_INSTANT_MAX {
                return Err(RunError::Stuck { at: self.now, limit: STEPS_PER_INSTANT_MAX, cause });
            }
        }
    }

    /// Ends the work of the agents other than `except` cleanly.
    fn stop_all(&mut self, except: Option<usize>, reason: &str) -> Result<(), RunError> {
        for index in self.group.stop(except, self.now, reason)? {
            if let Some(batch) = self.group.take(index, self.now) {
                self.execute(index, &batch)?;
            }
        }
        Ok(())
    }

    /// Gathers the inputs of this instant; answers with the cause of the step, as text.
    fn collect(&mut self) -> Result<String, RunError> {
        let now = self.now;
        let mut inputs = Vec::new();
        self.vehicle.advance(now, &mut inputs).map_err(|message| RunError::Vehicle { at: now, message })?;
        let cause = if inputs.is_empty() { "an input" } else { "a report of the vehicle" };
        self.pool.take_due(now, &mut inputs);
        while let Some(input) = self.scheduled.pop_if(|input| input.at <= now) {
            inputs.push(input);
        }
        if let Some(stream) = &mut self.stream {
            while let Some(input) = stream.take_due(now).map_err(RunError::Options)? {
                inputs.push(input);
            }
        }
        for mut input in inputs {
            // A vehicle may be ahead of the flight, but no input may reach the executive with a later instant than the present one.
            input.at = input.at.min(now);
            self.group.deliver(input)?;
        }
        Ok(self.group.wake(now)?.unwrap_or_else(|| cause.to_owned()))
    }

    /// Executes one step of one agent, with recording and sending. Returns `Some` if the application is over.
    fn execute(&mut self, index: usize, batch: &Batch) -> Result<Option<String>, RunError> {
        let now = batch.now;
        if self.group.len() > 1 {
            self.each_observer(now, |observer| observer.turn(index))?;
        }
        self.each_observer(now, |observer| observer.begin(batch))?;
        let Some(agent) = self.group.agent_mut(index) else { return Ok(None) };
        let effects = (self.step)(agent, batch);
        self.end.steps += 1;
        self.end.events += batch.events.len() as u64;
        self.end.effects += effects.len() as u64;
        if self.stepping && !effects.is_empty() {
            self.pause_after_step(now)?;
        }
        // In sequence: a trace that a vehicle reads is written after the recorder has committed.
        let leaves = self.vehicle.acts_outside() && effects.iter().any(outbox::leaves);
        self.each_observer(now, |observer| {
            observer.observe(batch, &effects)?;
            if leaves { observer.flush() } else { Ok(()) }
        })?;
        self.deliberator.observe(index, batch, &effects);
        self.deliberator.derive().into_iter().try_for_each(|input| self.group.deliver(input))?;
        let numbering = Numbering::new(index, self.group.len());
        let sent = outbox::send(&effects, numbering, now, self.vehicle, &mut self.pool);
        for request in &sent.requests {
            self.pose(request, now)?;
        }
        let undelivered = self.group.post(index, sent.told);
        self.answer(index, &effects, now);
        let ignored = self.answered.take(index, batch, |command| numbering.outer(command.0));
        for text in sent.notes.iter().chain(&undelivered).chain(&ignored) {
            self.each_observer(now, |observer| observer.note(now, text))?;
        }
        self.hear_observers(now)?;
        if let Some(agent) = self.group.agent(index) {
            for observer in self.observers.iter_mut() {
                let inspected = observer.inspect(agent, &*self.deliberator, now);
                inspected.map_err(|message| RunError::Observer { at: now, message })?;
            }
        }
        Ok(sent.end)
    }

    /// Poses a request's problem from the present situation, and queues the job.
    fn pose(&mut self, request: &SolveRequest, now: Time) -> Result<(), RunError> {
        let posed = self.deliberator.pose(request, now);
        self.each_observer(now, |observer| observer.posed(request, now, &posed.problem))?;
        if self.hold_for_solvers || !self.pacer.is_paced() {
            // The flight waits here for the solver.
            self.flush(now)?;
        }
        let waits = self.hold_for_solvers || !self.pacer.is_paced();
        self.pool.request(request, now, posed.job, waits);
        if waits {
            // The wall time that the solver took does not count as mission time.
            self.pacer.hold(now);
        }
        self.show_answers(now)
    }

    /// Shows the answers that have arrived to the observers.
    fn show_answers(&mut self, now: Time) -> Result<(), RunError> {
        for Arrival { request, due, answer } in self.pool.take_fresh() {
            self.each_observer(now, |observer| observer.answered(request, due, &answer))?;
        }
        Ok(())
    }

    /// Answers the questions among the effects by the script.
    fn answer(&mut self, index: usize, effects: &[Effect], now: Time) {
        for effect in effects {
            let Effect::Ask { question, text, .. } = effect else { continue };
            let Some(agent) = self.group.agent(index).map(|agent| agent.name.clone()) else { continue };
            let asked = text.to_lowercase();
            let fits = |answer: &ScriptedAnswer| {
                asked.contains(&answer.question.to_lowercase())
                    && answer.agent.as_ref().is_none_or(|wanted| *wanted == agent)
            };
            let Some(found) = self.answers.iter().position(fits) else { continue };
            let answer = self.answers.remove(found);
            let at = now + answer.after.max(Duration::ZERO);
            let kind = EventKind::OperatorAnswered(*question, answer.value);
            // The list is in descending order of time; answers of one instant keep their order.
            let place = self.scheduled.partition_point(|input| input.at > at);
            self.scheduled.insert(place, Input { at, kind, agent: Some(agent), command_form: None });
        }
    }

    /// Passes messages of observers, such as a full disk, to the agents and to all observers.
    pub(super) fn hear_observers(&mut self, now: Time) -> Result<(), RunError> {
        while let Some(news) = self.observers.iter_mut().find_map(|observer| observer.take_news()) {
            self.each_observer(now, |observer| observer.note(now, &news.note))?;
            self.each_observer(now, |observer| observer.hear_news(now, &news))?;
            self.group.deliver(Input::new(now, EventKind::Occurrence(news.message)))?;
        }
        Ok(())
    }

    fn each_observer(
        &mut self,
        at: Time,
        mut call: impl FnMut(&mut dyn Observer) -> Result<(), String>,
    ) -> Result<(), RunError> {
        for observer in self.observers.iter_mut() {
            call(&mut **observer).map_err(|message| RunError::Observer { at, message })?;
        }
        Ok(())
    }

    /// Ends the flight: reports requests and inputs that can no longer take effect.
    pub(crate) fn close(mut self, reason: EndReason) -> Result<RunEnd, RunError> {
        let now = self.now;
        for text in self.pool.close(now) {
            self.each_observer(now, |observer| observer.note(now, &text))?;
        }
        self.each_observer(now, |observer| observer.flush())?;
        Ok(RunEnd { at: now, reason, ..self.end })
    }
}
