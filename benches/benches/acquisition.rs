//! Synthesis of manoeuvres from data-acquisition goals: one target (at most 50 ms), and forty (at most 1 s of processor time).
#![allow(missing_docs, reason = "criterion's macros make public items")]
#![allow(clippy::panic, reason = "a measurement stops where it is surprised")]

use apex_mission::Mission;
use apex_mission::acquisition::synthesised;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::path::Path;

const TARGETS: usize = 40;

/// Goals for pixels of 10 cm: of the mission's area, and of places around it.
fn goals() -> Vec<Value> {
    let place = |index: usize| {
        let (north, east) = ((index / 8) as f64, (index % 8) as f64);
        Value::list([37.41 + 0.001 * north, -121.12 + 0.001 * east, 9.0].map(Value::Real))
    };
    let target = |index: usize| if index.is_multiple_of(2) { Value::symbol("plume") } else { place(index) };
    let goal = |index: usize| {
        let resolution = Value::measured(0.1, Dimension::LENGTH);
        Value::list([Value::symbol("acquire"), target(index), Value::symbol(":resolution"), resolution])
    };
    (0..TARGETS).map(goal).collect()
}

fn synthesis(criterion: &mut Criterion) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../missions/stand-off");
    let mission = Mission::load(&folder).unwrap_or_else(|error| panic!("{error:?}"));
    let goals = goals();
    let solve = |goal: &Value| synthesised(&mission, goal, 0.0).unwrap_or_else(|why| panic!("{why}")).len();
    let mut group = criterion.benchmark_group("acquisition");
    group.sample_size(10);
    for count in [1, TARGETS] {
        group.bench_with_input(BenchmarkId::new("targets", count), &count, |bencher, count| {
            bencher.iter(|| goals.iter().take(*count).map(|goal| solve(black_box(goal))).sum::<usize>());
        });
    }
    group.finish();
}

criterion_group!(benches, synthesis);
criterion_main!(benches);
