//! Evaluation of expressions (`pdl.md` section 6): a small total language over values.
//!
//! One file per family of functions. [`evaluate`] is pure; [`run`] evaluates the forms of a hook and collects what they
//! want done as [`Action`]s. Every evaluation is bounded by the limits of `apex_model::limits`.

mod surroundings;

pub use surroundings::{Surroundings, WithBindings};

use apex_model::bindings::Bindings;
use apex_model::event::StateVariable;
use apex_model::expression::{Expr, Template};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;

/// Why an expression has no value: a sentence for people and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct EvaluationError {
    /// What went wrong, with the values concerned, and what to do.
    pub message: String,
    /// Where.
    pub place: Place,
}

/// What a hook's forms want done, in order.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// `(inform FORM)`.
    Inform(Value),
    /// `(print ..)`.
    Print(String),
    /// `(command FORM [:timeout D])`, or a call of a host function declared `:command t`.
    Command {
        /// The ground form.
        form: Value,
        /// How long to wait for the answer; none is the default.
        timeout: Option<Duration>,
    },
    /// `(publish (ATTR OBJ) value)`.
    Publish(StateVariable, Value),
    /// `(complete [value])`.
    Complete(Value),
    /// `(setq ?x value)`.
    SetTaskVariable(Symbol, Value),
    /// `(cogevent FORM [agent])`.
    Cogevent(Value, Option<Value>),
    /// `(end-application [reason])`.
    EndApplication(Option<Value>),
}

/// The value of `expr`. Has no effect; a form that acts is an error here.
///
/// # Errors
/// A message for people when a variable is unbound, an argument is of the wrong kind or dimension, or a limit is reached.
pub fn evaluate(expr: &Expr, surroundings: &dyn Surroundings) -> Result<Value, EvaluationError> {
    let _ = surroundings;
    Err(EvaluationError { message: "no evaluator".into(), place: expr.place })
}

/// The value of `template` with its holes filled.
///
/// # Errors
/// As [`evaluate`]; an unbound variable is an error.
pub fn instantiate(template: &Template, surroundings: &dyn Surroundings) -> Result<Value, EvaluationError> {
    let _ = (template, surroundings);
    Ok(Value::nil())
}

/// The value of `template` where a hole that has no value yet is shown as it is written (`?x`).
pub fn instantiate_partially(template: &Template, surroundings: &dyn Surroundings) -> Value {
    let _ = (template, surroundings);
    Value::nil()
}

/// Evaluates the forms of a hook in order; the value is the last form's. `locals` are the primitive's variables, which
/// `setq` changes; what the forms want done is appended to `actions`. On an error the actions so far stay.
///
/// # Errors
/// As [`evaluate`].
pub fn run(
    forms: &[Expr],
    surroundings: &dyn Surroundings,
    locals: &mut Bindings,
    actions: &mut Vec<Action>,
) -> Result<Value, EvaluationError> {
    let _ = (forms, surroundings, locals, actions);
    Ok(Value::nil())
}

/// `values` as `(print ..)` shows them: strings without quotes, one blank between.
pub fn printed(values: &[Value]) -> String {
    values.iter().map(display).collect::<Vec<_>>().join(" ")
}

/// A value as people read it: a string without its quotes.
pub fn display(value: &Value) -> String {
    match value {
        Value::Text(text) => text.to_string(),
        other => other.to_string(),
    }
}
