//! Testability figures of a model: the failures that its tests detect, how far they isolate them, and redundant tests.
//!
//! Definitions as in multi-signal flow graphs (TEAMS): detection counts single failures, and isolation divides detected failures by the
//! size of their ambiguity group. Tests that fail only with several simultaneous failures (redundancy) have no part in either.
//! Bound: O(modes^2 x words) and the limits of the search for the smallest set of tests.

mod masking;
mod test_set;

use crate::bits::Bits;
use crate::model::Model;
use std::collections::BTreeMap;

pub use masking::Mask;
pub use test_set::TestSet;

/// Ambiguity groups up to this size have an isolation figure.
pub const ISOLATION_SIZES: usize = 3;

/// Testability figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Testability {
    /// The D-matrix: for each failure mode the tests that fail because of it alone.
    pub rows: Vec<Bits>,
    /// Failure modes that at least one test detects.
    pub detected: Vec<usize>,
    /// Failure modes that no test detects.
    pub undetected: Vec<usize>,
    /// Share of failure modes that are detected, 0 to 1.
    pub detection: f64,
    /// As `detection`, weighted by probability.
    pub detection_weighted: f64,
    /// Share of detected failure modes in an ambiguity group of at most one, two and three failure modes.
    pub isolation: [f64; ISOLATION_SIZES],
    /// As `isolation`, with groups counted by their components.
    pub isolation_components: [f64; ISOLATION_SIZES],
    /// Sets of two or more detected failure modes that the same tests detect.
    pub ambiguity_groups: Vec<Vec<usize>>,
    /// Sets of two or more tests that fail because of the same failure modes.
    pub equal_tests: Vec<Vec<usize>>,
    /// Tests that no single failure mode makes fail: only several together do.
    pub silent_tests: Vec<usize>,
    /// Pairs of failure modes: the first makes every test fail that detects the second, and so hides the second.
    pub hidden: Vec<(usize, usize)>,
    /// Masking pairs of failures: together they make the same tests fail as a third failure alone.
    pub masks: Vec<Mask>,
    /// Number of all such pairs; `masks` holds at most [`crate::limits::MASKS_MAX`] of them.
    pub masks_count: usize,
    /// A smallest set of tests with the detection and isolation of all.
    pub test_set: TestSet,
}

/// Computes the figures of a model.
pub fn testability(model: &Model) -> Testability {
    let rows = model.rows();
    let (undetected, detected): (Vec<usize>, Vec<usize>) =
        (0..rows.len()).partition(|mode| rows.get(*mode).is_none_or(Bits::is_empty));
    let probability = |modes: &[usize]| -> f64 {
        modes.iter().filter_map(|mode| model.modes.get(*mode)).map(|mode| mode.probability_per_hour).sum()
    };
    let all: f64 = model.modes.iter().map(|mode| mode.probability_per_hour).sum();
    let groups = equal(rows.iter().enumerate().filter(|(_, row)| !row.is_empty()));
    let within = |size: &dyn Fn(&[usize]) -> usize| {
        let mut shares = [0.0; ISOLATION_SIZES];
        for (index, share) in shares.iter_mut().enumerate() {
            let modes: usize = groups.iter().filter(|group| size(group) <= index + 1).map(Vec::len).sum();
            *share = part(modes, detected.len());
        }
        shares
    };
    let components = |group: &[usize]| {
        let owner = |mode: &usize| model.modes.get(*mode).map(|mode| mode.component);
        group.iter().filter_map(owner).collect::<std::collections::BTreeSet<_>>().len()
    };
    let columns = model.columns();
    let (masks, masks_count) = masking::masks(&rows, &detected);
    Testability {
        detection: part(detected.len(), rows.len()),
        detection_weighted: probability(&detected) / all,
        isolation: within(&|group| group.len()),
        isolation_components: within(&|group| components(group)),
        equal_tests: several(equal(columns.iter().enumerate().filter(|(_, column)| !column.is_empty()))),
        silent_tests: (0..columns.len()).filter(|test| columns.get(*test).is_some_and(Bits::is_empty)).collect(),
        hidden: masking::hidden(&rows, &detected),
        masks,
        masks_count,
        test_set: test_set::smallest(&rows, model.tests.len()),
        ambiguity_groups: several(groups),
        undetected,
        detected,
        rows,
    }
}

fn part(count: usize, of: usize) -> f64 {
    if of == 0 { 0.0 } else { count as f64 / of as f64 }
}

/// Returns the numbers grouped by equal sets, in order of their first number.
fn equal<'a>(sets: impl Iterator<Item = (usize, &'a Bits)>) -> Vec<Vec<usize>> {
    let mut by_set: BTreeMap<&Bits, Vec<usize>> = BTreeMap::new();
    for (number, set) in sets {
        by_set.entry(set).or_default().push(number);
    }
    let mut groups: Vec<Vec<usize>> = by_set.into_values().collect();
    groups.sort();
    groups
}

fn several(groups: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    groups.into_iter().filter(|group| group.len() > 1).collect()
}
