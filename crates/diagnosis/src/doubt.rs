//! Doubt of old passes: a pass says nothing about a failure that came after it.
//!
//! Where a failed test contradicts passed tests, the passes that are older than the failure are left out of the diagnosis, if it is
//! consistent without them. A pass that is as new as the failure, or newer, is not doubted.
//! Bound: each failed test raises doubts once and withdraws them at most once.

use crate::bits::Bits;
use crate::evidence::{Exclusion, Outcome};
use crate::model::Model;
use std::collections::BTreeSet;

/// A passed test that a newer failure contradicts. The diagnosis treats its outcome as unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Doubt {
    /// The passed test by index.
    pub test: usize,
    /// The failed test by index.
    pub failed: usize,
    /// Time from the newest report of the pass to the beginning of the failure, ns.
    pub age_ns: i64,
}

/// Outcome of a test with its instant: of a pass that of the newest report, of a failure its beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct TestReport {
    pub(crate) outcome: Outcome,
    /// Instant on the caller's clock, ns.
    pub(crate) at_ns: i64,
}

/// The doubts of a set of reports while they are searched for.
#[derive(Default)]
pub(crate) struct Doubts {
    /// Pairs of a passed test and the newer failed test that contradicts it.
    pairs: BTreeSet<(usize, usize)>,
    /// Failed tests that have raised doubts.
    raised: BTreeSet<usize>,
}

impl Doubts {
    /// Returns the outcomes of the reports, with the doubted ones unknown.
    pub(crate) fn outcomes(&self, reports: &[TestReport]) -> Vec<Outcome> {
        let mut outcomes: Vec<Outcome> = reports.iter().map(|report| report.outcome).collect();
        for (test, _) in &self.pairs {
            outcomes.get_mut(*test).into_iter().for_each(|outcome| *outcome = Outcome::Unknown);
        }
        outcomes
    }

    /// Takes the failed tests that are not explained under the present doubts; returns true if the doubts have changed. A failed test
    /// that is not explained without the older passes is contradicted by evidence that is not older: its doubts are withdrawn.
    pub(crate) fn revise(
        &mut self,
        model: &Model,
        exclusions: &[Exclusion],
        reports: &[TestReport],
        good: &Bits,
        unexplained: &[usize],
    ) -> bool {
        let before = self.pairs.len();
        self.pairs.retain(|(_, failed)| !unexplained.contains(failed));
        if self.pairs.len() != before {
            return true;
        }
        for failed in unexplained {
            if self.raised.insert(*failed) {
                let older = OlderPasses { model, exclusions, reports, failed: *failed };
                self.pairs.extend(older.contradicting(good).into_iter().map(|test| (test, *failed)));
            }
        }
        self.pairs.len() != before
    }

    /// Returns each doubted test once, with the newest failure that contradicts it.
    pub(crate) fn list(&self, reports: &[TestReport]) -> Vec<Doubt> {
        let at_ns = |test: usize| reports.get(test).map_or(0, |report| report.at_ns);
        let mut doubts: Vec<Doubt> = Vec::new();
        for (test, failed) in &self.pairs {
            let doubt = Doubt { test: *test, failed: *failed, age_ns: at_ns(*failed).saturating_sub(at_ns(*test)) };
            match doubts.last_mut().filter(|last| last.test == *test) {
                Some(last) if last.age_ns < doubt.age_ns => *last = doubt,
                Some(_) => {}
                None => doubts.push(doubt),
            }
        }
        doubts
    }
}

/// The passes that are older than a failure.
struct OlderPasses<'a> {
    model: &'a Model,
    exclusions: &'a [Exclusion],
    reports: &'a [TestReport],
    failed: usize,
}

impl OlderPasses<'_> {
    /// Returns the older passes that contradict the failure. For a conflict with no failure mode left these are the tests that clear a
    /// mode which no newer test clears; otherwise those that exclude sets with its failure modes.
    fn contradicting(&self, good: &Bits) -> Vec<usize> {
        let clauses = self.model.tests.get(self.failed).map_or(&[][..], |test| test.clauses());
        let cleared: Vec<&Bits> = clauses.iter().filter(|clause| clause.is_subset(good)).collect();
        let mut tests = Vec::new();
        if cleared.is_empty() {
            let touches = |exclusion: &Exclusion| {
                let sets = || exclusion.nogoods.iter().chain([&exclusion.clears]);
                clauses.iter().any(|clause| sets().any(|set| set.intersects(clause)))
            };
            tests.extend(self.passed(touches).filter(|test| self.is_older(*test)));
        }
        for mode in cleared.into_iter().flat_map(Bits::iter) {
            let clearing: Vec<usize> = self.passed(|exclusion| exclusion.clears.contains(mode)).collect();
            if clearing.iter().all(|test| self.is_older(*test)) {
                tests.extend(clearing);
            }
        }
        tests
    }

    fn passed<'s>(&'s self, wanted: impl Fn(&Exclusion) -> bool + 's) -> impl Iterator<Item = usize> + 's {
        let tests = self.reports.iter().zip(self.exclusions).enumerate();
        tests
            .filter(move |(_, (report, exclusion))| report.outcome == Outcome::Passed && wanted(exclusion))
            .map(|(test, _)| test)
    }

    fn is_older(&self, test: usize) -> bool {
        let at_ns = |test: usize| self.reports.get(test).map_or(0, |report| report.at_ns);
        at_ns(test) < at_ns(self.failed)
    }
}
