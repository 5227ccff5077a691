//! The mission loop: simulated time jumps from instant to instant; at each the vehicle reports, the executive steps,
//! observers see, and effects go out.
//!
//! The next instant is the earliest of: the vehicle's next report, the agent's next wake, the next solver answer, the
//! next scheduled input. Nothing else moves time, so a run depends on its inputs only.

use crate::crew::{Crew, Numbering};
use crate::error::RunError;
use crate::limits::STEPS_PER_INSTANT_MAX;
use crate::outbox;
use crate::pacing::{Pacer, Wait};
use crate::pool::SolverPool;
use crate::ports::{Deliberator, Input, Observer, Vehicle};
use apex_executive::{Agent, step};
use apex_model::effect::Effect;
use apex_model::event::{Batch, EventKind};
use apex_model::time::{Duration, Time};
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};

/// How to fly.
#[derive(Debug)]
pub struct FlyOptions {
    /// The last instant that is executed.
    pub until: Time,
    /// Mission seconds per second of wall time; none is as fast as possible, 0 waits for [`Control::Pace`].
    pub pace: Option<f64>,
    /// Inputs that come at known times, besides the vehicle's: a scenario, an operator's answers. Any order.
    pub inputs: Vec<Input>,
    /// What people say while it runs.
    pub controls: Option<Receiver<Control>>,
    /// Largest step of time for a vehicle that does not know when it reports next; none trusts the other instants.
    pub poll: Option<Duration>,
}

impl Default for FlyOptions {
    fn default() -> FlyOptions {
        FlyOptions { until: Time::END, pace: None, inputs: Vec::new(), controls: None, poll: None }
    }
}

/// Said from outside while a run goes on.
#[derive(Clone, Debug, PartialEq)]
pub enum Control {
    /// An input, now: an operator's answer, a message.
    Input(EventKind),
    /// Another pace; see [`FlyOptions::pace`].
    Pace(Option<f64>),
    /// End the run in good order.
    Stop,
}

/// Why a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EndReason {
    /// `(end-application)` or the end of the root task, with the agent's reason.
    Application(String),
    /// The time limit.
    Until,
    /// Nothing would ever happen again: no wake, no report, no answer, no input.
    Quiescent,
    /// [`Control::Stop`].
    Stopped,
}

impl EndReason {
    /// The reason in words, as stored under `end_reason` in the record.
    pub fn text(&self) -> String {
        match self {
            EndReason::Application(reason) => reason.clone(),
            EndReason::Until => "the time limit was reached".into(),
            EndReason::Quiescent => "nothing more can happen: no wake, report, answer or input is left".into(),
            EndReason::Stopped => "it was stopped from outside".into(),
        }
    }
}

/// How a run ended and how much work it was.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunEnd {
    /// Mission time at the end.
    pub at: Time,
    /// Why.
    pub reason: EndReason,
    /// Executive steps.
    pub steps: u64,
    /// Events that came in.
    pub events: u64,
    /// Effects that went out.
    pub effects: u64,
}

/// Flies: runs `agent` with `vehicle` from mission time 0 until the application ends or `options.until`.
///
/// Observers are called in order; the recorder comes first, so that nobody sees what is not stored.
///
/// # Errors
/// [`RunError`] when the vehicle's link or an observer breaks, or time stands still.
pub fn fly(
    agent: &mut Agent,
    vehicle: &mut dyn Vehicle,
    deliberator: &mut (dyn Deliberator + Send),
    observers: &mut [&mut dyn Observer],
    options: FlyOptions,
) -> Result<RunEnd, RunError> {
    fly_by(step, std::slice::from_mut(agent), vehicle, deliberator, observers, options)
}

/// As [`fly`], with all agents of an application at one clock, in the order of their declarations: see
/// [`crate::crew`]. The run is over when `(end-application)` says so, or when all agents are done.
///
/// # Errors
/// As [`fly`], and when an input is for an agent that does not exist.
pub fn fly_all(
    agents: &mut [Agent],
    vehicle: &mut dyn Vehicle,
    deliberator: &mut (dyn Deliberator + Send),
    observers: &mut [&mut dyn Observer],
    options: FlyOptions,
) -> Result<RunEnd, RunError> {
    fly_by(step, agents, vehicle, deliberator, observers, options)
}

