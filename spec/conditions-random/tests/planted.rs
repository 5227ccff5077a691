//! Bugs that are planted in the monitors are found. `make nightly` runs this; it needs the feature `planted-bugs`.
#![cfg(feature = "planted-bugs")]

use apex_conditions_random::compare::{Finding, compare};
use apex_conditions_random::generate::question;
use apex_executive::planted::{self, Bug};

/// Questions after which a bug counts as not found: some seconds.
const QUESTIONS_MAX: u64 = 20_000;

#[test]
fn every_bug_planted_in_the_monitors_is_found() {
    for bug in planted::IN_MONITORS {
        let found = (1..=QUESTIONS_MAX).find(|seed| differs(Some(bug), *seed) && !differs(None, *seed));
        println!("{bug:?}: {found:?}");
        assert!(found.is_some(), "{bug:?} is not found by {QUESTIONS_MAX} questions");
    }
    planted::plant(None);
}

fn differs(bug: Option<Bug>, seed: u64) -> bool {
    planted::plant(bug);
    matches!(compare(&question(seed)), Finding::Different(_))
}
