//! Evidence of test outcomes about failure modes: healthy modes, conflicts, and sets that are not present together.

use crate::bits::Bits;
use crate::grouping::Conflict;
use crate::model::Model;
use serde::{Deserialize, Serialize};

/// Outcome of a test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The test was not run, or its result is out of date.
    #[default]
    Unknown,
    /// The test passed.
    Passed,
    /// The test failed.
    Failed,
    /// The test fails at some times and passes at others: something that it depends on fails, and its passes clear nothing.
    Intermittent,
}

impl Outcome {
    /// All outcomes with their words.
    pub const WORDS: [(&'static str, Outcome); 4] = [
        ("unknown", Outcome::Unknown),
        ("passed", Outcome::Passed),
        ("failed", Outcome::Failed),
        ("intermittent", Outcome::Intermittent),
    ];

    /// Returns the outcome of this word.
    pub fn of_word(word: &str) -> Option<Outcome> {
        Outcome::WORDS.iter().find(|(known, _)| *known == word).map(|(_, outcome)| *outcome)
    }

    /// Returns true if the test failed, always or at times.
    pub fn is_failure(self) -> bool {
        matches!(self, Outcome::Failed | Outcome::Intermittent)
    }
}

/// Failure modes and sets of them that a test excludes if it passes.
#[derive(Clone, Debug)]
pub(crate) struct Exclusion {
    /// Failure modes that are not present.
    pub(crate) clears: Bits,
    /// Sets of failure modes that are not present together.
    pub(crate) nogoods: Vec<Bits>,
}

/// Evidence of the outcomes, without the tests that are left out.
pub(crate) struct TestEvidence {
    pub(crate) good: Bits,
    pub(crate) conflicts: Vec<Conflict>,
    /// Sets of modes that are not all present; sets with a good mode are omitted, since they cannot be.
    pub(crate) nogoods: Vec<Bits>,
    /// Failed tests of which a conflict has no failure mode left.
    pub(crate) unexplained: Vec<usize>,
}

impl TestEvidence {
    pub(crate) fn new(model: &Model, exclusions: &[Exclusion], outcomes: &[Outcome], left_out: &Bits) -> TestEvidence {
        let good = TestEvidence::good(model, exclusions, outcomes, left_out);
        let counted = || outcomes.iter().enumerate().filter(|(test, _)| !left_out.contains(*test));
        let passed = || counted().filter(|(_, outcome)| **outcome == Outcome::Passed);
        let excluded = || passed().filter_map(|(test, _)| exclusions.get(test));
        let nogoods = excluded().flat_map(|exclusion| &exclusion.nogoods).filter(|set| !set.intersects(&good));
        let nogoods: Vec<Bits> = nogoods.cloned().collect();
        let (mut conflicts, mut unexplained) = (Vec::new(), Vec::new());
        for (index, _) in counted().filter(|(_, outcome)| outcome.is_failure()) {
            let clauses = model.tests.get(index).map_or(&[][..], |test| test.clauses());
            if clauses.iter().any(|clause| clause.is_subset(&good)) {
                unexplained.push(index);
            } else {
                conflicts.extend(clauses.iter().map(|clause| Conflict { test: index, modes: clause.without(&good) }));
            }
        }
        TestEvidence { good, conflicts, nogoods, unexplained }
    }

    /// Returns the failure modes that a passed test clears.
    pub(crate) fn good(model: &Model, exclusions: &[Exclusion], outcomes: &[Outcome], left_out: &Bits) -> Bits {
        let mut good = Bits::new(model.modes.len());
        for (test, (outcome, exclusion)) in outcomes.iter().zip(exclusions).enumerate() {
            if *outcome == Outcome::Passed && !left_out.contains(test) {
                good.extend(&exclusion.clears);
            }
        }
        good
    }
}
