//! Errors of benchmark files, for operators.

use std::fmt;

/// An error in a file: place, failure, reason and remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FormatError {
    /// Line, from 1; 0 if the error concerns the file as a whole.
    pub line: usize,
    /// Column, from 1, in characters.
    pub column: usize,
    /// The line's text.
    pub text: String,
    /// Error.
    pub message: String,
    /// Reason.
    pub reason: String,
    /// Remedy.
    pub help: String,
}

impl fmt::Display for FormatError {
    /// `3:7: x is not a number (the profit of vertex 2): write a number`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {} ({}): {}", self.line, self.column, self.message, self.reason, self.help)
    }
}

impl std::error::Error for FormatError {}
