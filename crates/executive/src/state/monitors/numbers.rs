//! State of the conditions that compute: statistics, trends, regression, persistence (`condition-rules.md`, rules 9 to 13). Plain data;
//! the services in the executive's `monitoring` folder operate on it.

use crate::state::bindings::Bindings;
use crate::state::monitors::moments::{HeldMoments, Moments};
use crate::state::monitors::monitor::{Satisfaction, Tests};
use crate::state::monitors::ordered_numbers::OrderedNumbers;
use apex_model::condition::{Constraint, EpisodeCondition, MeasurementCondition};
use apex_model::event::StateVariable;
use apex_model::expression::Expr;
use apex_model::quantity::Dimension;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Measure over the samples of an episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Measure {
    /// Arithmetic mean.
    Mean,
    /// Number of samples.
    Count,
    /// Population standard deviation.
    StandardDeviation,
    /// Population variance.
    Variance,
    /// Sum.
    Sum,
    /// Greatest less least.
    Difference,
    /// Least value.
    Least,
    /// Greatest value.
    Greatest,
    /// Middle value.
    Median,
    /// Mean over time of the persisted values.
    HeldMean,
    /// Variance over time of the persisted values.
    HeldVariance,
    /// Standard deviation over time of the persisted values.
    HeldStandardDeviation,
    /// Slope of the line of least squares, per unit of time.
    Rate,
    /// Every difference of successive values.
    Step,
    /// Samples per unit of time.
    Frequency,
    /// A predicate of the list of values.
    Custom,
    /// The slope differs from zero at this level of significance.
    Significance(Expr),
}

/// A measure and the constraint on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Criterion {
    /// Measure.
    pub measure: Measure,
    /// All must hold of it.
    pub constraints: Vec<Constraint>,
    /// The constraints, prepared.
    pub tests: Tests,
    /// Meaning of a bare number on a right side: its factor to SI and its dimension.
    pub bare: Option<(f64, Dimension)>,
}

/// State of an episode condition with statistics or trends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StatisticalPart {
    /// The condition.
    pub condition: Arc<EpisodeCondition>,
    /// The value tests, prepared.
    pub tests: Tests,
    /// The measures in written order, statistics first.
    pub criteria: Vec<Criterion>,
    /// The state variable; `None` while its object is unknown.
    pub variable: Option<StateVariable>,
    /// The dimension of the values, once it is known.
    pub dimension: Option<Dimension>,
    /// The greatest gap between samples; `None` does not constrain.
    pub gap_max: Option<Duration>,
    /// The least duration; of a sliding window the duration.
    pub duration_min: Duration,
    /// True if it is evaluated over a window of `duration_min`, not over the whole run.
    pub slides: bool,
    /// True if a constraint on end or duration is not a lower bound: the run is evaluated when it is over.
    pub at_close: bool,
    /// True if the window reaches before the oldest sample that was kept when the monitor was made.
    pub blind: bool,
    /// The first known sample if older ones are no longer kept: a run that starts there may have begun earlier.
    pub first_known: Option<Time>,
    /// Results that no later arrival of the same instant can withdraw.
    pub settled: Vec<Satisfaction>,
    /// The run of each object.
    #[serde(with = "crate::state::pairs")]
    pub objects: BTreeMap<Value, NumberRun>,
}

/// Samples of one object. The newest is separate, because a later arrival of its instant may still replace it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NumberRun {
    /// Order of the object's first appearance.
    pub rank: u64,
    /// The run up to the sample before the newest.
    pub run: Option<Box<Totals>>,
    /// The newest sample.
    pub newest: NumberSample,
    /// The result that began when the criteria came to hold, while they do.
    pub found: Option<Satisfaction>,
    /// True if a sample contradicted the value constraints, and no gap has followed.
    pub contradicted: bool,
    /// The gap that cut the last run.
    pub gap: Option<Duration>,
}

/// The newest sample of a run of numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NumberSample {
    /// Its instant.
    pub at: Time,
    /// Its value in SI; `None` if it is not a finite number.
    pub number: Option<f64>,
    /// Bindings, if the sample satisfies the value constraints.
    pub holds: Option<Bindings>,
    /// True if it continues the preceding run.
    pub joins: bool,
    /// True if it satisfies the constraints on first values.
    pub first_holds: bool,
    /// True if it satisfies the constraints on last values.
    pub last_holds: bool,
    /// True if its difference from the preceding number violates the constraints on steps.
    pub bad_step: bool,
}

/// Known facts of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Totals {
    /// First sample's instant.
    pub start: Time,
    /// Last sample's instant.
    pub last: Time,
    /// Bindings of its samples.
    pub bindings: Bindings,
    /// True if its first sample satisfies the constraints on first values.
    pub first_holds: bool,
    /// True if its last sample satisfies the constraints on last values.
    pub last_holds: bool,
    /// The last number and its instant.
    pub previous: Option<(Time, f64)>,
    /// The last two numbers, and the instant of the first of them.
    pub last_step: Option<(Time, f64, f64)>,
    /// Instant of the number from which the last bad step was made.
    pub bad_step: Option<Time>,
    /// Moments of all numbers of the run; empty if a window slides.
    pub moments: Moments,
    /// Moments over time; empty if a window slides.
    pub held: HeldMoments,
    /// The numbers in order, if a median is required.
    pub ordered: Option<OrderedNumbers>,
    /// True if there were more numbers than are kept in order: the median is then unknown.
    #[serde(default)]
    pub is_overfull: bool,
    /// The window, where one slides.
    pub window: Option<Box<SlidingWindow>>,
}

