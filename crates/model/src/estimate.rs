//! Computed evidence: values between and beyond samples, statistics and trends (`condition-rules.md`, rules 1, 6, 10 to 12 and 22). Each
//! refers to the samples on which it rests.

use crate::event::StateVariable;
use crate::quantity::format_rounded;
use crate::time::{Duration, Time};
use crate::value::Value;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Method that finds values between and beyond samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Estimator {
    /// The last sample holds.
    Persistence,
    /// A straight line of least squares.
    LinearRegression,
}

impl fmt::Display for Estimator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Estimator::Persistence => ":persist",
            Estimator::LinearRegression => ":linear-regression",
        })
    }
}

/// A value that an estimator gives for an instant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Method that found it.
    pub estimator: Estimator,
    /// Variable of the value.
    pub variable: StateVariable,
    /// The estimated value.
    pub value: Value,
    /// The instant it is for.
    pub at: Time,
    /// Half-open interval in which the estimate is valid: for a persisted sample from its instant to its expiry or replacement; for a
    /// line from the first to just after the last fitted sample.
    pub extent: (Time, Time),
    /// Number of samples on which it rests.
    pub samples: u64,
    /// Distance of the instant from the samples; zero between them.
    pub extrapolation: Duration,
    /// Root mean square of the residuals of a line, in the unit of the variable.
    pub error: Option<Value>,
}

impl Estimate {
    /// Returns the estimate as text: `(altitude uav) = 120ft at 30s by :linear-regression over 12 samples, 4s beyond them, error 0.3ft`
    pub fn text(&self) -> String {
        let Estimate { estimator, variable, value, at, samples, extrapolation, .. } = self;
        let mut text = format!("{variable} = {} at {at} by {estimator}", computed(value));
        match estimator {
            Estimator::Persistence => text.push_str(&self.validity()),
            Estimator::LinearRegression => text.push_str(&format!(" over {samples} samples")),
        }
        if *extrapolation > Duration::ZERO && *estimator == Estimator::LinearRegression {
            text.push_str(&format!(", {extrapolation} beyond them"));
        }
        if let Some(error) = &self.error {
            text.push_str(&format!(", error {}", computed(error)));
        }
        text
    }

    fn validity(&self) -> String {
        match self.extent {
            (from, Time::END) => format!(", valid from {from} on"),
            (from, to) => format!(", valid in [{from}, {to})"),
        }
    }
}

/// A number computed over samples of one variable: a statistic or a trend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Aggregate {
    /// Variable of the samples.
    pub variable: StateVariable,
    /// Name of the measure: its PDL keyword without the colon, such as `mean`, `rate`.
    pub name: String,
    /// Computed value.
    pub value: Value,
    /// First and last instant of the interval, closed.
    pub interval: (Time, Time),
    /// Number of samples in it.
    pub samples: u64,
}

impl Aggregate {
    /// Returns the statistic as text: `mean of (rpm engine-1) from 2s to 9s = 812`
    pub fn text(&self) -> String {
        let Aggregate { variable, name, value, interval: (start, end), .. } = self;
        format!("{name} of {variable} from {start} to {end} = {}", computed(value))
    }
}

/// Returns a computed value without its last bits, which are rounding errors.
pub fn computed(value: &Value) -> String {
    match value {
        Value::Real(real) => format_rounded(*real),
        other => other.to_string(),
    }
}
