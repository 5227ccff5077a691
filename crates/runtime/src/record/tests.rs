//! Tests of records on disk: written rows are read back, and damage is reported.

use super::*;
use crate::error::RecordError;
use crate::ports::Observer;
use crate::program::NoDeliberator;
use crate::samples;
use crate::target_state::{TargetChange, TargetState};
use apex_model::event::{Batch, EventKind};
use apex_model::task::TaskState;
use apex_model::time::Time;
use apex_model::value::Value;
use rusqlite::Connection;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

pub(super) fn place_for_record() -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("flight.apex");
    (folder, path)
}

fn recorder(path: &Path) -> Recorder {
    let options = RecordOptions { vehicle: Some("aircraft-1".into()), ..RecordOptions::default() };
    Recorder::create(path, &samples::library(), options).unwrap()
}

pub(super) fn record_samples(path: &Path) -> Recorder {
    let mut recorder = recorder(path);
    recorder.program(&samples::library()).unwrap();
    recorder.source("fires.geojson", "data", b"{}").unwrap();
    for (batch, effects) in samples::steps() {
        recorder.begin(&batch).unwrap();
        recorder.observe(&batch, &effects).unwrap();
        recorder.inspect(&apex_executive::state::agent::Agent::default(), &NoDeliberator, batch.now).unwrap();
    }
    recorder
}

/// A closed record of the samples.
pub(super) fn closed_record() -> (TempDir, PathBuf) {
    let (folder, path) = place_for_record();
    record_samples(&path).finish(Time::from_seconds(300.3), "the root task ended").unwrap();
    (folder, path)
}

#[test]
fn what_goes_in_comes_out_byte_for_byte() {
    let (_folder, path) = place_for_record();
    record_samples(&path).finish(Time::from_seconds(300.3), "the root task ended").unwrap();
    assert!(!path.with_extension("apex-wal").exists(), "a finished record is one file");
    let reader = RecordReader::open(&path).unwrap();
    let read: Vec<RecordedStep> = reader.steps().unwrap().collect::<Result<_, _>>().unwrap();
    let written = samples::steps();
    assert_eq!(read.len(), written.len());
    for (step, (batch, effects)) in read.iter().zip(&written) {
        assert_eq!(postcard::to_stdvec(&step.batch).unwrap(), postcard::to_stdvec(batch).unwrap());
        let bodies: Vec<Vec<u8>> = effects.iter().map(|effect| postcard::to_stdvec(effect).unwrap()).collect();
        assert!(step.effects.iter().map(|effect| &effect.body).eq(&bodies));
        assert_eq!(step.decoded_effects().unwrap(), *effects);
    }
}

#[test]
fn readers_find_facts_sources_tasks_and_samples() {
    let (_folder, path) = place_for_record();
    let mut recorder = record_samples(&path);
    recorder.note(Time::from_seconds(300.3), "an answer was dropped").unwrap();
    recorder.finish(Time::from_seconds(300.3), "the root task ended").unwrap();
    let reader = RecordReader::open(&path).unwrap();
    assert_eq!(reader.warning().unwrap(), None);
    assert_eq!(reader.meta("end_ns").unwrap().as_deref(), Some("300300000000"));
    assert_eq!(reader.meta("nothing").unwrap(), None);
    assert_eq!(reader.span().unwrap(), Some((Time::ZERO, Time::from_seconds(300.3))));
    assert_eq!(reader.pdl_sources().unwrap(), samples::library().sources);
    assert_eq!(reader.sources().unwrap()[1].role, "data");
    assert_eq!(reader.notes().unwrap(), [(Time::from_seconds(300.3), "an answer was dropped".to_owned())]);
    let tasks = reader.tasks().unwrap();
    assert_eq!((tasks[0].goal.as_str(), tasks[0].outcome.as_deref()), ("(fly mission)", Some("success")));
    assert_eq!(tasks[1].goal, "(power-up camera-1)");
    assert_eq!((tasks[1].ended, tasks[1].outcome.as_deref()), (None, None), "it repeats");
    let method = tasks[1].method.as_ref().unwrap();
    assert_eq!((method.kind, method.place.as_deref()), ("primitive", Some("camera.pdl:9:1")));
    let altitudes = reader.samples(&samples::variable("altitude", "aircraft-1"), Time::ZERO, Time::END).unwrap();
    assert_eq!(altitudes.len(), 3, "spelling does not matter for readers");
    let rolls =
        reader.samples(&samples::variable("roll-angle", "aircraft-1"), Time::ZERO, Time::from_seconds(1.0)).unwrap();
    assert_eq!(rolls.len(), 1, "a late sample counts at its own time");
}

