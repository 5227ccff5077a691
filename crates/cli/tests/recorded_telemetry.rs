//! The paper's two examples as whole missions on the command line: checked, run over recorded telemetry, explained.

mod common;

use common::Desk;
use std::path::Path;

fn spec(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../spec/missions").join(name).display().to_string()
}

/// Returns the trace and effects of the run, and the answer to a question.
fn flown(program: &str, telemetry: &str, question: &[&str]) -> (String, String) {
    let desk = Desk::new();
    let program = spec(program);
    desk.apex(&["check", &program]).well().told(&["0 errors, 0 warnings"]);
    let run = desk.apex(&["run", &program, "--inputs", &spec(telemetry), "--text", "--record", "flight.apex"]);
    let story = run.well().out;
    let asked: Vec<&str> = ["why", "flight.apex"].iter().chain(question).copied().collect();
    let answer = desk.apex(&asked).well().out;
    (story, answer)
}

#[test]
fn a_gust_has_the_segment_flown_again() {
    let (story, answer) = flown("wings-level.pdl", "wings-level-gust.jsonl", &["refly", "--at", "44"]);
    let lost = "informs (scan-lines-lost (39.41 -119.98745 3000) (39.41 -119.98501 3000))";
    assert_eq!(story.matches(lost).count(), 1, "{story}");
    assert!(story.contains("command 3 (fly-line") && story.contains("informs (fire-mapped)"), "{story}");
    assert!(answer.contains("(roll-angle aircraft-1)") && answer.contains("from 41s to 43.5s"), "{answer}");
}

#[test]
fn in_calm_air_nothing_is_flown_again() {
    let (story, _) = flown("wings-level.pdl", "wings-level-calm.jsonl", &["south", "--at", "200"]);
    assert!(!story.contains("scan-lines-lost") && story.contains("informs (fire-mapped)"), "{story}");
}

#[test]
fn the_rotorcraft_goes_back_to_where_it_was_heard() {
    let (story, answer) =
        flown("regain-communication.pdl", "regain-communication-valley.jsonl", &["mill", "--at", "125"]);
    let violation = "informs (communication-violation (37.42461 -122.06 60))";
    assert_eq!(story.matches(violation).count(), 1, "{story}");
    assert!(answer.contains("is interrupted") && answer.contains("(signal-level 900MHzModem)"), "{answer}");
}

#[test]
fn fades_are_not_violations() {
    let (story, _) = flown("regain-communication.pdl", "regain-communication-fades.jsonl", &["home", "--at", "200"]);
    assert!(!story.contains("communication-violation") && story.contains("end: the initial task is done"), "{story}");
}
