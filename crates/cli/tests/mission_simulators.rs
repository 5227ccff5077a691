//! Missions flown by `apex run`: by the clock of the example simulator, and with a vehicle in real time.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

mod common;

use common::Desk;
use std::path::Path;
use std::process::{Command, Output};

/// Returns the shipped mission with another type of application.
fn structure_watch(kind: &str) -> Desk {
    let desk = Desk::with_mission("plain-watch");
    desk.change("m/mission.pdl", ":type native-sim", &format!(":type {kind}"));
    desk
}

/// Runs the example simulator, which starts `apex run`.
fn simulator(desk: &Desk, arguments: &[&str]) -> Output {
    let simulator = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/foreign-sim/simulator.py");
    let mut python = Command::new("python3");
    python.arg(simulator).args([env!("CARGO_BIN_EXE_apex"), "m"]).args(arguments).current_dir(desk.path("."));
    python.output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn an_outside_simulator_flies_a_mission() {
    let desk = structure_watch("foreign-sim");
    let flown = simulator(&desk, &["--record", "flight.apex"]);
    let (out, err) = (text(&flown.stdout), text(&flown.stderr));
    assert!(flown.status.success(), "{out}{err}");
    for phrase in ["(take-off 110m)", "(hover (", "(observed ", "(land home)", "end: the initial task is done"] {
        assert!(out.contains(phrase), "{phrase} is not in\n{out}");
    }
    // Visits are recorded and scored: only a flown visit has a gap between observations.
    for phrase in ["Structure Watch: ended at", "Expected cost of ignorance", "new plan: "] {
        assert!(err.contains(phrase), "{phrase} is not in\n{err}");
    }
    let visits = out.matches("(observed ").count();
    assert!(visits >= 16, "{visits} visits in an hour");
    // The camera takes a valid picture at each visit.
    let seen = err.lines().filter(|line| line.ends_with("1.00") && line.contains(" cm ")).count();
    assert!(seen >= 8 && !err.contains("not seen"), "{seen} sites seen\n{err}");
    desk.apex(&["trace", "flight.apex", "--type", "plan"]).well().told(&["patrol the structures"]);
    desk.apex(&["replay", "flight.apex"]).well().told(&["The record is confirmed: "]);
}

#[test]
fn a_mission_in_real_time_plans_for_the_vehicle_on_the_line() {
    let desk = structure_watch("realtime");
    // The vehicle flies on for ten times the wall time that the planner takes: a small budget and a moderate pace keep that short.
    desk.change("m/mission.pdl", ":budget 500ms", ":budget 20ms");
    let flown = simulator(&desk, &["--pace", "10", "--until", "7min", "--record", "flight.apex"]);
    let (out, err) = (text(&flown.stdout), text(&flown.stderr));
    assert!(flown.status.success(), "{out}{err}");
    assert!(err.contains("{\"acknowledge\": 3}"), "{err}");
    for phrase in ["new plan: ", "Expected cost of ignorance"] {
        assert!(err.contains(phrase), "{phrase} is not in\n{err}");
    }
    assert!(out.contains("(observed "), "{out}");
    desk.apex(&["replay", "flight.apex"]).well().told(&["The record is confirmed: "]);
}

#[test]
fn what_is_wrong_with_a_mission_is_said_before_the_simulator_is_greeted() {
    let desk = structure_watch("foreign-sim");
    desk.change("m/mission.pdl", "winds.csv", "wind.csv");
    let said = desk.apex(&["run", "m"]).complained(2, &["wind.csv", "there is no such file", "winds.csv"]);
    assert_eq!(said.out, "");
}
