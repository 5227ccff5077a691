//! Conditions, which monitors watch (`conditions.md`, paper Appendix B and Table 1).
//!
//! Everything in the language is representable; a condition that the executive cannot evaluate yet is rejected by the checker with a
//! diagnostic, never ignored.

pub use crate::cyclic::CyclicCondition;
use crate::expression::{Expr, Template};
use crate::pattern::Pattern;
use crate::source::Place;
use crate::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A condition with its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// The name that its result is bound to, without `?`.
    pub tag: Option<Symbol>,
    /// Kind and parameters.
    pub kind: ConditionKind,
    /// Place in the source.
    pub place: Place,
}

/// The forms of conditions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ConditionKind {
    /// One sample of a state variable.
    Measurement(Arc<MeasurementCondition>),
    /// A run of samples of a state variable.
    Episode(Arc<EpisodeCondition>),
    /// All parts hold; constraints over the parts' tags.
    And(Vec<Condition>, Vec<Expr>),
    /// One part holds; constraints over the parts' tags.
    Or(Vec<Condition>, Vec<Expr>),
    /// The part has no result up to now.
    Not(Box<Condition>),
    /// A whole window of this length passed without the part.
    Absent(Box<Condition>, Expr),
    /// Each part ends before the next starts.
    InOrder(Vec<Condition>, Vec<Expr>),
    /// An Allen relation between adjacent parts.
    Allen {
        /// Relation, one of the thirteen.
        relation: AllenRelation,
        /// The parts.
        parts: Vec<Condition>,
        /// Difference within which end points count as equal.
        tolerance: Option<Expr>,
        /// Constraints over tags.
        constraints: Vec<Expr>,
    },
    /// `(:delay D1 [D2])`.
    Delay(Expr, Option<Expr>),
    /// `(:timestamp T1 [T2])`: the current time is T1, or within [T1, T2].
    Timestamp(Expr, Option<Expr>),
    /// An event (atomic episode) whose form matches.
    Event {
        /// The form waited for.
        pattern: Arc<Pattern>,
        /// Constraints on the time of the event.
        timing: Arc<Timing>,
    },
    /// `?s1`, `(end ?s1)`, `(terminated ?s1)`: the task of that step has ended.
    TaskEnded(Symbol),
    /// `(state ?s1 = S)`, `(task-state +this-task+ = S)`; S may be `resumed`, the change interrupted -> ongoing.
    TaskState {
        /// The task: a variable or an indexical.
        task: Expr,
        /// The state's name.
        state: Pattern,
    },
    /// `(:function EXPR)`, pure.
    Function(Expr),
    /// `:probing`: active sensing while the part is watched.
    Probing {
        /// Watched condition.
        condition: Box<Condition>,
        /// The goal pursued to sense.
        goal: Template,
        /// Interval between probes.
        interval: Expr,
        /// Greatest duration of probing.
        time_limit: Option<Expr>,
        /// Greatest number of probes.
        count_limit: Option<Expr>,
    },
    /// `(:cyclic (ATTR OBJ) :period C ..)`.
    Cyclic(Arc<CyclicCondition>),
}

/// `(ATTR OBJ)`: the attribute is fixed, the object may contain variables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VariablePattern {
    /// The attribute, for example `roll-angle`.
    pub attribute: Symbol,
    /// The object: a list pattern for several objects, the literal nil for none.
    pub object: Pattern,
}

/// A constraint on one sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasurementCondition {
    /// The state variable.
    pub variable: VariablePattern,
    /// All must hold of the value.
    pub value: Vec<Constraint>,
    /// All must hold of the object.
    pub object: Vec<Constraint>,
    /// All must hold of the time stamp; empty means the default window, from the creation of the task on.
    pub timestamp: Vec<Constraint>,
    /// Estimation of values between samples.
    pub estimation: Option<Estimation>,
}

/// One constraint on a value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Constraint {
    /// `REL expr [+/- tolerance]`.
    Compare {
        /// The relation.
        relation: Relation,
        /// The right side.
        right: Expr,
        /// Symmetric tolerance of `=`.
        tolerance: Option<Expr>,
    },
    /// The value matches a pattern, and may bind variables (`= ?loc`).
    Matches(Pattern),
    /// A predicate by name, with arguments after the value.
    Predicate(Symbol, Vec<Expr>),
    /// `(:range a b)`, closed; `:min` and `:max` leave one side open.
    Range(Option<Expr>, Option<Expr>),
}

/// Comparison of measured values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Relation {
    /// `=`
    Equal,
    /// `/=`
    Different,
    /// `<`
    Less,
    /// `<=`
    LessOrEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterOrEqual,
}

/// Values between and beyond samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Estimation {
    /// The last sample holds, at most for the timeout.
    Persist(Option<Expr>),
    /// Least squares line; options by keyword without the colon.
    LinearRegression(Vec<(Symbol, Expr)>),
}

/// A constraint on a run of samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeCondition {
    /// The state variable.
    pub variable: VariablePattern,
    /// The required sampling quality; stating none is a load-time error.
    pub quality: Quality,
    /// `:any`: any two samples of a run bound an episode, not only the whole run (`condition-rules.md`, rule 7).
    pub any: bool,
    /// Must hold of every value in the run.
    pub value: Vec<Constraint>,
    /// Must hold of the first value.
    pub first_value: Vec<Constraint>,
    /// Must hold of the last value.
    pub last_value: Vec<Constraint>,
    /// Must hold of the object.
    pub object: Vec<Constraint>,
    /// Constraints on start, end and duration.
    pub timing: Timing,
    /// Aggregates: name without the colon and constraints.
    pub stats: Vec<(Symbol, Vec<Constraint>)>,
    /// Trends: name without the colon and constraints.
    pub trend: Vec<(Symbol, Vec<Constraint>)>,
}

/// Required density of samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Quality {
    /// Every arrival counts.
    NoConstraints,
    /// The largest gap between samples, and from the last sample to now.
    MaximumGap(Expr),
}

/// Constraints on an interval.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// On the start.
    pub start: Vec<Constraint>,
    /// On the end.
    pub end: Vec<Constraint>,
    /// On end - start.
    pub duration: Vec<Constraint>,
}

/// Allen's thirteen relations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum AllenRelation {
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

impl AllenRelation {
    /// Returns the relation's keyword, without its colon.
    pub fn word(self) -> &'static str {
        match self {
            AllenRelation::Before => "before",
            AllenRelation::After => "after",
            AllenRelation::Meets => "meets",
            AllenRelation::MetBy => "met-by",
            AllenRelation::Overlaps => "overlaps",
            AllenRelation::OverlappedBy => "overlapped-by",
            AllenRelation::Starts => "starts",
            AllenRelation::StartedBy => "started-by",
            AllenRelation::Finishes => "finishes",
            AllenRelation::FinishedBy => "finished-by",
            AllenRelation::During => "during",
            AllenRelation::Contains => "contains",
            AllenRelation::Cotemporal => "cotemporal",
        }
    }
}
