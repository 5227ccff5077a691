//! Repeats one kind of work for a profiler that counts instructions, which do not depend on the load of the machine.
//!
//! `valgrind --tool=callgrind --toggle-collect=apex_benches::Driven::step instructions ROW COUNT TIMES`. ROW is `event`, `again`,
//! `hand-off`, `next` (the holder ends, the next one begins), or a shape of plan (`flat nested sequence chain concurrent ranked`), whose
//! lives are counted by `--toggle-collect=apex_executive::step::step`; or `load`, which is counted whole. Without a profiler it prints
//! the least time of each piece of work: of windows of a hundred steps, or the processor time of a whole life or load.
#![allow(clippy::print_stdout, reason = "the count is what the program is for")]

use apex_benches::{Driven, WATCHERS, agent, command_in, level, library, programs};
use apex_model::effect::CommandId;
use apex_model::event::EventKind;
use apex_model::value::Value;
use std::hint::black_box;
use std::process::ExitCode;
use std::sync::LazyLock;
use std::time::Instant;

/// Competitors for one resource; an alarm outranks all of them.
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
        "next" => next_ones(count, times),
        "load" => loads(&programs::procedures(count), times),
        "flat" => lives(&programs::flat(count), times),
        "nested" => lives(&programs::nested(count), times),
        "sequence" => lives(&programs::sequence(count), times),
        "chain" => lives(&programs::chain(count), times),
        "concurrent" => lives(&programs::concurrent(count), times),
        "ranked" => lives(&programs::ranked(count), times),
        _ => {
            println!(
                "usage: instructions event|again|hand-off|next|load|flat|nested|sequence|chain|concurrent|ranked COUNT TIMES"
            );
            return ExitCode::FAILURE;
        }
    };
    println!("{row} {count}: {:.0} ns at least, {} effects", steps.least_ns, steps.effects);
    ExitCode::SUCCESS
}

/// Sends samples that each satisfy one of `count` waiting tasks, up to its command and the answer.
fn events(text: &str, count: usize, times: usize) -> Meter {
    let mut driven = Driven::new(&library(text));
    let mut done = Meter::default();
    for number in 0..times.min(count) {
        let batch = driven.batch(level((number * 7_919 % count) as i64, 11));
        let start = Instant::now();
        let effects = driven.step(black_box(&batch));
        done.step(start, effects.len());
        done.end_of_one();
        if let Some(command) = command_in(&effects) {
            let batch = driven.batch(acknowledged(command));
            driven.answer(&batch);
        }
    }
    done
}

/// Measures interruption and resumption.
fn hand_offs(count: usize, times: usize) -> Meter {
    let mut driven = Driven::new(&library(&COMPETITORS.replace("COUNT", &count.to_string())));
    let mut done = Meter::default();
    for _ in 0..times {
        let alarm = driven.batch(EventKind::Occurrence(Value::list([Value::symbol("alarm")])));
        let start = Instant::now();
        let effects = driven.step(black_box(&alarm));
        done.step(start, effects.len());
        if let Some(command) = command_in(&effects) {
            let batch = driven.batch(acknowledged(command));
            let start = Instant::now();
            let effects = driven.step(black_box(&batch));
            done.step(start, effects.len());
        }
        done.end_of_one();
    }
    done
}

/// Measures hand-offs: the holder ends, and the next one begins.
fn next_ones(count: usize, times: usize) -> Meter {
    let (mut driven, effects) = Driven::begun(&library(&COMPETITORS.replace("COUNT", &count.to_string())));
    let mut done = Meter::default();
    let mut command = command_in(&effects);
    for _ in 0..times.min(count) {
        let Some(holder) = command else { break };
        let batch = driven.batch(acknowledged(holder));
        let start = Instant::now();
        let effects = driven.step(black_box(&batch));
        done.step(start, effects.len());
        done.end_of_one();
        command = command_in(&effects);
    }
    done
}

/// Measures the lives of all tasks of a plan, together.
fn lives(text: &str, times: usize) -> Meter {
    let library = library(text);
    let mut done = Meter::default();
    for _ in 0..times {
        let driven = Driven::ready(&library);
        let start = (Instant::now(), worked_ns());
        let (_driven, effects) = driven.begin();
        done.piece(start);
        done.effects += effects.len();
    }
    done
}

fn loads(text: &str, times: usize) -> Meter {
    let mut done = Meter::default();
    for _ in 0..times {
        let start = (Instant::now(), worked_ns());
        black_box(agent(&library(black_box(text))));
        done.piece(start);
    }
    done
}

/// Steps whose times are added up in windows, short enough for most not to be interrupted.
struct Meter {
    effects: usize,
    least_ns: f64,
    window_ns: f64,
    window_count: usize,
}

impl Default for Meter {
    fn default() -> Meter {
        Meter { effects: 0, least_ns: f64::INFINITY, window_ns: 0.0, window_count: 0 }
    }
}

impl Meter {
    fn step(&mut self, start: Instant, effects: usize) {
        self.window_ns += start.elapsed().as_nanos() as f64;
        self.effects += effects;
    }

    /// Adds one long piece of work. The system counts processor time in steps of some milliseconds, which is accurate for long pieces only.
    fn piece(&mut self, (start, worked): (Instant, f64)) {
        const LONG_NS: f64 = 3e7;
        let passed = start.elapsed().as_nanos() as f64;
        let worked = worked_ns() - worked;
        self.least_ns = self.least_ns.min(if passed > LONG_NS { worked } else { passed });
    }

    fn end_of_one(&mut self) {
        const WINDOW: usize = 100;
        self.window_count += 1;
        if self.window_count == WINDOW {
            self.least_ns = self.least_ns.min(self.window_ns / WINDOW as f64);
            (self.window_ns, self.window_count) = (0.0, 0);
        }
    }
}

/// Returns the processor time of this thread, or elapsed time if the system does not provide it.
fn worked_ns() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let worked = stat.and_then(|stat| stat.split(' ').next()?.parse().ok());
    worked.unwrap_or_else(|| START.elapsed().as_nanos() as f64)
}

fn acknowledged(command: CommandId) -> EventKind {
    EventKind::CommandAcknowledged(command, Ok(Value::nil()))
}
