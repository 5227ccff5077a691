//! Measures the time in which planted bugs of the executive are found.

use crate::compare::{Verdict, judge};
use crate::generate;
use apex_executive::planted::{self, Bug};
use std::time::{Duration, Instant};

/// Programs after which a bug counts as not found.
pub const PROGRAMS_MAX: u64 = 20_000;

/// Returns each planted bug with the seed of the first program that reveals it, and the time taken.
pub fn measure(first: u64) -> Vec<(Bug, Option<u64>, Duration)> {
    let mut found = Vec::new();
    for bug in planted::IN_CONTROL {
        let begun = Instant::now();
        let seed = (first..first + PROGRAMS_MAX).find(|seed| shows(bug, *seed));
        found.push((bug, seed, begun.elapsed()));
    }
    planted::plant(None);
    found
}

/// Returns true if the program of `seed` shows a difference with the bug, and only with it.
fn shows(bug: Bug, seed: u64) -> bool {
    let case = generate::case(seed);
    let differs = |bug| {
        planted::plant(bug);
        matches!(judge(&case), Verdict::Different(_))
    };
    differs(Some(bug)) && !differs(None)
}
