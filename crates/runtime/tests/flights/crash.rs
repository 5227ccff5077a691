//! The crash simulator: the writes of a recorded and closed flight are logged. Then the program is killed at many points of the log, and
//! the power is cut at many more, with torn sectors in any order. Every acknowledged step must be found, and everything found must equal
//! what was recorded.
//!
//! `APEX_KILL_POINTS` and `APEX_POWER_CUTS` (`make nightly`) set how many.

mod disk;

use crate::support::{CAMERA, altitude, camera_inputs, load, program};
use apex_executive::Agent;
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::time::Time;
use apex_runtime::mission_loop::{RunSettings, fly};
use apex_runtime::ports::{Deliberator, Observer};
use apex_runtime::program::{NoDeliberator, NoVehicle};
use apex_runtime::record::{Durability, RecordOptions, RecordReader, RecordedStep, Recorder, recover};
use apex_runtime::replay::replay;
use disk::{Disk, Files, Operation, read_log};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

const RECORD: &str = "flight.apex";
const ACKNOWLEDGEMENTS: &str = "acknowledged";

/// Acknowledges committed steps in a file, like a vehicle that obeys them.
struct Acknowledging<'r> {
    recorder: &'r mut Recorder,
    acknowledgements: File,
    steps: u64,
    /// A planted bug in the order: acknowledges before the commit.
    too_soon: bool,
}

impl Acknowledging<'_> {
    fn acknowledge(&mut self) {
        self.acknowledgements.write_all(&self.steps.to_le_bytes()).unwrap();
    }
}

impl Observer for Acknowledging<'_> {
    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        self.recorder.begin(batch)
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        self.recorder.observe(batch, effects)
    }

    fn inspect(&mut self, agent: &Agent, deliberator: &dyn Deliberator, now: Time) -> Result<(), String> {
        self.steps += 1;
        // Groups of one to three steps.
        let is_due = self.steps % 5 < 3;
        if is_due && self.too_soon {
            // Before the end of the step: a recorder that is slow commits a group there.
            self.acknowledge();
        }
        self.recorder.inspect(agent, deliberator, now)?;
        if is_due {
            self.recorder.flush()?;
            if !self.too_soon {
                self.acknowledge();
            }
        }
        // Gives the thread that copies groups into the main file time to run.
        std::thread::sleep(std::time::Duration::from_millis(40));
        Ok(())
    }
}

/// Not a test: the program whose writes are logged.
#[test]
#[ignore = "is run as a child by other tests"]
fn child_that_is_logged() {
    let Some(folder) = std::env::var_os("APEX_CRASH_FOLDER").map(PathBuf::from) else { return };
    let is = |name: &str| std::env::var_os("APEX_CRASH_PLAN").is_some_and(|plan| plan.to_string_lossy().contains(name));
    let durability = if is("power") { Durability::Power } else { Durability::Program };
    let (library, declaration, host) = program(CAMERA);
    let options = RecordOptions { durability, ..RecordOptions::default() };
    let mut recorder = Recorder::create(&folder.join(RECORD), &library, options).unwrap();
    recorder.program(&library).unwrap();
    recorder.flush().unwrap();
    let mut agent = apex_executive::load(library, &declaration, host).unwrap();
    let acknowledgements = File::create(folder.join(ACKNOWLEDGEMENTS)).unwrap();
    let too_soon = is("too-soon");
    let mut observer = Acknowledging { recorder: &mut recorder, acknowledgements, steps: 0, too_soon };
    let mut inputs = camera_inputs();
    inputs.extend((0..50).map(|number| altitude(0.35 * f64::from(number), 6000 + i64::from(number))));
    let options = RunSettings { inputs, ..RunSettings::default() };
    let mut vehicle = NoVehicle::default();
    let end = fly(&mut agent, &mut vehicle, &mut NoDeliberator, &mut [&mut observer], options).unwrap();
    recorder.finish(end.at, &end.reason.text()).unwrap();
}

/// A logged flight.
struct Logged {
    operations: Vec<(String, Operation)>,
    /// All of its steps, as in its closed record.
    steps: Vec<RecordedStep>,
    folder: TempDir,
}

