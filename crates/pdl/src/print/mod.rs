//! Prints definitions as PDL text that can be loaded again. The printer of the model makes flat text; [`crate::format`] lays it out.

mod procedure;

pub use procedure::{PrintedPlan, print_plan, print_primitive, print_procedure};

use apex_forms::print::Style;
use apex_model::condition::Condition;
use apex_model::expression::{Expr, Template};
use apex_model::pattern::Pattern;

/// Returns the condition as PDL.
pub fn print_condition(condition: &Condition) -> String {
    laid_out(Style::Exact.condition(condition))
}

/// Returns the expression as PDL.
pub fn print_expression(expr: &Expr) -> String {
    laid_out(expression_text(expr))
}

/// Lays `text` out. Printed text is always well formed; if it were not, it would be returned unchanged.
fn laid_out(text: String) -> String {
    laid_out_steps(text).0
}

/// Like [`laid_out`], with the lines of the steps.
fn laid_out_steps(text: String) -> (String, Vec<u32>) {
    match crate::format::format_steps(&text) {
        Ok((formatted, steps)) => (formatted.trim_end().to_string(), steps),
        Err(_) => (text, Vec::new()),
    }
}

fn expression_text(expr: &Expr) -> String {
    Style::Exact.expression(expr)
}

/// Returns the template as flat text.
pub(crate) fn template_text(template: &Template) -> String {
    Style::Exact.template(template)
}

/// Returns the pattern as flat text.
pub(crate) fn pattern_text(pattern: &Pattern) -> String {
    Style::Exact.pattern(pattern)
}
