//! `apex-conditions-random --count N --seed S`: asks random questions, tells how it goes on, and writes down what differs.

use apex_conditions_random::campaign::{self, Outcome};
use apex_conditions_random::{compare, generate, page, shrink};
use std::process::ExitCode;

const USAGE: &str = "\
usage: apex-conditions-random [--count N] [--seed S]   ask N questions from seed S on; 20000 and 1 unless given
       apex-conditions-random --show S                 the question of seed S as a page
       apex-conditions-random --planted                how soon planted bugs are found (feature planted-bugs)";
/// Questions between two lines of progress.
const PORTION: u64 = 100_000;
/// Differences that are made small and printed.
const SHOWN_MAX: usize = 12;

fn main() -> ExitCode {
    let mut count = 20_000;
    let mut seed = 1;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut number = || arguments.next().and_then(|text| text.parse().ok());
        match argument.as_str() {
            "--count" => count = number().unwrap_or(count),
            "--seed" => seed = number().unwrap_or(seed),
            "--show" => return show(number().unwrap_or(seed)),
            "--planted" => return planted(),
            _ => {
                eprintln!("{USAGE}");
                return ExitCode::from(2);
            }
        }
    }
    hunt(seed, count)
}

fn hunt(seed: u64, count: u64) -> ExitCode {
    let mut whole = Outcome::default();
    let mut from = seed;
    while from < seed + count {
        let to = (from + PORTION).min(seed + count);
        let part = campaign::run(from..to);
        from = to;
        whole.join(&part);
        println!("{} questions, {} different, {} refused", from - seed, whole.different.len(), whole.refused.len());
    }
    println!("{}", whole.text());
    if let Some(refused) = whole.refused.first() {
        println!("refused, for example:\n{:?}", compare::compare(&generate::question(*refused)));
    }
    for seed in whole.different.iter().take(SHOWN_MAX) {
        println!("{}", page::of(*seed, &shrink::shrink(&{let mut question = generate::question(*seed); if std::env::var("NOLATE").is_ok() { question.arrivals.retain(|each| each.at == each.arrives) }; question})));
    }
    if whole.different.is_empty() && whole.refused.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn show(seed: u64) -> ExitCode {
    println!("{}", page::of(seed, &generate::question(seed)));
    ExitCode::SUCCESS
}

#[cfg(feature = "planted-bugs")]
fn planted() -> ExitCode {
    apex_conditions_random::planted::report()
}

#[cfg(not(feature = "planted-bugs"))]
fn planted() -> ExitCode {
    eprintln!("this needs the feature planted-bugs");
    ExitCode::from(2)
}
