//! Arbitration by queues gives the same results as a comparison of all claimants, over whole runs. Needs, durations, urgencies and ranks
//! are mixed at random. A second run compares all claimants at each hand-off: it has one more claimant, which comes after all others and
//! whose priority must be computed.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test stops at an unexpected result")]

mod support;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::fmt::Write as _;
use support::{agent, message, run, story};

/// Programs in one run of the test; `CONTENTION_PROGRAMS` sets another number, `CONTENTION_SEED` another seed.
const PROGRAMS: u64 = 50;
/// Seeds of programs that differed once.
const FOUND: [u64; 1] = [30_399];
const UNTIL: f64 = 300.0;
const WAVES: u32 = 3;

struct TestRng(ChaCha8Rng);

impl TestRng {
    fn below(&mut self, bound: u32) -> u32 {
        self.0.next_u32() % bound
    }

    fn chance(&mut self, percent: u32) -> bool {
        self.below(100) < percent
    }

    fn of(&mut self, all: &[&str]) -> String {
        all[self.below(all.len() as u32) as usize].to_string()
    }
}

/// Liking of a program for kinds of claimants, in percent.
struct Taste {
    profiles: Vec<String>,
    known: u32,
    numbers: u32,
    urgency: u32,
    urgencies: u32,
    late: u32,
    ranks: u32,
}

impl Taste {
    fn of(rng: &mut TestRng) -> Taste {
        let pools: [&[&str]; 6] = [
            &["r"],
            &["r q", "r", "q"],
            &["(r3 1)", "(r3 2)", "(r3 3)"],
            &["(r3 1) (q3 2)", "(r3 2) (q3 1)", "(r3 1) (q3 1)", "(r3 3)"],
            &["r (r3 1)", "(r3 2)", "q (r3 1)"],
            &["(r3 1)"],
        ];
        let profiles = pools[rng.below(6) as usize].iter().map(|each| (*each).to_string()).collect();
        let mut liking = |values: [u32; 4]| values[rng.below(4) as usize];
        Taste {
            profiles,
            known: liking([0, 50, 100, 100]),
            numbers: liking([0, 0, 40, 100]),
            urgency: liking([0, 0, 50, 100]),
            urgencies: liking([0, 0, 0, 50]),
            late: liking([0, 0, 20, 40]),
            ranks: liking([0, 0, 0, 60]),
        }
    }
}

/// The clauses of one claimant.
fn clauses(rng: &mut TestRng, taste: &Taste) -> String {
    let profile = &taste.profiles[rng.below(taste.profiles.len() as u32) as usize];
    let mut text = format!("(profile {profile})");
    if rng.chance(taste.numbers) {
        let _ = write!(text, " (priority {})", rng.below(4));
    }
    if rng.chance(taste.urgency) {
        text.push_str(" (priority :urgency 6 :importance 3)");
    }
    if rng.chance(taste.urgencies) {
        let _ = write!(text, " (priority :urgency {} :importance {})", 4 + rng.below(4), 1 + rng.below(4));
    }
    if rng.chance(15) {
        let _ = write!(text, " (interrupt-cost {})", rng.below(3));
    }
    if rng.chance(taste.late) {
        let _ = write!(text, " (waitfor (go {}))", rng.below(WAVES));
    }
    text
}

fn activity(rng: &mut TestRng, taste: &Taste) -> String {
    let work = if rng.chance(taste.known) { "use" } else { "work" };
    format!("({work} {}s)", 1 + rng.below(4))
}

/// Steps of one procedure, and procedures below some of them.
fn procedure(rng: &mut TestRng, taste: &Taste, name: &str, depth: u32, text: &mut String) {
    let order = rng.of(&["", "", ":ranked", ":ranked"]);
    let mut body = format!("(procedure {order} (index ({name}))\n");
    for number in 0..2 + rng.below(if depth == 0 { 9 } else { 5 }) {
        let tag = format!("{name}{number}");
        let rank = if rng.chance(taste.ranks) { format!("(rank {})", rng.below(4)) } else { String::new() };
        let step = match rng.below(10) {
            0 | 1 if depth < 2 => {
                procedure(rng, taste, &tag, depth + 1, text);
                format!("({tag})")
            }
            2 | 3 => {
                let (clauses, activity) = (clauses(rng, taste), activity(rng, taste));
                let _ = writeln!(text, "(procedure (index (item-of-{tag} ?i)) (step {tag}-go {activity} {clauses}))");
                format!("(item-of-{tag} ?i) (forall ?i in (range {}))", 2 + rng.below(6))
            }
            _ => format!("{} {}", activity(rng, taste), clauses(rng, taste)),
        };
        let _ = writeln!(body, "  (step {tag} {step} {rank})");
    }
    let _ = writeln!(text, "{body})");
}

