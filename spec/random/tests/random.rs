//! Ten thousand random programs: the executive and the reference behave the same.

use apex_random::{campaign, generate, page, shrink};

/// The number used in CI; `make nightly` runs a million. Conditions of execution end many tasks before they are interrupted, so this many
/// programs are needed to reach every least count below.
const COUNT: u64 = 10_000;

#[test]
fn the_executive_and_the_reference_do_the_same() {
    let outcome = campaign::run(1..COUNT + 1);
    let different = &outcome.different;
    if let Some(seed) = different.first() {
        let smallest = page::of(*seed, &shrink::shrink(&generate::case(*seed)));
        panic!("{} programs differ: {different:?}; the first, reduced:\n{smallest}", different.len());
    }
    let table = outcome.coverage.text();
    assert!(outcome.refused * 10 < COUNT, "{} programs are refused by the checker", outcome.refused);
    assert!(outcome.restless * 50 < COUNT, "{} programs do not come to rest", outcome.restless);
    assert!(outcome.long * 100 < COUNT, "{} programs are too long to compare", outcome.long);
    for (construct, count) in &outcome.coverage.constructs {
        assert!(*count >= 20, "only {count} programs with {construct}\n{table}");
    }
    let legal = [
        ("pending -> enabled", 20_000),
        ("enabled -> ongoing", 20_000),
        ("ongoing -> interrupted", 1_000),
        ("interrupted -> ongoing", 480),
        ("ongoing -> pending", 200),
        ("interrupted -> pending", 8),
        ("terminated -> pending", 1_200),
        ("pending -> terminated", 2_000),
        ("enabled -> terminated", 200),
        ("ongoing -> terminated", 20_000),
        ("interrupted -> terminated", 200),
        ("because outranked by", 120),
        ("because a resource is exhausted", 8),
        ("because handled by", 80),
        ("ends before its turn", 80),
    ];
    for (what, least) in legal {
        let count = outcome.coverage.moves.get(what).copied().unwrap_or(0);
        assert!(count >= least, "{what} only {count} times\n{table}");
    }
}

#[test]
fn a_seed_always_makes_the_same_program() {
    assert_eq!(generate::case(7), generate::case(7));
    assert_ne!(generate::case(7), generate::case(8));
}
