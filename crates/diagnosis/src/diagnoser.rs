//! Run-time diagnosis: from test outcomes to the health of every failure mode and the minimal candidate sets.
//!
//! A passed test clears every failure mode that alone would have made it fail. Each failed test is a conflict: a set of remaining failure
//! modes, at least one of which is present. Candidates are the minimal sets that hit every conflict and would not have made a passed test
//! fail. A mode is *bad* if it is in every candidate, *suspect* if it is in some, *good* if it is cleared, and *unknown* otherwise, which
//! includes modes masked by a bad one.
//! Bound: one change of an outcome solves the groups that it changes, each within [`crate::limits::NODES_MAX`] partial sets.

use crate::bits::{Bits, minimal};
use crate::contradiction::{Contradiction, Retraction};
use crate::doubt::{Doubt, Doubts, TestReport};
use crate::evidence::{Exclusion, Outcome, TestEvidence};
use crate::grouping::{ConflictGroup, groups};
use crate::hitting::{Problem, SearchEnd, search};
use crate::limits::{CANDIDATES_MAX, NODES_MAX, RETRACTIONS_MAX, RETRACTIONS_REPORT_MAX};
use crate::model::Model;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

/// Health of a failure mode or of a component.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Health {
    /// The outcomes say nothing about the failure mode: it is in no candidate, and no passed test clears it.
    #[default]
    Unknown,
    /// A passed test clears it.
    Good,
    /// The failure mode is in some candidates, or may be in some if a search ended at its limit.
    Suspect,
    /// Every candidate contains the failure mode.
    Bad,
}

impl Health {
    /// Returns the word of PDL and reports.
    pub fn word(self) -> &'static str {
        match self {
            Health::Unknown => "unknown",
            Health::Good => "good",
            Health::Suspect => "suspect",
            Health::Bad => "bad",
        }
    }
}

impl fmt::Display for Health {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// A minimal set of failure modes that explains failed tests.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The failure modes by index.
    pub modes: Bits,
    /// Negative logarithm of the product of their prior odds.
    pub cost: f64,
    /// Its part of the prior odds of all candidates found, 0 to 1.
    pub share: f64,
}

/// The diagnosis of failed tests that share failure modes.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupDiagnosis {
    /// The failed tests by index.
    pub tests: Vec<usize>,
    /// Candidates, the likeliest first; empty only if passed tests exclude sets of failures and the limit ended the search
    /// before the first candidate.
    pub candidates: Vec<Candidate>,
    /// Reason for which the search for candidates ended.
    pub end: SearchEnd,
}

/// A diagnosis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnosis {
    /// Health of each failure mode.
    pub modes: Vec<Health>,
    /// Health of each component: bad if every candidate contains one of its failure modes.
    pub components: Vec<Health>,
    /// Groups of failed tests: a candidate for all failed tests consists of one candidate from each group.
    pub groups: Vec<GroupDiagnosis>,
    /// Passed tests that a newer failure contradicts, by index: the diagnosis treats their outcomes as unknown.
    pub doubts: Vec<Doubt>,
    /// Outcomes that exclude each other.
    pub contradiction: Option<Contradiction>,
}

/// A group with its diagnosis, kept until its conflicts change.
#[derive(Clone, Debug)]
struct Solved {
    group: ConflictGroup,
    diagnosis: GroupDiagnosis,
    bad: Bits,
    suspect: Bits,
    bad_components: Vec<usize>,
}

/// Diagnoses a model while outcomes of tests arrive. The diagnosis depends only on the newest report of each test, on its outcome and its
/// instant.
#[derive(Clone, Debug)]
pub struct Diagnoser {
    model: Arc<Model>,
    reports: Vec<TestReport>,
    /// The outcomes of the reports that the diagnosis uses.
    outcomes: Vec<Outcome>,
    exclusions: Vec<Exclusion>,
    costs: Vec<f64>,
    solved: Vec<Solved>,
    /// Maximum number of sets of tests that are left out on trial for a contradiction.
    retractions_max: usize,
    diagnosis: Diagnosis,
}

