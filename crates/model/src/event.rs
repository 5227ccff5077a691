//! Events: the only input of the executive. Telemetry, messages, acknowledgements, solver answers and wakes are all events.

use crate::effect::{CommandId, QuestionId, SolveRequestId};
use crate::planned::PlannedProcedure;
use crate::symbol::Symbol;
use crate::time::Time;
use crate::value::Value;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Input of one call of the executive's `step`. Events are in order of arrival, none later than `now`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Batch {
    /// The instant of this step.
    pub now: Time,
    /// Events since the last step.
    pub events: Vec<Event>,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// Arrival number, strictly increasing over the life of an agent; orders events of one instant.
    pub sequence: u64,
    /// Instant of the event; may be earlier than the step's `now`.
    pub at: Time,
    /// Kind and data.
    pub kind: EventKind,
}

/// Kinds of events.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum EventKind {
    /// A sample of a state variable (publish-subscribe input).
    Measurement(StateVariable, Value),
    /// A message (message-passing input), for example `(ready camera-1)`.
    Occurrence(Value),
    /// The vehicle completed a command, or refused or lost it.
    CommandAcknowledged(CommandId, Result<Value, String>),
    /// A solver answered.
    SolverReported(SolveRequestId, SolverReport),
    /// The operator answered.
    OperatorAnswered(QuestionId, Value),
    /// An instant has arrived at which the executive wanted to be called.
    Woken,
    /// A message or sample from another agent of the application.
    Told(Symbol, Message),
    /// The application ends, for this reason: all tasks are cut.
    Stop(String),
    /// The vehicle reports the progress of a command; its end is a `CommandAcknowledged`.
    CommandProgressed(CommandId, CommandProgress),
}

/// Progress of a command that the vehicle has not finished.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CommandProgress {
    /// The vehicle has taken the command.
    Accepted,
    /// The vehicle is executing it.
    InProgress,
}

impl CommandProgress {
    /// Returns the word in `(command-state ?step = accepted)` and in inputs.
    pub fn word(self) -> &'static str {
        match self {
            CommandProgress::Accepted => "accepted",
            CommandProgress::InProgress => "in-progress",
        }
    }

    /// Returns the progress with this word.
    pub fn named(word: &str) -> Option<CommandProgress> {
        [CommandProgress::Accepted, CommandProgress::InProgress].into_iter().find(|each| each.word() == word)
    }
}

/// Attribute of the state variable that holds the state of the last command of a task, `(command-state ?step)`: `sent`,
/// `accepted`, `in-progress`, `done`, `failed`, `timed-out` or `withdrawn`.
pub const COMMAND_STATE: &str = "command-state";

/// Attribute of the state variable with the pace of a run by the wall clock, `(mission-pace)`: seconds of mission time that pass in one
/// second of wall time. Only runs that are faster than the wall clock and do not wait for planners have it.
pub const MISSION_PACE: &str = "mission-pace";

/// Message from one agent to others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Message {
    /// A message.
    Occurrence(Value),
    /// A sample of a state variable.
    Measurement(StateVariable, Value),
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Message::Occurrence(form) => write!(f, "{form}"),
            Message::Measurement(variable, value) => write!(f, "{variable} = {value}"),
        }
    }
}

/// A state variable: an attribute of an object, for example `(altitude aircraft-1)`.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct StateVariable {
    /// The attribute.
    pub attribute: Symbol,
    /// The object: usually a symbol, a list for several objects, nil for none.
    pub object: Value,
}

/// Returns the measurement that a message `(ATTRIBUTE OBJECT.. = VALUE)` contains, as in the original Apex; else `None`.
pub fn measured(form: &Value) -> Option<(StateVariable, Value)> {
    let [attribute, objects @ .., relation, value] = form.as_list()? else { return None };
    let attribute = attribute.as_symbol().filter(|name| !name.folded().starts_with(':'))?;
    if !relation.as_symbol().is_some_and(|name| name.is("=")) {
        return None;
    }
    let object = match objects {
        [] => Value::nil(),
        [one] => one.clone(),
        several => Value::list(several.iter().cloned()),
    };
    Some((StateVariable::new(attribute.clone(), object), value.clone()))
}

impl StateVariable {
    /// Returns the variable `(attribute object)`; a whole real object is the integer, so that 2 and 2.0 name one variable.
    pub fn new(attribute: Symbol, object: Value) -> StateVariable {
        let object = match object {
            Value::Real(real) if libm::trunc(real) == real && real.abs() < 9e15 => Value::Integer(real as i64),
            other => other,
        };
        StateVariable { attribute, object }
    }

    /// Returns the variable `(mission-pace)`.
    pub fn mission_pace() -> StateVariable {
        StateVariable::new(Symbol::new(MISSION_PACE), Value::nil())
    }
}

impl StateVariable {
    /// Returns the variable as a list, `(altitude aircraft-1)`, with which topics of routers are compared.
    pub fn form(&self) -> Value {
        let attribute = Value::Symbol(self.attribute.clone());
        match &self.object {
            Value::List(items) => Value::list(std::iter::once(attribute).chain(items.iter().cloned())),
            object => Value::list([attribute, object.clone()]),
        }
    }
}

impl fmt::Display for StateVariable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.object {
            Value::List(items) if items.is_empty() => write!(f, "({})", self.attribute),
            Value::List(items) => {
                write!(f, "({}", self.attribute)?;
                items.iter().try_for_each(|item| write!(f, " {item}"))?;
                f.write_str(")")
            }
            object => write!(f, "({} {object})", self.attribute),
        }
    }
}

impl fmt::Debug for StateVariable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Answer of a solver, already checked by the pool.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum SolverReport {
    /// A plan as steps of a sequential procedure.
    Plan(PlannedProcedure),
    /// No plan, with the reason.
    Failed(String),
}
