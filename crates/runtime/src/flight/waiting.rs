//! Waits for the next instant of a flight, and processes inputs that arrive meanwhile.

use super::{Flight, Waited};
use crate::error::RunError;
use crate::limits::{FLUSH_INTERVAL, SOLVER_LOOK};
use crate::live::LiveInput;
use crate::pacing::Wait;
use crate::ports::Input;
use crate::run_settings::Control;
use apex_model::event::{EventKind, StateVariable};
use apex_model::time::Time;
use apex_model::value::Value;
use std::sync::mpsc::{RecvTimeoutError, TryRecvError};
use std::time::{Duration, Instant};

impl Flight<'_, '_> {
    /// Sleeps until `instant` where the run is paced; an operator's input or a solver's answer cuts the sleep short.
    pub(super) fn wait(&mut self, instant: Time) -> Result<Waited, RunError> {
        let mut flushed = self.flush_when_due(instant)?;
        let listening = self.controls.is_some();
        loop {
            if !self.group.is_idle() {
                return Ok(Waited::Reached(self.pacer.now(self.now, instant)));
            }
            if self.fetch_answers(instant)? {
                return Ok(Waited::Changed);
            }
            let wait = self.pacer.wait(instant);
            let live = self.live.as_ref().and_then(|live| live.0.ready_in());
            if wait != Wait::Over && live != Some(Duration::ZERO) && !flushed {
                self.each_observer(instant, |observer| observer.flush())?;
                (flushed, self.flushed_at) = (true, Instant::now());
                self.hear_observers(self.pacer.now(self.now, instant))?;
                continue;
            }
            match self.hear(live.map_or(wait, |span| wait.at_most(span)))? {
                Some(control) => {
                    if let Some(waited) = self.follow(control, instant)? {
                        return Ok(waited);
                    }
                }
                None if live == Some(Duration::ZERO) => {
                    if let Some(waited) = self.take_live(instant)? {
                        return Ok(waited);
                    }
                    // A flood of inputs must not delay what is due.
                    if wait == Wait::Over {
                        return Ok(Waited::Reached(instant));
                    }
                }
                None if wait == Wait::Over => return Ok(Waited::Reached(instant)),
                None if listening && self.controls.is_none() => return Ok(Waited::Changed),
                None => {}
            }
        }
    }

    /// Lets observers write their held-back data in a run that is never idle. Returns true if it did.
    fn flush_when_due(&mut self, instant: Time) -> Result<bool, RunError> {
        if self.live.is_none() || self.flushed_at.elapsed() < FLUSH_INTERVAL {
            return Ok(false);
        }
        self.flushed_at = Instant::now();
        self.each_observer(instant, |observer| observer.flush())?;
        Ok(true)
    }

    /// Takes the inputs of live sources that the permitted rates admit now.
    fn take_live(&mut self, instant: Time) -> Result<Option<Waited>, RunError> {
        for input in self.live.as_ref().map(|live| live.0.take()).unwrap_or_default() {
            let control = match input {
                LiveInput::Event(None, kind) => Control::Input(kind),
                LiveInput::Event(Some(agent), kind) => Control::InputFor(agent, kind),
                LiveInput::Stop => Control::Stop,
            };
            if let Some(waited) = self.follow(control, instant)? {
                return Ok(Some(waited));
            }
        }
        Ok(None)
    }

    /// Processes a message from outside while the run waits for `instant`. Returns `Some` if the wait is over.
    fn follow(&mut self, control: Control, instant: Time) -> Result<Option<Waited>, RunError> {
        if instant > self.now {
            // No work is left at this instant: the steps that follow are not a loop without time, however many a paused run takes.
            self.steps_at_now = 0;
        }
        match control {
            Control::Stop => {
                let reached = if self.pacer.is_paced() { self.pacer.now(self.now, instant) } else { self.now };
                return Ok(Some(Waited::Stop(reached)));
            }
            Control::Quiet => {
                self.expecting = false;
                return Ok(Some(Waited::Changed));
            }
            // The wait begins again, and takes the inputs of live sources then.
            Control::Look => {}
            Control::Pace(pace) => {
                let now = self.pacer.now(self.now, instant);
                self.pacer.set(pace, now).map_err(RunError::Options)?;
                self.tell_pace(now)?;
            }
            Control::Command(command) => return self.obey(&command, instant),
            Control::Input(kind) => self.take_in(Input::new(instant, kind))?,
            Control::InputFor(agent, kind) => {
                self.take_in(Input { at: instant, kind, agent: Some(agent), command_form: None })?;
            }
        }
        Ok(None)
    }

    /// Reports to the agents a pace above that of the wall clock, because planners take wall time (decision 0268).
    pub(super) fn tell_pace(&mut self, now: Time) -> Result<(), RunError> {
        let pace = self.pacer.pace().map_or(1.0, |pace| pace.max(1.0));
        if self.hold_for_solvers || pace.total_cmp(&self.known_pace).is_eq() {
            return Ok(());
        }
        self.known_pace = pace;
        let kind = EventKind::Measurement(StateVariable::mission_pace(), Value::Real(pace));
        self.group.deliver(Input::new(now, kind))
    }

    /// Takes an input that arrives while the run waits: its instant is the present one.
    fn take_in(&mut self, mut input: Input) -> Result<(), RunError> {
        input.at = self.pacer.now(self.now, input.at);
        match self.group.check(&input) {
            Ok(()) => self.group.deliver(input),
            Err(error) => {
                let (now, text) = (input.at, error.to_string());
                self.each_observer(now, |observer| observer.note(now, &text))
            }
        }
    }

    /// Waits for at most `wait` for a message from outside, or until solvers must be polled for answers.
    fn hear(&mut self, wait: Wait) -> Result<Option<Control>, RunError> {
        let wait = match wait {
            Wait::For(span) if self.pool.is_waiting() => Wait::For(span.min(SOLVER_LOOK)),
            other => other,
        };
        let Some(controls) = &self.controls else {
            return match wait {
                Wait::Over => Ok(None),
                Wait::For(span) => {
                    self.pacer.sleep(span);
                    Ok(None)
                }
                Wait::Paused => {
                    Err(RunError::Options("the run is paused and no operator is connected to resume it".into()))
                }
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
}
