//! From a sample to a command, with many tasks waiting; and the life of a task.
#![allow(missing_docs, reason = "criterion's macros make public items")]

use apex_benches::{Driven, SHORT_LIVES, WATCHERS, command_in, level, library};
use apex_model::event::EventKind;
use apex_model::value::Value;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// A sample that satisfies one of `count` waiting tasks, each with its own variable, until its command is there.
fn event_to_command(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("event to command");
    group.sample_size(20);
    for count in [1_000_i64, 100_000] {
        let library = library(&WATCHERS.replace("COUNT", &count.to_string()));
        let mut driven = Driven::new(&library);
        let mut next = 0;
        group.bench_function(BenchmarkId::new("waiting tasks", count), |bencher| {
            bencher.iter_custom(|iterations| {
                let mut total = Duration::ZERO;
                for _ in 0..iterations {
                    next = (next + 7_919) % count;
                    let batch = driven.batch(level(next, 11));
                    let start = Instant::now();
                    let effects = driven.step(black_box(&batch));
                    total += start.elapsed();
                    let command = command_in(&effects);
                    assert!(command.is_some(), "the waiting task did not command");
                    if let Some(command) = command {
                        let done = driven.batch(EventKind::CommandAcknowledged(command, Ok(Value::nil())));
                        driven.step(&done);
                    }
                }
                total
            });
        });
        group.bench_function(BenchmarkId::new("sample nobody watches", count), |bencher| {
            bencher.iter_custom(|iterations| {
                let batches: Vec<_> = (0..iterations).map(|_| driven.batch(level(-1, 11))).collect();
                let start = Instant::now();
                for batch in &batches {
                    black_box(driven.step(batch));
                }
                start.elapsed()
            });
        });
    }
    group.finish();
}

/// Creation, enablement, selection, work and end of a task, a thousand at one instant.
fn task_life(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("task life");
    let library = library(&SHORT_LIVES.replace("COUNT", "1000"));
    group.throughput(Throughput::Elements(1_000));
    group.bench_function("1000 tasks", |bencher| bencher.iter(|| black_box(Driven::new(&library))));
    group.finish();
}

criterion_group!(benches, event_to_command, task_life);
criterion_main!(benches);
