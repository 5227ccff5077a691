//! Errors of missions: failure, reason and remedy.

use apex_pdl::{Checked, Severity};
use std::fmt;

/// Subject of a [`MissionError`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorKind {
    /// The PDL program: it cannot be read, or contains errors (see [`MissionError::diagnostics`]).
    Program,
    /// A file of the mission's data: it cannot be read, or its content is invalid.
    Data,
    /// An option of `(defapplication ..)`.
    Setting,
    /// A planning problem, or a plan.
    Planning,
    /// The model of a vehicle, or the vehicle itself.
    Vehicle,
    /// A file given as flight record, or the path of a record to be written.
    RecordFile,
    /// A flight record that cannot be written: the disk is full, or refuses.
    Record,
    /// A file that cannot be written.
    Output,
    /// An input that cannot be read to its end.
    Input,
    /// A flight that cannot begin, or was aborted.
    Flight,
}

/// A failure of a mission.
#[derive(Debug)]
pub struct MissionError {
    /// Subject.
    pub kind: ErrorKind,
    /// The file, feature, row or option with the error, if there is one.
    pub place: Option<String>,
    /// Failure, one line.
    pub message: String,
    /// Reason, if known.
    pub reason: Option<String>,
    /// Remedy, if known.
    pub help: Option<String>,
    /// The checked program, where its errors are the failure.
    pub diagnostics: Option<Box<Checked>>,
}

/// Result of functions of this crate.
pub type MissionResult<T = ()> = Result<T, MissionError>;

impl MissionError {
    /// Returns a failure of this kind.
    pub fn new(kind: ErrorKind, message: impl Into<String>) -> MissionError {
        MissionError { kind, place: None, message: message.into(), reason: None, help: None, diagnostics: None }
    }

    /// Returns an error of the program.
    pub fn program(message: impl Into<String>) -> MissionError {
        MissionError::new(ErrorKind::Program, message)
    }

    /// Returns an error of a data file.
    pub fn data(message: impl Into<String>) -> MissionError {
        MissionError::new(ErrorKind::Data, message)
    }

    /// Returns an error of an option of the application.
    pub fn setting(message: impl Into<String>) -> MissionError {
        MissionError::new(ErrorKind::Setting, message)
    }

    /// Returns an error of a planning problem or a plan.
    pub fn planning(message: impl Into<String>) -> MissionError {
        MissionError::new(ErrorKind::Planning, message)
    }

    /// Returns the error of a file that cannot be written.
    pub fn output(message: impl Into<String>) -> MissionError {
        MissionError::new(ErrorKind::Output, message)
    }

    /// Returns an error of the path of a flight record.
    pub fn record_file(message: impl Into<String>) -> MissionError {
        MissionError::new(ErrorKind::RecordFile, message)
    }

    /// Returns the error of a flight record that cannot be written.
    pub fn record(message: impl Into<String>) -> MissionError {
        MissionError::new(ErrorKind::Record, message)
    }

    /// Returns an error of the vehicle.
    pub fn vehicle(message: impl Into<String>) -> MissionError {
        MissionError::new(ErrorKind::Vehicle, message)
    }

    /// Returns the error of a flight that cannot begin, or was aborted.
    pub fn flight(message: impl Into<String>) -> MissionError {
        MissionError::new(ErrorKind::Flight, message)
    }

    /// Adds the place.
    #[must_use]
    pub fn at(mut self, place: impl Into<String>) -> MissionError {
        self.place = Some(place.into());
        self
    }

    /// Returns the failure with its place, in one line.
    pub fn headline(&self) -> String {
        match &self.place {
            Some(place) => format!("{place}: {}", self.message),
            None => self.message.clone(),
        }
    }

    /// Returns the file of the place, with its line and column where the place has the form `FILE:LINE:COLUMN` or `FILE:LINE`; `None`
    /// without a place.
    pub fn position(&self) -> Option<(&str, Option<u32>, Option<u32>)> {
        let place = self.place.as_deref()?;
        let number = |text: &str| -> Option<u32> { text.parse().ok().filter(|number| *number > 0) };
        let split = |text: &'_ str| -> Option<(usize, u32)> {
            let (before, last) = text.rsplit_once(':')?;
            Some((before.len(), number(last)?))
        };
        let Some((end, last)) = split(place) else { return Some((place, None, None)) };
        let before = place.get(..end)?;
        Some(match split(before) {
            Some((end, line)) => (before.get(..end)?, Some(line), Some(last)),
            None => (before, Some(last), None),
        })
    }

    /// Replaces a failure by the first error of its program, for callers that show a single error. Failures without diagnostics are
    /// unchanged.
    #[must_use]
    pub fn first_diagnostic(self) -> MissionError {
        let Some(checked) = &self.diagnostics else { return self };
        let first = checked.diagnostics.iter().find(|diagnostic| diagnostic.severity == Severity::Error);
        let Some(first) = first else { return self };
        MissionError {
            kind: self.kind,
            place: Some(checked.library.describe_place(first.span.place())),
            message: format!("{}: {}", first.code, first.message),
            reason: first.reason.clone(),
            help: first.help.first().cloned(),
            diagnostics: self.diagnostics,
        }
    }

    /// Adds the reason.
    #[must_use]
    pub fn because(mut self, reason: impl fmt::Display) -> MissionError {
        self.reason = Some(reason.to_string());
        self
    }

    /// Adds advice on what to do.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> MissionError {
        self.help = Some(help.into());
        self
    }
}

impl fmt::Display for MissionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.headline())?;
        if let Some(reason) = &self.reason {
            write!(f, "\n  why: {reason}")?;
        }
        if let Some(help) = &self.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

impl std::error::Error for MissionError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_a_file_with_line_and_column_or_another_description() {
        let position = |place: &str| {
            let error = MissionError::data("unreadable").at(place);
            error.position().map(|(file, line, column)| (file.to_string(), line, column))
        };
        let expected = |file: &str, line, column| Some((file.to_string(), line, column));
        assert_eq!(position("a/mission.pdl:8:3"), expected("a/mission.pdl", Some(8), Some(3)));
        assert_eq!(position("fires.csv:12"), expected("fires.csv", Some(12), None));
        assert_eq!(position("targets.geojson, feature 3"), expected("targets.geojson, feature 3", None, None));
        assert_eq!(position("C:/data/fires.csv:2"), expected("C:/data/fires.csv", Some(2), None));
        assert_eq!(position("fires.csv:0"), expected("fires.csv:0", None, None));
        assert_eq!(MissionError::data("unreadable").position(), None);
    }
}
