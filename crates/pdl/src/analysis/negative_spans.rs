//! Spans of time that are always below zero: the task that takes one fails. Literals are reported where they are read.

use super::constant_number::constant_number;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::locate::Locator;
use crate::print::pattern_text;
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::procedure::Step;
use apex_model::quantity::Dimension;
use apex_model::source::Place;
use apex_model::value::Value;

/// Returns the finding about the duration or interval of a primitive.
pub(super) fn of_primitive(library: &Library, expr: &Expr, locator: &mut Locator<'_>) -> Option<Diagnostic> {
    let (number, dimension) = constant_number(library, expr)?;
    if number >= 0.0 || dimension != Dimension::TIME || matches!(expr.kind, ExprKind::Constant(_)) {
        return None;
    }
    let message = format!("this is always {}, a negative span of time", Value::measured(number, dimension));
    let diagnostic = Diagnostic::error(codes::DURATION_EXPECTED, locator.span(expr.place), message);
    Some(diagnostic.help("write a duration of at least 0"))
}

/// Returns the finding about a word of a goal that the primitive which serves it takes as a duration.
pub(super) fn of_goal(step: &Step, needed: Place, served: &Pattern, locator: &mut Locator<'_>) -> Diagnostic {
    let index = pattern_text(served);
    let message = format!("`{index}` needs a span of time of at least 0, but this goal has a negative one");
    Diagnostic::error(codes::DURATION_EXPECTED, locator.activity(step.place), message)
        .label(locator.span(needed), "a negative span fails here")
        .help("write a span of at least 0, such as `(max 0s ..)`")
}
