//! Arbitration of one resource among many claimants: hand-offs when the holder ends, and interruptions.
#![allow(missing_docs, reason = "criterion's macros make public items")]
#![allow(clippy::expect_used, reason = "a measurement that cannot be set up must stop at once")]

use apex_benches::{Driven, MEASUREMENT, WARM_UP, command_in, library, moved};
use apex_model::event::EventKind;
use apex_model::library::Library;
use apex_model::task::TaskState;
use apex_model::value::Value;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Program of competitors with rising priorities; one holds the resource, and an alarm outranks all of them.
const COMPETITORS: &str = "
(procedure (index (do-domain))
  (step all (compete ?n) (forall ?n in (range COUNT)))
  (step alarm (look) (waitfor (alarm)) (responding) (priority 1000000)))
(procedure (index (compete ?n))
  (step work (work ?n) (priority ?n)))
(primitive (index (work ?n)) (profile camera) (on-start (command (work ?n))))
(primitive (index (look)) (profile camera) (on-start (command (look))))
";

/// Program of families with ranks and rising urgency: a member inherits the urgency of others, so the priorities of any pair may cross.
const FAMILIES: &str = "
(procedure :ranked (index (do-domain))
  (step alarm (look) (waitfor (alarm)) (responding) (priority :urgency 9 :importance 10))
  (step all (family ?n) (forall ?n in (range COUNT)) (priority :urgency 3 :importance 2)))
(procedure :ranked (index (family ?n))
  (step first (work ?n) (priority 1) (priority :urgency 4 :importance 3))
  (step second (work ?n) (priority :urgency 2 :importance 6)))
(primitive (index (work ?n)) (profile camera) (on-start (command (work ?n))))
(primitive (index (look)) (profile camera) (duration 10ms))
";

/// Kinds of competitors: name, declarations, and the primitive that serves each competitor.
const KINDS: [(&str, &str, &str); 6] = [
    ("known durations", "", "(index (use ?n)) (profile camera) (expected-duration 1s)"),
    ("two resources", "", "(index (use ?n)) (profile camera link)"),
    ("two resources, known durations", "", "(index (use ?n)) (profile camera link) (expected-duration 1s)"),
    ("a shared and a separate resource", "", "(index (use ?n)) (profile camera ((antenna ?n) 1))"),
    ("capacity 2", "(resource link :capacity 2)", "(index (use ?n)) (profile (link 1))"),
    ("urgency", "", "(index (use ?n)) (profile camera)"),
];

/// Kinds of ranked steps, with their clauses.
const RANKED: [(&str, &str); 4] = [
    ("ranked steps", "(profile camera)"),
    ("ranked steps, two resources", "(profile camera link)"),
    ("ranked steps, urgency", "(profile camera) (priority :urgency 3 :importance 5)"),
    ("ranked steps, two resources, priorities", "(profile camera link) (priority 4)"),
];

/// Returns the program of a kind: each competitor is an item of a `forall`.
fn competitors(kind: &str, declared: &str, served: &str, count: usize) -> String {
    let priority = if kind == "urgency" { "(priority :urgency 3 :importance 5)" } else { "" };
    format!(
        "{declared}
(procedure (index (do-domain))
  (step all (use ?n) (forall ?n in (range {count})) {priority}))
(procedure {served} (step go (work ?n)))
(primitive (index (work ?n)) (on-start (command (work ?n))))
"
    )
}

/// Returns the same program as steps of one ranked procedure, with these clauses.
fn ranked(count: usize, clauses: &str) -> String {
    let step = |number| format!("  (step s{number} (use {number}) {clauses})\n");
    let steps: String = (0..count).map(step).collect();
    format!(
        "(procedure :ranked (index (do-domain))\n{steps})
(primitive (index (use ?n)) (on-start (command (work ?n))))
"
    )
}

/// Number of hand-offs after the creation of all competitors that are not measured.
const COLD: u64 = 10;
const COUNTS: [usize; 4] = [100, 1_000, 10_000, 100_000];

fn acknowledged(command: apex_model::effect::CommandId) -> EventKind {
    EventKind::CommandAcknowledged(command, Ok(Value::nil()))
}