fn fly_by(
    step: Step,
    agents: &mut [Agent],
    vehicle: &mut dyn Vehicle,
    deliberator: &mut (dyn Deliberator + Send),
    observers: &mut [&mut dyn Observer],
    options: FlyOptions,
) -> Result<RunEnd, RunError> {
    let pacer = Pacer::new(options.pace, Time::ZERO).map_err(RunError::Options)?;
    let mut scheduled = options.inputs;
    // Inputs of one instant keep their order: sorted stably first, then turned round for popping.
    scheduled.sort_by_key(|input| input.at);
    scheduled.reverse();
    let crew = Crew::new(agents);
    scheduled.iter().try_for_each(|input| crew.check(input))?;
    let mut flight = Flight {
        step,
        crew,
        vehicle,
        deliberator,
        observers,
        pacer,
        scheduled,
        controls: options.controls,
        until: options.until,
        poll: options.poll,
        pool: SolverPool::new(),
        now: Time::ZERO,
        steps_at_now: 0,
        end: RunEnd { at: Time::ZERO, reason: EndReason::Quiescent, steps: 0, events: 0, effects: 0 },
    };
    let reason = flight.run()?;
    flight.close(reason)
}

/// The executive's door, as a value so that tests can stand in for it.
type Step = fn(&mut Agent, &Batch) -> Vec<Effect>;

struct Flight<'a, 'o> {
    step: Step,
    crew: Crew<'a>,
    vehicle: &'a mut dyn Vehicle,
    deliberator: &'a mut (dyn Deliberator + Send),
    observers: &'a mut [&'o mut dyn Observer],
    pacer: Pacer,
    /// Latest first, so that the next one is popped off the end.
    scheduled: Vec<Input>,
    controls: Option<Receiver<Control>>,
    until: Time,
    poll: Option<Duration>,
    pool: SolverPool,
    now: Time,
    steps_at_now: u64,
    end: RunEnd,
}

/// What waiting for an instant came to.
enum Waited {
    Reached(Time),
    /// Nobody listens from outside any more: what comes next must be asked again.
    Deserted,
    /// Somebody wants the run to end, at this instant.
    Stop(Time),
}

impl Flight<'_, '_> {
    fn run(&mut self) -> Result<EndReason, RunError> {
        if let Some(reason) = self.live_instant(Time::ZERO, true)? {
            return Ok(reason);
        }
        loop {
            if let Some(reason) = self.crew.finish() {
                return Ok(EndReason::Application(reason));
            }
            let Some(instant) = self.next_instant() else { return Ok(EndReason::Quiescent) };
            let beyond = instant > self.until;
            match self.wait(instant.min(self.until))? {
                Waited::Stop(at) => {
                    self.now = at;
                    self.stop_all(None, &EndReason::Stopped.text())?;
                    return Ok(EndReason::Stopped);
                }
                Waited::Deserted => {}
                Waited::Reached(at) if beyond && at >= self.until && self.crew.is_idle() => {
                    self.now = self.now.max(self.until);
                    return Ok(EndReason::Until);
                }
                Waited::Reached(at) => {
                    if let Some(reason) = self.live_instant(at, false)? {
                        return Ok(reason);
                    }
                }
            }
        }
    }

    /// The next instant at which something happens, never before now. None: nothing ever will.
    fn next_instant(&self) -> Option<Time> {
        let report = self.vehicle.next_report();
        let poll = self.poll.filter(|_| report.is_none()).map(|poll| self.now + poll.max(Duration(1)));
        let wake = self.crew.next_wake();
        let scheduled = self.scheduled.last().map(|input| input.at);
        let people = self.controls.is_some() && self.pacer.is_paced();
        let listening = people.then_some(Time::END);
        let all = [report, poll, wake, self.pool.next_due(), scheduled, listening];
        all.into_iter().flatten().min().map(|at| at.max(self.now))
    }

    /// Sleeps until `instant` where the run is paced; an input from people cuts the sleep short.
    fn wait(&mut self, instant: Time) -> Result<Waited, RunError> {
        let mut flushed = false;
        let listening = self.controls.is_some();
        loop {
            if !self.crew.is_idle() {
                return Ok(Waited::Reached(self.pacer.now(self.now, instant)));
            }
            let wait = self.pacer.wait(instant);
            if wait != Wait::Over && !flushed {
                self.each_observer(instant, |observer| observer.flush())?;
                flushed = true;
            }
            match self.hear(wait)? {
                Some(Control::Stop) => {
                    let reached = if self.pacer.is_paced() { self.pacer.now(self.now, instant) } else { self.now };
                    return Ok(Waited::Stop(reached));
                }
                Some(Control::Pace(pace)) => {
                    let now = self.pacer.now(self.now, instant);
                    self.pacer.set(pace, now).map_err(RunError::Options)?;
                }
                Some(Control::Input(kind)) => {
                    let at = self.pacer.now(self.now, instant);
                    self.crew.deliver(Input::new(at, kind))?;
                }
                None if wait == Wait::Over => return Ok(Waited::Reached(instant)),
                None if listening && self.controls.is_none() => return Ok(Waited::Deserted),
                None => {}
            }
        }
    }

