//! Hands resources on among many competitors, of every kind that users write, until no competitor is left.
//!
//! `hand_off [COUNT [WORD]..]` prints a row for each kind with all of the words in its name: the mean time of an instant in which a holder
//! ends and the next one begins, over the whole run or the first [`LONGEST`], and the greatest mean over any hundredth of the run. The
//! times are processor times of the thread, without the creation of the competitors.
#![allow(clippy::print_stdout, reason = "the figures are what the program is for")]
#![allow(clippy::expect_used, reason = "a measurement that cannot be set up must stop at once")]

use apex_benches::{declaration, library};
use apex_executive::{Agent, load, step};
use apex_model::effect::{CommandId, DecisionKind, Effect};
use apex_model::event::{Batch, Event, EventKind};
use apex_model::host::HostFunctions;
use apex_model::task::TaskState;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use rustix::time::{ClockId, clock_gettime};
use std::collections::VecDeque;
use std::fmt::Write as _;

/// A run ends after this many hand-offs, or after this processor time in nanoseconds.
const LONGEST: usize = 20_000;
const TIMEOUT_NS: f64 = 20e9;

/// Durations of tasks: not stated, one of three, or a separate duration for each task.
const DURATIONS: [&str; 3] = ["unknown", "known", "separate"];
/// Resources that each competitor needs.
const NEEDS: [&str; 6] = ["one", "two", "capacity 2", "capacity 2 of two", "amounts", "amounts of two"];
const PRIORITIES: [&str; 5] = ["none", "numbers", "urgency", "urgencies", "numbers and urgency"];
const SHAPES: [&str; 5] = ["steps", "forall", "ranked", "forall below a rank", "families"];

/// One kind of competitors.
#[derive(Clone, Copy)]
struct Kind {
    duration: &'static str,
    needs: &'static str,
    priority: &'static str,
    shape: &'static str,
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let count: usize = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(1_000);
    let words: Vec<String> = arguments.collect();
    println!("| shape | priority | needs | duration | hand-offs | mean | worst hundredth |");
    println!("|---|---|---|---|---|---|---|");
    for kind in kinds() {
        let name = format!("/{}/{}/{}/{}/", kind.shape, kind.priority, kind.needs, kind.duration);
        if words.iter().all(|word| name.contains(word.as_str())) {
            let Kind { duration, needs, priority, shape } = kind;
            let run = measure(&program(kind, count));
            let (hand_offs, mean, worst) = (run.len(), mean(&run), worst_hundredth(&run));
            println!("| {shape} | {priority} | {needs} | {duration} | {hand_offs} | {mean:.1} us | {worst:.1} us |");
        }
    }
}

fn kinds() -> Vec<Kind> {
    let mut kinds = Vec::new();
    for shape in SHAPES {
        for priority in PRIORITIES {
            for needs in NEEDS {
                kinds.extend(DURATIONS.map(|duration| Kind { duration, needs, priority, shape }));
            }
        }
    }
    kinds
}

/// Returns the program of a kind with `count` competitors.
fn program(kind: Kind, count: usize) -> String {
    let mut text = String::from(
        "(resource r2 :capacity 2)\n(resource q2 :capacity 2)\n(resource r3 :capacity 3)\n(resource q3 :capacity 3)\n",
    );
    let body = if kind.duration == "unknown" { "(on-start (command (work ?n)))" } else { "(duration ?d)" };
    let _ = writeln!(text, "(primitive (index (work ?n ?d)) {body})");
    match kind.shape {
        "steps" | "ranked" => {
            let order = if kind.shape == "ranked" { ":ranked " } else { "" };
            let _ = writeln!(text, "(procedure {order}(index (do-domain))");
            for number in 0..count {
                let (duration, profile, priority) = (span(kind, number), profile(kind, number), priority(kind, number));
                let _ = writeln!(text, "  (step s{number} (work {number} {duration}) {profile} {priority})");
            }
            text.push_str(")\n");
        }
        "families" => {
            let _ = writeln!(
                text,
                "(procedure (index (do-domain)) (step all (family ?f) (forall ?f in (range {}))))",
                count / 10
            );
            text.push_str("(procedure :ranked (index (family ?f))\n");
            for number in 0..10 {
                let (duration, profile, priority) = (span(kind, number), profile(kind, number), priority(kind, number));
                let _ = writeln!(text, "  (step s{number} (work {number} {duration}) {profile} {priority})");
            }
            text.push_str(")\n");
        }
        _ => {
            let order = if kind.shape == "forall" { "" } else { ":ranked " };
            let _ = writeln!(
                text,
                "(procedure {order}(index (do-domain)) (step all (item ?n) (forall ?n in (range {count}))))"
            );
            // The profile and the priority of an item follow from its number and the kind of its class.
            for class in 0..30 {
                let (profile, priority) = (profile(kind, class), priority(kind, class));
                let duration = span(kind, class);
                let _ = writeln!(
                    text,
                    "(procedure (index (item (?and ?n (?if (= (mod ?n 30) {class}))))) (step go (work ?n {duration}) {profile} {priority}))"
                );
            }
        }
    }
    text
}

