//! The error of a vehicle file: file, field, expected, found, help.

use std::fmt;

/// Why a text is not a vehicle model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VehicleFileError {
    /// Name of the file as the caller gave it.
    pub file: String,
    /// JSON path of the field, for example `flight.ceiling_m` or `cameras[1].name`; empty for the file as a whole.
    pub path: String,
    /// What the field must be.
    pub expected: String,
    /// What the file has there.
    pub found: String,
    /// What to do about it, in the imperative.
    pub help: String,
}

impl VehicleFileError {
    /// What failed and where, without the reason: ``vehicle file `my-uav.json`: invalid `flight.ceiling_m` ``.
    pub fn place(&self) -> String {
        match self.path.as_str() {
            "" => format!("vehicle file `{}` is invalid", self.file),
            path => format!("vehicle file `{}`: invalid `{path}`", self.file),
        }
    }

    /// Why: `expected .., found ..`.
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
