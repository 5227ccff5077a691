//! The ports of the shell: what a vehicle, a source of planning problems and an observer of a run must offer.
//!
//! One trait per border. Adapters implement [`Vehicle`]; the command and tests implement the others.

use apex_model::agent::Agent;
use apex_model::effect::{CommandId, Effect, SolveRequest, SolveRequestId};
use apex_model::event::{Batch, EventKind, PlannedProcedure};
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Something that came in, before the inbox numbers it.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// When it happened, in mission time.
    pub at: Time,
    /// What.
    pub kind: EventKind,
    /// The agent that it is for, by name; none is every agent. Answers find whoever asked.
    pub agent: Option<Symbol>,
}

impl Input {
    /// An input for every agent.
    pub fn new(at: Time, kind: EventKind) -> Input {
        Input { at, kind, agent: None }
    }
}

/// A controlled system: the built-in simulator, a simulator elsewhere, or an autopilot behind a link.
pub trait Vehicle {
    /// When it will next have something to say by itself, if it knows (simulators do).
    fn next_report(&self) -> Option<Time>;

    /// Lets it live until `to` (never backwards) and collects what it says, in order of time, none later than `to`.
    ///
    /// # Errors
    /// A sentence when the link is beyond repair.
    fn advance(&mut self, to: Time, inputs: &mut Vec<Input>) -> Result<(), String>;

    /// Sends a command, for example `(fly-to (34.7 -119.8 7010))`. The answer comes as `CommandAcknowledged`
    /// out of a later [`Vehicle::advance`], also for commands it refuses.
    fn command(&mut self, command: CommandId, form: &Value, at: Time);

    /// Withdraws a command that is still being carried out.
    fn withdraw(&mut self, command: CommandId, at: Time);
}

/// What the pool brings back for one request.
#[derive(Clone, Debug, PartialEq)]
pub struct SolverAnswer {
    /// The plan as a procedure, or the reason why there is none.
    pub result: Result<PlannedProcedure, String>,
    /// Deliberation time to charge in simulation.
    pub charged: Duration,
}

/// Turns a request's goal into a planning problem, solves and translates. The mission knows targets, weather and
/// vehicle; the runtime only knows when to ask and when the answer counts.
pub trait Deliberator {
    /// Answers `request`, made at `at`. Must not touch the clock in simulation: `charged` counts work units.
    /// Once withdrawn, nobody uses the answer: it should come soon, and change nothing.
    fn deliberate(&mut self, request: &SolveRequest, at: Time, withdrawal: &Withdrawal) -> SolverAnswer;

    /// Where requests can be left without waiting for their answers; none where there is only [`Deliberator::deliberate`].
    fn desk(&mut self) -> Option<&mut dyn SolverDesk> {
        None
    }
}

/// Takes requests of a flight that does not wait for its solvers. No call but [`SolverDesk::wait`] waits.
pub trait SolverDesk {
    /// Leaves `request`, made at `at`, to be answered.
    ///
    /// # Errors
    /// A sentence when nobody is there to answer it.
    fn hand_over(&mut self, request: &SolveRequest, at: Time) -> Result<(), String>;

    /// Says that the answer is not wanted any more; it comes all the same, sooner.
    fn withdraw(&mut self, request: SolveRequestId);

    /// An answer that has come.
    fn take(&mut self) -> Option<(SolveRequestId, SolverAnswer)>;

    /// Waits for the next answer, as long as solvers are waited for. None when nothing is open, or nobody answers any more.
    fn wait(&mut self) -> Option<(SolveRequestId, SolverAnswer)>;
}

/// Tells whoever deliberates that the answer is not wanted any more. Copies tell each other.
#[derive(Clone, Debug, Default)]
pub struct Withdrawal(Arc<AtomicBool>);

impl Withdrawal {
    /// Of a request that is wanted.
    pub fn new() -> Withdrawal {
        Withdrawal::default()
    }

    /// The answer is not wanted any more.
    pub fn withdraw(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// True when the answer is not wanted any more.
    pub fn is_withdrawn(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}

/// Sees every step of a run, live: recorder, progress bar, Sherpa and mission bookkeeping are observers.
///
/// Where several agents run, `turn` tells before the other calls whose step they are about.
/// Per step the calls are `begin`, (the executive works), `observe`, (the effects go out), `inspect`.
/// An error of any call is a sentence that says why going on would lose data (an unwritable record); the run stops.
pub trait Observer {
    /// The agent with this number, in order of declaration from 0, steps from now on.
    ///
    /// # Errors
    /// A sentence; the run stops.
    fn turn(&mut self, agent: usize) -> Result<(), String> {
        let _ = agent;
        Ok(())
    }

    /// The batch that is about to be executed: recorders store inputs before they are used.
    ///
    /// # Errors
    /// A sentence; the run stops.
    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        let _ = batch;
        Ok(())
    }

    /// One executive step: the batch that went in and the effects that came out, before they are sent.
    ///
    /// # Errors
    /// A sentence when going on would lose data (an unwritable record); the run stops.
    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String>;

    /// The agent after the step, for snapshots.
    ///
    /// # Errors
    /// A sentence; the run stops.
    fn inspect(&mut self, agent: &Agent, now: Time) -> Result<(), String> {
        let _ = (agent, now);
        Ok(())
    }

    /// Something that the shell itself decided, for example a solver's answer that was dropped.
    ///
    /// # Errors
    /// A sentence; the run stops.
    fn note(&mut self, at: Time, text: &str) -> Result<(), String> {
        let _ = (at, text);
        Ok(())
    }

    /// The run is about to sleep or to end: whatever is held back should go out now.
    ///
    /// # Errors
    /// A sentence; the run stops.
    fn flush(&mut self) -> Result<(), String> {
        Ok(())
    }
}

/// A shared observer, so that mission bookkeeping can write rows of its own into the recorder of a running mission.
impl<O: Observer + ?Sized> Observer for Arc<Mutex<O>> {
    fn turn(&mut self, agent: usize) -> Result<(), String> {
        self.lock().unwrap_or_else(PoisonError::into_inner).turn(agent)
    }
    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        self.lock().unwrap_or_else(PoisonError::into_inner).begin(batch)
    }
    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        self.lock().unwrap_or_else(PoisonError::into_inner).observe(batch, effects)
    }
    fn inspect(&mut self, agent: &Agent, now: Time) -> Result<(), String> {
        self.lock().unwrap_or_else(PoisonError::into_inner).inspect(agent, now)
    }
    fn note(&mut self, at: Time, text: &str) -> Result<(), String> {
        self.lock().unwrap_or_else(PoisonError::into_inner).note(at, text)
    }
    fn flush(&mut self) -> Result<(), String> {
        self.lock().unwrap_or_else(PoisonError::into_inner).flush()
    }
}