impl Diagnoser {
    /// Returns a diagnoser without any outcome.
    pub fn new(model: Arc<Model>) -> Diagnoser {
        Diagnoser::searching(model, RETRACTIONS_MAX)
    }

    /// Returns a diagnoser for a report on the ground: the search for the smallest contradictions takes more time than a flight permits.
    pub fn thorough(model: Arc<Model>) -> Diagnoser {
        Diagnoser::searching(model, RETRACTIONS_REPORT_MAX)
    }

    fn searching(model: Arc<Model>, retractions_max: usize) -> Diagnoser {
        let permanent = Bits::of(
            model.modes.len(),
            (0..model.modes.len()).filter(|mode| model.modes.get(*mode).is_some_and(|mode| !mode.is_intermittent)),
        );
        let exclusion = |implicants: &[Bits]| {
            // An intermittent failure may have been absent when the test passed.
            let lasting = implicants.iter().filter(|implicant| implicant.is_subset(&permanent));
            let (single, several): (Vec<&Bits>, Vec<&Bits>) = lasting.partition(|implicant| implicant.len() == 1);
            let clears = Bits::of(model.modes.len(), single.into_iter().filter_map(Bits::first));
            Exclusion { clears, nogoods: several.into_iter().cloned().collect() }
        };
        let mut diagnoser = Diagnoser {
            reports: vec![TestReport::default(); model.tests.len()],
            outcomes: Vec::new(),
            exclusions: model.tests.iter().map(|test| exclusion(test.implicants())).collect(),
            costs: (0..model.modes.len()).map(|mode| model.cost(mode)).collect(),
            solved: Vec::new(),
            retractions_max,
            diagnosis: Diagnosis::default(),
            model,
        };
        diagnoser.update();
        diagnoser
    }

    /// Returns the model.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// Returns the outcome of each test that the diagnosis uses: that of its report, or `Unknown` if it is doubted.
    pub fn outcomes(&self) -> &[Outcome] {
        &self.outcomes
    }

    /// Returns the instant of a test's report, ns, as [`Diagnoser::report_all`] took it; 0 for a test without a report.
    pub fn instant_ns(&self, test: usize) -> i64 {
        self.reports.get(test).map_or(0, |report| report.at_ns)
    }

    /// Returns the diagnosis of the outcomes so far.
    pub fn diagnosis(&self) -> &Diagnosis {
        &self.diagnosis
    }

    /// Sets the outcome of a test; returns true if the outcome has changed. A test that the model does not have is ignored.
    pub fn set(&mut self, test: usize, outcome: Outcome) -> bool {
        self.set_all([(test, outcome)])
    }

    /// Sets several outcomes and diagnoses once; returns true if any outcome has changed. All are equally old.
    pub fn set_all(&mut self, outcomes: impl IntoIterator<Item = (usize, Outcome)>) -> bool {
        self.report_all(outcomes.into_iter().map(|(test, outcome)| (test, outcome, 0)))
    }

    /// Sets several outcomes with instants on the caller's clock, ns, and diagnoses once; returns true if any outcome has changed. The
    /// instant of a pass is that of its newest report, the instant of a failure that since which the test fails. Of outcomes that
    /// contradict each other the newer one counts.
    pub fn report_all(&mut self, reports: impl IntoIterator<Item = (usize, Outcome, i64)>) -> bool {
        // Ages matter only where outcomes contradict each other.
        let (mut changed, mut aged) = (false, false);
        for (test, outcome, at_ns) in reports {
            if let Some(known) = self.reports.get_mut(test) {
                changed |= known.outcome != outcome;
                aged |= known.at_ns != at_ns;
                *known = TestReport { outcome, at_ns };
            }
        }
        let is_consistent = self.diagnosis.doubts.is_empty() && self.diagnosis.contradiction.is_none();
        if changed || (aged && !is_consistent) {
            self.update();
        }
        changed
    }

