//! Checking a long program.
#![allow(missing_docs, reason = "criterion's macros make public items")]

use apex_benches::{check, long_program};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

fn check_a_long_file(criterion: &mut Criterion) {
    let text = long_program(2_000);
    let mut group = criterion.benchmark_group("check");
    group.throughput(Throughput::Bytes(text.len() as u64));
    assert!(!check(&text).has_errors(), "the generated program has mistakes");
    group.bench_function(format!("{} lines", text.lines().count()), |bencher| bencher.iter(|| check(black_box(&text))));
    group.finish();
}

criterion_group!(benches, check_a_long_file);
criterion_main!(benches);
