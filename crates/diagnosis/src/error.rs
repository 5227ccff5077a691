//! The error of a model or results file: the problem, its place, the reason, and advice.

use std::fmt;

/// A text that is not a model, or not the results of its tests.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagnosisError {
    /// The file's name as given by the caller.
    pub file: String,
    /// `line:column` for text that cannot be read, otherwise the path of a field, such as `tests[3].needs[0]`; empty for the whole file.
    pub place: String,
    /// Cause.
    pub reason: String,
    /// Remedy, in the imperative.
    pub help: String,
}

impl DiagnosisError {
    /// Returns the failure with its place, without the reason.
    pub fn headline(&self) -> String {
        match self.place.as_str() {
            "" => format!("{} cannot be used for diagnosis", self.file),
            place if place.starts_with(|first: char| first.is_ascii_digit()) => {
                format!("{}:{place} cannot be read", self.file)
            }
            place => format!("{}: `{place}` is invalid", self.file),
        }
    }
}

impl fmt::Display for DiagnosisError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; {}", self.headline(), self.reason, self.help)
    }
}

impl std::error::Error for DiagnosisError {}

/// The name of a file, for its errors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FileName<'a>(pub(crate) &'a str);

impl FileName<'_> {
    pub(crate) fn error(
        self,
        place: impl Into<String>,
        reason: impl Into<String>,
        help: impl Into<String>,
    ) -> DiagnosisError {
        DiagnosisError { file: self.0.to_string(), place: place.into(), reason: reason.into(), help: help.into() }
    }

    /// Returns the error of a text that is not JSON, or is JSON of another shape.
    pub(crate) fn unreadable(self, error: &serde_json::Error) -> DiagnosisError {
        let text = error.to_string();
        // serde_json appends the place in this form; here it is in front.
        let appended = format!(" at line {} column {}", error.line(), error.column());
        let reason = text.strip_suffix(&appended).unwrap_or(&text).to_string();
        let place = format!("{}:{}", error.line(), error.column());
        self.error(place, reason, "docs/reference/diagnosis.md describes the file")
    }
}

/// Returns the name among `known` that is closest to `wanted`, as a hint.
pub(crate) fn nearest<'a>(wanted: &str, known: impl Iterator<Item = &'a str>) -> String {
    let likeness = |name: &&str| (strsim::jaro_winkler(wanted, name) * 1e6) as u64;
    match known.max_by_key(likeness).filter(|name| strsim::jaro_winkler(wanted, name) > 0.75) {
        Some(name) => format!("write `{name}`, or declare `{wanted}`"),
        None => format!("declare `{wanted}`, or correct the name"),
    }
}
