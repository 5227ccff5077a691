//! Trace of a run.

use crate::program::Time;
pub use crate::task::State;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// One event of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Instant.
    pub at: Time,
    /// Task that the event concerns; tasks are numbered in order of creation.
    pub task: usize,
    /// Event.
    pub what: What,
}

/// Kinds of events.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// The task was created as a child of another one, from the step with this tag.
    Created(Option<usize>, String),
    /// The task changed its state: from, to, the outcome, and the cause.
    Moved(State, State, Option<String>, String),
    /// The task sent this text to the outside.
    Informed(String),
    /// The task printed a text.
    Printed(String),
    /// The application is over.
    Finished,
}

/// A whole run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// Events in order.
    pub lines: Vec<Line>,
    /// States at the end of the tasks that a clause may still refer to.
    pub states: BTreeMap<usize, State>,
    /// Holders at the end: resource, task, amount.
    pub holders: BTreeSet<(String, usize, String)>,
    /// Total of each resource at the end.
    pub totals: BTreeMap<String, String>,
    /// Reason if the run was cut short; the trace is right up to that point.
    pub cut: Option<Cut>,
    /// Number of steps of sequences that ended while earlier steps had not.
    pub early_ends: u64,
}

/// Reasons to cut a run short.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// The inputs of this instant never come to rest.
    Restless(Time),
    /// There are too many tasks for this interpreter.
    Long,
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}s ", self.at as f64 / 1e9)?;
        match &self.what {
            What::Created(Some(parent), tag) => write!(f, "T{} {tag} created by T{parent}", self.task),
            What::Created(None, tag) => write!(f, "T{} {tag} created", self.task),
            What::Moved(from, to, outcome, cause) => {
                let outcome = outcome.as_deref().map(|outcome| format!(" ({outcome})")).unwrap_or_default();
                write!(f, "T{} {from} -> {to}{outcome} because {cause}", self.task)
            }
            What::Informed(form) => write!(f, "T{} informs {form}", self.task),
            What::Printed(text) => write!(f, "T{} prints {text}", self.task),
            What::Finished => f.write_str("finished"),
        }
    }
}
