//! The ports of the runtime: the traits of a vehicle, a source of planning problems and an observer of a run.
//!
//! One trait per border. Adapters implement [`Vehicle`]; the command and tests implement the others.

use crate::target_state::TargetChange;
use apex_executive::state::agent::Agent;
use apex_model::effect::{CommandId, Effect, SolveRequest, SolveRequestId};
use apex_model::event::{Batch, EventKind};
use apex_model::planned::PlannedProcedure;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// An input before the inbox numbers it.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// Instant of the event, in mission time.
    pub at: Time,
    /// Content.
    pub kind: EventKind,
    /// Name of the agent for which it is; `None` for every agent. Answers go to the agent that asked.
    pub agent: Option<Symbol>,
    /// The form of the command, for an acknowledgement that identifies its command by form instead of number. Its number is known when
    /// the command is sent ([`crate::program`]).
    pub command_form: Option<Value>,
}

impl Input {
    /// Returns an input for every agent.
    pub fn new(at: Time, kind: EventKind) -> Input {
        Input { at, kind, agent: None, command_form: None }
    }
}

/// A controlled system: the built-in simulator, a simulator elsewhere, or an autopilot behind a link.
pub trait Vehicle {
    /// Returns the instant of its next report; `None` if it is unknown (only simulators know it).
    fn next_report(&self) -> Option<Time>;

    /// Advances the vehicle to `to` (never backwards) and returns its reports in order of time, none later than `to`.
    ///
    /// # Errors
    /// A message if the link is lost.
    fn advance(&mut self, to: Time, inputs: &mut Vec<Input>) -> Result<(), String>;

    /// Sends a command, for example `(fly-to (34.7 -119.8 7010))`. The answer is a `CommandAcknowledged` of a later [`Vehicle::advance`],
    /// also for refused commands.
    fn command(&mut self, command: CommandId, form: &Value, at: Time);

    /// Withdraws a command that is still being carried out.
    fn withdraw(&mut self, command: CommandId, at: Time);

    /// Returns true if a command has effects outside of this program at once. The observers then store the step first
    /// ([`Observer::flush`]), so that the record contains every command that a vehicle obeys. False for simulated vehicles and for links
    /// that hold commands until they are flushed themselves.
    fn acts_outside(&self) -> bool {
        true
    }
}

/// A solver's answer to one request.
#[derive(Clone, Debug, PartialEq)]
pub struct SolverAnswer {
    /// The plan as a procedure, or the reason why there is none.
    pub result: Result<PlannedProcedure, String>,
    /// Deliberation time to charge in simulation.
    pub charged: Duration,
}

/// The mission next to the executive: poses planning problems from its situation at an instant.
///
/// All calls come from the thread of the flight, in the order of the steps, so that a problem depends on the recorded
/// inputs and effects only. Solving is a separate [`SolverJob`], on any thread.
pub trait Deliberator {
    /// Observes one step of the agent with this number, before its effects are sent. The situation afterwards is a function of all
    /// observed steps.
    fn observe(&mut self, agent: usize, batch: &Batch, effects: &[Effect]) {
        let _ = (agent, batch, effects);
    }

    /// Returns inputs that the mission derives from the observed step: inputs of the same instant for the next batch, recorded like all
    /// others. They must be a function of the observed steps, so that replay derives the same.
    fn derive(&mut self) -> Vec<Input> {
        Vec::new()
    }

    /// Poses the problem that answers `request`, made at `at`. Must not change the situation.
    fn pose(&mut self, request: &SolveRequest, at: Time) -> Posed;

    /// Returns the situation now, encoded for a snapshot; `None` without a mission.
    fn snapshot(&self) -> Option<Vec<u8>> {
        None
    }

    /// Returns the layout of the situation in snapshots, which changes with the types in it; `None` without a mission.
    fn layout(&self) -> Option<&'static str> {
        None
    }

    /// Returns all changes of targets' states so far, in order.
    fn target_changes(&self) -> &[TargetChange] {
        &[]
    }
}

/// A posed problem, and the job that solves it.
pub struct Posed {
    /// The problem as JSON, for the record: everything on which the answer depends. Replay poses it again and compares both.
    pub problem: String,
    /// The job.
    pub job: Box<dyn SolverJob>,
}

impl Posed {
    /// Returns a problem with the job that solves it.
    pub fn new(problem: String, job: impl FnOnce(&CancelToken) -> SolverAnswer + Send + 'static) -> Posed {
        Posed { problem, job: Box::new(job) }
    }

    /// Returns a problem that cannot be posed for this reason: the request fails at once.
    pub fn failed(reason: String) -> Posed {
        let problem = serde_json::json!({ "no_problem": reason }).to_string();
        Posed::new(problem, |_| SolverAnswer { result: Err(reason), charged: Duration::ZERO })
    }
}

/// Solves one posed problem. Must not read the clock in simulation: [`SolverAnswer::charged`] counts work units.
///
/// Once cancelled, the answer is not used: the job should end soon.
pub trait SolverJob: Send {
    /// Does the work.
    fn run(self: Box<Self>, cancel: &CancelToken) -> SolverAnswer;
}

impl<F: FnOnce(&CancelToken) -> SolverAnswer + Send> SolverJob for F {
    fn run(self: Box<Self>, cancel: &CancelToken) -> SolverAnswer {
        self(cancel)
    }
}

