//! Monitors: the incremental state of one condition (paper, section III; `monitoring.md`).
//!
//! A monitor is a tree with the shape of its condition. It is plain data: the services in the executive's
//! `monitoring` folder create it, feed it and ask it.

use crate::because::Evidence;
use crate::bindings::Bindings;
use crate::condition::{Constraint, EpisodeCondition, MeasurementCondition, Relation, Timing, VariablePattern};
use crate::event::StateVariable;
use crate::expression::Expr;
use crate::pattern::Pattern;
use crate::source::Place;
use crate::symbol::Symbol;
use crate::task::TaskId;
use crate::time::{Duration, Time};
use crate::value::Value;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// From when on evidence counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Window {
    /// The first instant that counts; closed.
    pub start: Time,
    /// Samples and messages with an arrival number up to this do not count, even at the start: set for a repeated
    /// task to the newest arrival it has already answered. None lets everything count.
    pub after_sequence: Option<u64>,
}

impl Window {
    /// Everything from `start` on.
    pub fn from(start: Time) -> Window {
        Window { start, after_sequence: None }
    }

    /// Does evidence of this instant and arrival count?
    pub fn contains(&self, at: Time, sequence: u64) -> bool {
        at >= self.start && self.after_sequence.is_none_or(|after| sequence > after)
    }
}

/// One way in which a condition came true.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Satisfaction {
    /// First and last evidence, closed.
    pub interval: (Time, Time),
    /// The instant at which it was known.
    pub recognised_at: Time,
    /// Pattern variables, object variables and tags (as intervals).
    pub bindings: Bindings,
    /// What was seen.
    pub evidence: Vec<Evidence>,
}

/// What a monitor says about its condition.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// True, in this way: the earliest recognised; among those, the first in written order of parts.
    Satisfied(Satisfaction),
    /// Not true up to now.
    NotSatisfied,
    /// The data do not say.
    Unknown,
}

/// What wakes a monitor's attention.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Interest {
    /// Samples of one variable.
    Variable(StateVariable),
    /// Samples of an attribute of any object.
    Attribute(Symbol),
    /// Messages whose form begins with this symbol, or is it.
    EventHead(Symbol),
    /// All messages.
    AnyEvent,
    /// Transitions of one task.
    Task(TaskId),
    /// Transitions of all tasks: the task is not known yet.
    AnyTask,
}

/// Part of a condition that does not hold: what `apex why` prints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unmet {
    /// The part as PDL text.
    pub what: String,
    /// What is known about it now.
    pub now: String,
    /// Since when that is so.
    pub since: Option<Time>,
    /// Where it stands.
    pub place: Place,
}

/// The state of one condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Monitor {
    /// When it was made.
    pub created_at: Time,
    /// From when on evidence counts.
    pub window: Window,
    /// The condition's tree.
    pub root: Part,
    /// Errors met while judging, not yet reported.
    pub troubles: Vec<Trouble>,
}

/// An error inside a condition's expression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trouble {
    /// What went wrong, for people.
    pub message: String,
    /// Where.
    pub place: Place,
}

/// Which results a part must remember.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Keep {
    /// The first is enough: nothing else depends on it.
    First,
    /// All: another part shares a variable with it, or a constraint compares it.
    Every,
}

/// One condition within the tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Bound to the result's interval.
    pub tag: Option<Symbol>,
    /// Where it stands.
    pub place: Place,
    /// From when on evidence counts.
    pub window: Window,
    /// What it remembers.
    pub keep: Keep,
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
    /// A message.
    Event(Box<EventPart>),
    /// The end of a task.
    TaskEnded(TaskEndedPart),
    /// A task's state.
    TaskState(Box<TaskStatePart>),
    /// All parts, with constraints over them.
    And(Composite),
    /// One of the parts, with constraints over it.
    Or(Composite),
    /// All parts, each ending before the next starts.
    InOrder(Composite),
    /// No result of the part.
    Not(Box<Part>),
    /// An instant, or a span of instants, has come.
    Timestamp(TimePart),
    /// So long after the window's start.
    Delay(TimePart),
}

/// Parts under `:and`, `:or`, `:in-order`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Composite {
    /// The parts in written order.
    pub parts: Vec<Part>,
    /// All must be true of a combination of results.
    pub constraints: Vec<Expr>,
}