#[test]
fn effect_rows_say_what_the_reference_promises() {
    let (_folder, path) = place_for_record();
    drop(record_samples(&path));
    let reader = RecordReader::open(&path).unwrap();
    let effects = reader.effects().unwrap();
    let rows: Vec<String> = (0..effects.table.len())
        .map(|place| {
            let row = effects.told(place).unwrap().row;
            let task = row.task.map(|task| task.0.to_string()).unwrap_or_default();
            let [from, to] = [row.from, row.to].map(|state| state.map(TaskState::word).unwrap_or_default());
            let (outcome, place) = (row.outcome.unwrap_or_default(), row.place.unwrap_or_default());
            [row.kind, &task, from, to, outcome, &row.subject, &row.text, &place].join("|")
        })
        .collect();
    let expected = [
        "created|1||||(fly mission)|it is the agent's initial task|camera.pdl:2:3",
        "transition|1|pending|enabled||(fly mission)|there is nothing to wait for|camera.pdl:4:3",
        "created|3||||(power-up ?camera)|T1 started and has this step|camera.pdl:2:3",
        "transition|3|pending|enabled||(power-up ?camera)|its preconditions hold|camera.pdl:4:3",
        "solve|1||||(patrol)|request 1 to auto, budget P5S|",
        "satisfied|3||||waitfor|its preconditions hold: (roll-angle aircraft-1) = 7.25deg at 1.5s in [0.5s, 1.5s]|camera.pdl:5:3",
        "bound|3||||?camera = camera-1|select gave it|camera.pdl:6:3",
        "selected|3||||(power-up camera-1)|primitive camera.pdl:9:1 because it is the most specific of 2 matches|",
        "transition|3|enabled|ongoing||(power-up camera-1)|it was granted camera-1|camera.pdl:4:3",
        "procedure-added|1||||3 targets, value 12|two-opt answered request 1|",
        "refused|1||||flight-path|T3 outranks it on flight-path (priority 7 > 3 + interrupt cost 0.1)|camera.pdl:7:3",
        "command|3||||(switch camera-1)|command 1|camera.pdl:8:3",
        "inform|3||||(powering camera-1)||",
        "publish|3||||(pictures camera-1) = 4|a form of its on-start caused this|camera.pdl:9:3",
        "print|3|||||two\nlines|",
        "withdraw|||||command 2|its task ended|",
        "cancel-solve|||||request 2|no task waits for it any longer|",
        "ask|1||||Ready?|question 1; options: yes, no; no is taken at 0:06:40|",
        "trouble|||||division by zero|an expression failed: division by zero|", // english: allow
        "transition|3|ongoing|terminated|success|(power-up camera-1)|command 1 failed: icing|camera.pdl:4:3",
        "transition|3|terminated|pending||(power-up camera-1)|its step repeats|camera.pdl:4:3",
        "transition|1|enabled|terminated|success|(fly mission)|all of its steps have ended, T3 as the last|camera.pdl:4:3",
        "end-application||||||the root task ended|",
    ];
    assert_eq!(rows, expected);
}

#[test]
fn a_record_that_was_not_finished_states_it() {
    let (_folder, path) = place_for_record();
    drop(record_samples(&path));
    let reader = RecordReader::open(&path).unwrap();
    let warning = reader.warning().unwrap().unwrap();
    assert!(warning.contains("incomplete") && warning.contains("0:05:00.3"), "{warning}");
    assert_eq!(reader.steps().unwrap().count(), 3);
}

#[test]
fn a_running_flight_can_be_read_but_not_overwritten() {
    let (_folder, path) = place_for_record();
    let mut recorder = record_samples(&path);
    recorder.flush().unwrap();
    assert_eq!(RecordReader::open(&path).unwrap().steps().unwrap().count(), 3);
    recorder.meta("mission", "fires").unwrap();
    let refusal = Recorder::create(&path, &samples::library(), RecordOptions::default()).err().unwrap();
    assert!(matches!(refusal, RecordError::Busy { .. }), "{refusal}");
    recorder.finish(Time::ZERO, "stopped").unwrap();
    drop(recorder);
    let again = Recorder::create(&path, &samples::library(), RecordOptions::default());
    assert!(again.is_ok(), "an older record is replaced");
    assert_eq!(RecordReader::open(&path).unwrap().steps().unwrap().count(), 0);
}

