//! Messages for the authors of PDL: what is wrong, where, why, and what to do about it.

use crate::fix::Fix;
use apex_model::source::Place;

/// Severity. Only errors keep a library from being flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The text cannot be used.
    Error,
    /// The text can be used, but probably has another meaning than its author intends.
    Warning,
    /// A fact that the author should know; nothing need be changed.
    Note,
}

impl Severity {
    /// Returns the displayed word.
    pub fn word(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        }
    }
}

/// A range of one source text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Span {
    /// Index into the sources of the library.
    pub file: u32,
    /// Byte offset of the first character.
    pub start: u32,
    /// Byte offset after the last character.
    pub end: u32,
    /// Line of the first character, from 1.
    pub line: u32,
    /// Column of the first character, from 1, in characters.
    pub column: u32,
}

impl Span {
    /// Returns the start as a place of the model.
    pub fn place(self) -> Place {
        Place { file: self.file, line: self.line, column: self.column }
    }

    /// Returns the span from the start of this one to the end of `last`.
    pub(crate) fn to(self, last: Span) -> Span {
        Span { end: last.end.max(self.end), ..self }
    }
}

/// A second relevant place, with its description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Place in the text.
    pub span: Span,
    /// Note about that place.
    pub text: String,
}

/// One message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Stable code, listed in [`crate::error_codes`].
    pub code: &'static str,
    /// Severity.
    pub severity: Severity,
    /// Defect, in one line.
    pub message: String,
    /// Place in the text.
    pub span: Span,
    /// Other places that matter.
    pub labels: Vec<Label>,
    /// Reason, if it is not obvious.
    pub reason: Option<String>,
    /// Suggestions as text; one sentence each.
    pub help: Vec<String>,
    /// Suggestions as edits; any single one suffices. The likeliest is first.
    pub fixes: Vec<Fix>,
}

impl Diagnostic {
    /// Returns a message without labels, reason, help and fixes.
    pub(crate) fn new(severity: Severity, code: &'static str, span: Span, message: impl Into<String>) -> Diagnostic {
        let (labels, help, fixes) = (Vec::new(), Vec::new(), Vec::new());
        Diagnostic { code, severity, message: message.into(), span, labels, reason: None, help, fixes }
    }

    pub(crate) fn error(code: &'static str, span: Span, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(Severity::Error, code, span, message)
    }

    pub(crate) fn label(mut self, span: Span, text: impl Into<String>) -> Diagnostic {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    pub(crate) fn reason(mut self, reason: impl Into<String>) -> Diagnostic {
        self.reason = Some(reason.into());
        self
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Diagnostic {
        self.help.push(help.into());
        self
    }

    pub(crate) fn fix(mut self, fix: Fix) -> Diagnostic {
        self.fixes.push(fix);
        self
    }

    /// Adds fixes, the likeliest first.
    pub(crate) fn fixes(mut self, fixes: impl IntoIterator<Item = Fix>) -> Diagnostic {
        self.fixes.extend(fixes);
        self
    }

    /// Adds the fixes; without any, help as text.
    pub(crate) fn fixes_or_help(self, fixes: Vec<Fix>, help: impl FnOnce() -> String) -> Diagnostic {
        if fixes.is_empty() { self.help(help()) } else { self.fixes(fixes) }
    }
}
