//! Time to diagnose the change of one test outcome in models of 200 components and 300 tests: a usual case and hard cases.
//!
//! Every case alternates the outcome of one test, so each iteration diagnoses two changes; `Throughput` halves the figures.

#![allow(clippy::panic, clippy::indexing_slicing, reason = "a measurement stops at an unexpected result")]

use apex_diagnosis::{Diagnoser, Model, Outcome};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::fmt::Write;
use std::hint::black_box;
use std::sync::Arc;

const COMPONENTS: usize = 200;
const TESTS: usize = 300;

/// Generator of pseudo-random numbers (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % bound as u64) as usize
    }
}

/// Returns a model in which each test needs `width` random components and one more. For every `redundant`th test that one is either of two
/// components (0: for no test).
fn model(width: usize, redundant: usize) -> Arc<Model> {
    let mut numbers = Numbers(7);
    let mut components: Vec<String> = Vec::new();
    for index in 0..COMPONENTS {
        let probability = 1e-5 * (1 + numbers.below(90)) as f64;
        components.push(format!("{{\"name\": \"c{index}\", \"probability_per_hour\": {probability}}}"));
    }
    let mut tests: Vec<String> = Vec::new();
    for index in 0..TESTS {
        let mut needs = String::new();
        for _ in 0..width {
            let _ = write!(needs, "\"c{}\", ", numbers.below(COMPONENTS));
        }
        let spare = if redundant > 0 && index % redundant == 0 {
            format!("{{\"any_of\": [\"c{}\", \"c{}\"]}}", numbers.below(COMPONENTS), numbers.below(COMPONENTS))
        } else {
            format!("\"c{}\"", index % COMPONENTS)
        };
        tests.push(format!("{{\"name\": \"t{index}\", \"needs\": [{needs}{spare}]}}"));
    }
    let (components, tests) = (components.join(","), tests.join(","));
    let text = format!(
        "{{\"format\": \"apex-diagnosis-1\", \"name\": \"bench\", \"components\": [{components}], \"tests\": [{tests}]}}"
    );
    Arc::new(Model::parse("bench.json", &text).unwrap_or_else(|error| panic!("{error}")))
}

/// Returns the outcomes of all tests if the components `present` have failed; every `unknown`th test is not run (0: all run).
fn faulty(model: &Model, present: &[usize], unknown: usize) -> Vec<Outcome> {
    let faults = apex_diagnosis::Bits::of(model.modes.len(), present.iter().copied());
    let outcome = |(index, test): (usize, &apex_diagnosis::Test)| match test.fails_with(&faults) {
        _ if unknown > 0 && index % unknown == 1 => Outcome::Unknown,
        true => Outcome::Failed,
        false => Outcome::Passed,
    };
    model.tests.iter().enumerate().map(outcome).collect()
}

fn alternate(c: &mut Criterion, name: &str, model: &Arc<Model>, outcomes: Vec<Outcome>, between: (usize, Outcome)) {
    let mut diagnoser = Diagnoser::new(Arc::clone(model));
    diagnoser.set_all(outcomes.iter().copied().enumerate());
    let (test, other) = between;
    let first = outcomes[test];
    assert_ne!(first, other, "{name}: the test changes");
    let shown = |diagnoser: &Diagnoser| {
        let diagnosis = diagnoser.diagnosis();
        let contradiction = diagnosis.contradiction.as_ref().map(|one| (one.unexplained.len(), one.is_smallest));
        let failed = diagnoser.outcomes().iter().filter(|outcome| **outcome == Outcome::Failed).count();
        println!(
            "{name}: {failed} failed, {} groups, {} candidates, {:?}, contradiction {contradiction:?}",
            diagnosis.groups.len(),
            diagnosis.groups.iter().map(|group| group.candidates.len()).sum::<usize>(),
            diagnosis.end()
        );
    };
    shown(&diagnoser);
    diagnoser.set(test, other);
    shown(&diagnoser);
    diagnoser.set(test, first);
    let mut group = c.benchmark_group("one-test-change");
    group.throughput(Throughput::Elements(2));
    group.bench_function(name, |b| {
        b.iter(|| {
            black_box(diagnoser.set(test, other));
            black_box(diagnoser.set(test, first))
        })
    });
    group.finish();
}

fn changes(c: &mut Criterion) {
    let narrow = model(4, 10);
    let wide = model(19, 0);
    let spare = model(8, 1);
    let first = |outcomes: &[Outcome], wanted: Outcome| outcomes.iter().position(|one| *one == wanted).unwrap_or(0);
    let two = faulty(&narrow, &[3, 150], 0);
    let test = first(&two, Outcome::Passed);
    alternate(c, "two-faults", &narrow, two, (test, Outcome::Unknown));
    // Many failed tests in one group, and no passed test: the maximum number of minimal sets.
    for failed in [20, 40, 80, 150, 300] {
        let outcomes: Vec<Outcome> =
            (0..TESTS).map(|test| if test < failed { Outcome::Failed } else { Outcome::Unknown }).collect();
        alternate(c, &format!("{failed}-failed-wide"), &wide, outcomes.clone(), (0, Outcome::Unknown));
        alternate(c, &format!("{failed}-failed-narrow"), &narrow, outcomes, (0, Outcome::Unknown));
    }
    // Redundancy: passed tests exclude sets of failures.
    let several: Vec<usize> = (0..12).map(|index| 17 * index).collect();
    let outcomes = faulty(&spare, &several, 2);
    let test = first(&outcomes, Outcome::Failed);
    alternate(c, "twelve-faults-redundant", &spare, outcomes, (test, Outcome::Unknown));
    // One passed test that contradicts many failures, then many such tests.
    let mut outcomes = faulty(&narrow, &several, 0);
    let passed: Vec<usize> = (0..TESTS).filter(|test| outcomes[*test] == Outcome::Passed).collect();
    alternate(c, "one-contradiction", &narrow, outcomes.clone(), (passed[0], Outcome::Failed));
    for test in passed.iter().skip(1).step_by(8) {
        outcomes[*test] = Outcome::Failed;
    }
    alternate(c, "many-contradictions", &narrow, outcomes, (passed[0], Outcome::Failed));
    let mut outcomes = faulty(&spare, &several, 0);
    for test in (0..TESTS).step_by(6) {
        outcomes[test] = Outcome::Failed;
    }
    let test = first(&outcomes, Outcome::Passed);
    alternate(c, "many-contradictions-redundant", &spare, outcomes, (test, Outcome::Failed));
}

criterion_group!(benches, changes);
criterion_main!(benches);
