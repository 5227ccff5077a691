//! The printer of PDL forms: nouns back to flat PDL text.

mod condition;
mod cyclic;
mod expression;
mod value;

pub use expression::form_text;

use crate::value::Value;

/// Amount of detail with which a form is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Text that reads back as exactly the same noun.
    Exact,
    /// Text for traces and explanations: bodies are abbreviated as `..`, numbers are rounded, names are not quoted.
    Brief,
}

impl Style {
    /// Returns a value where holes are allowed: in exact text, symbols that would be read as holes are quoted.
    pub fn literal(self, value: &Value) -> String {
        match self {
            Style::Exact => value::literal_text(value),
            Style::Brief => value.to_string(),
        }
    }
}

/// `(head part..)`, empty parts left out.
pub fn list_text(head: &str, parts: impl IntoIterator<Item = String>) -> String {
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
pub fn joined(parts: impl IntoIterator<Item = String>) -> String {
    parts.into_iter().collect::<Vec<_>>().join(" ")
}
