//! Parts of the situation that the report and the next plan read: notes, chosen procedures, the plan that is flown.

use apex_model::problem::Plan;
use apex_model::source::Place;
use apex_model::time::Time;
use serde::{Deserialize, Serialize};

/// A notable decision.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Note {
    /// Instant.
    pub at: Time,
    /// Text, one line.
    pub text: String,
}

/// A procedure that was chosen for a goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Chosen {
    /// Place of the procedure.
    pub place: Place,
    /// Instant of its choice.
    pub since: Time,
}

/// A plan and the instant of its request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MadePlan {
    /// The plan.
    pub plan: Plan,
    /// Instant at which its problem was posed.
    pub made: Time,
}