impl Logged {
    /// Flies with the log of `writes.c`; needs a C compiler, as the build of SQLite does.
    fn fly(plan: &str) -> Logged {
        let tools = TempDir::new().unwrap();
        let (source, library, log) =
            (tools.path().join("writes.c"), tools.path().join("writes.so"), tools.path().join("log"));
        std::fs::write(&source, include_str!("crash/writes.c")).unwrap();
        let compiled = Command::new("cc").args(["-shared", "-fPIC", "-O1", "-o"]).args([&library, &source]).status();
        assert!(compiled.unwrap().success(), "cc cannot compile writes.c");
        let folder = TempDir::new().unwrap();
        let place = folder.path().canonicalize().unwrap();
        let flown = Command::new(std::env::current_exe().unwrap())
            .args(["crash::child_that_is_logged", "--exact", "--ignored", "--nocapture"])
            .env("LD_PRELOAD", &library)
            .env("APEX_CRASH_FOLDER", &place)
            .env("APEX_CRASH_LOG", &log)
            .env("APEX_CRASH_PLAN", plan)
            .output()
            .unwrap();
        assert!(flown.status.success(), "{}", String::from_utf8_lossy(&flown.stderr));
        let operations = read_log(&std::fs::read(&log).unwrap());
        let reader = RecordReader::open(&place.join(RECORD)).unwrap();
        assert!(reader.is_complete().unwrap());
        let steps: Vec<RecordedStep> = reader.steps().unwrap().map(Result::unwrap).collect();
        assert!(steps.len() > 40 && operations.len() > 300, "{} steps, {}", steps.len(), operations.len());
        Logged { operations, steps, folder: TempDir::new().unwrap() }
    }

    /// Steps that an operation acknowledges.
    fn acknowledges(name: &str, operation: &Operation) -> Option<usize> {
        let Operation::Write { data, .. } = operation else { return None };
        let number = u64::from_le_bytes(data.as_slice().try_into().ok().filter(|_| name == ACKNOWLEDGEMENTS)?);
        usize::try_from(number).ok()
    }

    /// Returns a fault of the files after a crash; `None` if every required step exists unchanged.
    fn fault(&self, files: &Files, acknowledged: usize, with_replay: bool) -> Option<String> {
        files.put(self.folder.path());
        let path = self.folder.path().join(RECORD);
        let reader = match RecordReader::open(&path) {
            Ok(reader) => reader,
            Err(error) => {
                let saved = self.folder.path().join("saved.apex");
                let opened = recover(&path, &saved).and_then(|_| RecordReader::open(&saved));
                match opened {
                    Ok(reader) => reader,
                    Err(_) if acknowledged == 0 => return None,
                    Err(_) => {
                        return Some(format!("{acknowledged} steps are acknowledged, and nothing is read: {error}"));
                    }
                }
            }
        };
        let steps: Vec<RecordedStep> = match reader.steps().and_then(Iterator::collect) {
            Ok(steps) => steps,
            Err(error) => return Some(error.to_string()),
        };
        if steps.len() < acknowledged {
            return Some(format!("{acknowledged} steps are acknowledged, {} are there", steps.len()));
        }
        if self.steps.get(..steps.len()) != Some(&steps) {
            return Some("what is there is not what was recorded".into());
        }
        if with_replay && !steps.is_empty() {
            let replayed = replay(&reader, &load);
            return replayed.map_or_else(
                |error| Some(error.to_string()),
                |report| report.difference.map(|_| "replay differs".into()),
            );
        }
        None
    }

