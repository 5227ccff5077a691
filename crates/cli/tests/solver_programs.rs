//! Solver programs: they plan and fly like other planners, and their faults stay in a separate process.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test stops at an unexpected result")]

mod common;

use common::{Desk, mission};

const FORM: &str = "(solver auto (index (patrol the structures)) :budget 500ms)";
/// Answers with all targets in their order.
const ROUND: &str = r#"
import json, sys
request = json.loads(sys.stdin.readline())
assert request["apex_solver"] == 1 and request["work_units"] > 0
targets = [target["name"] for target in request["problem"]["Surveillance"]["targets"]]
print(json.dumps({"charge": 500}))
print(json.dumps({"plan": targets}), flush=True)
"#;

#[test]
fn a_program_plans_and_flies() {
    let desk = Desk::with_mission("plain-watch");
    desk.write("round.py", ROUND);
    let program = "mine=python3 round.py";
    let planned =
        desk.apex(&["plan", &mission("structure-watch"), "--solver-program", program, "--solver", "mine"]).well();
    planned.told(&["planned by mine"]);
    desk.change("m/mission.pdl", FORM, "(solver mine (index (patrol the structures)) :budget 20ms)");
    let fly = ["fly", "m", "--record", "r.apex", "--no-progress", "--until", "3min", "--solver-program", program];
    desk.apex(&fly).well();
    desk.apex(&["trace", "r.apex", "--type", "plan"]).well().told(&["because mine answered request 0"]);
    desk.apex(&["replay", "r.apex"]).well();
}

#[test]
fn the_planners_that_ship_are_programs_too() {
    let desk = Desk::new();
    let program = format!("mine='{}' solver two-opt", env!("CARGO_BIN_EXE_apex"));
    let plan = |more: &[&str]| {
        let arguments = [&["plan", "small-fixed-fixed-8-uniform@7", "--budget", "20ms", "--seed", "4", "--json"], more];
        let planned = desk.apex(&arguments.concat()).well().out;
        let json: serde_json::Value = serde_json::from_str(&planned).unwrap();
        let visits = json["plan"]["Surveillance"]["visits"].as_array().unwrap().clone();
        visits.iter().map(|visit| visit["target"].as_str().unwrap().to_string()).collect::<Vec<_>>()
    };
    assert_eq!(plan(&["--solver", "mine", "--solver-program", &program]), plan(&["--solver", "two-opt"]));
    desk.apex(&["solver", "unknown"]).complained(2, &["there is no solver `unknown`", "two-opt"]);
}

#[test]
fn whatever_a_program_does_is_an_outcome_with_a_cause_and_the_flight_continues() {
    let desk = Desk::with_mission("plain-watch");
    desk.change("m/mission.pdl", FORM, "(solver mine (index (patrol the structures)) :budget 1ms)");
    let patrol = "(step patrol (patrol the structures) (waitfor (end ?up))";
    desk.change("m/mission.pdl", patrol, &format!("{patrol} (on-failure (inform (without-a-plan)))"));
    for (script, cause) in [
        ("exit 0", "ended with exit code 0 and without an answer"),
        ("ulimit -c 0; kill -SEGV $$", "was ended by signal 11 (SIGSEGV"),
        ("yes nonsense", "does not follow the protocol (expected ident at line 1 column 2): `nonsense`"),
        ("yes >&2", "more than 16 MiB to standard error"),
        ("sleep 600", "gave no answer within 2 s"),
    ] {
        desk.write("bad.sh", script);
        let program = "mine=bash bad.sh";
        // A busy machine needs seconds to start a program and to read what it writes.
        let limit = if script == "sleep 600" { "2s" } else { "60s" };
        let fly = ["fly", "m", "--record", "r.apex", "--no-progress", "--until", "3min", "--solver-timeout", limit];
        desk.apex(&[&fly[..], &["--solver-program", program]].concat()).well();
        let trace = desk.apex(&["trace", "r.apex"]).well();
        assert!(trace.out.contains(cause), "{script}: `{cause}` is not in\n{}", trace.out);
        let late = desk.apex(&["trace", "r.apex", "--from", "2:50"]).well();
        assert!(trace.out.contains("(without-a-plan)") && late.out.contains("signal-level"), "{script}");
        desk.apex(&["replay", "r.apex"]).well();
    }
}

#[test]
fn options_that_name_no_program_are_refused() {
    let desk = Desk::new();
    let test_mission = "small-fixed-fixed-4-uniform";
    for (text, why) in [
        ("mine", "`=` is missing"),
        ("mine=", "the command is empty"),
        ("mine='x", "a quotation mark in the command is not closed"),
        ("=x", "cannot be the name of a planner"),
        ("two-opt=x", "called `two-opt` already"),
    ] {
        desk.apex(&["plan", test_mission, "--solver-program", text]).complained(2, &[why, "for example"]);
    }
    let missing = ["plan", test_mission, "--solver", "mine", "--solver-program", "mine=/no/such/program"];
    desk.apex(&missing).complained(2, &["`/no/such/program` cannot be started"]);
}
