//! Results of a flight's observations.

use super::{FlownObservation, TargetObservations};
use crate::assess::{AssessContext, assess};
use crate::result::TargetResult;
use std::collections::BTreeMap;

impl FlownObservation {
    /// Returns the number of targets.
    pub fn target_count(&self) -> usize {
        self.watched.len()
    }

    /// Returns the results of all targets, in their order, from the observations so far.
    pub fn results(&self) -> Vec<TargetResult> {
        let first_valid_s = self.first_valid_s();
        (0..self.target_count()).filter_map(|number| self.result_of(number, &first_valid_s)).collect()
    }

    /// Returns one of [`FlownObservation::results`], with the first valid looks of all targets; `None` for a number without a target.
    /// Bound: O(looks of the target).
    pub fn result_of(&self, number: usize, first_valid_s: &BTreeMap<String, f64>) -> Option<TargetResult> {
        self.watched.get(number).map(|watched| self.assessed(watched, first_valid_s, true))
    }

    /// Returns the result of one target without the causes of its losses; `None` for an unknown name, and for a target that has not been
    /// seen. Bound: O(looks of the target).
    pub fn result(&self, name: &str) -> Option<TargetResult> {
        let seen = |watched: &&TargetObservations| watched.looks.passes.iter().any(|pass| !pass.looks.is_empty());
        let watched = self.watched.iter().find(|watched| watched.target.name == name).filter(seen)?;
        Some(self.assessed(watched, &self.first_valid_s(), false))
    }

    fn assessed(
        &self,
        watched: &TargetObservations,
        first_valid_s: &BTreeMap<String, f64>,
        is_explained: bool,
    ) -> TargetResult {
        let (zero_unix_s, products) = (self.settings.zero_unix_s, self.products.as_slice());
        let context = AssessContext { zero_unix_s, products, first_valid_s, is_explained };
        assess(&watched.target, &watched.grid, &[&watched.looks], &context)
    }
}