    fn update(&mut self) {
        let mut known = std::mem::take(&mut self.solved);
        let mut doubts = Doubts::default();
        let (good, unexplained) = loop {
            self.outcomes = doubts.outcomes(&self.reports);
            let (good, unexplained) = self.solve_groups(&mut known);
            if !doubts.revise(&self.model, &self.exclusions, &self.reports, &good, &unexplained) {
                break (good, unexplained);
            }
            known.append(&mut self.solved);
        };
        let contradiction = (!unexplained.is_empty()).then(|| {
            let most = self.retractions_max;
            let retraction = Retraction::new(&self.model, &self.exclusions, &self.outcomes, &self.costs, most);
            let mut found = retraction.contradiction(unexplained);
            let newest_ns =
                |set: &Vec<usize>| set.iter().filter_map(|test| self.reports.get(*test)).map(|known| known.at_ns).max();
            found.left_out.sort_by_key(newest_ns);
            found
        });
        let doubts = doubts.list(&self.reports);
        self.diagnosis = Diagnosis { doubts, ..self.labelled(&good, contradiction) };
    }

    /// Solves the groups of the outcomes in use, those in `known` without a search. Returns the cleared failure modes and the failed
    /// tests that are not explained.
    fn solve_groups(&mut self, known: &mut Vec<Solved>) -> (Bits, Vec<usize>) {
        let mut left_out = Bits::new(self.outcomes.len());
        let (good, mut unexplained) = loop {
            let evidence = TestEvidence::new(&self.model, &self.exclusions, &self.outcomes, &left_out);
            for group in groups(evidence.conflicts, evidence.nogoods, self.model.modes.len()) {
                let before = known.iter().position(|solved| solved.group == group);
                let before = before.map(|index| known.swap_remove(index));
                self.solved.push(before.unwrap_or_else(|| solve(&self.model, &self.costs, group)));
            }
            let excluded: Vec<usize> = self
                .solved
                .iter()
                .filter(|solved| !solved.is_explained())
                .flat_map(|solved| solved.diagnosis.tests.clone())
                .collect();
            if excluded.is_empty() {
                break (evidence.good, evidence.unexplained);
            }
            // An unexplained test gives no evidence, so its other conflicts are dropped, too, and the groups are formed again.
            excluded.into_iter().for_each(|test| left_out.insert(test));
            known.append(&mut self.solved);
        };
        unexplained.extend(left_out.iter());
        unexplained.sort_unstable();
        unexplained.dedup();
        (good, unexplained)
    }

    fn labelled(&self, good: &Bits, contradiction: Option<Contradiction>) -> Diagnosis {
        let mut modes = vec![Health::Unknown; self.model.modes.len()];
        let mut mark = |set: &Bits, health: Health| {
            set.iter().for_each(|mode| modes.get_mut(mode).into_iter().for_each(|known| *known = health));
        };
        mark(good, Health::Good);
        for solved in &self.solved {
            mark(&solved.suspect, Health::Suspect);
            mark(&solved.bad, Health::Bad);
        }
        let component = |(index, component): (usize, &crate::model::Component)| {
            let mut healths = component.modes.iter().filter_map(|mode| modes.get(*mode).copied());
            if self.solved.iter().any(|solved| solved.bad_components.contains(&index)) {
                return Health::Bad;
            }
            match healths.clone().max() {
                Some(worst @ (Health::Bad | Health::Suspect)) => worst,
                _ if healths.all(|health| health == Health::Good) => Health::Good,
                _ => Health::Unknown,
            }
        };
        Diagnosis {
            components: self.model.components.iter().enumerate().map(component).collect(),
            modes,
            groups: self.solved.iter().map(|solved| solved.diagnosis.clone()).collect(),
            doubts: Vec::new(),
            contradiction,
        }
    }
}

impl Solved {
    /// Returns false if every set of its failure modes that explains its failed tests would have made a passed test fail.
    fn is_explained(&self) -> bool {
        !(self.diagnosis.candidates.is_empty() && self.diagnosis.end == SearchEnd::All)
    }
}

