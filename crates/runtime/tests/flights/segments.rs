//! A record whose disk accepts no more writes continues in a new segment, and its segments can be joined into one record.

use crate::support::{altitude, load, program};
use apex_executive::Agent;
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::time::Time;
use apex_runtime::RecordError;
use apex_runtime::mission_loop::{RunEnd, RunSettings, fly};
use apex_runtime::ports::{Deliberator, News, Observer};
use apex_runtime::program::{NoDeliberator, NoVehicle};
use apex_runtime::record::{RecordOptions, RecordReader, Recorder, check_integrity, recover};
use apex_runtime::replay::replay;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;
use tempfile::TempDir;

/// Waits for heights, and hears when the record continues.
const PDL: &str = r#"
(procedure (index (do-domain))
  (step watch (print "high") (waitfor (altitude ac-1 > 99000)))
  (step again (inform (on-the-record ?kept ?dropped)) (waitfor (recording-resumed ?kept ?dropped)) (repeating)))
"#;

/// A disk that is full from an instant on; at some instants a second of wall time passes.
struct Disk<'r> {
    recorder: &'r mut Recorder,
    full_from: Time,
    waits_at: Vec<Time>,
    news: Vec<String>,
}

impl Observer for Disk<'_> {
    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        if batch.now == self.full_from {
            self.recorder.set_bytes_max(1).unwrap();
        }
        if self.waits_at.contains(&batch.now) {
            std::thread::sleep(Duration::from_millis(1_100));
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
    folder: TempDir,
    spare: TempDir,
    /// The file with which the flight began, and the one with which it ended.
    first: PathBuf,
    last: PathBuf,
    end: RunEnd,
    news: Vec<String>,
}

/// Flies for 60 s with 10 samples per second; the disk is full from 20 s on.
fn fly_on_a_full_disk(kept_bytes_max: Option<usize>) -> Flown {
    let (folder, spare) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let first = folder.path().join("flight.apex");
    let options = RecordOptions {
        bytes_max: Some(40_000_000),
        spare_folder: Some(spare.path().to_path_buf()),
        kept_bytes_max,
        ..RecordOptions::default()
    };
    let (end, news, last) = fly_recorded(&first, options, &[30.0, 40.0]);
    Flown { folder, spare, first, last, end, news }
}

fn fly_recorded(path: &Path, options: RecordOptions, waits: &[f64]) -> (RunEnd, Vec<String>, PathBuf) {
    let (library, declaration, host) = program(PDL);
    let mut recorder = Recorder::create(path, &library, options).unwrap();
    recorder.program(&library).unwrap();
    let mut agent = apex_executive::load(library, &declaration, host).unwrap();
    let inputs = (1..=610).map(|tenth| altitude(f64::from(tenth) * 0.1, i64::from(tenth))).collect();
    let options = RunSettings { inputs, until: Time::from_seconds(60.0), ..RunSettings::default() };
    let waits_at = waits.iter().copied().map(Time::from_seconds).collect();
    let mut disk = Disk { recorder: &mut recorder, full_from: Time::from_seconds(20.0), waits_at, news: Vec::new() };
    let mut vehicle = NoVehicle::default();
    let end = fly(&mut agent, &mut vehicle, &mut NoDeliberator, &mut [&mut disk], options).unwrap();
    let news = disk.news;
    recorder.finish(end.at, &end.reason.text()).unwrap();
    let last = recorder.path().to_path_buf();
    (end, news, last)
}

/// Compares the record that ends with `last` with a flight whose disk was never full.
fn is_whole(last: &Path, end: &RunEnd) {
    let reader = RecordReader::open(last).unwrap();
    assert_eq!(reader.warning().unwrap(), None);
    assert_eq!((reader.steps().unwrap().count() as u64, reader.gaps().unwrap()), (end.steps, vec![]));
    let report = replay(&reader, &load).unwrap();
    assert_eq!((report.batches, report.difference, report.gap), (end.steps, None, None));
    let program = reader.load(&load).unwrap();
    for seconds in [5.0, 19.0, 25.0, 39.0, 59.0] {
        assert!(reader.restore_with(Time::from_seconds(seconds), &program).is_ok(), "{seconds} s");
    }
}