/// A value test, prepared so that a sample costs little.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Test {
    /// Comparison with a number known beforehand: SI value and dimension must match the sample's.
    Number {
        /// The relation.
        relation: Relation,
        /// The right side.
        right: Value,
    },
    /// Anything else, evaluated for each sample.
    General(Constraint),
}

/// State of a measurement condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasurementPart {
    /// What is wanted.
    pub condition: Arc<MeasurementCondition>,
    /// The value tests, prepared.
    pub tests: Vec<Test>,
    /// The state variable when its object is known, else none.
    pub variable: Option<StateVariable>,
    /// For how long a sample is valid after its instant, when `:persist` is asked; none is this sample only.
    pub persistence: Option<Duration>,
    /// Results that no later arrival of the same instant can take back.
    pub settled: Vec<Satisfaction>,
    /// The newest sample of each object, in order of first appearance.
    pub newest: Vec<NewestSample>,
}

/// The newest sample of one object, which a later arrival of the same instant may still replace.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NewestSample {
    /// The object.
    pub object: Value,
    /// The sample's instant.
    pub at: Time,
    /// Its result, if it satisfies the condition.
    pub result: Option<Satisfaction>,
}

/// State of an episode condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodePart {
    /// What is wanted.
    pub condition: Arc<EpisodeCondition>,
    /// The value tests, prepared.
    pub tests: Vec<Test>,
    /// The state variable when its object is known, else none.
    pub variable: Option<StateVariable>,
    /// The greatest gap between samples; none is no constraint.
    pub gap_max: Option<Duration>,
    /// Timing, prepared.
    pub timing: RunTiming,
    /// Any two samples of a run bound an episode, not only the whole run.
    pub any_pair: bool,
    /// Results that no later arrival of the same instant can take back.
    pub settled: Vec<Satisfaction>,
    /// The run of each object, in order of first appearance.
    pub runs: Vec<ObjectRun>,
}

/// Bounds on a run, prepared.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunTiming {
    /// The run lasts at least so long; lower bounds can be decided while the run goes on.
    pub duration_min: Option<Duration>,
    /// Set when other constraints exist: they are decided when the run is over.
    pub at_close: Option<Box<Timing>>,
}

/// Samples of one object that satisfy the value constraints without a break.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectRun {
    /// The object.
    pub object: Value,
    /// The run up to the sample before the newest.
    pub run: Option<Run>,
    /// The newest sample's instant.
    pub at: Time,
    /// The newest sample's value.
    pub value: Value,
    /// Whether it satisfies the value constraints, and what they bind.
    pub holds: Option<Bindings>,
    /// The current maximal run already has its settled result, or none can come.
    pub decided: bool,
    /// Something contradicted the condition since the window began.
    pub contradicted: bool,
    /// The last gap that cut a run: its length.
    pub gap: Option<Duration>,
}

/// A run of samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// First sample's instant.
    pub start: Time,
    /// Last sample's instant.
    pub last: Time,
    /// How many samples.
    pub samples: u64,
    /// What its first sample's value and object bind.
    pub bindings: Bindings,
    /// All instants, kept only where any pair may bound an episode.
    pub instants: Vec<Time>,
}

/// State of an event condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EventPart {
    /// The form waited for.
    pub pattern: Arc<Pattern>,
    /// Constraints on when it happened.
    pub timing: Arc<Timing>,
    /// What was found.
    pub settled: Vec<Satisfaction>,
}

/// State of a wait for a task's end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TaskEndedPart {
    /// The step's tag.
    pub variable: Symbol,
    /// The task, as soon as it is known.
    pub task: Option<TaskId>,
    /// When it ended.
    pub ended: Option<Time>,
}

/// State of a wait for a task's state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TaskStatePart {
    /// The task.
    pub expression: Expr,
    /// The state's name.
    pub state: Pattern,
    /// The task, as soon as it is known.
    pub task: Option<TaskId>,
    /// What was found.
    pub settled: Vec<Satisfaction>,
}

/// State of a wait for time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimePart {
    /// First instant, or least delay.
    pub from: Expr,
    /// Last instant, or greatest delay.
    pub to: Option<Expr>,
    /// The first and last instant, as last evaluated.
    pub span: Option<(Time, Time)>,
    /// The instant that satisfied it.
    pub reached: Option<Time>,
}

/// A variable pattern as a state variable, kept for messages.
impl VariablePattern {
    /// True when the object is written without variables and expressions.
    pub fn is_literal(&self) -> bool {
        matches!(self.object, Pattern::Literal(_))
    }
}
