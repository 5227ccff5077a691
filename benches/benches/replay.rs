//! Running, recording and replaying ten thousand seconds with a fire every twenty seconds.
#![allow(missing_docs, reason = "criterion's macros make public items")]
#![allow(clippy::expect_used, reason = "a measurement that cannot be set up must stop at once")]

use apex_benches::{MEASUREMENT, PATROL, WARM_UP, agent, declaration, library};
use apex_model::event::EventKind;
use apex_model::host::HostFunctions;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::{Input, Observer};
use apex_runtime::record::{RecordOptions, RecordReader, Recorder};
use apex_runtime::{RunSettings, program, replay};
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

fn inputs() -> Vec<Input> {
    let fires = (1..500).map(|number| {
        let form = Value::list([Value::symbol("fire"), Value::Integer(number)]);
        Input::new(Time::from_seconds(20.0 * number as f64), EventKind::Occurrence(form))
    });
    let landed = Value::list([Value::symbol("landed")]);
    fires.chain([Input::new(Time::from_seconds(10_000.0), EventKind::Occurrence(landed))]).collect()
}

fn fly(observers: &mut [&mut dyn Observer]) -> apex_runtime::RunEnd {
    let options = RunSettings { inputs: inputs(), ..RunSettings::default() };
    program::run(&mut agent(&library(PATROL)), observers, options).expect("the program runs")
}

fn record(path: &Path) {
    let library = library(PATROL);
    let mut recorder = Recorder::create(path, &library, RecordOptions::default()).expect("a new record");
    recorder.program(&library).expect("sources are stored");
    let end = fly(&mut [&mut recorder]);
    recorder.finish(end.at, &end.reason.text()).expect("the record is closed");
}

fn run_record_replay(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("bench.apex");
    let mut group = criterion.benchmark_group("ten thousand seconds");
    group.sample_size(10).warm_up_time(WARM_UP).measurement_time(MEASUREMENT);
    group.bench_function("run", |bencher| bencher.iter(|| black_box(fly(&mut []))));
    group.bench_function("run and record", |bencher| bencher.iter(|| record(&path)));
    record(&path);
    let reader = RecordReader::open(&path).expect("the record opens");
    group.bench_function("replay", |bencher| {
        bencher.iter(|| {
            let load = |_: &[_]| Ok((Arc::clone(&library(PATROL)), declaration(), HostFunctions::default()));
            let report = replay::replay(&reader, &load).expect("the record is read");
            assert_eq!(report.difference, None);
        });
    });
    group.finish();
}

criterion_group!(benches, run_record_replay);
criterion_main!(benches);