#[test]
fn a_record_continues_in_the_spare_folder_and_is_one_record() {
    let flown = fly_on_a_full_disk(None);
    let [lost, again] = flown.news.as_slice() else { panic!("{:?}", flown.news) };
    assert!(lost.contains("the disk is full"), "{lost}");
    assert!(again.contains("in the new segment") && again.contains("flight-segment-2.apex"), "{again}");
    assert_eq!(flown.last, flown.spare.path().join("flight-segment-2.apex"));
    is_whole(&flown.last, &flown.end);
    let integrity = check_integrity(&flown.last).unwrap();
    assert!(integrity.is_intact() && integrity.earlier == [flown.first.clone()], "{integrity:?}");
    assert_eq!(integrity.steps, flown.end.steps.cast_signed());
    // The first file contains the earlier steps, and states that the flight continues.
    let first = RecordReader::open(&flown.first).unwrap();
    assert!(first.warning().unwrap().unwrap().contains("incomplete"));
    // One joined file can be read without the others.
    let whole = flown.folder.path().join("whole.apex");
    assert_eq!(recover(&flown.last, &whole).unwrap().steps, flown.end.steps.cast_signed());
    std::fs::remove_file(&flown.first).unwrap();
    std::fs::remove_file(&flown.last).unwrap();
    is_whole(&whole, &flown.end);
    assert!(check_integrity(&whole).unwrap().is_intact());
}

#[test]
fn a_segment_whose_beginning_is_lost_is_read_alone() {
    let flown = fly_on_a_full_disk(None);
    std::fs::remove_file(&flown.first).unwrap();
    let reader = RecordReader::open(&flown.last).unwrap();
    let warning = reader.warning().unwrap().unwrap();
    assert!(warning.contains("continues") && warning.contains("flight.apex, which is not there"), "{warning}");
    let [gap] = reader.gaps().unwrap().try_into().unwrap();
    assert_eq!(gap.first_batch, 1);
    assert_eq!(reader.steps().unwrap().count() as i64, flown.end.steps as i64 - gap.last_batch);
    let program = reader.load(&load).unwrap();
    assert!(reader.restore_with(Time::from_seconds(10.0), &program).is_err());
    assert!(reader.restore_with(Time::from_seconds(59.0), &program).is_ok());
    let integrity = check_integrity(&flown.last).unwrap();
    assert!(integrity.fault.unwrap().contains("which is not there"));
}

#[test]
fn segments_that_are_moved_together_are_found_and_others_are_refused() {
    let flown = fly_on_a_full_disk(None);
    let moved = TempDir::new().unwrap();
    let place = |path: &Path| moved.path().join(path.file_name().unwrap());
    for path in [&flown.first, &flown.last] {
        std::fs::copy(path, place(path)).unwrap();
        std::fs::remove_file(path).unwrap();
    }
    // The part of the first file that the disk did not accept is in its log.
    let log = PathBuf::from(format!("{}-wal", flown.first.display()));
    if log.exists() {
        std::fs::rename(&log, moved.path().join("flight.apex-wal")).unwrap();
    }
    is_whole(&place(&flown.last), &flown.end);
    // Another flight in place of the first file.
    let other = fly_on_a_full_disk(Some(4_000));
    std::fs::copy(&other.last, place(&flown.first)).unwrap();
    std::fs::remove_file(moved.path().join("flight.apex-wal")).unwrap_or_default();
    let refused = RecordReader::open(&place(&flown.last)).err().unwrap();
    assert!(matches!(refused, RecordError::Damaged { .. }), "{refused}");
    assert!(!check_integrity(&place(&flown.last)).unwrap().is_intact());
}

#[test]
fn memory_that_is_too_small_leaves_one_gap_in_the_joined_record() {
    let flown = fly_on_a_full_disk(Some(4_000));
    let reader = RecordReader::open(&flown.last).unwrap();
    let [gap] = reader.gaps().unwrap().try_into().unwrap();
    assert!(gap.first_batch > 100 && gap.before.is_some(), "{gap}");
    let report = replay(&reader, &load).unwrap();
    assert_eq!((report.difference, report.gap), (None, Some(gap)));
}

/// Bytes of the largest file that the child may write.
const FILE_BYTES_MAX: u64 = 200_000;

