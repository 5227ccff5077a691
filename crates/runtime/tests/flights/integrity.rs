//! Damaged and forged records: every answer equals that of the genuine record, comes with a warning, or is refused.

use crate::support::{CAMERA, altitude, event, load, program};
use apex_executive::Agent;
use apex_model::effect::Effect;
use apex_model::event::{Batch, EventKind, StateVariable};
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::explain::{Explainer, Question};
use apex_runtime::mission_loop::RunSettings;
use apex_runtime::ports::{Deliberator, Input, Observer, Posed};
use apex_runtime::program::run_with;
use apex_runtime::record::view::{EventsQuery, RecordView, TasksQuery, TimelineQuery, TrackQuery};
use apex_runtime::record::{RecordOptions, RecordReader, Recorder, TargetRow, check_integrity, recover};
use apex_runtime::replay::{replay, replay_with};
use apex_runtime::target_state::{TargetChange, TargetState};
use apex_runtime::trace::{TraceFilter, TraceFormat, trace_record};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rusqlite::Connection;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Damages in `make test`; `APEX_DAMAGES=1000` tries as many as the release notes state.
const DAMAGES: usize = 200;

/// A mission with one observed target.
struct OneTarget(Vec<TargetChange>);

impl OneTarget {
    fn new() -> OneTarget {
        let change = |seconds, state| TargetChange {
            target: "zaca".into(),
            at: Time::from_seconds(seconds),
            state,
            detail: "seen from the north".into(),
        };
        OneTarget(vec![change(0.0, TargetState::Planned), change(4.0, TargetState::Observed)])
    }
}

impl Deliberator for OneTarget {
    fn pose(&mut self, _: &apex_model::effect::SolveRequest, _: Time) -> Posed {
        Posed::failed("no planners here".into())
    }

    fn target_changes(&self) -> &[TargetChange] {
        &self.0
    }

    fn snapshot(&self) -> Option<Vec<u8>> {
        Some(vec![1, 2, 3])
    }
}

/// A flight with rows in every table.
fn honest(path: &Path) {
    let (library, declaration, host) = program(CAMERA);
    let options = RecordOptions { vehicle: Some("ac-1".into()), ..RecordOptions::default() };
    let mut recorder = Recorder::create(path, &library, options).unwrap();
    recorder.program(&library).unwrap();
    recorder.meta("mission", "fires").unwrap();
    let zaca = TargetRow { id: "zaca".into(), name: "Zaca".into(), latitude_deg: 34.7, ..TargetRow::default() };
    recorder.target(&zaca).unwrap();
    let located = |seconds: f64| {
        let place = [34.5, -117.0 + seconds / 1000.0, 2000.0].map(Value::Real);
        let variable = StateVariable::new(Symbol::new("location"), Value::symbol("ac-1"));
        Input::new(Time::from_seconds(seconds), EventKind::Measurement(variable, Value::list(place)))
    };
    let mut inputs: Vec<Input> =
        (0..900_u32).map(|tick| altitude(f64::from(tick) * 0.02, 6000 + i64::from(tick % 900))).collect();
    inputs.extend((0..20_u32).map(|tick| located(f64::from(tick))));
    inputs.extend([event(3.5, "(fire-seen)"), altitude(20.0, 7200)]);
    inputs.sort_by_key(|input| input.at);
    let mut agent = apex_executive::load(library, &declaration, host).unwrap();
    let mut observers: Vec<&mut dyn Observer> = vec![&mut recorder];
    let options = RunSettings { inputs, ..RunSettings::default() };
    let end = run_with(&mut agent, &mut OneTarget::new(), &mut observers, options).unwrap();
    recorder.note(end.at, "the computer was slow").unwrap();
    recorder.report("score", "{\"score\": 0.87}").unwrap();
    recorder.finish(end.at, &end.reason.text()).unwrap();
}

/// Returns every answer that a record gives, and true if a warning or an error accompanies them.
fn answers(path: &Path) -> (bool, Vec<String>) {
    match try_answers(path) {
        Ok((warned, answers)) => (warned, answers),
        Err(_) => (true, Vec::new()),
    }
}

