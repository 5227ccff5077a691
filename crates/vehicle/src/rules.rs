//! Rules for single figures, and the errors of figures that break them.

use crate::error::{FileName, VehicleFileError};

/// Values that a figure may have.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Rule {
    /// Greater than zero.
    Positive,
    /// Zero or greater.
    NotNegative,
    /// Any finite number.
    Finite,
    /// From the first to the second, both included.
    Between(f64, f64),
    /// Greater than the first, up to the second included.
    AboveUpTo(f64, f64),
}

impl Rule {
    /// Returns true if the value obeys the rule.
    pub(crate) fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Rule::Positive => value > 0.0,
                Rule::NotNegative => value >= 0.0,
                Rule::Finite => true,
                Rule::Between(low, high) => (low..=high).contains(&value),
                Rule::AboveUpTo(low, high) => value > low && value <= high,
            }
    }

    fn describe(self) -> String {
        match self {
            Rule::Positive => "a number greater than zero".to_owned(),
            Rule::NotNegative => "a number that is not negative".to_owned(),
            Rule::Finite => "a finite number".to_owned(),
            Rule::Between(low, high) => format!("a number from {low} to {high}"),
            Rule::AboveUpTo(low, high) => format!("a number greater than {low} and at most {high}"),
        }
    }
}

/// Checks the figures of one file in order and returns the first error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Checker<'a> {
    /// The file.
    pub(crate) file: FileName<'a>,
}

impl Checker<'_> {
    /// Checks each figure of a section by its rule; an empty section is the file's top level.
    ///
    /// # Errors
    /// The first figure that breaks its rule.
    pub(crate) fn each(&self, section: &str, figures: &[(&str, f64, Rule)]) -> Result<(), VehicleFileError> {
        let wrong = figures.iter().find(|(_, value, rule)| !rule.holds(*value));
        let Some((name, value, rule)) = wrong else { return Ok(()) };
        let path = if section.is_empty() { (*name).to_owned() } else { format!("{section}.{name}") };
        let help = "correct the figure; its unit is part of its name";
        Err(self.file.error(path, rule.describe(), value.to_string(), help))
    }

    /// Checks that `value` is at most `limit`, the figure called `other`.
    ///
    /// # Errors
    /// The value is greater.
    pub(crate) fn at_most(&self, path: &str, value: f64, limit: f64, other: &str) -> Result<(), VehicleFileError> {
        if value <= limit {
            return Ok(());
        }
        let expected = format!("at most `{other}`, {limit}");
        Err(self.file.error(path, expected, value.to_string(), "correct one of the two figures"))
    }

    /// Checks that `value` is less than `limit`, the figure called `other`.
    ///
    /// # Errors
    /// The value is not below the limit.
    pub(crate) fn below(&self, path: &str, value: f64, limit: f64, other: &str) -> Result<(), VehicleFileError> {
        if value < limit {
            return Ok(());
        }
        let expected = format!("less than `{other}`, {limit}");
        Err(self.file.error(path, expected, value.to_string(), "correct one of the two figures"))
    }
}