/// Works on jobs in parallel to the flight. Only [`SolverQueue::recv`] waits.
pub trait SolverQueue {
    /// Queues the job that answers `request`; `solver` names it in messages.
    ///
    /// # Errors
    /// An error message if no worker accepts jobs.
    fn submit(&mut self, request: SolveRequestId, solver: &Symbol, job: Box<dyn SolverJob>) -> Result<(), String>;

    /// Cancels a request. Its answer still arrives, but earlier.
    fn cancel(&mut self, request: SolveRequestId);

    /// Returns an answer that has arrived.
    fn try_recv(&mut self) -> Option<(SolveRequestId, SolverAnswer)>;

    /// Waits for the next answer, at most for the queue's timeout. `None` if no request is open.
    fn recv(&mut self) -> Option<(SolveRequestId, SolverAnswer)>;
}

/// Cancellation token of one solver request. Clones share one flag.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// Returns a token that is not cancelled.
    pub fn new() -> CancelToken {
        CancelToken::default()
    }

    /// Cancels the request.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// Returns true after [`CancelToken::cancel`].
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}

/// Sees every step of a run, live: recorder, progress bar, Sherpa and mission bookkeeping are observers.
///
/// If several agents run, `turn` announces the agent of the following calls. The calls for a step are `begin`, (the executive computes),
/// `observe`, (the effects are sent), `inspect`. An error of any call is a message that states why continuing would lose data, such as an
/// unwritable record; the run then stops.
pub trait Observer {
    /// Announces the agent whose steps follow, by its number in order of declaration from 0.
    ///
    /// # Errors
    /// A message; the run stops.
    fn turn(&mut self, agent: usize) -> Result<(), String> {
        let _ = agent;
        Ok(())
    }

    /// Receives the batch that is about to be executed: recorders store inputs before they are used.
    ///
    /// # Errors
    /// A message; the run stops.
    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        let _ = batch;
        Ok(())
    }

    /// Receives one executive step: the batch and its effects, before they are sent.
    ///
    /// # Errors
    /// A message if continuing would lose data (an unwritable record); the run stops.
    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String>;

    /// Receives the agent after the step, for snapshots; `deliberator` has observed the same step.
    ///
    /// # Errors
    /// An error message; the run stops.
    fn inspect(&mut self, agent: &Agent, deliberator: &dyn Deliberator, now: Time) -> Result<(), String> {
        let _ = (agent, deliberator, now);
        Ok(())
    }

    /// Receives a planning problem that was posed at `at` for `request`, before a solver works on it. The request has its outside number.
    ///
    /// # Errors
    /// An error message; the run stops.
    fn posed(&mut self, request: &SolveRequest, at: Time, problem: &str) -> Result<(), String> {
        let _ = (request, at, problem);
        Ok(())
    }

    /// Receives the answer of a solver to `request`, which takes effect at `due`. It is stored even if it arrives too late to be used.
    ///
    /// # Errors
    /// An error message; the run stops.
    fn answered(&mut self, request: SolveRequestId, due: Time, answer: &SolverAnswer) -> Result<(), String> {
        let _ = (request, due, answer);
        Ok(())
    }

    /// Receives a decision of the runtime, for example that a solver's answer was dropped.
    ///
    /// # Errors
    /// A message; the run stops.
    fn note(&mut self, at: Time, text: &str) -> Result<(), String> {
        let _ = (at, text);
        Ok(())
    }

    /// Writes everything that is held back, because the run is about to sleep or to end.
    ///
    /// # Errors
    /// A message; the run stops.
    fn flush(&mut self) -> Result<(), String> {
        Ok(())
    }

    /// Returns the next message of the observer to the agents; `None` if there are no more.
    fn take_news(&mut self) -> Option<News> {
        None
    }

    /// Receives a message of an observer, after its note.
    ///
    /// # Errors
    /// A message; the run stops.
    fn hear_news(&mut self, at: Time, news: &News) -> Result<(), String> {
        let _ = (at, news);
        Ok(())
    }
}

/// A message of an observer for the agents and the operators.
#[derive(Clone, Debug, PartialEq)]
pub struct News {
    /// The message to all agents, as an input.
    pub message: Value,
    /// The same for operators.
    pub note: String,
}

/// A shared observer, so that mission bookkeeping can write its rows into the recorder of a running mission.
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
    fn inspect(&mut self, agent: &Agent, deliberator: &dyn Deliberator, now: Time) -> Result<(), String> {
        self.lock().unwrap_or_else(PoisonError::into_inner).inspect(agent, deliberator, now)
    }
    fn posed(&mut self, request: &SolveRequest, at: Time, problem: &str) -> Result<(), String> {
        self.lock().unwrap_or_else(PoisonError::into_inner).posed(request, at, problem)
    }
    fn answered(&mut self, request: SolveRequestId, due: Time, answer: &SolverAnswer) -> Result<(), String> {
        self.lock().unwrap_or_else(PoisonError::into_inner).answered(request, due, answer)
    }
    fn note(&mut self, at: Time, text: &str) -> Result<(), String> {
        self.lock().unwrap_or_else(PoisonError::into_inner).note(at, text)
    }
    fn flush(&mut self) -> Result<(), String> {
        self.lock().unwrap_or_else(PoisonError::into_inner).flush()
    }
    fn take_news(&mut self) -> Option<News> {
        self.lock().unwrap_or_else(PoisonError::into_inner).take_news()
    }
    fn hear_news(&mut self, at: Time, news: &News) -> Result<(), String> {
        self.lock().unwrap_or_else(PoisonError::into_inner).hear_news(at, news)
    }
}
