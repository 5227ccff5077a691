//! What was gathered where, the most first: the one question of who is beaten by whom.

use super::memory::Targets;

/// Pairs of a value and a set of targets of which none has both more value and fewer targets than another, by value from
/// the highest.
#[derive(Clone, Debug, Default)]
pub(super) struct Front(Vec<(f64, Targets)>);

impl Front {
    /// Has some pair at least `value` and no target but those of `closed`? Counts the pairs that were looked at.
    #[inline]
    pub(super) fn beats(&self, value: f64, closed: Targets, steps: &mut u64) -> bool {
        for (other, seen) in &self.0 {
            *steps += 1;
            if *other < value {
                return false;
            }
            if seen & !closed == 0 {
                return true;
            }
        }
        false
    }

    /// Puts a pair that nothing beats in its place, and takes out what it beats.
    pub(super) fn insert(&mut self, value: f64, seen: Targets, steps: &mut u64) {
        let place = self.0.partition_point(|(other, _)| *other >= value);
        *steps += (self.0.len() - place) as u64;
        self.0.insert(place, (value, seen));
        let mut index = 0;
        self.0.retain(|(_, other)| {
            index += 1;
            index <= place + 1 || seen & !other != 0
        });
    }

    /// Keeps the `most` of the highest value; the highest value of those taken out.
    pub(super) fn shorten(&mut self, most: usize) -> f64 {
        let highest = self.0.get(most).map_or(f64::NEG_INFINITY, |(value, _)| *value);
        self.0.truncate(most);
        highest
    }
}