/// Ranked procedures that compete with one another: families with steady priorities, or with urgencies in a part of them.
fn families(rng: &mut TestRng, taste: &Taste, text: &mut String) {
    let kinds = 1 + rng.below(3);
    let (urgency, urgencies) = if rng.chance(50) { (60, 60) } else { (0, 0) };
    for kind in 0..kinds {
        let mut body = format!("(procedure :ranked (index (family {kind} ?n))\n");
        for number in 0..2 + rng.below(6) {
            let own = Taste { urgency, urgencies, profiles: taste.profiles.clone(), ..*taste };
            let (activity, clauses) = (activity(rng, taste), clauses(rng, &own));
            let rank = if rng.chance(taste.ranks) { format!("(rank {})", rng.below(4)) } else { String::new() };
            let _ = writeln!(body, "  (step k{kind}n{number} {activity} {clauses} {rank})");
        }
        let _ = writeln!(text, "{body})");
    }
    text.push_str("(procedure (index (m))\n");
    for kind in 0..kinds {
        let (late, count) = (rng.below(3), 1 + rng.below(4));
        let wait = if rng.chance(taste.late) { format!("(waitfor (go {late}))") } else { String::new() };
        let _ = writeln!(text, "  (step f{kind} (family {kind} ?n) (forall ?n in (range {count})) {wait})");
    }
    text.push_str(")\n");
}

/// Returns a program, and the same program with one more claimant.
fn programs(seed: u64) -> [String; 2] {
    let mut rng = TestRng(ChaCha8Rng::seed_from_u64(seed));
    let taste = Taste::of(&mut rng);
    let mut text = String::from(
        "(resource r3 :capacity 3)\n(resource q3 :capacity 3)
(primitive (index (use ?d)) (duration ?d))
(procedure (index (work ?d)) (step sleep (sleep ?d)))
(primitive (index (sleep ?d)) (duration ?d))
",
    );
    match seed % 3 {
        0 => families(&mut rng, &taste, &mut text),
        _ => procedure(&mut rng, &taste, "m", 0, &mut text),
    }
    with_and_without_last(&text)
}

/// Returns a program that pursues `(m)`, and the same program with one more claimant.
fn with_and_without_last(text: &str) -> [String; 2] {
    let last = "(step last (sleep 1s) (profile r q (r3 3) (q3 3)) (priority (if (> 1 0) -1000 -1000)))";
    [String::new(), last.into()].map(|last| format!("{text}(procedure (index (do-domain)) (step main (m)) {last})\n"))
}

fn lived(text: &str) -> Vec<String> {
    let events: Vec<_> = (0..WAVES).map(|wave| message(f64::from(3 + wave * 4), &format!("(go {wave})"))).collect();
    let mut agent = agent(text);
    let effects = run(&mut agent, &events, UNTIL);
    // The additional claimant begins after all others, and the program ends with it.
    let others = |line: &String| !["last", "root", "end"].iter().any(|word| line.split(' ').nth(1) == Some(word));
    story(&effects).into_iter().filter(others).collect()
}

fn first_difference(one: &[String], other: &[String]) -> Option<String> {
    let count = one.len().max(other.len());
    let index = (0..count).find(|index| one.get(*index) != other.get(*index))?;
    Some(format!("line {index}: queues {:?}, comparison {:?}", one.get(index), other.get(index)))
}

#[test]
fn queues_decide_as_a_comparison_of_all_does() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    let first = number("CONTENTION_SEED").unwrap_or(1);
    let seeds = first..first + number("CONTENTION_PROGRAMS").unwrap_or(PROGRAMS);
    for seed in FOUND.into_iter().chain(seeds) {
        let [queued, compared] = programs(seed);
        let (one, other) = (lived(&queued), lived(&compared));
        assert!(one.len() > 4, "seed {seed}: nothing happens\n{queued}");
        if let Some(difference) = first_difference(&one, &other) {
            panic!("seed {seed}: {difference}\n{queued}\n{}", one.join("\n"));
        }
    }
}

/// The weaker of two holders of one rank depends on the tasks that both precede: here on `behind`, whose priority counts for both, so that
/// the interrupt cost decides.
#[test]
fn the_weaker_of_two_holders_of_one_rank_is_that_of_a_comparison() {
    let text = "(resource r3 :capacity 3) (resource q3 :capacity 3)
(procedure (index (work ?d)) (step sleep (sleep ?d)))
(primitive (index (sleep ?d)) (duration ?d))
(procedure :ranked (index (m))
  (step first (work 4s) (profile (r3 1)) (waitfor (go 0)) (rank 1))
  (step held (work 9s) (profile (r3 1)) (rank 2))
  (step costly (work 9s) (profile (r3 1)) (interrupt-cost 1) (rank 3))
  (step worthy (work 9s) (profile (r3 1)) (priority 2) (rank 3))
  (step behind (work 1s) (profile (r3 1)) (priority 3) (rank 5)))
";
    let [one, other] = with_and_without_last(text).map(|text| lived(&text));
    assert_eq!(first_difference(&one, &other), None);
    assert!(one.contains(&"3s worthy interrupted".to_string()), "{}", one.join("\n"));
}
