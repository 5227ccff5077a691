//! `apex check` and `apex fmt` in normal use and with many kinds of mistakes.

mod common;

use common::{Desk, mission};

const UNKNOWN_GOAL: &str = "(procedure\n  (index (do-domain))\n  (step s (make coffee)))\n";

#[test]
fn shipped_missions_are_well() {
    for name in ["day-and-night", "first-picture", "pipeline-inspection", "structure-watch", "western-states"] {
        Desk::new().apex(&["check", &mission(name)]).well().told(&["mission.pdl: ", " 0 errors, 0 warnings"]);
    }
}

#[test]
fn a_mistake_is_named_with_file_line_and_column() {
    let desk = Desk::new();
    desk.write("a.pdl", UNKNOWN_GOAL);
    let said = desk.apex(&["check", "a.pdl"]).complained(2, &[]);
    said.told(&[
        "no procedure, primitive or solver serves `(make coffee)`",
        "--> a.pdl:3:11",
        "possible fix:",
        "1 error,",
    ]);
}

#[test]
fn a_fragment_may_leave_goals_to_others() {
    let desk = Desk::new();
    desk.write("a.pdl", UNKNOWN_GOAL);
    desk.apex(&["check", "--fragment", "a.pdl"]).well().told(&["0 errors, 0 warnings"]);
}

#[test]
fn json_names_every_part_of_a_diagnostic() {
    let desk = Desk::new();
    desk.write("a.pdl", UNKNOWN_GOAL);
    let said = desk.apex(&["check", "--json", "a.pdl"]).complained(2, &[]);
    let lines = said.json_lines();
    let errors: Vec<_> = lines.iter().filter(|line| line["severity"] == "error").collect();
    let [error] = errors.as_slice() else { panic!("one error in {lines:?}") };
    assert_eq!(error["file"], "a.pdl");
    assert_eq!((error["line"].as_u64(), error["column"].as_u64()), (Some(3), Some(11)));
    assert!(error["code"].is_string() && error["message"].is_string(), "{error}");
    assert!(error["fixes"][0]["title"].as_str().unwrap().starts_with("write a procedure for it"), "{error}");
}

#[test]
fn memory_is_reported_in_samples_and_clauses_without_bound_are_named() {
    let desk = Desk::new();
    let text = "(state-variable (roll ?a) :unit deg :rate 50)\n(procedure (index (do-domain))\n  (step a (print (mean-over 'roll 'uav P10S) (value-at 'pitch 'uav ?when)) (waitfor (asked ?when))))\n";
    desk.write("a.pdl", text);
    let said = desk.apex(&["check", "--memory", "a.pdl"]).well();
    said.told(&[
        "roll: the last P10S at 50 per second; at most 502 samples",
        "without bound, up to the limit of 360000: a.pdl:3:46: (value-at pitch uav ?when)",
        "write instead: a window such as `P10M`",
    ]);
    let lines = desk.apex(&["check", "--memory", "--json", "a.pdl"]).well().json_lines();
    assert!(lines.iter().any(|line| line["keeps"] == "roll" && line["count_max"] == 502), "{lines:?}");
    assert!(lines.iter().any(|line| line["keeps"] == "pitch" && line["bounded"] == false), "{lines:?}");
}

#[test]
fn json_names_the_edits_of_a_fix_in_bytes() {
    let desk = Desk::new();
    desk.write("a.pdl", "; größe\n(primitive (index (a)) (on-start (prnt 1)))\n");
    let lines = desk.apex(&["check", "--json", "a.pdl"]).complained(2, &[]).json_lines();
    let fix = &lines[0]["fixes"][0];
    assert_eq!(
        (fix["title"].as_str(), fix["applicability"].as_str()),
        (Some("replace `prnt` by `print`"), Some("safe"))
    );
    let edit = serde_json::json!({ "file": "a.pdl", "start": 44, "end": 48, "replacement": "print" });
    assert_eq!(fix["edits"], serde_json::json!([edit]));
}

#[test]
fn all_files_are_checked_even_after_a_bad_one() {
    let desk = Desk::with_greetings();
    desk.write("a.pdl", UNKNOWN_GOAL);
    desk.apex(&["check", "a.pdl", "greetings.pdl"]).complained(2, &[]).told(&["a.pdl: 1 ", "greetings.pdl: 1 "]);
}

#[test]
fn unbalanced_parentheses_are_found_where_they_are() {
    let desk = Desk::with_greetings();
    desk.change("greetings.pdl", "(step a (greet world))", "(step a (greet world)");
    desk.apex(&["check", "greetings.pdl"]).complained(2, &[]).told(&["error[", "greetings.pdl:", "fix:"]);
}

