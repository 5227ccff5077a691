//! The error of a vehicle or sensor file: the file, the field, the expected and the found value, and advice.

use std::fmt;

/// Kinds of files that this crate reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A vehicle file.
    Vehicle,
    /// A sensor file.
    Sensor,
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FileKind::Vehicle => "vehicle file",
            FileKind::Sensor => "sensor file",
        })
    }
}

/// A file in messages: its kind and its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FileName<'a> {
    /// Its kind.
    pub(crate) kind: FileKind,
    /// The file's name as given by the caller.
    pub(crate) name: &'a str,
}

impl<'a> FileName<'a> {
    /// Returns a vehicle file.
    pub(crate) fn vehicle(name: &'a str) -> FileName<'a> {
        FileName { kind: FileKind::Vehicle, name }
    }

    /// Returns a sensor file.
    pub(crate) fn sensor(name: &'a str) -> FileName<'a> {
        FileName { kind: FileKind::Sensor, name }
    }

    /// Returns an error at `path` in this file.
    pub(crate) fn error(
        self,
        path: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
        help: impl Into<String>,
    ) -> VehicleFileError {
        VehicleFileError {
            kind: self.kind,
            file: self.name.into(),
            path: path.into(),
            expected: expected.into(),
            found: found.into(),
            help: help.into(),
        }
    }
}

/// Error in the text of a vehicle or sensor model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VehicleFileError {
    /// Kind of the file.
    pub kind: FileKind,
    /// The file's name as given by the caller.
    pub file: Box<str>,
    /// JSON path of the field, for example `flight.ceiling_m` or `sensors[1].name`; empty for the file as a whole.
    pub path: String,
    /// Expected value of the field.
    pub expected: String,
    /// Value in the file.
    pub found: String,
    /// Remedy, in the imperative.
    pub help: String,
}

impl VehicleFileError {
    /// Returns the failure and its place, without the reason: ``vehicle file `my-uav.json`: invalid `flight.ceiling_m`
    /// ``.
    pub fn place(&self) -> String {
        match self.path.as_str() {
            "" => format!("{} `{}` is invalid", self.kind, self.file),
            path => format!("{} `{}`: invalid `{path}`", self.kind, self.file),
        }
    }

    /// Returns the reason: `expected .., found ..`.
    pub fn reason(&self) -> String {
        format!("expected {}, found {}", self.expected, self.found)
    }
}

impl fmt::Display for VehicleFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; {}", self.place(), self.reason(), self.help)
    }
}

impl std::error::Error for VehicleFileError {}
