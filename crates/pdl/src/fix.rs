//! Fixes: edits of the texts that resolve a message, in a form that a program can apply.

use crate::diagnostic::Span;

/// Certainty that a fix matches the author's intention.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Applicability {
    /// No other meaning is possible: the fix may be applied without asking.
    Safe,
    /// Probably meant, or one of several possibilities: the author decides.
    NeedsLook,
}

impl Applicability {
    /// Returns the displayed word.
    pub fn word(self) -> &'static str {
        match self {
            Applicability::Safe => "safe",
            Applicability::NeedsLook => "needs a look",
        }
    }
}

/// Replaces a range of one source text.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TextEdit {
    /// Index into the sources of the library.
    pub file: u32,
    /// Byte offset of the first character that is replaced.
    pub start: u32,
    /// Byte offset after the last character that is replaced; equal to `start` where text is only inserted.
    pub end: u32,
    /// Text after the edit.
    pub replacement: String,
}

/// A titled list of edits that belong together: all are made or none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// Effect of the edits, in a few words: "replace `foo` by `bar`".
    pub title: String,
    /// Certainty.
    pub applicability: Applicability,
    /// The edits; they do not overlap.
    pub edits: Vec<TextEdit>,
}

impl Fix {
    /// Returns a fix that needs no review, still without edits.
    pub(crate) fn safe(title: impl Into<String>) -> Fix {
        Fix { title: title.into(), applicability: Applicability::Safe, edits: Vec::new() }
    }

    /// Returns a fix that its author must review, still without edits.
    pub(crate) fn look(title: impl Into<String>) -> Fix {
        Fix { title: title.into(), applicability: Applicability::NeedsLook, edits: Vec::new() }
    }

    /// Puts `text` in place of `span`.
    pub(crate) fn replace(mut self, span: Span, text: impl Into<String>) -> Fix {
        self.edits.push(TextEdit { file: span.file, start: span.start, end: span.end, replacement: text.into() });
        self
    }

    /// Puts `text` before `span`.
    pub(crate) fn insert_before(self, span: Span, text: impl Into<String>) -> Fix {
        self.replace(Span { end: span.start, ..span }, text)
    }

    /// Puts `text` after `span`.
    pub(crate) fn insert_after(self, span: Span, text: impl Into<String>) -> Fix {
        self.replace(Span { start: span.end, ..span }, text)
    }
}