impl Diagnosis {
    /// Returns the likeliest candidates for all failed tests, at most `keep`; the empty set if no test failed. The share of each is the
    /// product of the shares of its parts among the candidates found in each group.
    pub fn candidates(&self, keep: usize) -> Vec<Candidate> {
        let modes = self.modes.len();
        let mut whole = vec![Candidate { modes: Bits::new(modes), cost: 0.0, share: 1.0 }];
        for group in &self.groups {
            let mut joined = Vec::new();
            for (index, one) in whole.iter().enumerate() {
                // In sorted lists, only pairs within this bound can be among the first `keep`.
                for other in group.candidates.iter().take(keep / (index + 1)) {
                    joined.push(Candidate {
                        modes: one.modes.union(&other.modes),
                        cost: one.cost + other.cost,
                        share: one.share * other.share,
                    });
                }
            }
            joined.sort_by(|a, b| a.cost.total_cmp(&b.cost).then_with(|| a.modes.iter().cmp(b.modes.iter())));
            joined.truncate(keep);
            whole = joined;
        }
        whole
    }

    /// Returns the reason for which the search ended, over all groups.
    pub fn end(&self) -> SearchEnd {
        self.groups.iter().fold(SearchEnd::All, |end, group| end.worse(group.end))
    }
}

fn solve(model: &Model, costs: &[f64], group: ConflictGroup) -> Solved {
    let modes = model.modes.len();
    let clauses = minimal(group.conflicts.iter().map(|conflict| conflict.modes.clone()).collect());
    let problem =
        Problem { modes, clauses: &clauses, nogoods: &group.nogoods, costs, keep: CANDIDATES_MAX, nodes: NODES_MAX };
    let (found, end) = search(&problem);
    let odds: Vec<f64> =
        found.iter().map(|set| libm::exp(found.first().map_or(0.0, |best| best.cost) - set.cost)).collect();
    let all: f64 = odds.iter().sum();
    let candidates: Vec<Candidate> = found
        .into_iter()
        .zip(odds)
        .map(|(found, odds)| Candidate { modes: found.set, cost: found.cost, share: odds / all })
        .collect();
    // For each mode of a minimal clause there is a minimal hitting set that contains it. So without sets that must not be present as a
    // whole, health follows from the clauses alone. With such sets, it follows from the candidates if all are known.
    let by_candidates = !group.nogoods.is_empty() && end == SearchEnd::All;
    let sets: Vec<&Bits> = candidates.iter().map(|candidate| &candidate.modes).collect();
    let (bad, mut suspect) = if by_candidates {
        (common(modes, &sets), union(modes, sets.iter().copied()))
    } else {
        let single = clauses.iter().filter(|clause| clause.len() == 1);
        (union(modes, single), union(modes, clauses.iter()))
    };
    suspect.subtract(&bad);
    let bad_components = (0..model.components.len()).filter(|index| {
        let own = model.components.get(*index).map(|component| Bits::of(modes, component.modes.iter().copied()));
        own.is_some_and(|own| match by_candidates {
            true => sets.iter().all(|set| set.intersects(&own)),
            false => clauses.iter().any(|clause| clause.is_subset(&own)),
        })
    });
    let bad_components = bad_components.collect();
    let mut tests: Vec<usize> = group.conflicts.iter().map(|conflict| conflict.test).collect();
    tests.dedup();
    Solved { diagnosis: GroupDiagnosis { tests, candidates, end }, group, bad, suspect, bad_components }
}

fn union<'a>(modes: usize, sets: impl Iterator<Item = &'a Bits>) -> Bits {
    sets.fold(Bits::new(modes), |all, set| all.union(set))
}

fn common(modes: usize, sets: &[&Bits]) -> Bits {
    let mut shared = sets.first().map_or_else(|| Bits::new(modes), |set| (*set).clone());
    sets.iter().for_each(|set| shared.retain(set));
    shared
}
