//! Durability: records survive the end of the program at any moment, a plain copy of the file is complete, and commands are sent only
//! after they are recorded.

use crate::support::{CAMERA, altitude, camera, camera_inputs, event, load, program};
use apex_executive::Agent;
use apex_model::effect::{CommandId, SolveRequest};
use apex_model::event::{Batch, EventKind};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_runtime::foreign::{self, Cues, SimulatorLink};
use apex_runtime::mission_loop::{RunSettings, fly};
use apex_runtime::ports::{Deliberator, Input, Observer, Posed, SolverAnswer, Vehicle};
use apex_runtime::program::NoDeliberator;
use apex_runtime::record::{Durability, FileSeal, RecordOptions, RecordReader, Recorder, check_integrity, recover};
use apex_runtime::replay::replay;
use rusqlite::Connection;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};
use tempfile::TempDir;

fn place() -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("flight.apex");
    (folder, path)
}

fn recorder(path: &Path, pdl: &str) -> (Recorder, Agent) {
    let (library, declaration, host) = program(pdl);
    let mut recorder = Recorder::create(path, &library, RecordOptions::default()).unwrap();
    recorder.program(&library).unwrap();
    (recorder, apex_executive::load(library, &declaration, host).unwrap())
}

fn steps(path: &Path) -> usize {
    RecordReader::open(path).unwrap().steps().unwrap().count()
}

fn batch(number: u64) -> Batch {
    let Input { at, kind, .. } = altitude(number as f64, 6000);
    Batch { now: at, events: vec![apex_model::event::Event { sequence: number + 1, at, kind }] }
}

/// Steps of the child's records.
const STEPS: u64 = 400;

/// Not a test: the program that [`a_flight_that_is_killed_while_it_closes_can_be_read`] kills.
#[test]
#[ignore = "is run as a child by another test"]
fn child_that_closes_a_record() {
    let Some(path) = std::env::var_os("APEX_TEST_RECORD") else { return };
    let (mut recorder, agent) = recorder(Path::new(&path), CAMERA);
    for number in 0..STEPS {
        recorder.begin(&batch(number)).unwrap();
        recorder.observe(&batch(number), &[]).unwrap();
        recorder.inspect(&agent, &NoDeliberator, batch(number).now).unwrap();
    }
    recorder.flush().unwrap();
    println!("closing");
    std::io::stdout().flush().unwrap();
    recorder.finish(Time::from_seconds(400.0), "stopped").unwrap();
    println!("closed");
    std::thread::sleep(std::time::Duration::from_secs(60));
}

#[test]
fn a_flight_that_is_killed_while_it_closes_can_be_read() {
    let mut closed = 0;
    for kill in 0..40_u64 {
        let (_folder, path) = place();
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["durability::child_that_closes_a_record", "--exact", "--ignored", "--nocapture"])
            .env("APEX_TEST_RECORD", &path)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = BufReader::new(child.stdout.take().unwrap()).lines();
        assert!(said.any(|line| line.unwrap().ends_with("closing")));
        std::thread::sleep(std::time::Duration::from_micros(kill * 1_500));
        child.kill().unwrap();
        child.wait().unwrap();
        let reader = RecordReader::open(&path).unwrap_or_else(|error| panic!("killed after {kill} * 1.5 ms: {error}"));
        assert_eq!(reader.steps().unwrap().count() as u64, STEPS, "killed after {kill} * 1.5 ms");
        closed += u32::from(reader.is_complete().unwrap());
    }
    println!("{closed} of 40 were closed");
}

#[test]
fn a_plain_copy_of_a_running_flight_lacks_the_last_seconds_only() {
    let (folder, path) = place();
    let (mut recorder, agent) = recorder(&path, CAMERA);
    for number in 0..10 {
        recorder.begin(&batch(number)).unwrap();
        recorder.observe(&batch(number), &[]).unwrap();
        recorder.inspect(&agent, &NoDeliberator, batch(number).now).unwrap();
    }
    recorder.flush().unwrap();
    // The bound that the reference states.
    std::thread::sleep(std::time::Duration::from_millis(2500));
    let copy = folder.path().join("copy.apex");
    std::fs::copy(&path, &copy).unwrap();
    assert_eq!(steps(&copy), 10);
    assert!(RecordReader::open(&copy).unwrap().warning().unwrap().unwrap().contains("incomplete"));
}

