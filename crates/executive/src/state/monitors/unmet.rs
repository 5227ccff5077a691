//! What a waiting condition lacks, for `apex why`.

use apex_model::source::Place;
use apex_model::time::Time;
use apex_model::value::Value;
use serde::{Deserialize, Serialize};

/// Part of a condition that does not hold: what `apex why` prints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unmet {
    /// The part as PDL text.
    pub what: String,
    /// What is known about it now.
    pub now: String,
    /// Since when that is so.
    pub since: Option<Time>,
    /// When it comes true by time alone, if nothing changes before.
    pub until: Option<Time>,
    /// How far the newest sample is from the threshold.
    pub distance: Option<Value>,
    /// Where it stands.
    pub place: Place,
}
