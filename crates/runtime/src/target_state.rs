//! States of a mission's targets, as the record stores them.

use apex_model::time::Time;
use serde::{Deserialize, Serialize};

/// The message that changes the value of a target, `(new-value ID NUMBER)`.
pub const NEW_VALUE: &str = "new-value";
/// Highest value of a target; a message with a higher one changes nothing.
pub const TARGET_VALUE_MAX: f64 = 1e9;

/// State of a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TargetState {
    /// The target is part of the plan.
    Planned,
    /// The vehicle observes the target now.
    Observing,
    /// The target was observed.
    Observed,
    /// The plan leaves the target out.
    Skipped,
}

impl TargetState {
    /// Returns the state's word in the record.
    pub fn word(self) -> &'static str {
        match self {
            TargetState::Planned => "planned",
            TargetState::Observing => "observing",
            TargetState::Observed => "observed",
            TargetState::Skipped => "skipped",
        }
    }
}

/// A target changed its state.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TargetChange {
    /// The target's id.
    pub target: String,
    /// Instant.
    pub at: Time,
    /// The new state.
    pub state: TargetState,
    /// Reason, or the planned time, `for 9:30:00`; may be empty.
    pub detail: String,
}
