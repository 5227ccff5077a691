//! Input of the arbiter's decision among claimants at one instant.

use std::collections::BTreeMap;

/// Everything that determines the decision, except for the time.
#[derive(PartialEq)]
pub(crate) struct Competition {
    /// All tasks that claim resources or work.
    pub(crate) competitors: Vec<Competitor>,
    /// The strengths of claims and defences, the weakest first; true where a strength equals the previous one.
    pub(crate) order: Vec<(usize, bool, bool)>,
    pub(crate) ranks: Vec<(usize, Option<f64>)>,
    pub(crate) totals: BTreeMap<String, f64>,
}

/// A task that claims or works, how often its state changed, and its needs.
type Competitor = (usize, usize, Vec<(String, f64)>);