fn refusal_of(path: &Path) -> (String, String) {
    let write = Recorder::create(path, &samples::library(), RecordOptions::default()).err().unwrap().to_string();
    (write, RecordReader::open(path).err().unwrap().to_string())
}

#[test]
fn other_files_are_left_alone() {
    let (folder, path) = place_for_record();
    std::fs::write(&path, "my diary").unwrap();
    let (write, read) = refusal_of(&path);
    assert!(write.contains("is not a flight record") && read.contains("are not those of a record"), "{write} {read}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "my diary");
    let other = folder.path().join("other.db");
    Connection::open(&other).unwrap().execute_batch("CREATE TABLE t (x)").unwrap();
    assert!(refusal_of(&other).0.contains("database of another program"));
    assert!(refusal_of(folder.path()).0.contains("it is a folder"));
}

#[test]
fn missing_empty_newer_and_unwritable_records_are_distinguished() {
    let (folder, path) = place_for_record();
    let missing = RecordReader::open(&path).err().unwrap().to_string();
    assert!(missing.contains("there is no flight record at"), "{missing}");
    std::fs::write(&path, "").unwrap();
    let empty = RecordReader::open(&path).err().unwrap().to_string();
    assert!(empty.contains("it is empty"), "{empty}");
    drop(record_samples(&path));
    Connection::open(&path).unwrap().execute_batch("PRAGMA user_version = 9").unwrap();
    let newer = RecordReader::open(&path).err().unwrap().to_string();
    assert!(newer.contains("version 9") && newer.contains("newer Apex"), "{newer}");
    let nowhere = folder.path().join("no/such/folder/flight.apex");
    let unwritable = Recorder::create(&nowhere, &samples::library(), RecordOptions::default()).err().unwrap();
    assert!(matches!(unwritable, RecordError::Unwritable { .. }), "{unwritable}");
    assert!(unwritable.to_string().contains("another place"), "{unwritable}");
}

#[test]
fn damage_is_reported_after_what_stands_before_it() {
    let (_folder, path) = place_for_record();
    record_samples(&path).finish(Time::ZERO, "stopped").unwrap();
    let connection = Connection::open(&path).unwrap();
    connection.execute("UPDATE batch SET events = substr(events, 1, 9) WHERE id = 2", []).unwrap();
    let refused = RecordReader::open(&path).err().unwrap().to_string();
    assert!(refused.contains("group 3") && refused.contains("apex recover"), "{refused}");
    // Sealed again, its hash is valid, but it is not a batch.
    connection.execute("DELETE FROM seal", []).unwrap();
    seal_rows(&connection).unwrap();
    let reader = RecordReader::open(&path).unwrap();
    let steps: Vec<Result<RecordedStep, RecordError>> = reader.steps().unwrap().collect();
    assert_eq!(steps.len(), 2);
    assert!(steps[0].is_ok());
    let message = steps[1].as_ref().err().unwrap().to_string();
    assert!(message.contains("batch 2 at 1.5s cannot be read: it is cut off"), "{message}");
}

#[test]
fn a_file_with_a_hole_is_an_error_and_no_panic() {
    let (_folder, path) = place_for_record();
    record_samples(&path).finish(Time::ZERO, "stopped").unwrap();
    let whole = std::fs::read(&path).unwrap();
    for start in (100..whole.len()).step_by(2048) {
        let mut bytes = whole.clone();
        bytes[start..].iter_mut().take(700).for_each(|byte| *byte = 0xA5);
        std::fs::write(&path, &bytes).unwrap();
        if let Ok(reader) = RecordReader::open(&path) {
            let _ = (reader.warning(), reader.tasks(), reader.sources(), reader.notes());
            if let Ok(steps) = reader.steps() {
                steps.take(10).filter_map(Result::ok).for_each(|step| drop(step.decoded_effects()));
            }
        }
    }
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let reader = RecordReader::open(&path);
    let outcome = reader.and_then(|reader| reader.steps()?.collect::<Result<Vec<_>, _>>());
    assert!(matches!(outcome, Err(RecordError::Damaged { .. })), "{outcome:?}");
}

#[test]
fn a_full_disk_ends_the_record_with_whole_steps_and_is_reported_at_the_end() {
    let (_folder, path) = place_for_record();
    let options = RecordOptions { bytes_max: Some(200_000), ..RecordOptions::default() };
    let mut recorder = Recorder::create(&path, &samples::library(), options).unwrap();
    let mut messages = Vec::new();
    for number in 0..2_000_u64 {
        let batch =
            samples::batch(number as f64, number + 1, vec![EventKind::Occurrence(Value::text(&"x".repeat(500)))]);
        recorder.begin(&batch).unwrap();
        recorder.observe(&batch, &[]).unwrap();
        recorder.inspect(&apex_executive::state::agent::Agent::default(), &NoDeliberator, batch.now).unwrap();
        messages.extend(recorder.take_news());
    }
    assert_eq!(messages.len(), 1, "{messages:#?}");
    assert_eq!(messages[0].message.to_string(), "(recording-lost \"the disk is full\")");
    let message = recorder.finish(Time::ZERO, "disk full").unwrap_err().to_string();
    assert!(message.contains("the disk is full") && message.contains("record to another disk"), "{message}");
    drop(recorder);
    let reader = RecordReader::open(&path).unwrap();
    assert!(!reader.is_complete().unwrap());
    assert!(reader.steps().unwrap().all(|step| step.is_ok()));
}

#[test]
fn rows_of_the_mission_are_stored_during_a_flight() {
    let (_folder, path) = place_for_record();
    let mut recorder = record_samples(&path);
    let zaca = TargetRow { id: "zaca".into(), name: "Zaca".into(), latitude_deg: 34.716, ..TargetRow::default() };
    recorder.target(&zaca).unwrap();
    let (target, at, detail) = ("zaca".to_string(), Time::from_seconds(9.0), "no fuel".to_string());
    recorder.target_changes(&[TargetChange { target, at, state: TargetState::Skipped, detail }]).unwrap();
    recorder.report("score", "{\"total\":1}").unwrap();
    recorder.finish(Time::ZERO, "stopped").unwrap();
    let connection = Connection::open(&path).unwrap();
    let count = |sql: &str| connection.query_row(sql, [], |row| row.get::<_, i64>(0)).unwrap();
    assert_eq!(count("SELECT count(*) FROM target WHERE latitude_deg = 34.716"), 1);
    assert_eq!(count("SELECT count(*) FROM target_state WHERE state = 'skipped' AND t_ns = 9000000000"), 1);
    assert_eq!(count("SELECT count(*) FROM report WHERE section = 'score'"), 1);
    assert_eq!(count("SELECT count(*) FROM track WHERE altitude_m = 7000"), 1);
}

/// Run with `cargo test --release -p apex-runtime -- --ignored`: 50,000 packets of 35 samples in less than 0.7 s.
#[test]
#[ignore = "measures time; meaningful in release builds on a quiet machine only"]
fn a_day_of_packets_is_recorded_quickly() {
    let (_folder, path) = place_for_record();
    let variables: Vec<_> =
        (0..35).map(|number| samples::variable(&format!("attribute-{number}"), "aircraft-1")).collect();
    let mut packet = Batch { now: Time::ZERO, events: Vec::new() };
    let mut recorder = recorder(&path);
    let mut sequence = 0;
    let mut spent = std::time::Duration::ZERO;
    for number in 0..50_000_u32 {
        packet.now = Time::from_seconds(f64::from(number) * 1.728);
        packet.events.clear();
        for (index, variable) in (0_u32..).zip(&variables) {
            sequence += 1;
            let value = match index % 3 {
                0 => Value::Real(f64::from(number) + 0.1),
                1 => samples::quantity(f64::from(number) * 0.01, "m"),
                _ => samples::quantity(f64::from(index), "deg"),
            };
            let kind = EventKind::Measurement(variable.clone(), value);
            packet.events.push(apex_model::event::Event { sequence, at: packet.now, kind });
        }
        let began = std::time::Instant::now();
        recorder.begin(&packet).unwrap();
        recorder.observe(&packet, &[]).unwrap();
        recorder.inspect(&apex_executive::state::agent::Agent::default(), &NoDeliberator, packet.now).unwrap();
        spent += began.elapsed();
    }
    let began = std::time::Instant::now();
    recorder.finish(packet.now, "measured").unwrap();
    spent += began.elapsed();
    let megabytes = std::fs::metadata(&path).unwrap().len() as f64 / 1e6;
    println!("recorded in {:.3} s, {megabytes:.1} MB", spent.as_secs_f64());
    assert!(spent.as_secs_f64() < 0.7, "{spent:?}");
}
