//! State of the parts of a monitor that watch no samples themselves: messages, tasks, time, functions, and parts that relate others in
//! time, namely Allen relations and absence (`condition-rules.md`, rules 7, 14, 15).

use crate::state::monitors::monitor::{Part, Satisfaction};
use apex_model::condition::{AllenRelation, Timing};
use apex_model::expression::Expr;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::sync::Arc;

/// State of an Allen relation between adjacent parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AllenPart {
    /// The relation that each part has to the next.
    pub relation: AllenRelation,
    /// End points that are at most this far apart count as equal; a point is earlier than another only by more than this.
    pub tolerance: Duration,
    /// The parts in written order.
    pub parts: Vec<Part>,
    /// Results of each part, in the same order.
    pub sides: Vec<RelationSide>,
    /// Constraints that the related results must satisfy.
    pub constraints: Vec<Expr>,
    /// True if the parts share variables: results with different bindings are then not combined.
    pub shares: bool,
    /// Results that cannot change any longer; only the first if one suffices.
    pub found: Vec<Chain>,
    /// Results with an open run, as last evaluated.
    pub passing: Vec<Chain>,
    /// True if only the end of an open run can decide the relation.
    pub undecided: bool,
    /// Next instant at which time alone can decide: a run without samples is over, or a delay within a part.
    pub decides_at: Option<Time>,
}

/// Results of parts that are related, each to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chain {
    /// The parts' intervals, in written order.
    pub intervals: Vec<(Time, Time)>,
    /// The result: hull, bindings and evidence of all.
    pub result: Satisfaction,
}

/// Results of a part of a relation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RelationSide {
    /// Final results that a later result of a neighbour could still be related to.
    pub settled: Vec<Satisfaction>,
    /// Number of results that were ever final.
    pub count: u64,
    /// The newest result, for explanations, and whether its run is open.
    pub newest: Option<((Time, Time), bool)>,
    /// The number of kept results at which those that no later result can be related to are searched and dropped.
    pub sweep_at: usize,
}

/// State of `(:absent C :for D)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AbsentPart {
    /// The part that must be absent.
    pub part: Part,
    /// Duration for which the part must be absent.
    pub length: Duration,
    /// The end of the last result of the part, or the window's start: the start of the present absence.
    pub since: Time,
    /// The same, computed only from results that no sample can replace any longer.
    pub since_final: Time,
    /// True if the part holds now: it is then not absent.
    pub goes_on: bool,
    /// True if the data do not decide whether the part holds.
    pub unknown: bool,
    /// For a part that holds at instants (`:not`, `:function`, a regression): the instant since which every evaluation found it true or
    /// undecided. Absence begins with the first evaluation that does not.
    pub broken: Option<Time>,
    /// For each part of an `:and` whose combinations are all valid, the span of its final results, stored in place of them.
    pub reached: Vec<Option<(Time, Time)>>,
    /// For an order of samples and messages, the points that later ones may follow, stored in place of them.
    pub order: Option<Box<OrderSpan>>,
    /// Evidence that arrived while the part held or was undecided: the windows between are judged when that is over.
    pub seen: Vec<(Time, Time)>,
    /// The start of the newest reported window.
    pub told: Option<Time>,
    /// Windows that begin at this instant or later were withdrawn, and may pass again.
    pub taken_back: Option<Time>,
    /// The windows that passed without a result of the part; only the first if one suffices.
    pub found: Vec<Satisfaction>,
    /// Next instant at which time alone can decide.
    pub decides_at: Option<Time>,
}

/// Progress of an absent order of samples and messages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrderSpan {
    /// For each point the least and the greatest time from the preceding one, according to constraints.
    pub limits: Vec<(Duration, Duration)>,
    /// For each point of the order, in order.
    pub steps: Vec<SpanStep>,
    /// The time that complete chains cover, as far as windows before it may still be withdrawn.
    pub covered: VecDeque<CoveredSpan>,
    /// True once a chain was found.
    pub found: bool,
}

/// Time without a window between the chains that cover it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoveredSpan {
    /// The start of the first chain and the end of the last one.
    pub interval: (Time, Time),
    /// The instant at which the window before it was judged.
    pub noted_at: Time,
}

/// Samples or messages of one part of an order that no later arrival can replace.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpanStep {
    /// Points of which it is not known yet whether a chain ends in them, in order of time.
    pub pending: VecDeque<Time>,
    /// Points in which chains end, in order of time, and the earliest start of these chains.
    pub ends: VecDeque<(Time, Time)>,
    /// True once the part had a result.
    pub held: bool,
}

/// State of `(:function EXPR)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FunctionPart {
    /// The expression.
    pub expression: Expr,
    /// Its value as text, as last evaluated; `None` before, and after an error.
    pub value: Option<String>,
    /// The present instant as result, if the function is true now.
    pub holds: Option<Satisfaction>,
}

/// State of an event condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EventPart {
    /// The form waited for.
    pub pattern: Arc<Pattern>,
    /// Constraints on when it happened.
    pub timing: Arc<Timing>,
    /// True if the window reaches before the oldest message that was kept when the monitor was made.
    pub blind: bool,
    /// Results.
    pub settled: Vec<Satisfaction>,
}

/// State of a wait for a task's end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TaskEndedPart {
    /// The step's tag.
    pub variable: Symbol,
    /// True if an end before the window counts too.
    pub standing: bool,
    /// The task, once it is known.
    pub task: Option<TaskId>,
    /// Instant of the end.
    pub ended: Option<Time>,
}

/// State of a wait for a task's state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TaskStatePart {
    /// The task.
    pub expression: Expr,
    /// The state's name.
    pub state: Pattern,
    /// True if the state at the beginning of the window counts too.
    pub standing: bool,
    /// The task, once it is known.
    pub task: Option<TaskId>,
    /// Results.
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
    /// True once an Allen relation has taken the result of this part.
    #[serde(default)]
    pub taken: bool,
}

/// The instants of the samples of an episode that bound its intervals. A run of n samples has n (n + 1) / 2 pairs; an order needs only the
/// instants, because a pair is a beginning followed by an end of the same run, after at least the least and at most the greatest duration.
/// The newest sample is separate, because a later arrival of its instant may still replace it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PairPoints {
    /// Beginnings before the newest sample, in order of time.
    pub starts: Vec<Satisfaction>,
    /// Ends before the newest sample, in order of time.
    pub ends: Vec<Satisfaction>,
    /// First and last sample of the runs that contain these instants, in order of time.
    pub runs: Vec<(Time, Time)>,
    /// The least and the greatest duration of a pair.
    pub durations: (Duration, Duration),
    /// Beginnings in the last of these runs: the first one, or with a greatest duration all that a later sample may still follow.
    pub begun: VecDeque<Time>,
    /// The newest sample but one.
    pub settled_at: Option<Time>,
    /// The newest sample, if it satisfies the value constraints.
    pub newest: Option<NewestPoints>,
    /// True if a pair that ends before the newest sample was found since results were reported.
    pub held: bool,
}

/// The points of the newest sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NewestPoints {
    /// The first sample of its run.
    pub run_start: Time,
    /// Its instant.
    pub at: Time,
    /// Set if a pair may begin with it.
    pub start: Option<Satisfaction>,
    /// Set if a pair ends with it.
    pub end: Option<Satisfaction>,
    /// True if the pairs that end with it belong to a reported result.
    pub used: bool,
}
