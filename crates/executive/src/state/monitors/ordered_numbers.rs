//! Numbers in order, for medians, in two halves of equal size (`condition-rules.md`, rule 11).
//!
//! Bound: adding and removing O(log n), the middle O(m log m) when m numbers are left out.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Finite numbers, each as often as it was added.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OrderedNumbers {
    #[serde(with = "crate::state::pairs")]
    low: BTreeMap<i64, u64>,
    #[serde(with = "crate::state::pairs")]
    high: BTreeMap<i64, u64>,
    low_count: u64,
    high_count: u64,
}

/// Returns an integer that is ordered like the number.
fn key(number: f64) -> i64 {
    // Both zeros are one number.
    let bits = (number + 0.0).to_bits() as i64;
    bits ^ (((bits >> 63) as u64) >> 1) as i64
}

fn number(key: i64) -> f64 {
    f64::from_bits((key ^ (((key >> 63) as u64) >> 1) as i64) as u64)
}

fn put(half: &mut BTreeMap<i64, u64>, count: &mut u64, key: i64) {
    *half.entry(key).or_default() += 1;
    *count += 1;
}

fn take(half: &mut BTreeMap<i64, u64>, count: &mut u64, key: i64) -> bool {
    let Some(times) = half.get_mut(&key) else { return false };
    *times -= 1;
    if *times == 0 {
        half.remove(&key);
    }
    *count -= 1;
    true
}

impl OrderedNumbers {
    /// Returns the number of numbers.
    pub fn count(&self) -> u64 {
        self.low_count + self.high_count
    }

    /// Adds a number.
    pub fn add(&mut self, number: f64) {
        let key = key(number);
        if self.high.first_key_value().is_some_and(|(least, _)| key >= *least) {
            put(&mut self.high, &mut self.high_count, key);
        } else {
            put(&mut self.low, &mut self.low_count, key);
        }
        self.balance();
    }

    /// Removes a number that was added.
    pub fn remove(&mut self, number: f64) {
        let key = key(number);
        if !take(&mut self.low, &mut self.low_count, key) {
            take(&mut self.high, &mut self.high_count, key);
        }
        self.balance();
    }

    fn balance(&mut self) {
        while self.low_count > self.high_count + 1 {
            let Some((greatest, _)) = self.low.last_key_value() else { return };
            let greatest = *greatest;
            take(&mut self.low, &mut self.low_count, greatest);
            put(&mut self.high, &mut self.high_count, greatest);
        }
        while self.high_count > self.low_count {
            let Some((least, _)) = self.high.first_key_value() else { return };
            let least = *least;
            take(&mut self.high, &mut self.high_count, least);
            put(&mut self.low, &mut self.low_count, least);
        }
    }

    /// Returns the median with `extra` added and with `without` (each contained) left out; for an even count the mean of the two middle
    /// numbers.
    pub fn median(&self, extra: Option<f64>, without: &[f64]) -> Option<f64> {
        let changes = without.len() + usize::from(extra.is_some());
        let reach = changes + 2;
        let expand = |(key, times): (&i64, &u64)| std::iter::repeat_n(*key, (*times).min(reach as u64) as usize);
        let mut middle: Vec<i64> = self.low.iter().rev().flat_map(expand).take(reach).collect();
        let mut before = self.low_count - middle.len() as u64;
        middle.extend(self.high.iter().flat_map(expand).take(reach));
        middle.sort_unstable();
        for left_out in without {
            let key = key(*left_out);
            match middle.binary_search(&key) {
                Ok(index) => drop(middle.remove(index)),
                Err(0) => before = before.saturating_sub(1),
                Err(_) => {}
            }
        }
        if let Some(extra) = extra {
            let key = key(extra);
            let index = middle.partition_point(|present| *present < key);
            // A number below the middle part only shifts the ranks, because smaller numbers exist outside of it.
            if index == 0 && before > 0 { before += 1 } else { middle.insert(index, key) }
        }
        let count =
            (self.count() + u64::from(extra.is_some())).checked_sub(without.len() as u64).filter(|count| *count > 0)?;
        let at = |rank: u64| middle.get(usize::try_from(rank.checked_sub(before)?).ok()?).map(|key| number(*key));
        let (lower, upper) = (at((count - 1) / 2)?, at(count / 2)?);
        Some(lower + (upper - lower) / 2.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn plain(mut numbers: Vec<f64>) -> Option<f64> {
        numbers.sort_by(f64::total_cmp);
        let count = numbers.len().checked_sub(1)? + 1;
        let (lower, upper) = (numbers[(count - 1) / 2], numbers[count / 2]);
        Some(lower + (upper - lower) / 2.0)
    }

    proptest! {
        #[test]
        fn the_median_is_the_middle_of_the_sorted_numbers(
            numbers in proptest::collection::vec((-20..20_i32, any::<bool>()), 1..60),
            extra in proptest::option::of(-25..25_i32),
            without in 0..5_usize,
        ) {
            let mut ordered = OrderedNumbers::default();
            let mut present: Vec<f64> = Vec::new();
            for (number, leaves) in numbers {
                ordered.add(f64::from(number));
                present.push(f64::from(number));
                if leaves && present.len() > 3 {
                    ordered.remove(present.remove(0));
                }
                prop_assert_eq!(ordered.median(None, &[]), plain(present.clone()));
            }
            let without: Vec<f64> = present.iter().copied().take(without).collect();
            let mut expected: Vec<f64> = present.iter().copied().skip(without.len()).collect();
            expected.extend(extra.map(f64::from));
            prop_assert_eq!(ordered.median(extra.map(f64::from), &without), plain(expected));
        }
    }
}
