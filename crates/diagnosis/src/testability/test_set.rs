//! A smallest set of tests that detects and isolates as much as all tests: a hitting set of the tests that distinguish pairs of failure
//! modes.
//!
//! Bound: [`TEST_SET_NODES_MAX`] partial sets; greedy beyond [`TEST_SET_PAIRS_MAX`] pairs.

use crate::bits::{Bits, minimal};
use crate::hitting::{Problem, SearchEnd, search};
use crate::limits::{TEST_SET_NODES_MAX, TEST_SET_PAIRS_MAX};
use std::collections::BTreeSet;

/// A set of tests with the detection and isolation of all tests.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TestSet {
    /// The tests by index.
    pub tests: Vec<usize>,
    /// True if no smaller set has the same detection and isolation; false if a limit ended the search.
    pub is_smallest: bool,
}

pub(super) fn smallest(rows: &[Bits], tests: usize) -> TestSet {
    // Equal rows cannot be distinguished; the empty row means no failure.
    let different: BTreeSet<Bits> = rows.iter().cloned().chain([Bits::new(tests)]).collect();
    let different: Vec<Bits> = different.into_iter().collect();
    let mut pairs = BTreeSet::new();
    for (index, one) in different.iter().enumerate() {
        for other in different.iter().skip(index + 1) {
            let mut apart = one.without(other);
            apart.extend(&other.without(one));
            pairs.insert(apart);
        }
    }
    let pairs: Vec<Bits> = pairs.into_iter().collect();
    let greedy = greedy(&pairs, tests);
    if pairs.len() > TEST_SET_PAIRS_MAX {
        return TestSet { tests: greedy, is_smallest: false };
    }
    let clauses = minimal(pairs);
    let costs = vec![1.0; tests];
    let problem =
        Problem { modes: tests, clauses: &clauses, nogoods: &[], costs: &costs, keep: 1, nodes: TEST_SET_NODES_MAX };
    let (found, end) = search(&problem);
    let is_smallest = end != SearchEnd::NodeLimit;
    match found.first().filter(|found| is_smallest || found.set.len() < greedy.len()) {
        Some(found) => TestSet { tests: found.set.iter().collect(), is_smallest },
        None => TestSet { tests: greedy, is_smallest },
    }
}

/// Repeatedly takes the test that distinguishes the most pairs.
fn greedy(pairs: &[Bits], tests: usize) -> Vec<usize> {
    let mut open: Vec<&Bits> = pairs.iter().filter(|pair| !pair.is_empty()).collect();
    let mut taken = BTreeSet::new();
    while !open.is_empty() {
        let mut counts = vec![0_usize; tests];
        for pair in &open {
            pair.iter().for_each(|test| counts.get_mut(test).into_iter().for_each(|count| *count += 1));
        }
        let best = counts.iter().enumerate().max_by_key(|(test, count)| (**count, std::cmp::Reverse(*test)));
        let Some((test, _)) = best else { break };
        taken.insert(test);
        open.retain(|pair| !pair.contains(test));
    }
    taken.into_iter().collect()
}
