//! `apex-conditions-random --count N --seed S` asks random questions, and prints its progress and the questions that are answered
//! differently.

use apex_conditions_random::campaign::{self, Manner, Outcome};
use apex_conditions_random::{compare, generate, page, shrink};
use std::process::ExitCode;

const USAGE: &str = "\
usage: apex-conditions-random [OPTION..]   ask random questions, and print those with different answers
       apex-conditions-random --show S     print the question of seed S as a page

  --count N     number of questions; default 20000
  --seed S      seed of the first question; default 1
  --threads T   number of threads; default is the number of cores
  --only FORM   only questions with this form, as the printed table names it
  --shown K     number of differing questions that are reduced and printed; default 5";
/// Number of questions between two lines of progress. Each line states its seeds.
const PORTION: u64 = 100_000;

fn main() -> ExitCode {
    let mut count = 20_000;
    let mut seed = 1;
    let mut shown = 5;
    let mut threads = None;
    let mut only = None;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--only" {
            only = arguments.next();
            continue;
        }
        let mut number = || arguments.next().and_then(|text| text.parse().ok());
        match argument.as_str() {
            "--threads" => threads = number(),
            "--count" => count = number().unwrap_or(count),
            "--seed" => seed = number().unwrap_or(seed),
            "--shown" => shown = number().unwrap_or(shown),
            "--show" => return show(number().unwrap_or(seed)),
            _ => {
                eprintln!("{USAGE}");
                return ExitCode::from(2);
            }
        }
    }
    let manner = Manner { threads: threads.unwrap_or_else(campaign::cores), only };
    hunt(seed, count, &manner, usize::try_from(shown).unwrap_or(usize::MAX))
}

fn hunt(seed: u64, count: u64, manner: &Manner, shown: usize) -> ExitCode {
    let mut whole = Outcome::default();
    let mut from = seed;
    while from < seed + count {
        let to = (from + PORTION).min(seed + count);
        let part = campaign::run_as(from..to, manner);
        println!("seeds {from}..{to}: {} alike, different {:?}, refused {:?}", part.same, part.different, part.refused);
        from = to;
        whole.join(&part);
    }
    println!("{}", whole.text());
    if let Some(refused) = whole.refused.first() {
        println!("refused, for example:\n{:?}", compare::compare(&generate::question(*refused)));
    }
    for seed in whole.different.iter().take(shown) {
        println!("{}", page::of(*seed, &shrink::shrink(&generate::question(*seed))));
    }
    if whole.different.is_empty() && whole.refused.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn show(seed: u64) -> ExitCode {
    println!("{}", page::of(seed, &generate::question(seed)));
    ExitCode::SUCCESS
}
