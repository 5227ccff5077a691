//! Effects: the only output of the executive. Commands, solver requests, output and decisions are all effects.

use crate::because::Because;
use crate::event::{Message, StateVariable};
use crate::source::Place;
use crate::symbol::Symbol;
use crate::task::{Outcome, TaskId, TaskState};
use crate::time::{Duration, Time};
use crate::value::Value;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Number of a command, from a counter of the agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct CommandId(pub u64);

/// Number of a request to a solver, from a counter of the agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct SolveRequestId(pub u64);

/// Number of a question to the operator, from a counter of the agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct QuestionId(pub u64);

/// Request or report of the executive to the outside, in the order decided.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Effect {
    /// A decision, with its cause. Every change of a task's state is one.
    Decided(Decision),
    /// Send this form to the vehicle; answered by `CommandAcknowledged`.
    Command {
        /// Number of the command, which its answer repeats.
        command: CommandId,
        /// The primitive's task.
        task: TaskId,
        /// The ground form, for example `(fly-to (34.7 -119.8 7010))`.
        form: Value,
        /// Cause, with the form of PDL that led to it.
        because: Because,
    },
    /// The command's task ended or was interrupted before the answer: the vehicle should stop executing the command.
    WithdrawCommand {
        /// The command.
        command: CommandId,
        /// Reason, for the record.
        reason: String,
    },
    /// Run a solver; answered by `SolverReported`.
    Solve(SolveRequest),
    /// No task waits for this answer any longer.
    CancelSolve(SolveRequestId),
    /// `(inform FORM)`: a message for receivers outside of the application. The agent itself receives it as an event too.
    Inform {
        /// Sending task.
        task: TaskId,
        /// Form of the message.
        form: Value,
    },
    /// `(print ..)`.
    Print {
        /// Printing task.
        task: TaskId,
        /// The text.
        text: String,
    },
    /// `(ask operator ..)`; answered by `OperatorAnswered`.
    Ask {
        /// Number of the question, which its answer repeats.
        question: QuestionId,
        /// Asking task.
        task: TaskId,
        /// The question.
        text: String,
        /// Choices.
        options: Vec<Value>,
        /// Instant at which the operator's time is over.
        by: Option<Time>,
        /// Answer that is taken at that instant; `None`: the task fails.
        default: Option<Value>,
    },
    /// The application is over: by `(end-application)`, or because the root task of its only agent ended.
    EndApplication {
        /// Reason.
        reason: String,
    },
    /// A message or sample for other agents of the application: by `(cogevent FORM agent)`, or by `inform` and `publish` along routers.
    /// It arrives at the same instant.
    Tell {
        /// Sending task.
        task: TaskId,
        /// Receivers in the order of their declarations, each once.
        to: Vec<Symbol>,
        /// Message.
        message: Message,
    },
    /// No task waits for the answer to this question any longer: its task ended or was interrupted, or its time is over.
    WithdrawQuestion {
        /// The question.
        question: QuestionId,
        /// Reason, for the record and the operator.
        reason: String,
    },
    /// This agent has ended, because its root task ended; the application's other agents continue.
    AgentEnded {
        /// Reason.
        reason: String,
    },
    /// `(publish (ATTRIBUTE OBJECT) VALUE)`: a sample of the agent itself, which its histories hold from this instant on.
    Publish {
        /// The task whose clause published it.
        task: TaskId,
        /// The state variable.
        variable: StateVariable,
        /// The value, in the declared unit.
        value: Value,
        /// The clause, and the place of the form.
        because: Because,
    },
}

/// A request to plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolveRequest {
    /// Number of the request, which its answer repeats.
    pub request: SolveRequestId,
    /// The task whose goal no procedure matched.
    pub task: TaskId,
    /// The ground goal.
    pub goal: Value,
    /// The chosen solver's name, or `auto`.
    pub solver: Symbol,
    /// Deliberation time; `None` for the runtime's default.
    pub budget: Option<Duration>,
    /// True if the program handles a failure of the request: by `on-failure` here or above, or by a clause that names the failure.
    pub is_failure_handled: bool,
}

/// One decision of the executive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    /// The task concerned; `None` for decisions about the whole agent.
    pub task: Option<TaskId>,
    /// Decision.
    pub kind: DecisionKind,
    /// Cause.
    pub because: Because,
}

/// Kind of a decision, with its data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum DecisionKind {
    /// A task was created, in state pending.
    Created {
        /// Its parent; `None` for the root.
        parent: Option<TaskId>,
        /// The step's tag.
        tag: Symbol,
        /// The goal with its known values; unbound variables remain `?x` symbols.
        goal: Value,
        /// The step.
        place: Option<Place>,
    },
    /// A task changed state. The cause states which rule of its life cycle applied.
    Transition {
        /// State before the transition.
        from: TaskState,
        /// State after the transition.
        to: TaskState,
        /// Outcome of the task; `None` unless `to` is terminated.
        outcome: Option<Outcome>,
    },
    /// A monitor's condition became true.
    Satisfied {
        /// Clause: `waitfor`, `end-when`, ..
        clause: Cow<'static, str>,
        /// From the earliest to the latest instant of the evidence.
        interval: (Time, Time),
    },
    /// A variable got a value in a task's context.
    Bound {
        /// The name without `?`.
        variable: Symbol,
        /// The value.
        value: Value,
    },
    /// A way to pursue the goal was selected.
    Selected {
        /// Procedure, primitive, built-in or solver.
        method: Method,
        /// The goal, now ground.
        goal: Value,
        /// Other methods that matched, less specific or later in the library.
        alternatives: Vec<Method>,
    },
    /// The task keeps its state for lack of resources: it lost a conflict, or the holder defends its resource.
    Refused {
        /// The resource.
        resource: Value,
        /// Task that holds or gets the resource.
        winner: TaskId,
    },
    /// A procedure was added to the library from a plan.
    ProcedureAdded {
        /// The request it answers.
        request: SolveRequestId,
        /// One line about the plan.
        summary: String,
        /// The plan as PDL text.
        pdl: String,
    },
    /// An error inside an expression, a reached limit, or an answer without a question.
    Trouble {
        /// Message.
        message: String,
    },
}

/// A way to pursue a goal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Method {
    /// A procedure at this place.
    Procedure(Place),
    /// A primitive at this place.
    Primitive(Place),
    /// A built-in activity.
    BuiltIn,
    /// A solver by name.
    Solver(Symbol),
}
