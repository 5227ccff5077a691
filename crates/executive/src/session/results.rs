//! Output of a session: results, verdicts with their reasons, errors.

#[cfg(doc)]
use super::MonitorSession;
use super::SamplingGap;
use crate::state::clause::MonitorId;
use crate::state::monitors::monitor::{Satisfaction, Unmet, Verdict};
use apex_model::source::Place;
use apex_model::time::Time;

/// A result of a watched condition.
#[derive(Clone, Debug, PartialEq)]
pub struct MonitorResult {
    /// The condition.
    pub watch: MonitorId,
    /// Kind of report.
    pub telling: ResultEvent,
    /// The result: interval, instant of recognition, bindings, evidence.
    pub result: Satisfaction,
    /// The largest sampling gap of each run on which the result rests, as known when this was reported; see
    /// [`MonitorSession::with_gaps`].
    pub gaps: Vec<SamplingGap>,
}

/// Report about a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResultEvent {
    /// The result was recognised just now.
    Recognised {
        /// True if its interval may still grow; it will be reported once more when it is final.
        open: bool,
    },
    /// Its interval is final; it was reported before.
    Closed,
}

/// Status of a condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// Satisfied by the first result; otherwise false or unknown.
    pub verdict: Verdict,
    /// The parts that do not hold, with the reason of each; empty when satisfied.
    pub because: Vec<Unmet>,
    /// Number of reported results.
    pub results: u64,
}

/// An error of a session: a rejected sample, or a condition whose expression failed.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionError {
    /// The condition concerned; `None` for an error without one.
    pub watch: Option<MonitorId>,
    /// Instant.
    pub at: Time,
    /// A message for operators.
    pub message: String,
    /// Position in the text of the condition or library.
    pub place: Option<Place>,
}
