//! Nouns back to PDL text that loads again. Flat text is made here; [`crate::format`] lays it out.

mod condition;
mod expression;
mod procedure;
mod value;

pub(crate) use expression::{pattern_text, template_text};
pub use procedure::{PrintedPlan, print_plan, print_primitive, print_procedure};

use apex_model::condition::Condition;
use apex_model::expression::Expr;

/// The condition as PDL.
pub fn print_condition(condition: &Condition) -> String {
    laid_out(condition::condition_text(condition))
}

/// The expression as PDL.
pub fn print_expression(expr: &Expr) -> String {
    laid_out(expression::expression_text(expr))
}

/// Lays `text` out. Printed text is always well formed; if it were not, it would still be better than nothing.
fn laid_out(text: String) -> String {
    laid_out_steps(text).0
}

/// As [`laid_out`], with the lines of the steps.
fn laid_out_steps(text: String) -> (String, Vec<u32>) {
    match crate::format::format_steps(&text) {
        Ok((formatted, steps)) => (formatted.trim_end().to_string(), steps),
        Err(_) => (text, Vec::new()),
    }
}

/// `(head part..)`, empty parts left out.
pub(crate) fn list_text(head: &str, parts: impl IntoIterator<Item = String>) -> String {
    let mut text = format!("({head}");
    for part in parts.into_iter().filter(|part| !part.is_empty()) {
        if text.len() > 1 {
            text.push(' ');
        }
        text.push_str(&part);
    }
    text.push(')');
    text
}

/// ` part part ..` joined by blanks.
pub(crate) fn joined(parts: impl IntoIterator<Item = String>) -> String {
    parts.into_iter().collect::<Vec<_>>().join(" ")
}
