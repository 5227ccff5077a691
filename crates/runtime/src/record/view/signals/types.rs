//! Queries about signals and their answers.

use super::limits::{Excursion, SignalLimit};
use serde::Serialize;

/// Number of buckets of an answer, unless the query states one.
pub(in crate::record::view) const PIXELS_DEFAULT: usize = 1_000;
/// Maximum number of buckets of any answer.
pub(in crate::record::view) const PIXELS_MAX: usize = 8_000;
/// Maximum number of signals of one answer.
pub const SIGNALS_MAX: usize = 24;

/// A query of signals.
#[derive(Clone, Debug, Default)]
pub struct SignalQuery {
    /// The variables' names as PDL writes them, `(roll-angle aircraft-1)`.
    pub names: Vec<String>,
    /// Start of the window, nanoseconds of mission time; default: the record's start.
    pub from_ns: Option<i64>,
    /// End of the window, nanoseconds of mission time; default: the instant.
    pub to_ns: Option<i64>,
    /// The instant up to which the flight is known; default: the record's end.
    pub at_ns: Option<i64>,
    /// Number of pixels that the window is drawn on; default 1,000, at most 8,000.
    pub pixels: Option<usize>,
}

/// The signals that were measured by an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Signals {
    /// In order of their first sample.
    pub signals: Vec<Signal>,
}

/// A recorded state variable.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Signal {
    /// Its name in PDL, `(roll-angle aircraft-1)`.
    pub name: String,
    /// Its attribute, `roll-angle`.
    pub attribute: String,
    /// Its object, `aircraft-1`.
    pub object: String,
    /// The unit of its numbers in PDL; empty for numbers without a unit and for words.
    pub unit: String,
    /// Kind of its values.
    pub kind: SignalKind,
    /// Mission time in nanoseconds of its first sample.
    pub first_ns: i64,
    /// The limits that the mission watches.
    pub limits: Vec<SignalLimit>,
}

/// Kind of the values of a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "lowercase")]
pub enum SignalKind {
    /// Numbers.
    Number,
    /// Symbols, strings and truth values.
    Words,
    /// Places and other lists, which are not drawn over time.
    Other,
}

/// Windows of signals.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SignalWindows {
    /// Start of the window, nanoseconds of mission time.
    pub from_ns: i64,
    /// End of the window, nanoseconds of mission time.
    pub to_ns: i64,
    /// Mission time in nanoseconds up to which the flight is known.
    pub at_ns: i64,
    /// One window for each requested name, in that order; names without samples by the instant have none.
    pub windows: Vec<SignalWindow>,
}

/// A signal in a window of time. All lists have the same length: one entry for each sample, or, if there are more samples, for each pixel
/// that has samples. The last sample before the window comes first, so that a line enters the window.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SignalWindow {
    /// The signal.
    #[serde(flatten)]
    pub signal: Signal,
    /// Mission time in nanoseconds of the first sample of the entry.
    pub t_ns: Vec<i64>,
    /// The smallest value.
    pub low: Vec<f64>,
    /// The largest value.
    pub high: Vec<f64>,
    /// The mean of the values; for words the index in `words` of the last one.
    pub mean: Vec<f64>,
    /// Number of samples.
    pub count: Vec<u32>,
    /// The words of a signal of words.
    pub words: Vec<String>,
    /// Statistics of the samples in the window; none without samples, and for words.
    pub statistics: Option<Statistics>,
    /// Number of samples in the window.
    pub samples: usize,
    /// The stretches of the window in which samples were beyond a limit, by time.
    pub excursions: Vec<Excursion>,
    /// Number of shorter excursions, which the executive did not answer, that are left out.
    pub left_out: usize,
}

/// Statistics of the samples of a window, each sample with the same weight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Statistics {
    /// Number of samples.
    pub samples: usize,
    /// The smallest value.
    pub low: f64,
    /// The largest value.
    pub high: f64,
    /// The mean.
    pub mean: f64,
    /// The standard deviation of the samples about their mean.
    pub deviation: f64,
    /// The first value.
    pub first: f64,
    /// The last value.
    pub last: f64,
}
