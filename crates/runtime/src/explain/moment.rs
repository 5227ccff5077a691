//! A moment of a task's history: an event or decision about the task.

use super::cause::CauseDetail;
use crate::method_detail::MethodDetail;
use apex_model::time::Time;
use serde::Serialize;
use std::fmt;

/// An event or decision about a task.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Moment {
    /// The decision's number in the record.
    pub id: i64,
    /// Seconds of mission time.
    pub t: f64,
    /// The kind of the effect; `docs/reference/flight-record.md` lists them.
    pub kind: String,
    /// Event, as text.
    pub what: String,
    /// Reason, as text; empty if `what` is complete.
    pub because: String,
    /// `file:line:column` of the clause of PDL.
    pub place: Option<String>,
    /// State before, for `transition`.
    pub from: Option<String>,
    /// State after, for `transition`.
    pub to: Option<String>,
    /// A word of `apex_model::task::OUTCOME_WORDS`, for the transition to `terminated`.
    pub outcome: Option<String>,
    /// The goal, form, clause, resource or variable concerned.
    pub subject: String,
    /// The selected method, for `selected`.
    pub method: Option<MethodDetail>,
    /// The cause with its parts; `None` for a moment that is not a decision.
    pub cause: Option<CauseDetail>,
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "  {:>12}  {}", Time::from_seconds(self.t).to_string(), self.what)?;
        if !self.because.is_empty() {
            write!(f, " because {}", self.because)?;
        }
        match &self.place {
            Some(place) => write!(f, "; from {place}"),
            None => Ok(()),
        }
    }
}