/// A number in a sliding window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Its instant.
    pub at: Time,
    /// Its value; `None` if it is not a finite number: the sample is then in the window but in no statistic.
    pub number: Option<f64>,
    /// Time until the next sample.
    pub held: Duration,
    /// True if its value may be the first one (`:first-value`).
    #[serde(default)]
    pub may_be_first: bool,
}

/// The numbers of a sliding window in two stacks: the older stack stores with each number the moments of it and of all younger ones of
/// that stack; the younger stack stores the moments of all its numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SlidingWindow {
    /// The older numbers, the oldest last.
    pub front: Vec<(Point, Moments)>,
    /// Moments over time for each number of `front`, if they are required.
    pub front_held: Vec<HeldMoments>,
    /// The younger numbers, oldest first.
    pub back: Vec<Point>,
    /// Moments of `back`.
    pub back_moments: Moments,
    /// Moments over time of `back`.
    pub back_held: HeldMoments,
    /// The last number that left the window; its value holds into the window.
    pub edge: Option<Point>,
}

/// State of a measurement condition under persistence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PersistedPart {
    /// The condition.
    pub condition: Arc<MeasurementCondition>,
    /// The value tests, prepared.
    pub tests: Tests,
    /// The state variable; `None` while its object is unknown.
    pub variable: Option<StateVariable>,
    /// For how long a sample is valid after its instant.
    pub timeout: Duration,
    /// True if the window reaches before the oldest sample that was kept when the monitor was made.
    pub blind: bool,
    /// Results of samples that have been followed by others.
    pub settled: Vec<Satisfaction>,
    /// The newest sample of each object.
    #[serde(with = "crate::state::pairs")]
    pub objects: BTreeMap<Value, PersistedSample>,
}

/// The newest sample of an object, which holds until the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PersistedSample {
    /// Order of the object's first appearance.
    pub rank: u64,
    /// Its instant.
    pub at: Time,
    /// Its value.
    pub value: Value,
    /// Bindings, if value and object satisfy the constraints.
    pub holds: Option<Bindings>,
}

/// State of a measurement condition under linear regression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RegressionPart {
    /// The condition.
    pub condition: Arc<MeasurementCondition>,
    /// The state variable; `None` while its object is unknown.
    pub variable: Option<StateVariable>,
    /// The dimension of the values, once it is known.
    pub dimension: Option<Dimension>,
    /// Least number of samples of a fit.
    pub points_min: u64,
    /// Greatest root mean square of the residuals, SI.
    pub error_max: Option<f64>,
    /// Greatest difference of an extrapolated value from that of the nearest sample, SI.
    pub difference_max: Option<f64>,
    /// Greatest permitted gap between samples, and from the last one to now.
    pub gap_max: Option<Duration>,
    /// The fit interval where its ends are stated, closed.
    pub fit: (Option<Time>, Option<Time>),
    /// True if the fit interval reaches before the oldest sample that was kept when the monitor was made.
    pub blind: bool,
    /// The samples of each object.
    #[serde(with = "crate::state::pairs")]
    pub objects: BTreeMap<Value, Fit>,
}

/// Samples of one object within the fit interval. The newest is separate, because a later arrival of its instant may still replace it,
/// even by a value that is not a number.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// Order of the object's first appearance.
    pub rank: u64,
    /// All but the newest.
    pub moments: Moments,
    /// Value of the first sample.
    pub first: f64,
    /// The last value of `moments`.
    pub before: f64,
    /// The newest sample; `None` if a value that is not a number has taken its place.
    pub newest: Option<(Time, f64)>,
    /// Bindings of the object; `None` if the object is not required.
    pub bindings: Option<Bindings>,
    /// The greatest gap between the samples of `moments`.
    pub gap: Duration,
}

impl Fit {
    /// Adds a sample that is not older than the newest; a sample of the same instant replaces the newest.
    pub fn add(&mut self, at: Time, number: f64) {
        if let Some((newest_at, value)) = self.newest.filter(|(newest_at, _)| *newest_at < at) {
            self.gap = self.with_newest().1;
            self.moments.add(newest_at, value);
            self.before = value;
        }
        if self.moments.count() == 0 {
            self.first = number;
        }
        self.newest = Some((at, number));
    }

    /// Records that a value that is not a number arrived at this instant: a newest sample of the same instant is removed from the fit.
    pub fn miss(&mut self, at: Time) {
        self.newest = self.newest.filter(|(newest_at, _)| *newest_at != at);
    }

    /// Returns the last sample; `None` before the first one.
    pub fn last(&self) -> Option<(Time, f64)> {
        self.newest.or_else(|| self.moments.span().map(|(_, last_at)| (last_at, self.before)))
    }

    /// Returns all samples, and the greatest gap between them.
    pub fn with_newest(&self) -> (Moments, Duration) {
        let (mut moments, mut gap) = (self.moments, self.gap);
        if let Some((at, number)) = self.newest {
            gap = moments.span().map_or(gap, |(_, last_at)| gap.max(at - last_at));
            moments.add(at, number);
        }
        (moments, gap)
    }
}
