//! Does one kind of work again and again, for a profiler to count: instructions do not depend on who else uses the machine.
//!
//! `valgrind --tool=callgrind --toggle-collect='*Driven*step*' --toggle-collect='*Driven*begin*' instructions ROW COUNT TIMES`,
//! ROW being `event`, `again`, `hand-off`, `load`, or a shape of plan (`flat nested sequence chain concurrent ranked`). What is
//! counted are the steps alone, without what sets them up.
#![allow(clippy::print_stdout, reason = "the count is what the program is for")]

use apex_benches::{Driven, WATCHERS, agent, command_in, level, library, programs};
use apex_model::effect::CommandId;
use apex_model::event::EventKind;
use apex_model::value::Value;
use std::hint::black_box;
use std::process::ExitCode;

/// Competitors for one resource; an alarm outranks them all.
const COMPETITORS: &str = "
(procedure (index (do-domain))
  (step all (compete ?n) (forall ?n in (range COUNT)))
  (step alarm (look) (waitfor (alarm)) (responding) (priority 1000000)))
(procedure (index (compete ?n))
  (step work (work ?n) (priority ?n)))
(primitive (index (work ?n)) (profile camera) (on-start (command (work ?n))))
(primitive (index (look)) (profile camera) (on-start (command (look))))
";

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let row = arguments.next().unwrap_or_default();
    let mut number = |default: usize| arguments.next().and_then(|text| text.parse().ok()).unwrap_or(default);
    let (count, times) = (number(1_000), number(100));
    let steps = match row.as_str() {
        "event" => events(&programs::waiting(count), count, times),
        "again" => events(&WATCHERS.replace("COUNT", &count.to_string()), count, times),
        "hand-off" => hand_offs(count, times),
        "load" => loads(&programs::procedures(count), times),
        "flat" => lives(&programs::flat(count), times),
        "nested" => lives(&programs::nested(count), times),
        "sequence" => lives(&programs::sequence(count), times),
        "chain" => lives(&programs::chain(count), times),
        "concurrent" => lives(&programs::concurrent(count), times),
        "ranked" => lives(&programs::ranked(count), times),
        _ => {
            println!(
                "usage: instructions event|again|hand-off|load|flat|nested|sequence|chain|concurrent|ranked COUNT TIMES"
            );
            return ExitCode::FAILURE;
        }
    };
    println!("{row} {count}: {steps} effects in {times} times");
    ExitCode::SUCCESS
}

/// A sample each that satisfies one of `count` waiting tasks, up to its command; and the answer.
fn events(text: &str, count: usize, times: usize) -> usize {
    let mut driven = Driven::new(&library(text));
    let mut done = 0;
    for number in 0..times.min(count) {
        let batch = driven.batch(level((number * 7_919 % count) as i64, 11));
        let effects = driven.step(black_box(&batch));
        done += effects.len();
        if let Some(command) = command_in(&effects) {
            let batch = driven.batch(acknowledged(command));
            driven.answer(&batch);
        }
    }
    done
}

/// Interruption and resumption.
fn hand_offs(count: usize, times: usize) -> usize {
    let mut driven = Driven::new(&library(&COMPETITORS.replace("COUNT", &count.to_string())));
    let mut done = 0;
    for _ in 0..times {
        let alarm = driven.batch(EventKind::Occurrence(Value::list([Value::symbol("alarm")])));
        let effects = driven.step(black_box(&alarm));
        done += effects.len();
        if let Some(command) = command_in(&effects) {
            let batch = driven.batch(acknowledged(command));
            done += driven.step(black_box(&batch)).len();
        }
    }
    done
}

/// The lives of all tasks of a plan.
fn lives(text: &str, times: usize) -> usize {
    let library = library(text);
    (0..times).map(|_| Driven::ready(&library).begin().1.len()).sum()
}

fn loads(text: &str, times: usize) -> usize {
    (0..times).map(|_| agent(&library(black_box(text))).tasks.len() + 1).sum()
}

fn acknowledged(command: CommandId) -> EventKind {
    EventKind::CommandAcknowledged(command, Ok(Value::nil()))
}