/// Measures both steps of an interruption: an alarm interrupts the holder, and the holder continues when the alarm's task ends.
fn interrupt_and_resume(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("hand-off");
    group.sample_size(20).warm_up_time(WARM_UP).measurement_time(MEASUREMENT);
    for count in COUNTS {
        let mut driven = Driven::new(&library(&COMPETITORS.replace("COUNT", &count.to_string())));
        group.bench_function(BenchmarkId::new("interruption and resumption", count), |bencher| {
            bencher.iter_custom(|iterations| {
                let mut total = Duration::ZERO;
                for _ in 0..iterations {
                    let alarm = driven.batch(EventKind::Occurrence(Value::list([Value::symbol("alarm")])));
                    let start = Instant::now();
                    let effects = driven.step(black_box(&alarm));
                    total += start.elapsed();
                    let command = command_in(&effects).expect("the alarm's task works");
                    assert!(moved(&effects, TaskState::Ongoing, TaskState::Interrupted), "no task was interrupted");
                    let done = driven.batch(acknowledged(command));
                    let start = Instant::now();
                    let effects = driven.step(black_box(&done));
                    total += start.elapsed();
                    assert!(moved(&effects, TaskState::Interrupted, TaskState::Ongoing), "no task continued");
                }
                total
            });
        });
        let library = library(&COMPETITORS.replace("COUNT", &count.to_string()));
        group.bench_function(BenchmarkId::new("holder ends, next begins", count), |bencher| {
            bencher.iter_custom(|iterations| hand_offs(&library, count, iterations));
        });
    }
    group.finish();
}

/// Returns the time of `iterations` hand-offs, each from a holder that ends to the next of `count` competitors.
fn hand_offs(library: &Arc<Library>, count: usize, iterations: u64) -> Duration {
    let (mut total, mut done) = (Duration::ZERO, 0);
    while done < iterations {
        // Each hand-off ends one competitor, so all competitors are created again after half of them have ended.
        let (mut driven, effects) = Driven::begun(library);
        let mut command = command_in(&effects).expect("one works");
        // The first hand-offs run with cold caches and would dominate the measurement.
        for number in 0..COLD + (iterations - done).min(count as u64 / 2) {
            let batch = driven.batch(acknowledged(command));
            let start = Instant::now();
            let effects = driven.step(black_box(&batch));
            if number >= COLD {
                total += start.elapsed();
                done += 1;
            }
            command = command_in(&effects).expect("the next one works");
        }
    }
    total
}

/// Measures hand-offs among competitors of each kind; their needs, messages and urgency should hardly change the cost.
fn every_kind(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("hand-off of each kind");
    group.sample_size(10).warm_up_time(WARM_UP).measurement_time(MEASUREMENT);
    for count in [1_000, 100_000] {
        let text = |(kind, declared, served)| (kind, competitors(kind, declared, served, count));
        let ranked = RANKED.map(|(kind, clauses)| (kind, ranked(count, clauses)));
        let programs = KINDS.into_iter().map(text).chain(ranked);
        for (kind, text) in programs {
            let library = library(&text);
            group.bench_function(BenchmarkId::new(kind, count), |bencher| {
                bencher.iter_custom(|iterations| hand_offs(&library, count, iterations));
            });
        }
    }
    group.finish();
}

/// Measures an instant at which all competitors are compared and the next crossing of their priorities is computed.
fn urgent_families(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("crossings");
    group.sample_size(10).warm_up_time(WARM_UP).measurement_time(MEASUREMENT);
    for count in [4, 16, 64] {
        let mut driven = Driven::new(&library(&FAMILIES.replace("COUNT", &count.to_string())));
        group.bench_function(BenchmarkId::new("ranked families with urgency", count), |bencher| {
            bencher.iter(|| {
                let alarm = driven.batch(EventKind::Occurrence(Value::list([Value::symbol("alarm")])));
                black_box(driven.step(&alarm));
            });
        });
    }
    group.finish();
}

criterion_group!(benches, interrupt_and_resume, every_kind, urgent_families);
criterion_main!(benches);
