//! Monitors: the incremental state of one condition (paper, section III; `conditions.md`).
//!
//! A monitor is a tree with the shape of its condition. It is plain data: the services in the executive's `monitoring` folder create it,
//! pass it stimuli and read its verdict.

use crate::state::bindings::Bindings;
use crate::state::monitors::cyclic::CyclicPart;
use crate::state::monitors::numbers::{PersistedPart, RegressionPart, StatisticalPart};
pub use crate::state::monitors::unmet::Unmet;
use apex_model::condition::{EpisodeCondition, MeasurementCondition, Relation};
use apex_model::event::StateVariable;
use apex_model::evidence_list::EvidenceList;
use apex_model::expression::Expr;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;
use std::collections::BTreeMap;
use std::sync::Arc;

pub use crate::state::monitors::orders::{PointLimit, PointOrder};
pub use crate::state::monitors::parts::{
    AbsentPart, AllenPart, Chain, CoveredSpan, EventPart, FunctionPart, NewestPoints, OrderSpan, PairPoints,
    RelationSide, SpanStep, TaskEndedPart, TaskStatePart, TimePart,
};

/// Instant from which evidence counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Window {
    /// The first instant that counts; closed.
    pub start: Time,
    /// Samples and messages with an arrival number up to this one do not count: a repeated task has answered them.
    pub after_sequence: Option<u64>,
}

impl Window {
    /// Returns a window that contains everything from `start` on.
    pub fn from(start: Time) -> Window {
        Window { start, ..Window::default() }
    }
    /// Returns true if evidence of this instant and arrival counts.
    pub fn contains(&self, at: Time, sequence: u64) -> bool {
        at >= self.start && self.after_sequence.is_none_or(|after| sequence > after)
    }
}

/// One way in which a condition is true.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Satisfaction {
    /// First and last evidence, closed.
    pub interval: (Time, Time),
    /// The instant at which the result was known.
    pub recognised_at: Time,
    /// Pattern variables, object variables and tags (as intervals).
    pub bindings: Bindings,
    /// Evidence.
    pub evidence: EvidenceList,
}

/// Verdict of a monitor.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// True with this result: the one recognised first; of several, the first in written order of parts.
    Satisfied(Satisfaction),
    /// Not true up to now.
    NotSatisfied,
    /// The data do not decide the condition.
    Unknown,
}

/// Kind of stimulus that a monitor receives.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Interest {
    /// Samples of one variable.
    Variable(StateVariable),
    /// Samples of an attribute of any object.
    Attribute(Symbol),
    /// Messages whose form is this symbol or begins with it.
    EventHead(Symbol),
    /// All messages.
    AnyEvent,
    /// Transitions of one task.
    Task(TaskId),
    /// Transitions of all tasks: the task is not known yet.
    AnyTask,
    /// Every instant at which an event happens.
    EveryStep,
}

/// The state of one condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Monitor {
    /// Instant of its creation.
    pub created_at: Time,
    /// Instant from which evidence counts.
    pub window: Window,
    /// The condition's tree.
    pub root: Part,
    /// Instant of the last verdict.
    pub asked_at: Time,
    /// Data that few monitors have.
    pub notes: Option<Box<Notes>>,
}

/// Rarely used parts of a monitor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Notes {
    /// End of a delay at the end of an order, as the last verdict computed it.
    pub delay_over_at: Option<Time>,
    /// Errors of evaluation that are not reported yet.
    pub troubles: Vec<ConditionFault>,
    /// Errors that were reported: each is reported once.
    pub told: Vec<ConditionFault>,
}

/// An error inside a condition's expression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConditionFault {
    /// Failure, human-readable.
    pub message: String,
    /// Position in the PDL text.
    pub place: Place,
}

/// Results that a part must remember.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Keep {
    /// The first result suffices: no other part depends on this one.
    First,
    /// All results: another part shares a variable with this part, or a constraint compares it.
    Every,
}

/// One condition within the tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// The name that is bound to the result's interval.
    pub tag: Option<Symbol>,
    /// Position in the PDL text.
    pub place: Place,
    /// Instant from which evidence counts.
    pub window: Window,
    /// Results that the part remembers.
    pub keep: Keep,
    /// True if a limit was reached in the part or within it: a result may be missing.
    pub forgotten: bool,
    /// Its kind and state.
    pub kind: PartKind,
}

