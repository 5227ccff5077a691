//! Reasons of wakes (M&I)
//! What: states the reason for which time alone may change a verdict.
//! Runs: with every wake.
//! Reads: nothing.
//! Writes: nothing.
//! Bound: O(1).
//! PDL: `:max-gap`, `:duration`, `:delay`, `:timestamp`, `:absent`, `:estimation`.
//! Paper: section III, condition monitoring.

use apex_model::time::Duration;
use std::fmt;

/// Reason for which time alone may change a verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum WakeReason {
    /// A run without samples for longer than this is over.
    GapEnds(Duration),
    /// A run has reached its duration.
    DurationReached(Duration),
    /// An instant that the last verdict foresaw: the end of a `:delay` at the end of an order, or the instant at which an estimate, a run
    /// or a window satisfies its constraints.
    Foreseen,
    /// A `:delay` is over.
    Delay,
    /// A `:timestamp` is reached.
    Timestamp,
    /// A relation of runs can be decided, because one of the runs is over.
    RelationDecided,
    /// The window of an absence is over.
    AbsenceOver(Duration),
}

impl fmt::Display for WakeReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WakeReason::GapEnds(gap) => write!(f, "no sample for more than {gap} ends the episode"),
            WakeReason::DurationReached(span) => write!(f, ":duration {span} of the episode is reached"),
            WakeReason::Foreseen => f.write_str("a :delay is over, or an estimate or a window meets its constraints"),
            WakeReason::Delay => f.write_str(":delay is over"),
            WakeReason::Timestamp => f.write_str(":timestamp is reached"),
            WakeReason::RelationDecided => f.write_str("an episode without samples is over, which decides a relation"),
            WakeReason::AbsenceOver(length) => write!(f, "the {length} of an :absent are over, or its episode is"),
        }
    }
}
