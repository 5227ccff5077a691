//! Many random questions on all cores; the results do not depend on the number of cores.

use crate::compare::{Finding, compare};
use crate::features::features;
use crate::generate;
use std::collections::BTreeMap;
use std::ops::Range;
use std::thread;

/// Totals of many questions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Number of questions that the executive and the definition answer alike.
    pub same: u64,
    /// Number of questions that have a result.
    pub satisfied: u64,
    /// Number of questions that the checker calls impossible and that are never satisfied.
    pub never: u64,
    /// Seeds of questions whose text the checker rejects.
    pub refused: Vec<u64>,
    /// Seeds of questions that the executive and the definition answer differently.
    pub different: Vec<u64>,
    /// For each form, the number of compared questions that contain it, and of those with a result.
    pub features: BTreeMap<String, (u64, u64)>,
}

impl Outcome {
    fn add(&mut self, seed: u64, question: &apex_definition::Question, finding: Finding) {
        match finding {
            Finding::Same(result) => {
                self.same += 1;
                let satisfied = u64::from(result.is_some());
                self.satisfied += satisfied;
                for feature in features(question) {
                    let counts = self.features.entry(feature).or_default();
                    *counts = (counts.0 + 1, counts.1 + satisfied);
                }
            }
            Finding::Never => self.never += 1,
            Finding::Refused(_) => self.refused.push(seed),
            Finding::Different(_) => self.different.push(seed),
        }
    }

    /// Adds the totals of other questions.
    pub fn join(&mut self, other: &Outcome) {
        self.same += other.same;
        self.satisfied += other.satisfied;
        self.never += other.never;
        self.refused.extend(&other.refused);
        self.different.extend(&other.different);
        for (feature, (asked, satisfied)) in &other.features {
            let counts = self.features.entry(feature.clone()).or_default();
            *counts = (counts.0 + asked, counts.1 + satisfied);
        }
    }

    /// Returns the counts as a table for operators.
    pub fn text(&self) -> String {
        let mut text = format!("{} alike, {} of them with a result\n", self.same, self.satisfied);
        for (feature, (asked, satisfied)) in &self.features {
            text.push_str(&format!("  {asked:8} {satisfied:8}  {feature}\n"));
        }
        text.push_str(&format!("  {:8}           can never hold, says the checker\n", self.never));
        text
    }
}

/// Number of threads and selection of questions.
#[derive(Clone, Debug)]
pub struct Manner {
    /// Number of threads.
    pub threads: u64,
    /// If present, only questions with this form are used, as named by [`features`].
    pub only: Option<String>,
}

/// Returns the number of threads that this machine runs in parallel.
pub fn cores() -> u64 {
    thread::available_parallelism().map_or(2, |threads| threads.get() as u64)
}

/// Runs the questions of all `seeds` on all cores.
pub fn run(seeds: Range<u64>) -> Outcome {
    run_as(seeds, &Manner { threads: cores(), only: None })
}

/// Runs the questions of `seeds` that `manner` selects, in its number of threads.
pub fn run_as(seeds: Range<u64>, manner: &Manner) -> Outcome {
    let threads = manner.threads.max(1);
    let mut whole = Outcome::default();
    thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|worker| {
                let seeds = seeds.clone();
                scope.spawn(move || {
                    let mut part = Outcome::default();
                    for seed in seeds.filter(|seed| seed % threads == worker) {
                        let question = generate::question(seed);
                        if manner.only.as_ref().is_some_and(|form| !features(&question).contains(form)) {
                            continue;
                        }
                        part.add(seed, &question, compare(&question));
                    }
                    part
                })
            })
            .collect();
        for worker in workers {
            match worker.join() {
                Ok(part) => whole.join(&part),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
    });
    whole.different.sort_unstable();
    whole.refused.sort_unstable();
    whole
}