/// Not a test: a flight under `ulimit -f`, whose record is in several segments.
#[test]
#[ignore = "is run as a child by another test"]
fn child_with_small_files() {
    let Some(path) = std::env::var_os("APEX_TEST_RECORD").map(PathBuf::from) else { return };
    let limit = rustix::process::Rlimit { current: Some(FILE_BYTES_MAX), maximum: None };
    rustix::process::setrlimit(rustix::process::Resource::Fsize, limit).unwrap();
    let (library, declaration, host) = program(PDL);
    let mut recorder = Recorder::create(&path, &library, RecordOptions::default()).unwrap();
    recorder.program(&library).unwrap();
    let mut agent = apex_executive::load(library, &declaration, host).unwrap();
    // Without waits no attempt to store comes before the end: far more is kept than a file may hold.
    let (tenths, waits) = if std::env::var_os("APEX_TEST_WITHOUT_WAITS").is_some() { (20_000, 0) } else { (6_000, 12) };
    let inputs = (1..=tenths).map(|tenth| altitude(f64::from(tenth) * 0.1, i64::from(tenth))).collect();
    let until = Time::from_seconds(f64::from(tenths) * 0.1);
    let options = RunSettings { inputs, until, ..RunSettings::default() };
    let waits_at = (1..waits).map(|number| Time::from_seconds(50.0 * f64::from(number))).collect();
    let mut disk = Disk { recorder: &mut recorder, full_from: Time::END, waits_at, news: Vec::new() };
    let mut vehicle = NoVehicle::default();
    let end = fly(&mut agent, &mut vehicle, &mut NoDeliberator, &mut [&mut disk], options).unwrap();
    assert!(waits == 0 || disk.news.iter().any(|news| news.contains("in the new segment")), "{:?}", disk.news);
    recorder.finish(end.at, &end.reason.text()).unwrap();
    println!("steps={} last={}", end.steps, recorder.path().display());
}

/// Flies under a limit on the size of files, and checks that the segments are the whole record; returns how many there are.
fn fly_with_small_files(with_waits: bool) -> usize {
    let folder = TempDir::new().unwrap();
    let mut child = Command::new(std::env::current_exe().unwrap());
    child.args(["segments::child_with_small_files", "--exact", "--ignored", "--nocapture"]);
    child.env("APEX_TEST_RECORD", folder.path().join("flight.apex"));
    if !with_waits {
        child.env("APEX_TEST_WITHOUT_WAITS", "1");
    }
    let flown = child.output().unwrap();
    let said = format!("{}{}", String::from_utf8_lossy(&flown.stdout), String::from_utf8_lossy(&flown.stderr));
    assert!(flown.status.success(), "{said}");
    let (_, words) = said.split_once("steps=").unwrap();
    let (steps, last) = words.lines().next().unwrap().split_once(" last=").unwrap();
    let reader = RecordReader::open(Path::new(last)).unwrap();
    assert_eq!((reader.warning().unwrap(), reader.steps().unwrap().count().to_string()), (None, steps.to_string()));
    assert_eq!(replay(&reader, &load).unwrap().difference, None);
    let integrity = check_integrity(Path::new(last)).unwrap();
    assert!(integrity.is_intact() && !integrity.earlier.is_empty(), "{integrity:?}");
    integrity.earlier.len() + 1
}

#[test]
fn a_limit_on_the_size_of_files_does_not_end_a_flight() {
    fly_with_small_files(true);
}

#[test]
fn what_is_kept_and_larger_than_a_file_is_stored_in_several_segments() {
    let files = fly_with_small_files(false);
    assert!(files > 2, "{files} files");
}

/// Not a test: a reader of a record whose folder for temporary files takes nothing.
#[test]
#[ignore = "is run as a child by another test"]
fn child_that_reads_segments() {
    let Some(path) = std::env::var_os("APEX_TEST_RECORD").map(PathBuf::from) else { return };
    let reader = RecordReader::open(&path).unwrap();
    println!("steps={}.", reader.steps().unwrap().count());
}

