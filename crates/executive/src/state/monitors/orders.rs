//! State of orders of samples and messages, and the limits of the time between the points of a combination.

use apex_model::time::Duration;
use serde::{Deserialize, Serialize};

/// Bookkeeping of an order of samples and messages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointOrder {
    /// Number of kept results from which on useless ones are searched and removed.
    pub sweep_at: usize,
    /// For each part how many of its kept results were checked.
    pub checked: Vec<usize>,
    /// True if a pattern variable occurs in the order: each set of bindings has separate chains.
    pub binds: bool,
    /// For each point the least and the greatest time from the preceding one, according to constraints.
    pub limits: Vec<(Duration, Duration)>,
    /// The limits that constraints set on the time between points that are not neighbours.
    pub far: Vec<PointLimit>,
}

/// Limits of the time from one point of a combination to another one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointLimit {
    /// The place of the point that is written first.
    pub first: usize,
    /// The place of the other one.
    pub second: usize,
    /// The least time from the first to the second.
    pub least: Duration,
    /// The greatest one.
    pub most: Duration,
}
