//! A flight and its record survive failed writes: the flight continues and reacts as its mission states.

use crate::support::{altitude, load, program};
use apex_executive::Agent;
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::time::Time;
use apex_runtime::mission_loop::{EndReason, RunEnd, RunSettings, fly};
use apex_runtime::ports::{Deliberator, News, Observer};
use apex_runtime::program::{NoDeliberator, NoVehicle};
use apex_runtime::record::{RECORDING_LOST, RecordOptions, RecordReader, Recorder};
use apex_runtime::replay::replay;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Waits for heights, and answers a lost record.
const PDL: &str = r#"
(procedure (index (do-domain))
  (step watch (print "high") (waitfor (altitude ac-1 > 99000)))
  (step lost (inform (coming-home ?why)) (waitfor (recording-lost ?why)) (repeating))
  (step again (inform (on-the-record ?kept ?dropped)) (waitfor (recording-resumed ?kept ?dropped)) (repeating)))
"#;

/// A disk that is full between two instants.
struct Disk<'r> {
    recorder: &'r mut Recorder,
    full_from: Time,
    full_until: Time,
    news: Vec<String>,
}

const BYTES_AT_FIRST: u64 = 40_000_000;

impl Observer for Disk<'_> {
    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        if batch.now == self.full_from {
            // SQLite never makes the file smaller: it can add no page.
            self.recorder.set_bytes_max(1).unwrap();
        }
        if batch.now == self.full_until {
            self.recorder.set_bytes_max(BYTES_AT_FIRST).unwrap();
            std::thread::sleep(std::time::Duration::from_millis(1_100));
        }
        self.recorder.begin(batch)
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        self.recorder.observe(batch, effects)
    }

    fn inspect(&mut self, agent: &Agent, deliberator: &dyn Deliberator, now: Time) -> Result<(), String> {
        self.recorder.inspect(agent, deliberator, now)?;
        self.recorder.flush()
    }

    fn note(&mut self, at: Time, text: &str) -> Result<(), String> {
        self.news.push(format!("{at} {text}"));
        self.recorder.note(at, text)
    }

    fn take_news(&mut self) -> Option<News> {
        self.recorder.take_news()
    }
}

struct Flown {
    _folder: TempDir,
    path: PathBuf,
    end: RunEnd,
    news: Vec<String>,
    closed: Result<(), String>,
}

/// Returns a flight of 60 s with 10 samples per second.
fn fly_with_a_full_disk(full: (f64, f64), kept_bytes_max: usize, has_thread: bool) -> Flown {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("flight.apex");
    let (library, declaration, host) = program(PDL);
    let options = RecordOptions {
        bytes_max: Some(BYTES_AT_FIRST),
        kept_bytes_max: Some(kept_bytes_max),
        has_thread,
        ..RecordOptions::default()
    };
    let mut recorder = Recorder::create(&path, &library, options).unwrap();
    recorder.program(&library).unwrap();
    let mut agent = apex_executive::load(library, &declaration, host).unwrap();
    let inputs = (1..=610).map(|tenth| altitude(f64::from(tenth) * 0.1, i64::from(tenth))).collect();
    let options = RunSettings { inputs, until: Time::from_seconds(60.0), ..RunSettings::default() };
    let (full_from, full_until) = (Time::from_seconds(full.0), Time::from_seconds(full.1));
    let mut disk = Disk { recorder: &mut recorder, full_from, full_until, news: Vec::new() };
    let mut vehicle = NoVehicle::default();
    let end = fly(&mut agent, &mut vehicle, &mut NoDeliberator, &mut [&mut disk], options).unwrap();
    let news = disk.news;
    let closed = recorder.finish(end.at, &end.reason.text()).map_err(|error| error.to_string());
    Flown { _folder: folder, path, end, news, closed }
}

fn informs(path: &Path) -> Vec<String> {
    let reader = RecordReader::open(path).unwrap();
    let steps = reader.steps().unwrap().map(Result::unwrap);
    let effects = steps.flat_map(|step| step.decoded_effects().unwrap());
    effects
        .filter_map(|effect| if let Effect::Inform { form, .. } = effect { Some(form.to_string()) } else { None })
        .collect()
}

#[test]
fn a_record_whose_disk_was_full_for_a_while_has_no_gap() {
    for has_thread in [false, true] {
        has_no_gap(fly_with_a_full_disk((20.0, 40.0), 64 << 20, has_thread));
    }
}