#[test]
fn a_hot_rollback_journal_is_read_and_left_alone() {
    let flight = camera();
    let expected = steps(&flight.path);
    let connection = Connection::open(&flight.path).unwrap();
    // State after a program was killed in the middle of a change: new pages in the file, the old ones in the journal.
    connection.execute_batch("PRAGMA cache_size = 1; PRAGMA cache_spill = 1; BEGIN; DELETE FROM effects;").unwrap();
    connection.execute_batch("INSERT INTO note (text) SELECT randomblob(3000) FROM batch").unwrap();
    let (folder, copy) = place();
    let journal = |path: &Path| PathBuf::from(format!("{}-journal", path.display()));
    std::fs::copy(&flight.path, &copy).unwrap();
    std::fs::copy(journal(&flight.path), journal(&copy)).unwrap();
    assert!(std::fs::metadata(journal(&copy)).unwrap().len() > 0, "this test needs a hot journal");
    let before = (std::fs::read(&copy).unwrap(), std::fs::read(journal(&copy)).unwrap());
    assert_eq!(steps(&copy), expected);
    assert_eq!((std::fs::read(&copy).unwrap(), std::fs::read(journal(&copy)).unwrap()), before);
    drop(folder);
}

/// A vehicle that counts the recorded steps when it receives a command, as another program would find them.
struct Witness {
    path: PathBuf,
    found: Vec<(usize, bool)>,
}

impl Vehicle for Witness {
    fn next_report(&self) -> Option<Time> {
        None
    }

    fn advance(&mut self, _: Time, _: &mut Vec<Input>) -> Result<(), String> {
        Ok(())
    }

    fn command(&mut self, command: CommandId, _: &Value, _: Time) {
        let reader = RecordReader::open(&self.path).unwrap();
        let holds = |step: &apex_runtime::record::RecordedStep| {
            step.decoded_effects().unwrap().iter().any(|effect| {
                matches!(effect, apex_model::effect::Effect::Command { command: sent, .. } if *sent == command)
            })
        };
        let steps: Vec<_> = reader.steps().unwrap().map(Result::unwrap).collect();
        self.found.push((steps.len(), steps.iter().any(holds)));
    }

    fn withdraw(&mut self, _: CommandId, _: Time) {}
}

const COMMANDS: &str = "
(procedure (index (do-domain)) (step a (act 1)) (step b (act 2) (waitfor (go))) (step e (end-application) (waitfor (over))))
(primitive (index (act ?n)) (on-start (command (act ?n))) (duration 1s))";

#[test]
fn a_command_leaves_after_its_step_is_committed() {
    let (_folder, path) = place();
    let (mut recorder, mut agent) = recorder(&path, COMMANDS);
    let mut vehicle = Witness { path, found: Vec::new() };
    let options = RunSettings { inputs: vec![event(2.0, "(go)"), event(9.0, "(over)")], ..RunSettings::default() };
    fly(&mut agent, &mut vehicle, &mut NoDeliberator, &mut [&mut recorder], options).unwrap();
    assert_eq!(vehicle.found.len(), 2);
    assert!(
        vehicle.found.iter().all(|(_, holds)| *holds),
        "steps and whether the command is among them: {:?}",
        vehicle.found
    );
}

/// The simulator's side of the link: reads the record at each received line.
struct Told {
    path: PathBuf,
    lines: Vec<(String, usize)>,
}

