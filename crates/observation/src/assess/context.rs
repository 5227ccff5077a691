//! Context in which looks are assessed.

use std::collections::BTreeMap;

/// The image of a line or picture that was received on the ground.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Product {
    /// First instant in the image.
    pub from_s: f64,
    /// Last instant in the image.
    pub until_s: f64,
    /// Instant at which the image has arrived on the ground.
    pub on_ground_s: f64,
}

/// Context in which looks are assessed.
#[derive(Clone, Copy, Debug)]
pub struct AssessContext<'a> {
    /// Start of the mission, seconds of Unix time, for the sun.
    pub zero_unix_s: f64,
    /// Images received on the ground.
    pub products: &'a [Product],
    /// First valid look of each target seen so far, for order constraints.
    pub first_valid_s: &'a BTreeMap<String, f64>,
    /// True if losses are computed; planners do not need them.
    pub is_explained: bool,
}
