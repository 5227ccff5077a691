//! The options of a run, the orders of operators, and the end of a run.

use crate::authority::AuthorityBoard;
use crate::commands::Command;
use crate::input_stream::InputStream;
use crate::limits::{SOLVER_GRACE, SOLVER_TIMEOUT};
use crate::live::LiveSources;
use crate::pacing::{Clock, WallClock};
use crate::ports::Input;
use apex_model::event::EventKind;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::sync::Arc;
use std::sync::mpsc::Receiver;

/// Settings of a run.
#[derive(Debug)]
pub struct RunSettings {
    /// The last instant that is executed.
    pub until: Time,
    /// Mission seconds per second of wall time; `None` is as fast as possible, 0 waits for [`Control::Pace`].
    pub pace: Option<f64>,
    /// Clock that a pace follows: the wall clock, except in tests.
    pub clock: Arc<dyn Clock>,
    /// Inputs at known times in addition to those of the vehicle, such as a scenario or answers of an operator, in any order.
    pub inputs: Vec<Input>,
    /// Further inputs, read when they are needed. At one instant they follow the others.
    pub stream: Option<InputStream>,
    /// Answers of the operator to future questions; each answers one.
    pub answers: Vec<ScriptedAnswer>,
    /// Orders of operators during the run.
    pub controls: Option<Receiver<Control>>,
    /// Sources that are served by class and in turn; they wake the run by [`Control::Look`].
    pub live: Option<LiveSources>,
    /// Authority over the run, shared with the components that display it.
    pub authority: AuthorityBoard,
    /// Largest step of time for a vehicle whose next report is unknown; `None` if the other instants suffice.
    pub poll: Option<Duration>,
    /// True if mission time stops while a solver runs, even in a paced run: a simulated flight then does not depend on the pace.
    /// Otherwise a paced run continues, and a late answer takes effect when it arrives.
    pub hold_for_solvers: bool,
    /// Wall time after which a solver without an answer is abandoned, in runs that wait for it.
    pub solver_timeout: std::time::Duration,
}

impl Default for RunSettings {
    fn default() -> RunSettings {
        RunSettings {
            until: Time::END,
            pace: None,
            clock: Arc::new(WallClock::new()),
            inputs: Vec::new(),
            stream: None,
            answers: Vec::new(),
            controls: None,
            live: None,
            authority: AuthorityBoard::default(),
            poll: None,
            hold_for_solvers: false,
            solver_timeout: SOLVER_TIMEOUT + 10 * SOLVER_GRACE,
        }
    }
}

/// Answer of the operator to the first question with a certain text.
#[derive(Clone, Debug, PartialEq)]
pub struct ScriptedAnswer {
    /// Part of the question's text, in any case.
    pub question: String,
    /// The agent that asks; `None` for any agent.
    pub agent: Option<Symbol>,
    /// The answer.
    pub value: Value,
    /// Time that the operator takes.
    pub after: Duration,
}

/// Order from outside during a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Control {
    /// An input, now: an operator's answer, a message.
    Input(EventKind),
    /// An input for one agent.
    InputFor(Symbol, EventKind),
    /// Another pace; see [`RunSettings::pace`].
    Pace(Option<f64>),
    /// An operator's command, which ends as accepted, rejected or expired.
    Command(Arc<Command>),
    /// Live sources have inputs.
    Look,
    /// No further message follows except [`Control::Stop`]: the run need not wait for inputs.
    Quiet,
    /// End the run cleanly.
    Stop,
}

/// Reason for the end of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EndReason {
    /// `(end-application)` or the end of the initial task.
    Application {
        /// The agent's reason.
        reason: String,
        /// True if the initial task of an agent failed, whatever text the reason has.
        failed: bool,
        /// True if no initial task failed, and `(end-application)` cut that of an agent.
        cut: bool,
    },
    /// The time limit.
    Until,
    /// Nothing would ever happen again: no wake, no report, no answer, no input.
    Quiescent,
    /// [`Control::Stop`].
    Stopped,
}

impl EndReason {
    /// Returns true if the application ended without an order and its initial task did not fail.
    pub fn is_success(&self) -> bool {
        matches!(self, EndReason::Application { failed: false, .. })
    }

    /// Returns the reason as text, as stored under `end_reason` in the record.
    pub fn text(&self) -> String {
        match self {
            EndReason::Application { reason, .. } => reason.clone(),
            EndReason::Until => "the time limit was reached".into(),
            EndReason::Quiescent => "nothing more can happen: no wake, report, answer or input is left".into(),
            EndReason::Stopped => "it was stopped from outside".into(),
        }
    }
}

/// End of a run with its amount of work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunEnd {
    /// Mission time at the end.
    pub at: Time,
    /// Reason.
    pub reason: EndReason,
    /// Number of steps of the executive.
    pub steps: u64,
    /// Number of events that came in.
    pub events: u64,
    /// Number of effects that went out.
    pub effects: u64,
    /// Delay against wall time, if the run was paced.
    pub late: Lateness,
    /// Acknowledgements among the inputs that belong to no command that was sent, as text.
    pub unused: Vec<String>,
}

/// Delay of a paced run against wall time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lateness {
    /// Number of steps that came later than [`crate::limits::LATENESS_REPORTED_MIN`].
    pub steps: u64,
    /// The greatest delay, in wall time.
    pub worst: std::time::Duration,
}