impl Write for Told {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let found = steps(&self.path);
        self.lines.push((String::from_utf8_lossy(bytes).into_owned(), found));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn an_outside_simulator_receives_what_is_committed() {
    let (_folder, path) = place();
    let (mut recorder, agent) = recorder(&path, COMMANDS);
    let mut input: &[u8] = b"{\"advance\": 1}\n{\"advance\": 2, \"inputs\": [{\"t\": 2, \"event\": \"(go)\"}]}\n";
    let mut output = Told { path, lines: Vec::new() };
    let read_value = |text: &str| apex_pdl::read_value(text).map_err(|error| error.message);
    let mut link = SimulatorLink {
        input: &mut input,
        output: &mut output,
        read_value: &read_value,
        cues: Cues::default(),
        may_reset: false,
    };
    foreign::run(&mut [agent], &mut link, &mut NoDeliberator, &mut [&mut recorder], RunSettings::default()).unwrap();
    let commands: Vec<&(String, usize)> = output.lines.iter().filter(|(line, _)| line.contains("(act ")).collect();
    assert!(!commands.is_empty());
    assert!(commands.iter().all(|(_, steps)| *steps > 0), "{:?}", output.lines);
}

/// A planner that reads the record while the flight waits for it.
struct Slow(PathBuf, Arc<Mutex<Vec<usize>>>);

impl Deliberator for Slow {
    fn pose(&mut self, _: &SolveRequest, _: Time) -> Posed {
        let (path, found) = (self.0.clone(), Arc::clone(&self.1));
        Posed::new("{}".into(), move |_| {
            found.lock().unwrap().push(RecordReader::open(&path).unwrap().problems().unwrap().len());
            SolverAnswer { result: Err("no plan".into()), charged: Duration::from_seconds(1.0) }
        })
    }
}

#[test]
fn nothing_waits_uncommitted_for_a_solver() {
    let (_folder, path) = place();
    let pdl = "(solver auto (index (tour ?sites)))
      (procedure (index (do-domain)) (step t (tour (a b))) (step e (end-application) (waitfor (terminated ?t))))";
    let (mut recorder, mut agent) = recorder(&path, pdl);
    let found = Arc::new(Mutex::new(Vec::new()));
    let mut slow = Slow(path, Arc::clone(&found));
    let mut vehicle = apex_runtime::program::NoVehicle::default();
    let options = RunSettings { until: Time::from_seconds(10.0), ..RunSettings::default() };
    fly(&mut agent, &mut vehicle, &mut slow, &mut [&mut recorder], options).unwrap();
    assert_eq!(*found.lock().unwrap(), [1], "the problem is in the record while its solver works");
}

#[test]
fn what_stands_before_a_damage_is_recovered_and_replays() {
    let (folder, path) = place();
    let (mut recorder, mut agent) = recorder(&path, CAMERA);
    let mut vehicle = Witness { path: path.clone(), found: Vec::new() };
    let mut flushing = Flushing(&mut recorder);
    let options = RunSettings { inputs: camera_inputs(), ..RunSettings::default() };
    let end = fly(&mut agent, &mut vehicle, &mut NoDeliberator, &mut [&mut flushing], options).unwrap();
    recorder.finish(end.at, "stopped").unwrap();
    let all = steps(&path);
    let connection = Connection::open(&path).unwrap();
    connection.execute("UPDATE batch SET t_ns = t_ns + 1 WHERE id = 4", []).unwrap();
    drop(connection);
    let refused = RecordReader::open(&path).err().unwrap().to_string();
    assert!(refused.contains("Steps 1 to 3") && refused.contains("apex recover"), "{refused}");
    let found = check_integrity(&path).unwrap();
    assert_eq!((found.file, found.steps, found.is_intact()), (FileSeal::Broken, 3, false));
    let saved = folder.path().join("saved.apex");
    let recovered = recover(&path, &saved).unwrap();
    assert!(all > 3 && recovered.steps == 3 && recovered.damage.is_some(), "{recovered:?}");
    let reader = RecordReader::open(&saved).unwrap();
    assert_eq!(reader.steps().unwrap().count(), 3);
    assert!(reader.warning().unwrap().unwrap().contains("incomplete"));
    let report = replay(&reader, &load).unwrap();
    assert_eq!(report.difference, None, "{report}");
    assert_eq!(check_integrity(&saved).unwrap().file, FileSeal::Intact);
    assert!(recover(&saved, &saved).is_err());
}

/// Commits every step, as a paced flight does.
struct Flushing<'r>(&'r mut Recorder);

impl Observer for Flushing<'_> {
    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        self.0.begin(batch)
    }

    fn observe(&mut self, batch: &Batch, effects: &[apex_model::effect::Effect]) -> Result<(), String> {
        self.0.observe(batch, effects)
    }

    fn inspect(&mut self, agent: &Agent, deliberator: &dyn Deliberator, now: Time) -> Result<(), String> {
        self.0.inspect(agent, deliberator, now)?;
        self.0.flush()
    }
}

/// Run with `cargo test -p apex-runtime --test flights commit -- --ignored --nocapture`.
#[test]
#[ignore = "measures time"]
fn how_long_a_commit_takes() {
    for durability in [Durability::Program, Durability::Power] {
        let folder = TempDir::new_in(std::env::current_dir().unwrap()).unwrap();
        let path = folder.path().join("flight.apex");
        let (library, declaration, host) = program(CAMERA);
        let options = RecordOptions { durability, ..RecordOptions::default() };
        let mut recorder = Recorder::create(&path, &library, options).unwrap();
        let agent = apex_executive::load(library, &declaration, host).unwrap();
        let mut times = Vec::new();
        for number in 0..2000 {
            let EventKind::Measurement(..) = batch(number).events[0].kind else { continue };
            let began = std::time::Instant::now();
            recorder.begin(&batch(number)).unwrap();
            recorder.observe(&batch(number), &[]).unwrap();
            recorder.inspect(&agent, &NoDeliberator, batch(number).now).unwrap();
            recorder.flush().unwrap();
            times.push(began.elapsed());
        }
        times.sort_unstable();
        let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
        println!("{durability:?}: median {:?}, 99 % {:?}, worst {:?}", at(0.5), at(0.99), at(1.0));
    }
}
