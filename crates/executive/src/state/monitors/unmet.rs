//! Unmet requirements of a waiting condition, for `apex why`.

use apex_model::source::Place;
use apex_model::time::Time;
use apex_model::value::Value;
use serde::{Deserialize, Serialize};

/// Part of a condition that does not hold, as printed by `apex why`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unmet {
    /// The part as PDL text.
    pub what: String,
    /// Present state.
    pub now: String,
    /// True if no sample or message has arrived that the part could judge.
    pub unobserved: bool,
    /// Since when that is so.
    pub since: Option<Time>,
    /// Instant at which it becomes true by time alone, if nothing changes before.
    pub until: Option<Time>,
    /// Distance of the newest sample from the threshold.
    pub distance: Option<Value>,
    /// Position in the PDL text.
    pub place: Place,
}