fn span(kind: Kind, number: usize) -> String {
    match kind.duration {
        "separate" => format!("{}ms", 1_000 + number * 7_919 % 5_000),
        _ => format!("{}s", 1 + number % 3),
    }
}

fn profile(kind: Kind, number: usize) -> String {
    let (first, second) = (1 + number % 3, 1 + number / 3 % 3);
    match kind.needs {
        "one" => "(profile r)".into(),
        "two" => "(profile r q)".into(),
        "capacity 2" => "(profile (r2 1))".into(),
        "capacity 2 of two" => "(profile (r2 1) (q2 1))".into(),
        "amounts" => format!("(profile (r3 {first}))"),
        _ => format!("(profile (r3 {first}) (q3 {second}))"),
    }
}

fn priority(kind: Kind, number: usize) -> String {
    let (level, urgency, importance) = (number % 10, number % 7, 3 + number % 5);
    match kind.priority {
        "none" => String::new(),
        "numbers" => format!("(priority {level})"),
        "urgency" => "(priority :urgency 3 :importance 5)".into(),
        "urgencies" => format!("(priority :urgency {urgency} :importance {importance})"),
        _ => format!("(priority {level}) (priority :urgency 3 :importance 5)"),
    }
}

/// A run, and the commands that wait for an acknowledgement.
struct HandOffRun {
    agent: Agent,
    now: Time,
    sequence: u64,
    commands: VecDeque<CommandId>,
}

impl HandOffRun {
    /// Returns the next batch: an acknowledgement, or the next wake.
    fn next(&mut self) -> Option<Batch> {
        if let Some(command) = self.commands.pop_front() {
            self.now = self.now + Duration(1_000_000);
            self.sequence += 1;
            let kind = EventKind::CommandAcknowledged(command, Ok(Value::nil()));
            return Some(Batch { now: self.now, events: vec![Event { sequence: self.sequence, at: self.now, kind }] });
        }
        let (at, _) = self.agent.next_wake()?;
        self.now = at.max(self.now);
        Some(Batch { now: self.now, events: Vec::new() })
    }

    fn take(&mut self, effects: &[Effect]) -> usize {
        let mut begun = 0;
        for effect in effects {
            match effect {
                Effect::Command { command, .. } => self.commands.push_back(*command),
                Effect::Decided(decision) => {
                    let begins = matches!(decision.kind, DecisionKind::Transition { to: TaskState::Ongoing, .. });
                    begun += usize::from(begins);
                }
                _ => {}
            }
        }
        begun
    }
}

/// Returns the microseconds of each hand-off.
fn measure(text: &str) -> Vec<f64> {
    let library = library(text);
    let agent = load(library, &declaration(), HostFunctions::default()).expect("the program can be loaded");
    let mut run = HandOffRun { agent, now: Time::ZERO, sequence: 0, commands: VecDeque::new() };
    let effects = step(&mut run.agent, &Batch { now: Time::ZERO, events: Vec::new() });
    run.take(&effects);
    let (mut all, mut spent) = (Vec::new(), 0.0);
    while all.len() < LONGEST && spent < TIMEOUT_NS {
        let Some(batch) = run.next() else { break };
        let start = worked_ns();
        let effects = step(&mut run.agent, &batch);
        let passed = worked_ns() - start;
        spent += passed;
        let begun = run.take(&effects);
        // An instant at which several begin is as many hand-offs.
        all.extend((0..begun).map(|_| passed / begun as f64 / 1e3));
    }
    all
}

/// Returns the processor time of this thread, in nanoseconds.
fn worked_ns() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e9 + time.tv_nsec as f64
}

fn mean(run: &[f64]) -> f64 {
    run.iter().sum::<f64>() / run.len().max(1) as f64
}

fn worst_hundredth(run: &[f64]) -> f64 {
    run.chunks((run.len() / 100).max(1)).map(mean).fold(0.0, f64::max)
}
