//! Loading an agent from text up to its first step: reading, checking, indexing.
#![allow(missing_docs, reason = "criterion's macros make public items")]

use apex_benches::{MEASUREMENT, WARM_UP, agent, check, library, programs};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

/// Times loading, which must grow with the steps and no faster, however they are arranged.
fn load(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("load");
    group.sample_size(10).warm_up_time(WARM_UP).measurement_time(MEASUREMENT);
    for steps in [100_usize, 1_000, 10_000, 100_000] {
        group.throughput(Throughput::Elements(steps as u64));
        for (shape, text) in [
            ("one sequence", programs::sequence(steps)),
            ("one chain of waitfors", programs::chain(steps)),
            ("many procedures", programs::procedures(steps)),
        ] {
            assert!(!check(&text).has_errors(), "the generated program has mistakes");
            group.bench_function(BenchmarkId::new(shape, steps), |bencher| {
                bencher.iter(|| agent(&library(black_box(&text))));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, load);
criterion_main!(benches);