fn has_no_gap(flown: Flown) {
    assert_eq!((flown.end.reason, flown.closed), (EndReason::Until, Ok(())));
    let [lost, again] = flown.news.as_slice() else { panic!("{:?}", flown.news) };
    assert!(lost.contains(RECORDING_LOST) && lost.contains("disk is full"), "{lost}");
    assert!(again.contains("without a gap"), "{again}");
    // The mission has reacted to both messages, and the record contains that.
    let informed = informs(&flown.path);
    assert_eq!(informed[0], "(coming-home \"the disk is full\")");
    assert!(
        informed.len() == 2 && informed[1].starts_with("(on-the-record ") && informed[1].ends_with(" 0)"),
        "{informed:#?}"
    );
    let reader = RecordReader::open(&flown.path).unwrap();
    assert_eq!(reader.steps().unwrap().count() as u64, flown.end.steps);
    assert_eq!(reader.warning().unwrap(), None);
    let report = replay(&reader, &load).unwrap();
    assert_eq!((report.batches, report.difference, report.gap), (flown.end.steps, None, None));
    let troubles = reader.steps().unwrap().flat_map(|step| step.unwrap().decoded_effects().unwrap());
    let informed = troubles.filter(|effect| format!("{effect:?}").contains("RecordingLost")).count();
    assert_eq!(informed, 1, "it is reported once");
}

#[test]
fn memory_that_is_too_small_leaves_a_gap_that_every_reader_is_shown() {
    for has_thread in [false, true] {
        has_a_told_gap(fly_with_a_full_disk((20.0, 40.0), 4_000, has_thread));
    }
}

fn has_a_told_gap(flown: Flown) {
    assert_eq!(flown.closed, Ok(()));
    assert!(flown.news[1].contains("are not in the record"), "{:?}", flown.news);
    let reader = RecordReader::open(&flown.path).unwrap();
    let [gap] = reader.gaps().unwrap().try_into().unwrap();
    let steps = reader.steps().unwrap().count() as i64;
    assert_eq!(steps, flown.end.steps as i64 - (gap.last_batch - gap.first_batch + 1), "{gap}");
    // Pages that had space left took some steps more.
    assert!(gap.after < Time::from_seconds(35.0) && gap.before.unwrap() <= Time::from_seconds(40.0), "{gap}");
    assert!(reader.warning().unwrap().unwrap().contains("has a gap"));
    let report = replay(&reader, &load).unwrap();
    assert_eq!((report.difference.clone(), report.gap), (None, Some(gap)));
    assert!(report.to_string().contains("confirmed up to its gap"), "{report}");
    // No state is restored across the gap; after the next snapshot restoration works again.
    let program = reader.load(&load).unwrap();
    assert!(reader.restore_with(Time::from_seconds(19.0), &program).is_ok());
    let refused = reader.restore_with(Time::from_seconds(39.0), &program).unwrap_err().to_string();
    assert!(refused.contains("has a gap"), "{refused}");
    assert!(reader.restore_with(Time::from_seconds(59.0), &program).is_ok());
}

#[test]
fn a_record_that_never_resumes_reports_it_at_the_end_and_holds_what_came_before() {
    for has_thread in [false, true] {
        holds_what_came_before(fly_with_a_full_disk((20.0, 1e6), 64 << 20, has_thread));
    }
}

fn holds_what_came_before(flown: Flown) {
    assert_eq!(flown.end.reason, EndReason::Until, "the flight continues to its end");
    let informed = flown.closed.unwrap_err();
    assert!(informed.contains("the recording was lost at ") && informed.contains("the disk is full"), "{informed:#}");
    let reader = RecordReader::open(&flown.path).unwrap();
    assert!(!reader.is_complete().unwrap());
    // The steps that the messages call recorded are those that a reader finds.
    let held = reader.steps().unwrap().map(|step| step.unwrap().batch.now).last().unwrap();
    assert!(informed.contains(&format!("holds the steps up to {held}, and")), "{held}: {informed}");
    let steps = reader.steps().unwrap().count();
    assert!(informed.contains(&format!("and {} later steps", flown.end.steps - steps as u64)), "{steps}: {informed}");
    assert!(steps >= 199 && (steps as u64) < flown.end.steps, "{steps}");
    assert_eq!(replay(&reader, &load).unwrap().difference, None);
}