fn try_answers(path: &Path) -> Result<(bool, Vec<String>), String> {
    let told = |error: apex_runtime::RecordError| error.to_string();
    let reader = RecordReader::open(path).map_err(told)?;
    let mut warned = reader.warning().map_err(told)?.is_some();
    let mut answers = Vec::new();
    let trace = trace_record(&reader, Vec::new(), TraceFormat::JsonLines, TraceFilter::default()).map_err(told)?;
    answers.push(String::from_utf8_lossy(&trace).into_owned());
    // The steps as read by `apex export`.
    for step in reader.steps().map_err(told)?.without_effects() {
        answers.push(format!("{:?}", step.map_err(told)?.batch));
    }
    let replayed = replay(&reader, &load).map_err(told)?;
    warned |= replayed.difference.is_some();
    answers.push(replayed.to_string());
    for (name, seconds) in [("high", 2.0), ("patrol", 5.0), ("T0", 19.0)] {
        let question = Question::new(name, Time::from_seconds(seconds));
        let explainer = Explainer::new(&reader, &load);
        answers.push(explainer.why(&question).map_err(told)?.to_string());
        answers.push(explainer.why_not(&question).map_err(told)?.to_string());
    }
    let situations =
        (reader.situations().map_err(told)?, reader.problems().map_err(told)?, reader.notes().map_err(told)?);
    answers.push(format!("{situations:?} {:?}", reader.sources().map_err(told)?));
    let mut view = RecordView::open(path, 0).map_err(told)?;
    answers.push(format!("{:?}", view.tasks(&TasksQuery::default()).map_err(told)?));
    answers.push(format!("{:?}", view.timeline(&TimelineQuery::default()).map_err(told)?));
    answers.push(format!("{:?}", view.track(&TrackQuery::default()).map_err(told)?));
    answers.push(format!("{:?}", view.targets(None).map_err(told)?));
    answers.push(format!("{:?}", view.events(&EventsQuery::default()).map_err(told)?));
    answers.push(format!("{:?} {:?}", view.report(None).map_err(told)?, view.mission(None).map_err(told)?));
    Ok((warned, answers))
}

fn place() -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("flight.apex");
    (folder, path)
}

/// Damages the bytes at random, in one of the ways in which files are damaged.
fn damage(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    let mut below = |limit: usize| (random.next_u64() % limit.max(1) as u64) as usize;
    let length = bytes.len();
    let pages = length / 4096;
    match below(6) {
        0 => bytes[below(length)] ^= 1 << below(8),
        1 => (0..8).for_each(|_| bytes[below(length)] = below(256) as u8),
        2 => {
            let start = below(length);
            bytes[start..].iter_mut().take(1 + below(700)).for_each(|byte| *byte = 0);
        }
        3 => bytes.truncate(1 + below(length)),
        4 => {
            // A page in the place of another: trees that run in circles, rows twice.
            let (from, to) = (below(pages) * 4096, below(pages) * 4096);
            let page = bytes[from..from + 4096].to_vec();
            bytes[to..to + 4096].copy_from_slice(&page);
        }
        _ => {
            // A pointer inside of a page, or a short run anywhere, points elsewhere.
            let start = (below(pages) * 4096 + below(200)).min(length - 4);
            bytes[start..start + 4].copy_from_slice(&(below(pages) as u32).to_be_bytes());
        }
    }
}

#[test]
fn no_damage_changes_an_answer_unsaid() {
    let (_folder, path) = place();
    honest(&path);
    let (warned, expected) = answers(&path);
    assert!(!warned && expected.len() > 500, "{}", expected.len());
    let whole = std::fs::read(&path).unwrap();
    let count = std::env::var("APEX_DAMAGES").ok().and_then(|text| text.parse().ok()).unwrap_or(DAMAGES);
    let mut random = ChaCha8Rng::seed_from_u64(23);
    let mut silent = Vec::new();
    for number in 0..count {
        let mut bytes = whole.clone();
        // Every second file has no seal, as after a crash: its groups must prove themselves.
        if number % 2 == 1 && bytes.windows(24).rev().take(80).any(|end| end.starts_with(b"apex record file seal")) {
            bytes.truncate(whole.len() - 64);
        }
        damage(&mut bytes, &mut random);
        std::fs::write(&path, &bytes).unwrap();
        let (warned, found) = answers(&path);
        if !warned && found != expected {
            silent.push(number);
        }
    }
    assert!(silent.is_empty(), "{} of {count} damages change answers without a word: {silent:?}", silent.len());
}

/// An interrupted download: the steps before the missing end are saved, more of them the longer the file is.
#[test]
fn a_record_without_its_end_is_recovered_up_to_there() {
    let (folder, path) = place();
    honest(&path);
    let steps = check_integrity(&path).unwrap().steps;
    let whole = std::fs::read(&path).unwrap();
    let mut saved = Vec::new();
    for percent in [50, 70, 80, 90, 95] {
        std::fs::write(&path, &whole[..whole.len() * percent / 100]).unwrap();
        let error = RecordReader::open(&path).err().expect("a record without its end is not opened").to_string();
        assert!(error.contains("can be trusted"), "{percent} %: {error}");
        let to = folder.path().join(format!("{percent}.apex"));
        match recover(&path, &to) {
            Ok(recovered) => {
                assert!(
                    recovered.damage.is_some() && (1..steps).contains(&recovered.steps),
                    "{percent} %: {recovered:?}"
                );
                let reader = RecordReader::open(&to).unwrap();
                assert!(replay(&reader, &load).unwrap().difference.is_none(), "{percent} %");
                saved.push(recovered.steps);
            }
            Err(error) => {
                assert!(error.to_string().contains("No step before it can be trusted"), "{percent} %: {error}")
            }
        }
    }
    assert!(saved.is_sorted() && saved.last() >= Some(&(steps / 2)), "{saved:?} of {steps}");
}

