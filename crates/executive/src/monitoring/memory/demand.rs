//! Demands on memory (M&I)
//! What: describes how far back a clause looks, and the reason.
//! Runs: when a library is loaded or reported on.
//! Reads: nothing.
//! Writes: nothing.
//! Bound: O(1).
//! PDL: all conditions, queries and `log` clauses.
//! Paper: section IV, logging and retrieving data.

use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;

/// Remembered data.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// Samples of one attribute, for each object.
    Attribute(Symbol),
    /// Samples of any attribute.
    EveryAttribute,
    /// Messages.
    Messages,
    /// Messages that begin with this word.
    MessagesOf(Symbol),
}

/// Amount of remembered data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// A duration before the newest.
    Span(Duration),
    /// Everything, up to the hard limit.
    Unbounded,
    /// Data that a log policy keeps while its procedure is at work.
    Log {
        /// Maximum age of the data; `None`: unlimited.
        time: Option<Duration>,
        /// Maximum number of samples or messages; `None`: unlimited.
        count: Option<u64>,
    },
}

/// Reason to remember.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// A query or a constraint on time names its window.
    Window,
    /// Late samples are accepted.
    Lateness,
    /// A `:timestamp` without an earliest time that is written out.
    AnyTime,
    /// An episode's start or end is constrained.
    EpisodeTimes,
    /// A message's time is constrained, without an earliest time that is written out.
    EventTimes,
    /// A condition counts from its task's creation, but can be watched later only.
    SinceCreation,
    /// A query whose depth is only known when it is evaluated.
    QueryTime,
    /// A query whose variable is only known when it is evaluated.
    QueryVariable,
    /// The fit interval of a line begins at a time that is not written out.
    FitInterval,
    /// A `:custom` trend reads all values of an episode.
    Values,
    /// Cycles are looked for in all that is remembered.
    Cycles,
    /// A derived state variable joins it with others.
    Join,
    /// A `log` clause.
    Log,
}

impl Why {
    /// Returns the reason for the demand, and the PDL that would make it smaller.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Why::Window => ("it names its window", "a shorter window"),
            Why::Lateness => (
                "after a late sample, waiting conditions evaluate their whole window again",
                "no `:lateness`, if the variable's samples arrive in order",
            ),
            Why::AnyTime => {
                ("its samples may be of any age", "an earliest time before now: `:timestamp (> (- +now+ P10M))`")
            }
            Why::EpisodeTimes => (
                "its run may have begun at any time before",
                "no `:start` and no `:end`: without them it counts from its task's creation",
            ),
            Why::EventTimes => {
                ("its message may be of any age", "an earliest time before now: `:timing (:es (- +now+ P10M))`")
            }
            Why::SinceCreation => (
                "it counts from its task's creation, but names a task that is known only later",
                "two steps: one that waits for the task, and a later one that waits for this condition",
            ),
            Why::QueryTime => (
                "the span of its query is known only when the query is evaluated",
                "a window such as `P10M`, or an instant such as `(- +now+ P10S)`",
            ),
            Why::QueryVariable => {
                ("its state variable is known only when the query is evaluated", "the name of the state variable")
            }
            Why::FitInterval => (
                "the samples of its line may be of any age",
                "a `:start` before now that is written out: `:start (- +now+ P10M)`",
            ),
            Why::Values => {
                ("its predicate takes all values of the episode", "a statistic or another trend, which keep no values")
            }
            Why::Cycles => ("it searches all kept samples for cycles", "a condition with a window"),
            Why::Join => ("a derived state variable joins it with others", "a shorter limit in its `:join`"),
            Why::Log => ("its policy has no `:time-limit` and no `:count-limit`", "`:time-limit P10M`"),
        }
    }
}

/// Demand of one clause.
#[derive(Clone, Debug, PartialEq)]
pub struct Demand {
    /// Data that it reads.
    pub subject: Subject,
    /// Depth.
    pub reach: Reach,
    /// Reason.
    pub why: Why,
    /// The clause as PDL.
    pub text: String,
    /// Position in the PDL text.
    pub place: Place,
}

impl Demand {
    /// Returns true if the demand has no stated bound.
    pub fn is_unbounded(&self) -> bool {
        matches!(self.reach, Reach::Unbounded | Reach::Log { time: None, count: None })
    }

    /// Returns the reason of the clause's demand.
    pub fn reason(&self) -> &'static str {
        self.why.words().0
    }

    /// Returns the PDL to write for a smaller demand.
    pub fn help(&self) -> &'static str {
        self.why.words().1
    }
}
