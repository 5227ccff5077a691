//! `apex-random --count N --seed S` runs random programs, and prints its progress and the cases that differ.

use apex_random::campaign::{self, Outcome};
use apex_random::{generate, page, shrink};
use std::process::ExitCode;
use std::time::Instant;

const USAGE: &str = "\
usage: apex-random [--count N] [--seed S] [--show]   run N programs from seed S on; default 20000 from 1
       apex-random --planted                         how fast planted bugs are found (feature planted-bugs)
  --show   print the program of seed S and nothing else";
/// Programs between two lines of progress.
const CHUNK: u64 = 5_000;
/// Maximum number of different cases that are reduced and printed.
const SHOWN_MAX: usize = 3;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let has = |name: &str| arguments.iter().any(|each| each == name);
    let number = |name: &str, default: u64| match arguments.iter().position(|each| each == name) {
        None => Ok(default),
        Some(index) => arguments.get(index + 1).and_then(|value| value.parse().ok()).ok_or(name.to_string()),
    };
    let (count, seed) = match (number("--count", 20_000), number("--seed", 1)) {
        (Ok(count), Ok(seed)) => (count, seed),
        (Err(name), _) | (_, Err(name)) => {
            eprintln!("{name} needs a number\n{USAGE}");
            return ExitCode::FAILURE;
        }
    };
    if has("--help") {
        println!("{USAGE}");
        return ExitCode::SUCCESS;
    }
    if has("--planted") {
        return planted(seed);
    }
    if has("--show") {
        println!("{}", page::without_difference(seed, &generate::case(seed)));
        return ExitCode::SUCCESS;
    }
    many(seed, count)
}

fn many(first: u64, count: u64) -> ExitCode {
    let begun = Instant::now();
    let mut whole = Outcome::default();
    let mut next = first;
    while next < first + count {
        let end = (next + CHUNK).min(first + count);
        let part = campaign::run(next..end);
        for seed in part.different.iter().take(SHOWN_MAX.saturating_sub(whole.different.len())) {
            println!("{}", page::of(*seed, &shrink::shrink(&generate::case(*seed))));
        }
        whole.join(&part);
        next = end;
        let rate = whole.count() as f64 / begun.elapsed().as_secs_f64();
        eprintln!(
            "{} of {count} programs, {rate:.0}/s: {} the same, {} refused, {} restless, {} long, {} different",
            whole.count(),
            whole.same,
            whole.refused,
            whole.restless,
            whole.long,
            whole.different.len()
        );
    }
    let (time, seed) = whole.slowest;
    println!("slowest: {:.2} s for seed {seed}", time.as_secs_f64());
    print!("{}", whole.coverage.text());
    if whole.different.is_empty() {
        return ExitCode::SUCCESS;
    }
    println!("seeds that differ: {:?}", whole.different);
    ExitCode::FAILURE
}

#[cfg(feature = "planted-bugs")]
fn planted(seed: u64) -> ExitCode {
    let mut all = true;
    for (bug, found, time) in apex_random::planted::measure(seed) {
        match found {
            Some(at) => println!("{bug:?}: found by program {} after {:.2} s", at - seed + 1, time.as_secs_f64()),
            None => println!("{bug:?}: not found in {:.2} s", time.as_secs_f64()),
        }
        all &= found.is_some() && time.as_secs() < 60;
    }
    if all { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

#[cfg(not(feature = "planted-bugs"))]
fn planted(_: u64) -> ExitCode {
    eprintln!("this build has no planted bugs; build it with --features planted-bugs");
    ExitCode::FAILURE
}