const FORGERIES: [&str; 24] = [
    "UPDATE effects SET body = x'00' WHERE batch = 1",
    "UPDATE effects SET body = (SELECT body FROM effects WHERE batch = 1)",
    "UPDATE effects SET first = first + 1",
    "DELETE FROM effects WHERE batch = (SELECT max(batch) FROM effects)",
    "INSERT INTO effects SELECT max(batch) + 1, max(first) + 1, body FROM effects",
    "UPDATE word SET text = 'land'",
    "UPDATE word SET text = (SELECT text FROM word WHERE id = 1) WHERE id = 2",
    "UPDATE shape SET example = x'' WHERE id = 1",
    "DELETE FROM shape WHERE id = (SELECT max(id) FROM shape)",
    "UPDATE track SET latitude_deg = latitude_deg + 1",
    "DELETE FROM track WHERE t_ns > 8000000000",
    "UPDATE target_state SET state = 'skipped', detail = 'no fuel'",
    "UPDATE target SET latitude_deg = 10, name = 'Lick'",
    "UPDATE report SET body = '{\"score\": 0.99}'",
    "UPDATE meta SET value = '99.9.9' WHERE key = 'apex_version'",
    "UPDATE meta SET value = 'another' WHERE key = 'mission'",
    "UPDATE note SET text = 'all was well'",
    "UPDATE snapshot SET body = x'00'",
    "UPDATE situation SET body = x'0102'",
    "UPDATE variable SET name = '(speed ac-1)'",
    "UPDATE source SET body = replace(CAST(body AS TEXT), 'priority 7', 'priority 1')",
    "DELETE FROM batch WHERE id > 400; DELETE FROM effects WHERE batch > 400",
    "ALTER TABLE report RENAME TO old; CREATE VIEW report AS SELECT position, section, '{\"score\": 1}' AS body FROM old",
    "CREATE TRIGGER t AFTER INSERT ON note BEGIN DELETE FROM effects; END; DELETE FROM note",
];

#[test]
fn no_forgery_changes_an_answer_unsaid() {
    let (_folder, path) = place();
    honest(&path);
    let (_, expected) = answers(&path);
    let whole = std::fs::read(&path).unwrap();
    let mut silent = Vec::new();
    for forgery in FORGERIES {
        std::fs::write(&path, &whole).unwrap();
        Connection::open(&path).unwrap().execute_batch(forgery).unwrap();
        assert_ne!(std::fs::read(&path).unwrap(), whole, "nothing is changed by {forgery}");
        let (warned, found) = answers(&path);
        if !warned && found != expected {
            silent.push(forgery);
        }
    }
    assert!(silent.is_empty(), "{} forgeries change answers without a word: {silent:#?}", silent.len());
}

/// A mission whose target is observed at 4 s.
#[derive(Default)]
struct LateTarget(Vec<TargetChange>);

impl Deliberator for LateTarget {
    fn pose(&mut self, _: &apex_model::effect::SolveRequest, _: Time) -> Posed {
        Posed::failed("no planners here".into())
    }

    fn observe(&mut self, _: usize, batch: &Batch, _: &[Effect]) {
        if self.0.is_empty() && batch.now >= Time::from_seconds(4.0) {
            self.0.push(OneTarget::new().0.remove(1));
        }
    }

    fn target_changes(&self) -> &[TargetChange] {
        &self.0
    }
}

/// Ends the program after a step is committed and before its last rows are written, as a crash does while a planner works.
struct Crash<'r>(&'r mut Recorder);

impl Observer for Crash<'_> {
    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        self.0.begin(batch)
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        self.0.observe(batch, effects)?;
        if batch.now < Time::from_seconds(4.0) {
            return Ok(());
        }
        self.0.flush()?;
        Err("the program crashes here".into())
    }

    fn inspect(&mut self, agent: &Agent, deliberator: &dyn Deliberator, now: Time) -> Result<(), String> {
        self.0.inspect(agent, deliberator, now)
    }
}

#[test]
fn a_record_that_ends_within_a_step_is_confirmed_and_one_without_an_earlier_row_is_not() {
    let (_folder, path) = place();
    let (library, declaration, host) = program(CAMERA);
    let mut recorder = Recorder::create(&path, &library, RecordOptions::default()).unwrap();
    recorder.program(&library).unwrap();
    let mut agent = apex_executive::load(library, &declaration, host).unwrap();
    let inputs: Vec<Input> = (0..50_u32).map(|tick| altitude(f64::from(tick) * 0.1, 6000)).collect();
    let mut crash = Crash(&mut recorder);
    let options = RunSettings { inputs, ..RunSettings::default() };
    assert!(run_with(&mut agent, &mut LateTarget::default(), &mut [&mut crash], options).is_err());
    drop(recorder);
    let replayed = |deliberator: &mut dyn Deliberator| {
        let reader = RecordReader::open(&path).unwrap();
        assert!(!reader.is_complete().unwrap());
        replay_with(&reader, &load, deliberator).unwrap().difference
    };
    assert_eq!(replayed(&mut LateTarget::default()), None);
    // Rows of earlier steps must be there.
    let difference = replayed(&mut OneTarget::new()).unwrap();
    assert!(format!("{}", difference.what).contains("state of a target 1"), "{difference:?}");
}