/// Kinds of parts with their state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum PartKind {
    /// A constraint on one sample.
    Measurement(Box<MeasurementPart>),
    /// A constraint on a run of samples.
    Episode(Box<EpisodePart>),
    /// A constraint on a persisted value.
    Persisted(Box<PersistedPart>),
    /// A constraint on a value that a line of least squares gives.
    Regression(Box<RegressionPart>),
    /// Constraints on statistics and trends of a run of samples.
    Statistical(Box<StatisticalPart>),
    /// Values that rise and fall.
    Cyclic(Box<CyclicPart>),
    /// A message.
    Event(Box<EventPart>),
    /// The end of a task.
    TaskEnded(Box<TaskEndedPart>),
    /// A task's state.
    TaskState(Box<TaskStatePart>),
    /// All parts, with constraints over them.
    And(Box<Composite>),
    /// One of the parts, with constraints over it.
    Or(Box<Composite>),
    /// All parts, each ending before the next starts.
    InOrder(Box<Composite>),
    /// No result of the part.
    Not(Box<Part>),
    /// An instant, or a span of instants, has arrived.
    Timestamp(Box<TimePart>),
    /// A duration after the window's start.
    Delay(Box<TimePart>),
    /// Each part has an Allen relation to the next.
    Allen(Box<AllenPart>),
    /// A whole window without the part.
    Absent(Box<AbsentPart>),
    /// An expression is true.
    Function(Box<FunctionPart>),
}

/// Parts under `:and`, `:or`, `:in-order`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Composite {
    /// The parts in written order.
    pub parts: Vec<Part>,
    /// All must be true of a combination of results.
    pub constraints: Vec<Expr>,
    /// True if results of the parts must be combined: they share variables, or have constraints or an order.
    pub combines: bool,
    /// The variables that occur in more than one part.
    pub shared: Vec<Symbol>,
    /// Bookkeeping of an order of samples and messages of which only the first result for each set of bindings is required.
    pub order: Option<Box<PointOrder>>,
    /// Number of kept results from which on useless ones are searched and removed, in an `:and` of which only the first result for each set
    /// of bindings is required; `None` if another result may be required.
    pub sweep_at: Option<usize>,
    /// Pairs of parts of an `:and` whose results must lie within these limits of each other; a part is in at most one pair.
    pub pairs: Vec<PointLimit>,
}

impl Composite {
    /// Returns true if the part at this place is in a pair.
    pub fn is_paired(&self, number: usize) -> bool {
        self.pairs.iter().any(|pair| pair.first == number || pair.second == number)
    }
}

/// A value test, prepared to be cheap for each sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Test {
    /// Comparison with a value known beforehand, already in the variable's unit.
    Fixed {
        /// The relation.
        relation: Relation,
        /// The right side.
        right: Value,
    },
    /// Any other constraint, evaluated for each sample: its index among those of the condition.
    General(u32),
}

/// Value tests in written order; most conditions have one.
pub type Tests = SmallVec<[Test; 1]>;

/// State of a measurement condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasurementPart {
    /// The condition.
    pub condition: Arc<MeasurementCondition>,
    /// The value tests, prepared.
    pub tests: Tests,
    /// The state variable; `None` while its object is unknown.
    pub variable: Option<StateVariable>,
    /// True if the window reaches before the oldest sample that was kept when the monitor was made.
    pub blind: bool,
    /// Received samples; `None` for most monitors that wait, because they receive only samples that may matter.
    pub seen: Option<Box<SeenSamples>>,
}

/// Samples that a measurement condition has received.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SeenSamples {
    /// Results that no later arrival of the same instant can withdraw.
    pub settled: Vec<Satisfaction>,
    /// The newest sample of each object.
    pub newest: Newest,
}

/// The newest samples of the objects that a measurement condition follows. A condition on a known variable does not receive samples that
/// cannot satisfy it; the variable's history contains these.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Newest {
    /// No sample yet.
    #[default]
    None,
    /// The only object so far, with its newest sample.
    One(Value, NewestSample),
    /// The newest samples of several objects.
    Several(#[serde(with = "crate::state::pairs")] BTreeMap<Value, NewestSample>),
}

impl Newest {
    /// Returns the number of objects.
    pub fn len(&self) -> usize {
        match self {
            Newest::None => 0,
            Newest::One(..) => 1,
            Newest::Several(map) => map.len(),
        }
    }

    /// Returns true if there are no samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the newest sample of `object`.
    pub fn get(&self, object: &Value) -> Option<&NewestSample> {
        match self {
            Newest::None => None,
            Newest::One(present, sample) => (present == object).then_some(sample),
            Newest::Several(map) => map.get(object),
        }
    }

    /// Returns the newest sample of `object`, mutably.
    pub fn get_mut(&mut self, object: &Value) -> Option<&mut NewestSample> {
        match self {
            Newest::None => None,
            Newest::One(present, sample) => (present == object).then_some(sample),
            Newest::Several(map) => map.get_mut(object),
        }
    }

