//! Targets that a plan leaves out.

use serde::{Deserialize, Serialize};

/// A target that a plan does not visit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// The target's name.
    pub target: String,
    /// Reason, for example "needs 41 min more than endurance leaves".
    pub reason: String,
}
