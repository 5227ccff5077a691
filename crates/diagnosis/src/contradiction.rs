//! Outcomes that no set of failures explains: the smallest sets of tests without which the other outcomes are consistent.
//!
//! Either a test has a wrong result, or the model lacks a dependency. The search deepens iteratively over the number of tests left out. A
//! failed test without an explanation leaves two ways: leave out that test, or leave out all passed tests that clear one of its failure
//! modes.
//! Bound: the sets of tests that the caller permits.

use crate::bits::{Bits, minimal};
use crate::evidence::{Exclusion, Outcome, TestEvidence};
use crate::grouping::{ConflictGroup, groups};
use crate::hitting::{Problem, SearchEnd, search};
use crate::limits::{ALTERNATIVES_MAX, RETRACTION_NODES_MAX, RETRACTION_SEARCH};
use crate::model::Model;
use std::collections::BTreeSet;

/// Outcomes that exclude each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contradiction {
    /// Failed tests, by index, that no failure explains together with the passed tests. The diagnosis ignores them.
    pub unexplained: Vec<usize>,
    /// Sets of tests, by index. Without any one of these sets the other outcomes are consistent. All sets have the same size, and there
    /// are at most [`ALTERNATIVES_MAX`].
    pub left_out: Vec<Vec<usize>>,
    /// True if no smaller set makes the rest consistent; false if a limit ended the search.
    pub is_smallest: bool,
    /// True if no other set of this size makes the rest consistent; false if a limit ended the search.
    pub are_all: bool,
}

/// The search for tests to leave out.
pub(crate) struct Retraction<'a> {
    model: &'a Model,
    exclusions: &'a [Exclusion],
    outcomes: &'a [Outcome],
    costs: &'a [f64],
    /// Maximum number of sets that are tried.
    tried_max: usize,
    tried: usize,
    /// True if a set was not decided within its nodes.
    is_undecided: bool,
}

/// Defect of a set of outcomes.
enum Wrong {
    Nothing,
    /// A failed test with no failure mode left in its conflict.
    Unexplained(usize),
    /// A group without a valid candidate: each one would also have made a passed test fail.
    Excluded(Box<ConflictGroup>),
}

