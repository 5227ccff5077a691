//! The time from a sample to a command with many waiting tasks, and the time of a task's life.
#![allow(missing_docs, reason = "criterion's macros make public items")]
#![allow(clippy::expect_used, reason = "a measurement that did not happen must stop at once")]

use apex_benches::{Driven, MEASUREMENT, WARM_UP, WATCHERS, command_in, level, library, programs};
use apex_model::effect::{DecisionKind, Effect};
use apex_model::event::EventKind;
use apex_model::value::Value;
use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::{Duration, Instant};

const COUNTS: [i64; 4] = [100, 1_000, 10_000, 100_000];

/// Times the step that brings `kind`, which must end in a command; the vehicle then answers, outside of the measurement.
fn to_command(driven: &mut Driven, kind: EventKind) -> Duration {
    let batch = driven.batch(kind);
    let start = Instant::now();
    let effects = driven.step(black_box(&batch));
    let taken = start.elapsed();
    let command = command_in(&effects).expect("the waiting task did not command");
    let done = driven.batch(EventKind::CommandAcknowledged(command, Ok(Value::nil())));
    driven.step(&done);
    taken
}

/// Measures the time from a sample that satisfies one of `count` waiting tasks, each with a separate variable, to the task's command.
fn event_to_command(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("event to command");
    group.sample_size(20).warm_up_time(WARM_UP).measurement_time(MEASUREMENT);
    for count in COUNTS {
        let armed = Driven::new(&library(&programs::waiting(count as usize)));
        let (mut driven, mut used) = (armed.clone(), 0);
        group.bench_function(BenchmarkId::new("one step", count), |bencher| {
            bencher.iter_custom(|iterations| {
                let mut total = Duration::ZERO;
                for _ in 0..iterations {
                    if used == count {
                        (driven, used) = (armed.clone(), 0);
                    }
                    // A prime stride, so that the next task is not adjacent to the last one in memory.
                    total += to_command(&mut driven, level(used * 7_919 % count, 11));
                    used += 1;
                }
                total
            });
        });
        for (name, clause) in [("then waiting again", "(repeating)"), ("next to the next one", "(responding)")] {
            let text = WATCHERS.replace("(repeating)", clause).replace("COUNT", &count.to_string());
            let (mut driven, mut next) = (Driven::new(&library(&text)), 0);
            group.bench_function(BenchmarkId::new(name, count), |bencher| {
                bencher.iter_custom(|iterations| {
                    (0..iterations).fold(Duration::ZERO, |total, _| {
                        next = (next + 7_919) % count;
                        total + to_command(&mut driven, level(next, 11))
                    })
                });
            });
        }
    }
    group.finish();
}

/// Measures samples without effect: of a variable that no condition watches, and on the wrong side of every bound.
fn event_to_nothing(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("event to nothing");
    group.sample_size(20).warm_up_time(WARM_UP).measurement_time(MEASUREMENT);
    for count in COUNTS {
        for (name, text, variable) in [
            ("no task watches", programs::waiting(count as usize), -1),
            ("one variable, all bounds above", programs::bounds(count as usize), 0),
        ] {
            let mut driven = Driven::new(&library(&text));
            group.bench_function(BenchmarkId::new(name, count), |bencher| {
                bencher.iter_custom(|iterations| {
                    let value = |number| level(variable, (number % 1_000) as i64);
                    let batches: Vec<_> = (0..iterations).map(|number| driven.batch(value(number))).collect();
                    let start = Instant::now();
                    for batch in &batches {
                        assert!(driven.step(batch).is_empty(), "a sample without a monitor had an effect");
                    }
                    start.elapsed()
                });
            });
        }
    }
    group.finish();
}

/// Measures samples of one variable with as many bounds as tasks; each sample is just above the least remaining bound.
fn one_of_many_bounds(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("one of many bounds");
    group.sample_size(20).warm_up_time(WARM_UP).measurement_time(MEASUREMENT);
    for count in COUNTS {
        let armed = Driven::new(&library(&programs::bounds(count as usize)));
        let (mut driven, mut used) = (armed.clone(), 0);
        group.bench_function(BenchmarkId::new("to command", count), |bencher| {
            bencher.iter_custom(|iterations| {
                let mut total = Duration::ZERO;
                for _ in 0..iterations {
                    if used == count {
                        (driven, used) = (armed.clone(), 0);
                    }
                    total += to_command(&mut driven, level(0, 1_001 + used));
                    used += 1;
                }
                total
            });
        });
    }
    group.finish();
}

/// Measures creation, enablement, selection, work and end of every task of a plan, all at one instant.
fn task_life(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("task life");
    group.sample_size(10).warm_up_time(WARM_UP).measurement_time(MEASUREMENT);
    for count in COUNTS {
        let count = count as usize;
        group.throughput(Throughput::Elements(count as u64));
        for (shape, text) in [
            ("flat", programs::flat(count)),
            ("nested", programs::nested(count)),
            ("one sequence", programs::sequence(count)),
            ("one chain of waitfors", programs::chain(count)),
            ("concurrent", programs::concurrent(count)),
            ("ranked", programs::ranked(count)),
        ] {
            let library = library(&text);
            let (_, effects) = Driven::begun(&library);
            let created = |effect: &&Effect| matches!(effect, Effect::Decided(each) if matches!(each.kind, DecisionKind::Created { .. }));
            assert!(effects.iter().filter(created).count() >= count, "not all tasks were made");
            assert!(matches!(effects.last(), Some(Effect::EndApplication { .. })), "the plan did not come to its end");
            group.bench_function(BenchmarkId::new(shape, count), |bencher| {
                // Effects are dropped outside the measurement, because their cost depends on the code that receives them.
                bencher.iter_batched(|| Driven::ready(&library), |driven| driven.begin(), BatchSize::PerIteration);
            });
        }
    }
    group.finish();
}

criterion_group!(benches, event_to_command, event_to_nothing, one_of_many_bounds, task_life);
criterion_main!(benches);
