//! Records whose rows a separate thread writes: they hold what records without that thread hold.

use crate::support::{CAMERA, altitude, camera_inputs, load, program};
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::time::Time;
use apex_runtime::mission_loop::{RunSettings, fly};
use apex_runtime::ports::Observer;
use apex_runtime::program::{NoDeliberator, NoVehicle};
use apex_runtime::record::{RECORDING_LOST, RECORDING_RESUMED, RecordOptions, RecordReader, Recorder, check_integrity};
use apex_runtime::replay::replay;
use rusqlite::types::Value;
use rusqlite::{Connection, OpenFlags};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Reads the record while it is written, and limits its size for a while.
struct Witness<'r> {
    recorder: &'r mut Recorder,
    path: PathBuf,
    steps: usize,
    /// Instants from and until which the file takes no page more.
    full: Option<(f64, f64)>,
    found: Vec<(usize, usize)>,
    news: Vec<String>,
}

impl Observer for Witness<'_> {
    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        let (from, until) = self.full.unwrap_or((f64::INFINITY, f64::INFINITY));
        if batch.now == Time::from_seconds(from) {
            self.recorder.set_bytes_max(1).unwrap();
        } else if batch.now == Time::from_seconds(until) {
            self.recorder.set_bytes_max(1 << 30).unwrap();
            std::thread::sleep(std::time::Duration::from_millis(1_100));
        }
        self.recorder.begin(batch)
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        self.recorder.observe(batch, effects)
    }

    fn inspect(
        &mut self,
        agent: &apex_executive::Agent,
        deliberator: &dyn apex_runtime::ports::Deliberator,
        now: Time,
    ) -> Result<(), String> {
        self.steps += 1;
        self.recorder.inspect(agent, deliberator, now)?;
        if self.steps.is_multiple_of(777) && self.full.is_none() {
            self.recorder.flush()?;
            self.found.push((self.steps, rows(&self.path, "batch").len()));
        }
        Ok(())
    }

    fn note(&mut self, at: Time, text: &str) -> Result<(), String> {
        self.news.push(text.to_string());
        self.recorder.note(at, text)
    }

    fn take_news(&mut self) -> Option<apex_runtime::ports::News> {
        self.recorder.take_news()
    }
}

fn rows(path: &Path, table: &str) -> Vec<Vec<Value>> {
    let connection = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY).unwrap();
    let mut select = connection.prepare(&format!("SELECT * FROM {table}")).unwrap();
    let columns = select.column_count();
    let row = |row: &rusqlite::Row<'_>| (0..columns).map(|column| row.get(column)).collect();
    select.query_map([], row).unwrap().map(Result::unwrap).collect()
}

struct Flown {
    folder: TempDir,
    path: PathBuf,
    found: Vec<(usize, usize)>,
    news: Vec<String>,
    steps: usize,
}

/// Returns a flight of 3,000 samples; its record is closed, or its recorder dropped.
fn flown(has_thread: bool, full: Option<(f64, f64)>, is_closed: bool) -> Flown {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("flight.apex");
    let (library, declaration, host) = program(&CAMERA.replace("> 7000", "> 7000000"));
    let options = RecordOptions { vehicle: Some("ac-1".into()), has_thread, ..RecordOptions::default() };
    let mut recorder = Recorder::create(&path, &library, options).unwrap();
    recorder.program(&library).unwrap();
    let mut agent = apex_executive::load(library, &declaration, host).unwrap();
    let mut inputs = camera_inputs();
    inputs.extend((1..=3_000).map(|tenth| altitude(f64::from(tenth) * 0.1, i64::from(tenth))));
    let options = RunSettings { inputs, until: Time::from_seconds(300.0), ..RunSettings::default() };
    let mut witness =
        Witness { recorder: &mut recorder, path: path.clone(), steps: 0, full, found: Vec::new(), news: Vec::new() };
    let mut vehicle = NoVehicle::default();
    let end = fly(&mut agent, &mut vehicle, &mut NoDeliberator, &mut [&mut witness], options).unwrap();
    let (found, news, steps) = (witness.found, witness.news, witness.steps);
    if is_closed {
        recorder.finish(end.at, &end.reason.text()).unwrap();
    }
    drop(recorder);
    Flown { folder, path, found, news, steps }
}

#[test]
fn a_thread_writes_the_rows_that_are_written_without_it() {
    let [without, with] = [false, true].map(|has_thread| flown(has_thread, None, true));
    assert!(with.steps > 3_000);
    for table in "meta agent source variable batch word shape effects note snapshot situation track".split(' ') {
        assert!(rows(&without.path, table) == rows(&with.path, table), "{table}");
    }
    // After a commit, all steps up to it are found by others.
    assert_eq!(with.found, [777, 1554, 2331].map(|steps| (steps, steps)));
    let reader = RecordReader::open(&with.path).unwrap();
    check_integrity(&with.path).unwrap();
    let replayed = replay(&reader, &load).unwrap();
    assert_eq!((replayed.batches as usize, replayed.difference), (with.steps, None));
    drop(with.folder);
}

#[test]
fn a_record_that_is_not_closed_holds_all_steps() {
    let flown = flown(true, None, false);
    assert_eq!(rows(&flown.path, "batch").len(), flown.steps);
    assert!(!RecordReader::open(&flown.path).unwrap().is_complete().unwrap());
}

#[test]
fn a_full_disk_is_reported_and_the_record_continues_without_a_gap() {
    let flown = flown(true, Some((50.0, 200.0)), true);
    let [lost, again] = flown.news.as_slice() else { panic!("{:?}", flown.news) };
    assert!(lost.starts_with(RECORDING_LOST) && lost.contains("disk is full"), "{lost}");
    assert!(again.starts_with(RECORDING_RESUMED) && again.contains("without a gap"), "{again}");
    let reader = RecordReader::open(&flown.path).unwrap();
    assert_eq!(reader.steps().unwrap().count(), flown.steps);
    assert_eq!(replay(&reader, &load).unwrap().difference, None);
}
