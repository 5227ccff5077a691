//! Rejection of a manoeuvre: the violated limit, its figure, and the nearest possible manoeuvre.

use serde::{Deserialize, Serialize};
use std::fmt;

/// A manoeuvre that vehicle, sensor or wind do not permit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refusal {
    /// The manoeuvre in PDL.
    pub manoeuvre: String,
    /// The figure that breaks a limit, by name.
    pub figure: String,
    /// Its value.
    pub value: f64,
    /// The limit that it breaks.
    pub limit: f64,
    /// Unit of value and limit; empty for counts.
    pub unit: Box<str>,
    /// Owner of the limit, and its reason.
    pub because: Box<str>,
    /// The nearest possible value or manoeuvre, as text.
    pub nearest: String,
}

impl Refusal {
    /// Returns the excess of the figure over its limit, as a share of the larger of the two.
    pub fn excess(&self) -> f64 {
        (self.value - self.limit).abs() / self.limit.abs().max(self.value.abs()).max(1e-9)
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Refusal { manoeuvre, figure, value, limit, unit, because, nearest } = self;
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let (value, limit) = (short(*value), short(*limit));
        write!(f, "`{manoeuvre}`: {figure} of {value}{unit} breaks the limit of {limit}{unit}: {because}; {nearest}")
    }
}

impl std::error::Error for Refusal {}

/// Returns a number as text: without decimals from 100 on and for integers, with one decimal from 1 on, with three below.
pub(crate) fn short(number: f64) -> String {
    if number.abs() >= 100.0 || number == libm::trunc(number) {
        format!("{number:.0}")
    } else if number.abs() >= 1.0 {
        format!("{number:.1}")
    } else {
        format!("{number:.3}")
    }
}

/// Greatest number of decimals of a rounded limit.
const DECIMALS_MAX: usize = 9;

/// Returns a lower limit as text with `decimals`, rounded up: the number as printed keeps the limit, too.
pub fn rounded_up(limit: f64, decimals: usize) -> String {
    let printed: f64 = format!("{limit:.decimals$}").parse().unwrap_or(limit);
    let step = libm::pow(10.0, -(decimals as f64));
    format!("{:.decimals$}", if printed < limit { printed + step } else { printed })
}

/// Returns an upper limit as text with `decimals`, rounded down: the number as printed keeps the limit, too. A positive limit gets more
/// decimals if it would be printed as 0.
pub fn rounded_down(limit: f64, decimals: usize) -> String {
    for decimals in decimals..=DECIMALS_MAX {
        let printed: f64 = format!("{limit:.decimals$}").parse().unwrap_or(limit);
        let step = libm::pow(10.0, -(decimals as f64));
        let printed = if printed > limit { printed - step } else { printed };
        let text = format!("{printed:.decimals$}");
        if limit <= 0.0 || text.parse::<f64>().is_ok_and(|printed| printed > 0.0) {
            return text;
        }
    }
    limit.to_string()
}

/// A figure of a manoeuvre that is checked against a limit.
pub(crate) struct Limit<'a> {
    pub(crate) manoeuvre: &'a str,
    pub(crate) figure: &'a str,
    pub(crate) unit: &'a str,
}

impl Limit<'_> {
    /// Rejects a value above `limit`, and one that is not a number.
    pub(crate) fn at_most(
        &self,
        value: f64,
        limit: f64,
        because: &str,
        nearest: impl FnOnce() -> String,
    ) -> Result<(), Refusal> {
        if value <= limit { Ok(()) } else { Err(self.refusal(value, limit, because, nearest())) }
    }

    /// Rejects a value below `limit`, and one that is not a number.
    pub(crate) fn at_least(
        &self,
        value: f64,
        limit: f64,
        because: &str,
        nearest: impl FnOnce() -> String,
    ) -> Result<(), Refusal> {
        if value >= limit { Ok(()) } else { Err(self.refusal(value, limit, because, nearest())) }
    }

    pub(crate) fn refusal(&self, value: f64, limit: f64, because: &str, nearest: String) -> Refusal {
        Refusal {
            manoeuvre: self.manoeuvre.to_string(),
            figure: self.figure.to_string(),
            value,
            limit,
            unit: self.unit.into(),
            because: because.into(),
            nearest,
        }
    }
}

/// Rejects a parameter that is not a positive finite number.
pub(crate) fn positive(manoeuvre: &str, figure: &str, unit: &str, value: f64) -> Result<(), Refusal> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    let limit = Limit { manoeuvre, figure, unit };
    Err(limit.refusal(value, 0.0, "the value must be positive", "give a positive number".to_string()))
}
