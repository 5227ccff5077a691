//! The cost of handing a resource over must not grow with the number of waiting tasks, whatever they need or state.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test stops at an unexpected result")]
#![allow(
    clippy::disallowed_types,
    clippy::disallowed_methods,
    reason = "the test measures how long the executive takes"
)]

mod support;

use apex_executive::step;
use apex_model::event::Batch;
use std::time::{Duration, Instant};
use support::{agent, seconds};

/// Declarations, the profile of competitor number n, and the other clauses of its step.
type KindOfCompetitor = (&'static str, &'static str, fn(usize) -> String, &'static str);

/// Competitors with known durations, as `use NUMBER SECONDS` of one procedure.
fn program((_, declared, profile, clause): KindOfCompetitor, order: &str, count: usize) -> String {
    let step = |number: usize| {
        format!("  (step s{number} (use {}s) (profile {}) {clause})\n", 1 + number % 3, profile(number))
    };
    let steps: String = (0..count).map(step).collect();
    format!(
        "{declared}\n(procedure {order} (index (do-domain))\n{steps})\n(primitive (index (use ?d)) (duration ?d))\n"
    )
}

/// Returns the least time of a hand-off among `count` competitors.
fn least(text: &str) -> Duration {
    let mut agent = agent(text);
    step(&mut agent, &Batch { now: seconds(0.0), events: Vec::new() });
    let mut least = Duration::MAX;
    for instant in 1..60 {
        let now = seconds(f64::from(instant));
        let start = Instant::now();
        let effects = step(&mut agent, &Batch { now, events: Vec::new() });
        if !effects.is_empty() {
            least = least.min(start.elapsed());
        }
    }
    assert!(least < Duration::MAX, "no hand-off happened");
    least
}

/// Without arbitration at the front of queues, ten times as many took a hundred times as long.
#[test]
fn ten_times_as_many_competitors_cost_much_less_than_ten_times_as_much() {
    let kinds: [KindOfCompetitor; 6] = [
        ("known durations", "", |_| "r".into(), ""),
        ("two resources", "", |_| "r q".into(), ""),
        ("capacity 2", "(resource r :capacity 2)", |_| "(r 1)".into(), ""),
        ("capacity 3, amounts", "(resource r :capacity 3)", |number| format!("(r {})", 1 + number % 3), ""),
        ("pairs", "", |number| format!("r{} r{}", number % 5, (number + 1 + number % 3) % 5), ""),
        ("urgency", "", |_| "r".into(), "(priority :urgency 3 :importance 5)"),
    ];
    let ranked = (kinds[0], ":ranked");
    for (kind, order) in kinds.map(|kind| (kind, "")).into_iter().chain([ranked]) {
        let few = least(&program(kind, order, 100));
        let many = least(&program(kind, order, 1_000));
        println!("{} {order}: {few:?} among 100, {many:?} among 1,000", kind.0);
        assert!(many < few * 8, "{} {order}: {few:?} among 100, {many:?} among 1,000", kind.0);
    }
}

/// Tasks with separate durations that fill the gaps in two resources: the claims before a gap exceed the resources after few turns.
#[test]
fn gaps_in_two_resources_cost_much_less_than_their_number() {
    let program = |count: usize| {
        let step = |number: usize| {
            let (first, second, span) = (1 + number % 3, 1 + number / 3 % 3, 1_000 + number * 7_919 % 5_000);
            format!("  (step s{number} (use {span}ms) (profile (r {first}) (q {second})))\n")
        };
        let steps: String = (0..count).map(step).collect();
        let declared = "(resource r :capacity 3) (resource q :capacity 3)";
        format!("{declared}\n(procedure (index (do-domain))\n{steps})\n(primitive (index (use ?d)) (duration ?d))\n")
    };
    let (few, many) = (least(&program(100)), least(&program(1_000)));
    println!("gaps in two resources: {few:?} among 100, {many:?} among 1,000");
    assert!(many < few * 8, "{few:?} among 100, {many:?} among 1,000");
}

/// Ranked procedures of ten steps that compete with one another; numbers or urgencies of their steps differ.
fn families(profile: &str, urgent: bool, count: usize) -> String {
    let step = |number: usize| {
        let (span, level) = (1 + number % 3, number * 7 % 10);
        let priority = match urgent {
            true => format!("(priority :urgency {} :importance {})", level % 7, 3 + level % 5),
            false => format!("(priority {level})"),
        };
        format!("  (step s{number} (use {span}s) (profile {profile}) {priority})\n")
    };
    let steps: String = (0..10).map(step).collect();
    let families = count / 10;
    format!(
        "(procedure (index (do-domain)) (step all (family ?f) (forall ?f in (range {families}))))
(procedure :ranked (index (family ?f))\n{steps})\n(primitive (index (use ?d)) (duration ?d))\n"
    )
}

/// Compared pair by pair, ten times as many took more than a hundred times as long.
#[test]
fn ranked_families_cost_much_less_than_their_number() {
    for (profile, urgent) in [("r", false), ("r q", false), ("r", true), ("r q", true)] {
        let (few, many) = (least(&families(profile, urgent, 100)), least(&families(profile, urgent, 1_000)));
        println!("families of {profile}, urgent {urgent}: {few:?} among 100, {many:?} among 1,000");
        assert!(many < few * 8, "families of {profile}, urgent {urgent}: {few:?} among 100, {many:?} among 1,000");
    }
}
