//! Results of evaluation: values or errors, and the actions that the forms of a hook request.

use apex_model::event::StateVariable;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;

/// An expression without a value: a message and its place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct EvaluationError {
    /// Failure, with the values concerned and the remedy.
    pub(crate) message: String,
    /// Position in the PDL text.
    pub(crate) place: Place,
}

/// Value of an evaluated form, or the error.
pub(super) type EvalResult = Result<Value, EvaluationError>;

/// Value of a built-in function for its arguments, or an error message; the evaluator adds the place of the call.
pub(super) type FunctionResult = Result<Value, String>;

/// Actions that a hook's forms request, in order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Action {
    /// `(inform FORM [router])`.
    Inform(Value, Option<Value>),
    /// `(print ..)`.
    Print(String),
    /// `(command FORM [:timeout D])`, or a call of a host function declared `:command t`.
    Command {
        /// The form, with every variable replaced by its value.
        form: Value,
        /// Time limit for the answer; `None`: the default.
        timeout: Option<Duration>,
        /// Position in the PDL text.
        place: Place,
    },
    /// `(publish (ATTR OBJ) value [router])`.
    Publish {
        /// The state variable.
        variable: StateVariable,
        /// The value.
        value: Value,
        /// The only router that receives it; the author does not receive it then. `None`: every router of the author.
        router: Option<Value>,
        /// Position in the PDL text.
        place: Place,
    },
    /// `(replenish RESOURCE [amount])`.
    Replenish {
        /// The resource.
        resource: Value,
        /// Amount to add; `None` fills the resource.
        amount: Option<Value>,
        /// Place of the form.
        place: Place,
    },
    /// `(complete [value])`.
    Complete(Value),
    /// `(setq ?x value)`.
    SetTaskVariable(Symbol, Value),
    /// `(cogevent FORM [agent])`.
    Cogevent(Value, Option<Value>),
    /// `(end-application [reason])`.
    EndApplication(Option<Value>),
}
