//! Input of the decision between claimants at one instant.

use std::collections::BTreeMap;

/// All that decides who gets what,, except for the time.
#[derive(PartialEq)]
pub(crate) struct Competition {
    /// All that claim or work.
    pub(crate) competitors: Vec<Competitor>,
    /// The strengths with which they claim and defend, the weakest first; true where it is as strong as the one before.
    pub(crate) order: Vec<(usize, bool, bool)>,
    pub(crate) ranks: Vec<(usize, Option<f64>)>,
    pub(crate) totals: BTreeMap<String, f64>,
}

/// A task that claims or works, how often its state changed, and its needs.
type Competitor = (usize, usize, Vec<(String, f64)>);
