//! Evaluation of expressions (`pdl.md`, Forms): a small total language over values.
//!
//! One file per family of functions. [`evaluate`] is pure; [`run`] evaluates the forms of a hook and collects the requested [`Action`]s.
//! The limits of `apex_model::limits` bound every evaluation.

pub(crate) mod arithmetic;
pub(crate) mod comparison;
pub(crate) mod declared_unit;
pub(crate) mod effects;
pub(crate) mod eval_context;
pub(crate) mod evaluator;
pub(crate) mod higher_order;
pub(crate) mod history_queries;
pub(crate) mod lists;
pub(crate) mod result;
pub(crate) mod rounding;
pub(crate) mod strings;
pub(crate) mod templates;
#[cfg(test)]
mod tests;
pub(crate) mod time_functions;
pub(crate) mod view;

pub(crate) use eval_context::{EvalContext, WithBindings};
pub(crate) use result::{Action, EvaluationError};

use evaluator::{Evaluator, Hook};

use crate::state::bindings::Bindings;
use apex_model::expression::{Expr, Template};
use apex_model::limits::TEXT_CHARACTERS_MAX;
use apex_model::value::Value;
use std::fmt::Write;

/// Returns the value of `expr`. Has no effect; a form that acts is an error here.
///
/// # Errors
/// An error message when a variable is unbound, an argument is of the wrong kind or dimension, or a limit is reached.
pub(crate) fn evaluate(expr: &Expr, context: &dyn EvalContext) -> Result<Value, EvaluationError> {
    Evaluator::new(context, None).value(expr)
}

/// Returns the value of `template` with its holes filled.
///
/// # Errors
/// Like [`evaluate`]; an unbound variable is an error.
pub(crate) fn instantiate(template: &Template, context: &dyn EvalContext) -> Result<Value, EvaluationError> {
    Evaluator::new(context, None).template(template, templates::place_of(template))
}

/// Returns the value of `template`; a hole without a value is shown as it is written (`?x`).
pub(crate) fn instantiate_partially(template: &Template, context: &dyn EvalContext) -> Value {
    templates::partially(template, context)
}

/// Returns `expr` with known variables replaced by their values; calls remain as they are written.
pub(crate) fn expression_as_known(expr: &Expr, context: &dyn EvalContext) -> Value {
    templates::as_known(expr, context)
}

/// Evaluates the forms of a hook in order and returns the value of the last one. `locals` are the primitive's variables, which `setq`
/// changes. The requested actions are appended to `actions`, also those before an error.
///
/// # Errors
/// Like [`evaluate`].
pub(crate) fn run(
    forms: &[Expr],
    context: &dyn EvalContext,
    locals: &mut Bindings,
    actions: &mut Vec<Action>,
) -> Result<Value, EvaluationError> {
    let hook = Hook { locals, actions, assigned: Bindings::new() };
    Evaluator::new(context, Some(hook)).body(forms)
}

/// Returns `values` as `(print ..)` shows them: strings without quotes, separated by one blank.
pub(crate) fn printed(values: &[Value]) -> String {
    let mut text = String::new();
    for value in values {
        let part = display(value);
        if !text.is_empty() && !text.ends_with(char::is_whitespace) && !part.starts_with(char::is_whitespace) {
            text.push(' ');
        }
        text.push_str(&part);
    }
    text
}

/// Returns a value in human-readable form: a string without its quotes. A text above the greatest length ends with `..`.
pub(crate) fn display(value: &Value) -> String {
    if let Value::Text(text) = value {
        return text.to_string();
    }
    let mut text = BoundedText(String::new());
    if write!(text, "{value}").is_err() {
        text.0.push_str(" ..");
    }
    text.0
}

/// A small value whose parts are shared can have a very long text, so the writer stops at the greatest length.
struct BoundedText(String);

impl Write for BoundedText {
    fn write_str(&mut self, part: &str) -> std::fmt::Result {
        if self.0.len() + part.len() > TEXT_CHARACTERS_MAX {
            return Err(std::fmt::Error);
        }
        self.0.push_str(part);
        Ok(())
    }
}
