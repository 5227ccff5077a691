//! Conditions as plain data, as described in `docs/reference/conditions.md`, without places, units and expressions.

use crate::value::Value;

/// An instant in nanoseconds.
pub type Time = i64;
/// A length of time in nanoseconds.
pub type Span = i64;

/// A condition with the name of its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// The name, without `?`.
    pub tag: Option<String>,
    /// Kind.
    pub kind: Kind,
}

/// The forms.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// One sample, or one estimated value.
    Measurement(Measurement),
    /// A run of samples.
    Episode(Episode),
    /// A value that goes up and down repeatedly.
    Cyclic(Cyclic),
    /// All parts are satisfied.
    And(Vec<Condition>, Vec<Test>),
    /// At least one part is satisfied.
    Or(Vec<Condition>),
    /// The part has had no result so far.
    Not(Box<Condition>),
    /// The part has had no result for this duration.
    Absent(Box<Condition>, Span),
    /// The parts are satisfied in sequence.
    InOrder(Vec<Condition>, Vec<Test>),
    /// A relation between each two neighbouring parts.
    Allen {
        /// Relation.
        relation: Allen,
        /// The parts.
        parts: Vec<Condition>,
        /// Largest difference, in nanoseconds, of end points that count as equal.
        tolerance: Span,
        /// Tests of tags.
        tests: Vec<Test>,
    },
    /// A delay: at least the first span, at most the second.
    Delay(Span, Option<Span>),
    /// An instant that has been reached or, with a second instant, an interval.
    Timestamp(Time, Option<Time>),
    /// A message, with tests of its instant.
    Event(Vec<Term>, Vec<(Relation, Time)>),
    /// The newest value of a variable has a relation to a number.
    Function(String, String, Relation, f64),
    /// The task ended.
    TaskEnded(String),
    /// The task was in this state; `resumed` is the way back from `interrupted`.
    TaskState(String, String),
}

/// Constraints on one sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The watched variable.
    pub variable: Variable,
    /// Tests of the value.
    pub value: Vec<Constraint>,
    /// Tests of the instant; with none the window begins at the creation.
    pub timestamp: Vec<(Relation, Time)>,
    /// Values assumed between samples.
    pub estimation: Option<Estimation>,
}

/// `(ATTRIBUTE OBJECT)` with `:object` tests.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// The attribute.
    pub attribute: String,
    /// The object, or a variable to which it is bound.
    pub object: Term,
    /// Tests of the object.
    pub tests: Vec<Constraint>,
}

/// Constraints on cycles.
#[derive(Clone, Debug, PartialEq)]
pub struct Cyclic {
    /// The watched variable.
    pub variable: Variable,
    /// Tests of the length of each cycle.
    pub period: Vec<(Relation, Span)>,
    /// Tests of the amplitude of each cycle.
    pub amplitude: Vec<(Relation, f64)>,
    /// Tests of the number of cycles; an empty list requires at least two.
    pub cycles: Vec<(Relation, i64)>,
    /// The least distance by which a value must return from a turning point.
    pub hysteresis: Option<f64>,
}

/// Constraints on a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Episode {
    /// The watched variable.
    pub variable: Variable,
    /// True if any two samples of a run bound an episode.
    pub any: bool,
    /// Tests of every value.
    pub value: Vec<Constraint>,
    /// Tests of the first value.
    pub first_value: Vec<Constraint>,
    /// Tests of the last value.
    pub last_value: Vec<Constraint>,
    /// The largest gap between samples; `None` permits any.
    pub gap: Option<Span>,
    /// Tests of the first instant.
    pub start: Vec<(Relation, Time)>,
    /// Tests of the last instant.
    pub end: Vec<(Relation, Time)>,
    /// Tests of the length.
    pub duration: Vec<(Relation, Span)>,
    /// Tests of statistics.
    pub stats: Vec<(Statistic, Relation, f64)>,
    /// Tests of trends.
    pub trend: Vec<(Trend, Relation, f64)>,
}

/// Values assumed between and beyond samples.
#[derive(Clone, Debug, PartialEq)]
pub enum Estimation {
    /// The last value, at most for this duration.
    Persist(Option<Span>),
    /// A line.
    Regression(Regression),
}

/// Fit of the line, and the criteria for its rejection.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Regression {
    /// Least number of samples.
    pub points_min: Option<usize>,
    /// Greatest permitted root mean square of the residuals.
    pub error_max: Option<f64>,
    /// Greatest permitted distance of the line from the nearest sample.
    pub difference_max: Option<f64>,
    /// The largest gap between the samples that are fitted.
    pub gap_max: Option<Span>,
    /// The first instant that is fitted.
    pub start: Option<Time>,
    /// The last instant that is fitted.
    pub end: Option<Time>,
}

/// A test of a value.
#[derive(Clone, Debug, PartialEq)]
pub enum Constraint {
    /// A relation; `=` may have a tolerance.
    Compare(Relation, Value, Option<f64>),
    /// Takes the value: `= ?x`.
    Bind(String),
    /// Between both, each included.
    Range(Option<f64>, Option<f64>),
    /// An odd integer.
    Odd,
}

/// Relations of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Relation {
    Equal,
    Different,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

/// Part of a pattern.
#[derive(Clone, Debug, PartialEq)]
pub enum Term {
    /// This value.
    Is(Value),
    /// Any value; the same name must have the same value.
    Variable(String),
    /// Anything.
    Any,
}

/// The beginning or end of an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Edge {
    Start,
    End,
}

/// A `:constraint` over the results of parts.
#[derive(Clone, Debug, PartialEq)]
pub enum Test {
    /// `(REL (- (EDGE ?a) (EDGE ?b)) SPAN)`.
    Apart(Relation, (Edge, String), (Edge, String), Span),
    /// `(REL ?x NUMBER)`.
    Number(Relation, String, f64),
}

/// Aggregates over samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Statistic {
    Count,
    Mean,
    Sum,
    Min,
    Max,
    Median,
    Difference,
    Variance,
    StandardDeviation,
    TimeWeightedMean,
    TimeWeightedVariance,
    TimeWeightedDeviation,
}

/// Movement of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trend {
    /// The slope of the line through all, per second.
    Rate,
    /// Each difference of two neighbours.
    Step,
    /// Samples per second.
    Frequency,
}

/// Allen's thirteen relations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Allen {
    Before,
    After,
    Meets,
    MetBy,
    Overlaps,
    OverlappedBy,
    Starts,
    StartedBy,
    Finishes,
    FinishedBy,
    During,
    Contains,
    Cotemporal,
}
