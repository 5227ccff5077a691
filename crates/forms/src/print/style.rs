//! Amount of detail of printed forms.

use super::value;
use apex_model::value::Value;

/// Amount of detail with which a form is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Text from which exactly the same form is read.
    Exact,
    /// Text for traces and explanations: bodies are abbreviated as `..`, numbers are rounded, names are not quoted.
    Brief,
}

impl Style {
    /// Returns a value as text where holes are allowed: in exact text, symbols that would be read as holes are quoted.
    pub fn literal(self, value: &Value) -> String {
        match self {
            Style::Exact => value::literal_text(value),
            Style::Brief => value.to_string(),
        }
    }
}
