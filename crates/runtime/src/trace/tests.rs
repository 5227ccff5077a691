//! The trace's words and keys, which programs read: a change here is a change of an interface.

use super::*;
use crate::samples;

fn trace(format: TraceFormat, filter: TraceFilter) -> Vec<String> {
    let mut tracer = Tracer::new(Vec::new(), format, filter, &samples::library());
    for (batch, effects) in samples::steps() {
        tracer.observe(&batch, &effects).unwrap();
    }
    tracer.note(Time::from_seconds(300.3), "an answer was dropped").unwrap();
    String::from_utf8(tracer.into_inner().unwrap()).unwrap().lines().map(str::to_owned).collect()
}

#[test]
fn json_lines() {
    let lines = trace(TraceFormat::JsonLines, TraceFilter::default());
    let expected = include_str!("golden.jsonl").lines().collect::<Vec<_>>();
    assert_eq!(lines, expected, "\n{}\n", lines.join("\n"));
    for line in &lines {
        assert!(serde_json::from_str::<serde_json::Value>(line).is_ok(), "{line}");
    }
}

#[test]
fn text_lines() {
    let lines = trace(TraceFormat::Text, TraceFilter::default());
    let expected = include_str!("golden.txt").lines().collect::<Vec<_>>();
    assert_eq!(lines, expected, "\n{}\n", lines.join("\n"));
}

fn kinds(filter: TraceFilter) -> Vec<String> {
    let lines = trace(TraceFormat::JsonLines, filter);
    let kind =
        |line: String| serde_json::from_str::<serde_json::Value>(&line).unwrap()["kind"].as_str().unwrap().to_owned();
    lines.into_iter().map(kind).collect()
}

#[test]
fn filters_select_by_kind_object_time_and_place() {
    let of = |kinds: &[&str]| kinds.iter().map(|kind| (*kind).to_owned()).collect();
    let wakes = TraceFilter { kinds: of(&["wake", "end"]), ..TraceFilter::default() };
    assert_eq!(kinds(wakes), ["wake", "wake", "end"]);
    let task = TraceFilter { object: Some("T1".into()), to: Some(Time::ZERO), ..TraceFilter::default() };
    assert_eq!(kinds(task), ["created", "transition", "solve"]);
    let goal = TraceFilter { object: Some("CAMERA-1".into()), kinds: of(&["event"]), ..TraceFilter::default() };
    assert_eq!(kinds(goal), ["event", "event"]);
    let variable = TraceFilter { object: Some("roll-angle".into()), ..TraceFilter::default() };
    assert_eq!(kinds(variable), ["measurement", "measurement"]);
    let late =
        TraceFilter { from: Some(Time::from_seconds(2.0)), kinds: of(&["transition"]), ..TraceFilter::default() };
    assert_eq!(kinds(late).len(), 3);
    let procedure = TraceFilter {
        place: Some("camera.pdl:9".into()),
        kinds: of(&["command", "refused"]),
        ..TraceFilter::default()
    };
    assert_eq!(kinds(procedure), ["command"]);
}

#[test]
fn a_recorded_flight_gives_the_same_lines_as_the_live_one() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("flight.apex");
    let mut recorder =
        crate::record::Recorder::create(&path, &samples::library(), crate::record::RecordOptions::default()).unwrap();
    recorder.program(&samples::library()).unwrap();
    for (batch, effects) in samples::steps() {
        recorder.observe(&batch, &effects).unwrap();
    }
    recorder.note(Time::from_seconds(300.3), "an answer was dropped").unwrap();
    recorder.finish(Time::from_seconds(300.3), "stopped").unwrap();
    let reader = RecordReader::open(&path).unwrap();
    let out = trace_record(&reader, Vec::new(), TraceFormat::JsonLines, TraceFilter::default()).unwrap();
    assert_eq!(
        String::from_utf8(out).unwrap(),
        trace(TraceFormat::JsonLines, TraceFilter::default()).join("\n") + "\n"
    );
}