#[test]
fn a_missing_file_is_reported_with_its_neighbours() {
    let desk = Desk::with_greetings();
    let phrases = ["cannot read greeting.pdl", "why: ", "help: this folder holds greetings.pdl"];
    desk.apex(&["check", "greeting.pdl"]).complained(2, &phrases);
    desk.apex(&["check", "no/such.pdl"]).complained(2, &["no/such.pdl", "the folder no does not exist"]);
}

#[test]
fn a_folder_of_missions_is_answered_with_its_missions() {
    let missions = common::missions().display().to_string();
    let phrases = ["mission.pdl", "first-picture", "structure-watch", "western-states"];
    Desk::new().apex(&["check", &missions]).complained(2, &phrases);
}

#[test]
fn a_file_that_is_not_text_is_refused() {
    let desk = Desk::new();
    std::fs::write(desk.path("a.pdl"), [b'(', 0xff, 0xfe]).unwrap();
    for command in ["check", "fmt", "run"] {
        desk.apex(&[command, "a.pdl"]).complained(2, &["a.pdl is not text", "byte 1", "UTF-8"]);
    }
}

#[test]
fn formatting_is_idempotent_and_check_agrees() {
    let desk = Desk::new();
    desk.write("a.pdl", "(procedure (index (do-domain))\n\n\n      (step a   (terminate)))");
    let before = desk.read("a.pdl");
    desk.apex(&["fmt", "--check", "a.pdl"]).complained(2, &["not formatted: a.pdl", "help: run `apex fmt`"]);
    assert_eq!(desk.read("a.pdl"), before, "--check changes nothing");
    desk.apex(&["fmt", "a.pdl"]).well().told(&["formatted a.pdl"]);
    let formatted = desk.read("a.pdl");
    assert_ne!(formatted, before);
    assert_eq!(desk.apex(&["fmt", "a.pdl"]).well().out, "", "nothing is left to do");
    assert_eq!(desk.read("a.pdl"), formatted);
    desk.apex(&["fmt", "--check", "a.pdl"]).well();
    assert_eq!(desk.names(), ["a.pdl"], "no temporary file stays");
    assert_eq!(desk.apex_hearing(&["fmt", "-"], &before).well().out, formatted);
}

#[test]
fn a_file_that_cannot_be_read_as_pdl_is_left_alone() {
    let desk = Desk::new();
    desk.write("a.pdl", "(procedure (index (a))");
    desk.apex(&["fmt", "a.pdl"]).complained(2, &["error[", "a.pdl:1:22"]);
    assert_eq!(desk.read("a.pdl"), "(procedure (index (a))");
    desk.apex_hearing(&["fmt", "-"], "(a").complained(2, &["<standard input>:1:2"]);
}

#[test]
fn an_unknown_library_is_answered_with_the_shipped_ones() {
    let desk = Desk::with_mission("first-picture");
    desk.change("m/mission.pdl", "(\"vehicle\")", "(\"vehicel\")");
    let said = desk.apex(&["check", "m"]).complained(2, &[]);
    said.told(&[
        "mission.pdl:5:15",
        "no library `vehicel`",
        "aerial-observation, contingencies, interface, lost-link-figures, manoeuvres, replanning, requirements, vehicle, vehicle-figures",
    ]);
}

#[test]
fn a_code_is_explained_and_all_are_listed() {
    let desk = Desk::new();
    desk.apex(&["explain", "e0203"]).well().told(&["# E0203: No step of this procedure has this tag.", "```pdl right"]);
    desk.apex(&["explain", "must_cost"]).well().told(&["must_cost: in a mission's data", "what missing it costs"]);
    desk.apex(&["explain", ":end-margin"]).well().told(&[":end-margin: an option of a mission", "1h"]);
    desk.apex(&["explain", " "]).complained(2, &["a word to explain is empty"]);
    desk.apex(&["explain", "E0701", "W0504"]).well().told(&["# E0701", "# W0504"]);
    desk.apex(&["explain"]).well().told(&["E0001  ", "E0701  Steps wait for each other in a circle.", "N0601  "]);
    desk.apex(&["explain", "E9999"])
        .complained(2, &["`E9999` is neither a code of the checker nor a word of PDL", "lists all codes"]);
    desk.write("a.pdl", UNKNOWN_GOAL);
    desk.apex(&["check", "a.pdl"]).complained(2, &[]).told(&["`apex explain E0208` explains"]);
}
