//! Many random programs on all cores; the results do not depend on the number of cores.

use crate::compare::{Verdict, judge};
use crate::coverage::Coverage;
use crate::generate::{self, Case};
use apex_reference::Cut;
use std::ops::Range;
use std::thread;
use std::time::{Duration, Instant};

/// Totals of many programs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Programs that both ran alike.
    pub same: u64,
    /// Programs that the checker refused.
    pub refused: u64,
    /// Number of programs with an instant that does not come to rest in the reference; they are compared up to that instant.
    pub restless: u64,
    /// Number of programs with more tasks than the reference handles; they are compared up to that number of tasks.
    pub long: u64,
    /// The longest time of a program, and its seed.
    pub slowest: (Duration, u64),
    /// Seeds of programs that they ran differently.
    pub different: Vec<u64>,
    /// Coverage of the programs.
    pub coverage: Coverage,
}

impl Outcome {
    fn add(&mut self, seed: u64, case: &Case, verdict: &Verdict) {
        match verdict {
            Verdict::Same(run) => {
                self.same += 1;
                self.coverage.add(case, run);
            }
            Verdict::Refused(_) => self.refused += 1,
            Verdict::Cut(Cut::Restless(_)) => self.restless += 1,
            Verdict::Cut(Cut::Long) => self.long += 1,
            Verdict::Different(_) => self.different.push(seed),
        }
    }

    /// Adds the totals of others.
    pub fn join(&mut self, other: &Outcome) {
        self.same += other.same;
        self.refused += other.refused;
        self.restless += other.restless;
        self.long += other.long;
        self.slowest = self.slowest.max(other.slowest);
        self.different.extend(&other.different);
        self.coverage.join(&other.coverage);
    }

    /// Returns the number of programs.
    pub fn count(&self) -> u64 {
        self.same + self.refused + self.restless + self.long + self.different.len() as u64
    }
}

/// Runs the programs of all `seeds`.
pub fn run(seeds: Range<u64>) -> Outcome {
    let threads = thread::available_parallelism().map_or(2, |threads| threads.get() as u64);
    let mut whole = Outcome::default();
    thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|worker| {
                let seeds = seeds.clone();
                scope.spawn(move || {
                    let mut part = Outcome::default();
                    for seed in seeds.filter(|seed| seed % threads == worker) {
                        let begun = Instant::now();
                        let case = generate::case(seed);
                        part.add(seed, &case, &judge(&case));
                        part.slowest = part.slowest.max((begun.elapsed(), seed));
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
    whole
}