    /// Adds or replaces the newest sample of `object`.
    pub fn insert(&mut self, object: Value, sample: NewestSample) {
        *self = match std::mem::take(self) {
            Newest::None => Newest::One(object, sample),
            Newest::One(present, _) if present == object => Newest::One(object, sample),
            Newest::One(present, first) => Newest::Several(BTreeMap::from([(present, first), (object, sample)])),
            Newest::Several(mut map) => {
                map.insert(object, sample);
                Newest::Several(map)
            }
        };
    }

    /// Takes the results of all newest samples out, in order of the objects' first appearance.
    pub fn take_results(&mut self) -> Vec<Satisfaction> {
        let mut taken: Vec<(u64, Satisfaction)> = match self {
            Newest::None => Vec::new(),
            Newest::One(_, sample) => sample.result.take().map(|result| (sample.rank, result)).into_iter().collect(),
            Newest::Several(map) => {
                map.values_mut().filter_map(|sample| Some((sample.rank, sample.result.take()?))).collect()
            }
        };
        taken.sort_by_key(|(rank, _)| *rank);
        taken.into_iter().map(|(_, result)| result).collect()
    }

    /// Returns all newest samples, in order of their objects.
    pub fn samples(&self) -> impl Iterator<Item = &NewestSample> {
        let (one, several) = match self {
            Newest::None => (None, None),
            Newest::One(_, sample) => (Some(sample), None),
            Newest::Several(map) => (None, Some(map.values())),
        };
        one.into_iter().chain(several.into_iter().flatten())
    }
}

/// The newest sample of one object, which a later arrival of the same instant may still replace.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NewestSample {
    /// Order of the object's first appearance.
    pub rank: u64,
    /// The sample's instant.
    pub at: Time,
    /// Its result, if the sample satisfies the condition.
    pub result: Option<Satisfaction>,
}

/// State of an episode condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodePart {
    /// The condition.
    pub condition: Arc<EpisodeCondition>,
    /// The value tests, prepared.
    pub tests: Tests,
    /// The state variable; `None` while its object is unknown.
    pub variable: Option<StateVariable>,
    /// The greatest gap between samples; `None` does not constrain.
    pub gap_max: Option<Duration>,
    /// Minimum duration of the run; one tick more than D for `(> D)`.
    pub duration_min: Duration,
    /// True if a constraint on end or duration is not a lower bound: it is decided when the run is over.
    pub at_close: bool,
    /// True if any two samples of a run bound an episode; false if only the whole run is one.
    pub any_pair: bool,
    /// True if the window reaches before the oldest sample that was kept when the monitor was made.
    pub blind: bool,
    /// Results of runs that are over.
    pub settled: Vec<Satisfaction>,
    /// Kept instead of the results of pairs where the episode is a part of an order that needs only the instants of samples.
    pub points: Option<Box<PairPoints>>,
    /// The run of each object.
    #[serde(with = "crate::state::pairs")]
    pub runs: BTreeMap<Value, ObjectRun>,
}

/// Samples of one object. The newest is separate, because a later arrival of its instant may still replace it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectRun {
    /// Order of the object's first appearance.
    pub rank: u64,
    /// The run up to the sample before the newest.
    pub run: Option<Run>,
    /// The newest sample.
    pub newest: RunSample,
    /// The result of the current run, once it has one.
    pub found: Option<Satisfaction>,
    /// True if a sample before the newest contradicted the value constraints, and no gap has followed.
    pub contradicted: bool,
    /// The gap that cut the last run.
    pub gap: Option<Duration>,
}

/// The newest sample of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunSample {
    /// Its instant.
    pub at: Time,
    /// Bindings, if the sample satisfies the value constraints.
    pub holds: Option<Bindings>,
    /// True if it agrees with the bindings of the preceding run.
    pub joins: bool,
    /// True if it satisfies the constraints on first values.
    pub first_holds: bool,
    /// True if it satisfies the constraints on last values.
    pub last_holds: bool,
}

/// A run of samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// First sample's instant.
    pub start: Time,
    /// Last sample's instant.
    pub last: Time,
    /// Number of samples.
    pub samples: u64,
    /// Bindings of its samples.
    pub bindings: Bindings,
    /// True if its first sample satisfies the constraints on first values.
    pub first_holds: bool,
    /// True if its last sample satisfies the constraints on last values.
    pub last_holds: bool,
    /// All instants, kept only where any pair may bound an episode.
    pub instants: Vec<Time>,
}
