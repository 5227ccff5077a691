//! Plans and proofs against brute force that shares only the problem's data types with them.
//!
//! A bound that some plan exceeds is a false proof; a plan that claims more than the best order gives is a false plan.
//! `APEX_BRUTE_FORCE_PROBLEMS` sets the number of problems (`make nightly`: 100,000), `APEX_BRUTE_FORCE_SEED` the first one. A failure
//! prints its seed and the problem as JSON.
#![allow(clippy::expect_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]
#![allow(clippy::disallowed_methods, reason = "separate mathematics, and the environment")]

mod chance;
mod known;
mod visit_orders;
mod visit_problems;
mod visits;
mod watch_problems;
mod watch_words;
mod watches;

/// Returns the number of problems of a run; seven in ten are single-visit problems.
fn problems() -> u64 {
    number("APEX_BRUTE_FORCE_PROBLEMS").unwrap_or(2_000)
}

fn first_seed() -> u64 {
    number("APEX_BRUTE_FORCE_SEED").unwrap_or(0)
}

fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok().and_then(|text| text.parse().ok())
}

/// Tries problems by rising seed; panics with all differences.
fn try_all(what: &str, count: u64, check: impl Fn(u64) -> Vec<String>) {
    let mut failed = 0;
    let mut told = Vec::new();
    for seed in first_seed()..first_seed() + count {
        let found = check(seed);
        failed += u64::from(!found.is_empty());
        if told.len() < 6 {
            told.extend(found.into_iter().take(1).map(|difference| format!("seed {seed}: {difference}")));
        }
    }
    assert!(failed == 0, "{failed} of {count} problems of {what} differ:\n{}", told.join("\n"));
}

#[test]
fn single_visits() {
    try_all("single visits", problems() * 7 / 10, visits::differences);
}

#[test]
fn surveillance() {
    try_all("surveillance", problems() * 3 / 10, watches::differences);
}
