//! Failures hidden by other failures, and masking pairs of failures, which together make the same tests fail as a third failure alone.

use crate::bits::Bits;
use crate::limits::MASKS_MAX;
use std::collections::BTreeMap;

/// Two failures that together make exactly the tests fail that a third failure makes fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mask {
    /// The two failure modes.
    pub pair: (usize, usize),
    /// The failure mode that the two look like.
    pub looks_like: usize,
}

/// Returns the pairs of detected failure modes of which the first makes every test fail that the second makes fail. Two equal modes give
/// one pair, in order.
pub(super) fn hidden(rows: &[Bits], detected: &[usize]) -> Vec<(usize, usize)> {
    let row = |mode: &usize| rows.get(*mode);
    let mut pairs = Vec::new();
    for (index, first) in detected.iter().enumerate() {
        for second in detected.iter().skip(index + 1) {
            let (Some(one), Some(other)) = (row(first), row(second)) else { continue };
            if other.is_subset(one) {
                pairs.push((*first, *second));
            } else if one.is_subset(other) {
                pairs.push((*second, *first));
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

/// Returns the pairs in which neither mode hides the other and the two together make the same tests fail as a third mode: the first such
/// pairs, and the number of all.
pub(super) fn masks(rows: &[Bits], detected: &[usize]) -> (Vec<Mask>, usize) {
    let mut by_row: BTreeMap<&Bits, Vec<usize>> = BTreeMap::new();
    for mode in detected {
        if let Some(row) = rows.get(*mode) {
            by_row.entry(row).or_default().push(*mode);
        }
    }
    let (mut masks, mut count) = (Vec::new(), 0);
    for (index, first) in detected.iter().enumerate() {
        for second in detected.iter().skip(index + 1) {
            let (Some(one), Some(other)) = (rows.get(*first), rows.get(*second)) else { continue };
            if one.is_subset(other) || other.is_subset(one) {
                continue;
            }
            for looks_like in by_row.get(&one.union(other)).into_iter().flatten() {
                count += 1;
                if masks.len() < MASKS_MAX {
                    masks.push(Mask { pair: (*first, *second), looks_like: *looks_like });
                }
            }
        }
    }
    (masks, count)
}