impl<'a> Retraction<'a> {
    pub(crate) fn new(
        model: &'a Model,
        exclusions: &'a [Exclusion],
        outcomes: &'a [Outcome],
        costs: &'a [f64],
        tried_max: usize,
    ) -> Retraction<'a> {
        Retraction { model, exclusions, outcomes, costs, tried_max, tried: 0, is_undecided: false }
    }

    /// Returns the contradiction of these unexplained failed tests.
    pub(crate) fn contradiction(mut self, unexplained: Vec<usize>) -> Contradiction {
        let tests = self.outcomes.len();
        let mut is_smallest = true;
        for size in 1..=unexplained.len() {
            let mut found = BTreeSet::new();
            self.within(&Bits::new(tests), size, &mut found);
            if !found.is_empty() {
                let left_out = found.iter().map(|set| set.iter().collect()).collect();
                let are_all = is_smallest && self.is_thorough() && found.len() < ALTERNATIVES_MAX;
                return Contradiction { unexplained, left_out, is_smallest, are_all };
            }
            is_smallest &= self.is_thorough();
            if self.tried >= self.tried_max {
                break;
            }
        }
        // Without the unexplained tests themselves, the rest is consistent.
        Contradiction { left_out: vec![unexplained.clone()], unexplained, is_smallest: false, are_all: false }
    }

    /// Returns true if no limit has cut the search so far.
    fn is_thorough(&self) -> bool {
        self.tried < self.tried_max && !self.is_undecided
    }

    /// Finds the sets that leave out `left_out` and at most `size` further tests.
    fn within(&mut self, left_out: &Bits, size: usize, found: &mut BTreeSet<Bits>) {
        if self.tried >= self.tried_max || found.len() >= ALTERNATIVES_MAX {
            return;
        }
        self.tried += 1;
        let options = match self.wrong(left_out) {
            Wrong::Nothing => {
                found.insert(left_out.clone());
                return;
            }
            Wrong::Unexplained(test) => self.explaining(test, left_out),
            Wrong::Excluded(group) => self.allowing(&group, left_out),
        };
        for option in options.into_iter().filter(|option| option.len() <= size) {
            self.within(&left_out.union(&option), size - option.len(), found);
        }
    }

    fn wrong(&mut self, left_out: &Bits) -> Wrong {
        if let Some(test) = self.unexplained(left_out) {
            return Wrong::Unexplained(test);
        }
        let is_excluding = |(test, exclusion): (usize, &Exclusion)| {
            self.outcomes.get(test) == Some(&Outcome::Passed)
                && !exclusion.nogoods.is_empty()
                && !left_out.contains(test)
        };
        if !self.exclusions.iter().enumerate().any(is_excluding) {
            return Wrong::Nothing;
        }
        self.tried += RETRACTION_SEARCH;
        let evidence = TestEvidence::new(self.model, self.exclusions, self.outcomes, left_out);
        let modes = self.model.modes.len();
        for group in groups(evidence.conflicts, evidence.nogoods, modes) {
            if group.nogoods.is_empty() {
                continue;
            }
            let clauses = minimal(group.conflicts.iter().map(|conflict| conflict.modes.clone()).collect());
            let problem = Problem {
                modes,
                clauses: &clauses,
                nogoods: &group.nogoods,
                costs: self.costs,
                keep: 1,
                nodes: RETRACTION_NODES_MAX,
            };
            let (found, end) = search(&problem);
            if found.is_empty() {
                self.is_undecided |= end == SearchEnd::NodeLimit;
                return Wrong::Excluded(Box::new(group));
            }
        }
        Wrong::Nothing
    }

    /// Returns a failed test with no failure mode left in its conflict.
    fn unexplained(&self, left_out: &Bits) -> Option<usize> {
        let good = TestEvidence::good(self.model, self.exclusions, self.outcomes, left_out);
        let mut failed = self.outcomes.iter().zip(&self.model.tests).enumerate();
        let found = failed.find(|(index, (outcome, test))| {
            outcome.is_failure()
                && !left_out.contains(*index)
                && test.clauses().iter().any(|clause| clause.is_subset(&good))
        });
        found.map(|(index, _)| index)
    }

    /// Returns the sets of tests each of which makes a failed test consistent if it is left out: the test itself, or all passed tests that
    /// clear one of its failure modes.
    fn explaining(&self, test: usize, left_out: &Bits) -> Vec<Bits> {
        let tests = self.outcomes.len();
        let clauses = self.model.tests.get(test).map_or(&[][..], |test| test.clauses());
        let cleared = |clause: &&Bits| clause.iter().all(|mode| !self.clearing(mode, left_out).is_empty());
        let Some(clause) = clauses.iter().find(cleared) else { return Vec::new() };
        let passed = clause.iter().map(|mode| self.clearing(mode, left_out));
        let mut options: Vec<Bits> = passed.chain([Bits::of(tests, [test])]).collect();
        options.sort_by_key(|option| (option.len(), option.clone()));
        options.dedup();
        options
    }

    /// Returns the passed tests that clear a failure mode.
    fn clearing(&self, mode: usize, left_out: &Bits) -> Bits {
        let passed = self.outcomes.iter().enumerate().filter(|(test, outcome)| {
            **outcome == Outcome::Passed
                && !left_out.contains(*test)
                && self.exclusions.get(*test).is_some_and(|exclusion| exclusion.clears.contains(mode))
        });
        Bits::of(self.outcomes.len(), passed.map(|(test, _)| test))
    }

    /// Returns the tests, each as a set, of which one must be left out before a group can have a candidate: the group's failed tests, and
    /// passed tests that exclude sets of its failure modes or clear failure modes of its conflicts.
    fn allowing(&self, group: &ConflictGroup, left_out: &Bits) -> Vec<Bits> {
        let tests = self.outcomes.len();
        let failed = Bits::of(tests, group.conflicts.iter().map(|conflict| conflict.test));
        let mut accused = Bits::new(self.model.modes.len());
        let clauses = failed.iter().filter_map(|test| self.model.tests.get(test)).flat_map(|test| test.clauses());
        clauses.for_each(|clause| accused.extend(clause));
        let excludes = |exclusion: &Exclusion| {
            exclusion.clears.intersects(&accused) || exclusion.nogoods.iter().any(|set| group.nogoods.contains(set))
        };
        let passed = (0..tests).filter(|test| {
            self.outcomes.get(*test) == Some(&Outcome::Passed)
                && !left_out.contains(*test)
                && self.exclusions.get(*test).is_some_and(excludes)
        });
        failed.iter().chain(passed).map(|test| Bits::of(tests, [test])).collect()
    }
}
