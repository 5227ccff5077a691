//! Reasons for the end of a probing, with their words. The state of a probing is in the executive's `state::probing`.

use crate::time::Duration;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Reason for which probing ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ProbingEnd {
    /// The condition holds.
    Satisfied,
    /// No task waits for the condition any longer.
    NotAwaited,
    /// Its `:time-limit` is over.
    TimeLimit(Duration),
    /// Its `:count-limit` is reached.
    CountLimit(u64),
}

impl fmt::Display for ProbingEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ProbingEnd::Satisfied => f.write_str("its condition holds"),
            ProbingEnd::NotAwaited => f.write_str("its condition is no longer awaited"),
            ProbingEnd::TimeLimit(span) => write!(f, "its :time-limit of {span} is over"),
            ProbingEnd::CountLimit(count) => write!(f, "its :count-limit of {count} is reached"),
        }
    }
}

/// Returns the number of a probe as text: `probe 2 of at most 3`, `probe 2`.
pub fn ordinal(number: u64, limit: Option<u64>) -> String {
    match limit {
        Some(limit) => format!("probe {number} of at most {limit}"),
        None => format!("probe {number}"),
    }
}

/// Returns the end of probing as text: `probing stopped after 3 of 3 probes: its :count-limit of 3 is reached`.
pub fn stopped_text(probes: u64, reason: ProbingEnd) -> String {
    let of = match reason {
        ProbingEnd::CountLimit(limit) => format!(" of {limit}"),
        ProbingEnd::Satisfied | ProbingEnd::NotAwaited | ProbingEnd::TimeLimit(_) => String::new(),
    };
    let word = if probes == 1 { "probe" } else { "probes" };
    format!("probing stopped after {probes}{of} {word}: {reason}")
}
