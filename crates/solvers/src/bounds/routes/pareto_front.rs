//! Pareto front of profit and memory: dominance between labels.

use super::ng_sets::Targets;

/// Pairs of a value and a set of targets, in descending order of value. No pair dominates another, that is, has at least its
/// value and a subset of its targets.
#[derive(Clone, Debug, Default)]
pub(super) struct ParetoFront(Vec<(f64, Targets)>);

impl ParetoFront {
    /// Returns true if a pair has at least `value` and only targets of `closed`. Counts the pairs inspected.
    #[inline]
    pub(super) fn beats(&self, value: f64, closed: Targets, steps: &mut u64) -> bool {
        for (other, memory) in &self.0 {
            *steps += 1;
            if *other < value {
                return false;
            }
            if memory & !closed == 0 {
                return true;
            }
        }
        false
    }

    /// Inserts a pair that no other dominates, and removes the pairs that it dominates.
    pub(super) fn insert(&mut self, value: f64, memory: Targets, steps: &mut u64) {
        let place = self.0.partition_point(|(other, _)| *other >= value);
        *steps += (self.0.len() - place) as u64;
        self.0.insert(place, (value, memory));
        let mut index = 0;
        self.0.retain(|(_, other)| {
            index += 1;
            index <= place + 1 || memory & !other != 0
        });
    }

    /// Keeps the `most` pairs of the highest values. Returns the highest value removed.
    pub(super) fn shorten(&mut self, most: usize) -> f64 {
        let highest = self.0.get(most).map_or(f64::NEG_INFINITY, |(value, _)| *value);
        self.0.truncate(most);
        highest
    }
}