    /// Waits as long as told for a word from outside.
    fn hear(&mut self, wait: Wait) -> Result<Option<Control>, RunError> {
        let Some(controls) = &self.controls else {
            return match wait {
                Wait::Over => Ok(None),
                Wait::For(span) => {
                    std::thread::sleep(span);
                    Ok(None)
                }
                Wait::Paused => Err(RunError::Options("The run is paused and nobody is there to resume it.".into())),
            };
        };
        let heard = match wait {
            Wait::Over => controls.try_recv().map_err(|error| error == TryRecvError::Disconnected),
            Wait::For(span) => controls.recv_timeout(span).map_err(|error| error == RecvTimeoutError::Disconnected),
            Wait::Paused => controls.recv().map_err(|_| true),
        };
        match heard {
            Ok(control) => Ok(Some(control)),
            Err(gone) => {
                if gone {
                    self.controls = None;
                }
                Ok(None)
            }
        }
    }

    /// Everything that happens at one instant. Some: the run is over.
    fn live_instant(&mut self, at: Time, first: bool) -> Result<Option<EndReason>, RunError> {
        if at > self.now {
            self.steps_at_now = 0;
            self.crew.new_instant();
        }
        self.now = at;
        let cause = self.collect()?;
        let mut forced = first;
        loop {
            let mut anything = false;
            for index in 0..self.crew.len() {
                let batch = match self.crew.take(index, self.now) {
                    Some(batch) => batch,
                    None if forced => Batch { now: self.now, events: Vec::new() },
                    None => continue,
                };
                anything = true;
                if let Some(reason) = self.execute(index, &batch)? {
                    self.stop_all(Some(index), &reason)?;
                    return Ok(Some(EndReason::Application(reason)));
                }
            }
            forced = false;
            self.crew.end_round(self.now)?;
            if !anything {
                return Ok(None);
            }
            self.steps_at_now += 1;
            if self.steps_at_now > STEPS_PER_INSTANT_MAX {
                return Err(RunError::Stuck { at: self.now, limit: STEPS_PER_INSTANT_MAX, cause });
            }
        }
    }

    /// Cuts what the agents other than `except` still do, in good order.
    fn stop_all(&mut self, except: Option<usize>, reason: &str) -> Result<(), RunError> {
        for index in self.crew.stop(except, self.now, reason)? {
            if let Some(batch) = self.crew.take(index, self.now) {
                self.execute(index, &batch)?;
            }
        }
        Ok(())
    }

    /// Gathers the inputs of this instant; answers with the cause of the step, in words.
    fn collect(&mut self) -> Result<String, RunError> {
        let now = self.now;
        let mut inputs = Vec::new();
        self.vehicle.advance(now, &mut inputs).map_err(|message| RunError::Vehicle { at: now, message })?;
        let cause = if inputs.is_empty() { "an input" } else { "a report of the vehicle" };
        self.pool.take_due(now, &mut inputs);
        while let Some(input) = self.scheduled.pop_if(|input| input.at <= now) {
            inputs.push(input);
        }
        for mut input in inputs {
            // A vehicle that runs ahead of us must not make the executive believe in the future.
            input.at = input.at.min(now);
            self.crew.deliver(input)?;
        }
        Ok(self.crew.wake(now)?.unwrap_or_else(|| cause.to_owned()))
    }

    /// One executive step of one agent with everything around it. Some: the application is over.
    fn execute(&mut self, index: usize, batch: &Batch) -> Result<Option<String>, RunError> {
        let now = batch.now;
        if self.crew.len() > 1 {
            self.each_observer(now, |observer| observer.turn(index))?;
        }
        self.each_observer(now, |observer| observer.begin(batch))?;
        let Some(agent) = self.crew.agent_mut(index) else { return Ok(None) };
        let effects = (self.step)(agent, batch);
        self.end.steps += 1;
        self.end.events += batch.events.len() as u64;
        self.end.effects += effects.len() as u64;
        self.each_observer(now, |observer| observer.observe(batch, &effects))?;
        let numbering = Numbering::new(index, self.crew.len());
        let sent = outbox::send(&effects, numbering, now, self.vehicle, &mut self.pool, self.deliberator);
        let undelivered = self.crew.post(index, sent.told);
        for text in sent.notes.iter().chain(&undelivered) {
            self.each_observer(now, |observer| observer.note(now, text))?;
        }
        if let Some(agent) = self.crew.agent(index) {
            for observer in self.observers.iter_mut() {
                observer.inspect(agent, now).map_err(|message| RunError::Observer { at: now, message })?;
            }
        }
        Ok(sent.end)
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

    fn close(mut self, reason: EndReason) -> Result<RunEnd, RunError> {
        let now = self.now;
        for text in self.pool.close(now) {
            self.each_observer(now, |observer| observer.note(now, &text))?;
        }
        self.each_observer(now, |observer| observer.flush())?;
        Ok(RunEnd { at: now, reason, ..self.end })
    }
}

#[cfg(test)]
#[path = "mission_loop_tests.rs"]
mod tests;