    /// Kills the program at `count` points: between operations, and in the middle of writes. The first fault.
    fn kill(&self, count: usize, seed: u64) -> Option<String> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut points: Vec<usize> =
            (0..count).map(|_| rng.next_u32() as usize % (self.operations.len() + 1)).collect();
        points.sort_unstable();
        let (mut files, mut done, mut acknowledged) = (Files::default(), 0, 0);
        for (number, point) in points.into_iter().enumerate() {
            for (name, operation) in &self.operations[done..point] {
                files.apply(name, operation);
                acknowledged = Logged::acknowledges(name, operation).unwrap_or(acknowledged);
            }
            done = point;
            let mut found = files.clone();
            if let Some((name, Operation::Write { offset, data })) = self.operations.get(point) {
                // The kernel has taken a part of the next write.
                let part = data[..rng.next_u32() as usize % (data.len() + 1)].to_vec();
                found.apply(name, &Operation::Write { offset: *offset, data: part });
            }
            if let Some(fault) = self.fault(&found, acknowledged, number % 16 == 0) {
                return Some(format!("killed at operation {point}: {fault}"));
            }
        }
        None
    }

    /// Cuts the power at `count` points and returns the first fault. Acknowledged steps must exist only if the record is `safe`.
    fn cut(&self, count: usize, seed: u64, safe: bool) -> Option<String> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut points: Vec<usize> =
            (0..count).map(|_| rng.next_u32() as usize % (self.operations.len() + 1)).collect();
        points.sort_unstable();
        let (mut disk, mut done, mut acknowledged) = (Disk::default(), 0, 0);
        for (number, point) in points.into_iter().enumerate() {
            for (name, operation) in &self.operations[done..point] {
                disk.apply(name, operation);
                acknowledged = Logged::acknowledges(name, operation).unwrap_or(acknowledged);
            }
            done = point;
            let must = if safe { acknowledged } else { 0 };
            if let Some(fault) = self.fault(&disk.cut(&mut rng), must, number % 16 == 0) {
                return Some(format!("the power was cut at operation {point}: {fault}"));
            }
        }
        None
    }
}

/// Returns the number of crashes, from the environment.
fn count(variable: &str, usual: usize) -> usize {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// Demands that no crash lost anything, and adds a row to the quality page if `APEX_QUALITY_FOLDER` is set.
fn survived(what: &str, points: usize, fault: Option<String>) {
    if let Some(folder) = std::env::var_os("APEX_QUALITY_FOLDER") {
        let path = Path::new(&folder).join("crashes.tsv");
        let mut file = std::fs::OpenOptions::new().create(true).append(true).open(path).unwrap();
        file.write_all(format!("{what}\t{points}\t{}\n", usize::from(fault.is_some())).as_bytes()).unwrap();
    }
    assert_eq!(fault, None);
}

#[test]
fn no_kill_loses_what_is_acknowledged() {
    let points = count("APEX_KILL_POINTS", 300);
    survived("process killed", points, Logged::fly("program").kill(points, 1));
}

#[test]
fn no_power_cut_loses_what_a_power_safe_record_acknowledged() {
    let points = count("APEX_POWER_CUTS", 1_000) / 2;
    survived("power cut, power-safe record", points, Logged::fly("power").cut(points, 2, true));
}

#[test]
fn a_power_cut_takes_the_last_groups_only_and_never_the_order() {
    let points = count("APEX_POWER_CUTS", 1_000) / 2;
    survived("power cut, fast record: order kept", points, Logged::fly("program").cut(points, 3, false));
}

#[test]
fn the_simulator_finds_planted_bugs() {
    let early = Logged::fly("program too-soon").kill(2_000, 4);
    assert!(
        early.as_ref().is_some_and(|fault| fault.contains("acknowledged")),
        "acknowledged before the commit: {early:?}"
    );
    // A record that does not wait for the disk.
    let mut hasty = Logged::fly("power");
    hasty.operations.retain(|(_, operation)| !matches!(operation, Operation::Sync));
    let lost = hasty.cut(2_000, 5, true);
    assert!(lost.is_some(), "without syncs");
    // The log is removed before the main file is synchronised, however much of it was copied on the way.
    let mut swapped = Logged::fly("power");
    let unlink = swapped.operations.iter().rposition(|(name, operation)| {
        name.ends_with("-wal") && matches!(operation, Operation::Unlink | Operation::Truncate(0))
    });
    let unlink = unlink.expect("the log is removed when the record is closed");
    let mut at = 0;
    swapped.operations.retain(|(name, operation)| {
        at += 1;
        at > unlink || name != RECORD || !matches!(operation, Operation::Sync)
    });
    assert!(swapped.cut(5_000, 6, true).is_some(), "the log was removed before the main file was safe");
}