#[test]
fn segments_are_joined_next_to_the_last_one_where_temporary_files_have_no_place() {
    let flown = fly_on_a_full_disk(None);
    let read = Command::new(std::env::current_exe().unwrap())
        .args(["segments::child_that_reads_segments", "--exact", "--ignored", "--nocapture"])
        .env("APEX_TEST_RECORD", &flown.last)
        .env("TMPDIR", flown.folder.path().join("nowhere"))
        .output()
        .unwrap();
    let said = format!("{}{}", String::from_utf8_lossy(&read.stdout), String::from_utf8_lossy(&read.stderr));
    assert!(said.contains(&format!("steps={}.", flown.end.steps)), "{said}");
    // The copy is gone with its reader.
    let left =
        std::fs::read_dir(flown.spare.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect::<Vec<_>>();
    assert_eq!(left, ["flight-segment-2.apex"]);
}

#[test]
fn a_reader_of_a_growing_segment_sees_its_new_groups() {
    let (folder, spare) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let first = folder.path().join("flight.apex");
    let options = || RecordOptions {
        bytes_max: Some(40_000_000),
        spare_folder: Some(spare.path().to_path_buf()),
        ..RecordOptions::default()
    };
    // A segment of an older flight of the same name does not belong to this one.
    let (_, _, older) = fly_recorded(&first, options(), &[30.0, 40.0]);
    assert_eq!(RecordReader::open(&first).unwrap().successor().unwrap(), Some(older.clone()));
    let (library, declaration, host) = program(PDL);
    let mut recorder = Recorder::create(&first, &library, options()).unwrap();
    recorder.program(&library).unwrap();
    let mut agent = apex_executive::load(library, &declaration, host).unwrap();
    // Another height than in the older flight: equal flights have equal chains.
    let inputs = (1..=610).map(|tenth| altitude(f64::from(tenth) * 0.1, i64::from(tenth) + 1)).collect();
    let options = RunSettings { inputs, until: Time::from_seconds(60.0), ..RunSettings::default() };
    let waits_at = [30.0, 40.0].map(Time::from_seconds).to_vec();
    let disk = Disk { recorder: &mut recorder, full_from: Time::from_seconds(20.0), waits_at, news: Vec::new() };
    let mut watch = Watch { disk, first: first.clone(), readers: Vec::new(), steps: 0, seen: Vec::new() };
    let mut vehicle = NoVehicle::default();
    let end = fly(&mut agent, &mut vehicle, &mut NoDeliberator, &mut [&mut watch], options).unwrap();
    // The first file until it continues; from then on the segment, with every step that is stored.
    let Watch { mut readers, seen, .. } = watch;
    assert!(seen.iter().all(|(stored, found)| stored == found), "{seen:?}");
    assert!(seen.len() > 15 && seen.windows(2).all(|pair| pair[0].1 < pair[1].1), "{seen:?}");
    recorder.finish(end.at, &end.reason.text()).unwrap();
    let reader = readers.pop().unwrap();
    assert_eq!(reader.steps().unwrap().count() as u64, end.steps);
    assert!(reader.is_complete().unwrap() && reader.successor().unwrap().is_none());
    assert_ne!(recorder.path(), older);
    assert_eq!(RecordReader::open(&first).unwrap().successor().unwrap(), Some(recorder.path().to_path_buf()));
}

/// Counts the steps that a reader sees once a second, and those that are stored.
struct Watch<'r> {
    disk: Disk<'r>,
    first: PathBuf,
    /// The reader of the file that is written.
    readers: Vec<RecordReader>,
    steps: u64,
    seen: Vec<(u64, u64)>,
}

impl Observer for Watch<'_> {
    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        self.steps += 1;
        self.disk.begin(batch)
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        self.disk.observe(batch, effects)
    }

    fn inspect(&mut self, agent: &Agent, deliberator: &dyn Deliberator, now: Time) -> Result<(), String> {
        self.disk.inspect(agent, deliberator, now)?;
        let is_lost = now >= self.disk.full_from && self.disk.recorder.path() == self.first;
        if is_lost || now.0 % 1_000_000_000 != 0 {
            return Ok(());
        }
        let successor = self.readers.last().and_then(|reader| reader.successor().unwrap());
        if self.readers.is_empty() || successor.is_some() {
            self.readers.push(RecordReader::open(successor.as_ref().unwrap_or(&self.first)).unwrap());
        }
        let reader = self.readers.last().unwrap();
        // Another connection to the same copy.
        let other = reader.of_agent(0).unwrap();
        let found = [reader, &other].map(|reader| reader.steps().unwrap().count() as u64);
        assert_eq!(found[0], found[1]);
        self.seen.push((self.steps, found[0]));
        Ok(())
    }

    fn note(&mut self, at: Time, text: &str) -> Result<(), String> {
        self.disk.note(at, text)
    }

    fn take_news(&mut self) -> Option<News> {
        self.disk.take_news()
    }
}
