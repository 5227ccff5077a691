//! A flight, and all commands on its record: `fly`, `replay`, `why`, `trace`, `serve`; and `plan`.

mod common;

use common::{Desk, mission};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::Stdio;

#[test]
fn two_agents_fly_one_aircraft_and_their_record_distinguishes_them() {
    let desk = Desk::new();
    let arguments = ["fly", &mission("two-crew"), "--record", "f.apex", "--no-progress"];
    let said = desk.apex(&arguments).well();
    said.told(&["all agents are done", "picture of hangar-1 in memory", "picture of wind-tunnel in memory"]);
    desk.apex(&["replay", "f.apex"]).well().told(&["The record is confirmed: "]);
    let told = desk.apex(&["trace", "f.apex", "--type", "tell", "--agent", "camera-operator"]).well();
    assert_eq!(told.out.lines().count(), 2, "one for each picture: {}", told.out);
    told.told(&["camera-operator/T", "tells rotorcraft-1: (picture taken of hangar-1)"]);
    desk.apex(&["why", "f.apex", "stay", "--at", "58"]).well().told(&["rotorcraft-1/T", "is ongoing at 58s"]);
    desk.apex(&["why", "f.apex", "T0"])
        .complained(2, &["Several agents have a task T0", "camera-operator/T0 (operate"]);
    let unknown = ["No agent is called pilot; the record has rotorcraft-1, camera-operator."];
    desk.apex(&["why", "f.apex", "pilot/T0"]).complained(2, &unknown);
    desk.apex(&["why", "f.apex", "pilot/stay"]).complained(2, &unknown);
    desk.apex(&["why-not", "f.apex", "pilot/T0"]).complained(2, &unknown);
    desk.apex(&["why-not", "f.apex", "pilot/stay"]).complained(2, &unknown);
    desk.apex(&["trace", "f.apex", "--agent", "pilot"]).complained(2, &["No agent is called pilot"]);
    let lines = desk.apex(&["trace", "f.apex", "--json", "--object", "camera-operator/T0"]).well().json_lines();
    assert!(lines.iter().all(|line| line["agent"] == "camera-operator" && line["task"] == "T0"), "{lines:?}");
}

#[test]
fn a_flight_is_flown_reported_and_confirmed() {
    let desk = Desk::new();
    let arguments = ["fly", &mission("first-picture"), "--record", "f.apex", "--no-progress"];
    let said = desk.apex(&arguments).well();
    said.told(&[
        "First Picture: ended at ",
        "because the initial task is done",
        "picture of hangar-1 in memory",
        " min ",
        " s of flight in ",
        "Flight record: f.apex",
        "apex serve f.apex --open",
    ]);
    assert_eq!(desk.names(), ["f.apex"], "one file, without companions");
    for question in ["why", "why-not"] {
        let unknown = ["No agent is called copilot; the record has "];
        desk.apex(&[question, "f.apex", "copilot/T0"]).complained(2, &unknown);
        desk.apex(&[question, "f.apex", "copilot/camera-1"]).complained(2, &unknown);
    }
    desk.apex(&["replay", "f.apex"]).well().told(&["The record is confirmed: "]);
    let replayed = desk.apex(&["replay", "f.apex", "--json"]).well().json_lines();
    assert_eq!(replayed[0]["equal"], true);
    assert_eq!(replayed[0]["difference"], serde_json::Value::Null);
}

#[test]
fn the_record_is_called_after_the_mission_and_the_report_is_json_on_request() {
    let desk = Desk::new();
    let lines = desk.apex(&["fly", &mission("first-picture"), "--json"]).well().json_lines();
    assert_eq!(desk.names(), ["first-picture.apex"]);
    assert_eq!(lines.len(), 1);
    assert_eq!(lines[0]["end"]["reason"], "the initial task is done");
    let again = desk.apex(&["fly", &mission("first-picture"), "--json"]).well().json_lines();
    assert_eq!(lines, again, "the same seed makes the same flight, and an older record is replaced");
}

#[test]
fn lines_for_operators_are_aligned_and_narrow() {
    let desk = Desk::new();
    let said = desk.apex(&["fly", &mission("structure-watch"), "--until", "20min", "--no-progress"]).well();
    let said = said.told(&["Expected cost of ignorance", "  ranger-station  ", "20 min of flight"]);
    let sites: Vec<&str> = said.out.lines().skip_while(|line| !line.starts_with("  site ")).take(17).collect();
    let widths: Vec<usize> = sites.iter().map(|line| line.chars().count()).collect();
    assert!(widths.iter().all(|width| *width == widths[0] && *width <= 100), "{sites:?}");
}

#[test]
fn why_explains_an_interruption() {
    let desk = Desk::with_flight();
    desk.apex(&["why", "flight.apex", "hangar", "--at", "50"]).well().told(&[
        "T2 (get hires image hangar-1) is interrupted at 50s.",
        "It is the step `hangar` at ",
        "mission.pdl:22:3",
        "because T4 outranks it on camera-1",
        "What it waits for:",
    ]);
    let said = desk.apex(&["why", "flight.apex", "T2", "--at", "0:00:50", "--json"]).well();
    let why: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(why["task"], "T2");
    assert_eq!(why["state"], "interrupted");
    assert_eq!(why["t"], 50.0);
}

#[test]
fn why_goes_back_to_what_came_from_outside() {
    let desk = Desk::with_flight();
    let why = |what: &str, more: &[&str]| desk.apex(&[&["why", "flight.apex", what], more].concat());
    why("hangar", &["--at", "50"]).well().told(&["Why:", "(calibration-due camera-1) was received as an input"]);
    why("camera-1", &["--at", "50"])
        .well()
        .told(&["camera-1 is held by T4 (calibrate camera-1) at 50s", "Tasks that wait"]);
    why("command 0", &[]).well().told(&["(take-off 40m)", "because a form of its on-start caused", "vehicle.pdl:"]);
    let deep = why("command 0", &["--depth", "20", "--json"]).well();
    let deep: serde_json::Value = serde_json::from_str(&deep.out).unwrap();
    assert_eq!((deep["version"].as_u64(), deep["kind"].as_str()), (Some(1), Some("command")));
    let mut link = &deep["because"];
    while let Some(next) = link["causes"].get(0) {
        link = next;
    }
    assert_eq!(link["kind"], "initial-task", "the chain ends where the flight begins");
}

#[test]
fn why_not_answers_also_about_what_never_was() {
    let desk = Desk::with_flight();
    let why_not = |what: &str, more: &[&str]| desk.apex(&[&["why-not", "flight.apex", what], more].concat());
    why_not("take-picture ?x", &["--at", "5"]).well().told(&[
        "No task pursues (take-picture camera-1) at 5s: T2 (get hires image hangar-1), which leads to",
        "step `s4` at ",
        "waitfor (end ?up): T1 is ongoing",
    ]);
    why_not("finish", &["--at", "20"]).well().told(&["T6 (terminate) has not been enabled by 20s", "(end ?down)"]);
    let said = why_not("s4", &["--at", "5", "--json"]).well();
    let answer: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!((answer["question"].as_str(), answer["kind"].as_str()), (Some("why-not"), Some("step")));
    assert_eq!(answer["task"]["state"], "pending");
    assert_eq!(answer["missing"][0]["step"], "s4");
}

#[test]
fn a_task_that_is_not_there_is_answered_with_those_that_are() {
    let desk = Desk::with_flight();
    let why = |task: &str, more: &[&str]| desk.apex(&[&["why", "flight.apex", task], more].concat());
    let why_not = |what: &str, more: &[&str]| desk.apex(&[&["why-not", "flight.apex", what], more].concat());
    why("nonsense", &[])
        .complained(2, &["No task is called `nonsense`", "T2 (get hires image hangar-1), created at 0s"]);
    why("T999", &[]).complained(2, &["There is no task T999 in this flight", "Tasks are:"]);
    why("get hires", &[]).complained(2, &["may be one of 2 tasks. Say which:", "hangar-1", "wind-tunnel"]);
    why(" ", &[]).complained(2, &["is not given", "its number (T12)"]);
    why_not(" ", &[]).complained(2, &["the question is empty", "a goal such as"]);
    why_not("hangr", &[]).complained(2, &["Nothing is called `hangr`", "Near it are: ", "hangar"]);
    why_not("T999", &[]).complained(2, &["There is no task T999 in this flight"]);
    why_not("mission.pdl:3600", &[]).complained(2, &["Nothing is called `mission.pdl:3600`"]);
    why_not("T2", &["--at", "-5"]).complained(2, &["`--at -5` is before the start"]);
    why("T9", &["--at", "1"]).complained(2, &["T9", "later than 1s. Ask for a later instant"]);
    for at in ["soon", "NaN", "inf", "1:xx", "1:75:00", ""] {
        why("T2", &["--at", at]).complained(2, &[&format!("`--at {at}` is not a time"), "help: write seconds (90)"]);
    }
    why("T2", &["--at", "-5"]).complained(2, &["`--at -5` is before the start"]);
}

#[test]
fn the_trace_is_filtered() {
    let desk = Desk::with_flight();
    let trace = |more: &[&str]| desk.apex(&[&["trace", "flight.apex", "--json"], more].concat()).well().json_lines();
    let kinds = trace(&["--type", "transition,command"]);
    assert!(kinds.iter().all(|line| line["kind"] == "transition" || line["kind"] == "command"));
    assert!(kinds.iter().any(|line| line["kind"] == "command"));
    let object = trace(&["--object", "T2", "--type", "transition"]);
    assert!(!object.is_empty() && object.iter().all(|line| line["task"] == "T2"));
    let text = trace(&["--object", "wind-tunnel", "--type", "created"]);
    assert!(!text.is_empty() && text.iter().all(|line| line["goal"].as_str().unwrap().contains("wind-tunnel")));
    let span = trace(&["--from", "40", "--to", "P1M"]);
    assert!(span.iter().all(|line| (40.0..=60.0).contains(&line["t"].as_f64().unwrap())));
    let all = trace(&["--type", "created"]).len();
    let own = trace(&["--type", "created", "--procedure", "mission.pdl:36"]).len();
    assert!(own > 0 && own < all, "{own} of {all}");
}

#[test]
fn filters_that_admit_nothing_are_reported() {
    let desk = Desk::with_flight();
    let trace = |more: &[&str]| desk.apex(&[&["trace", "flight.apex"], more].concat());
    trace(&["--type", "transitions"]).complained(2, &["no trace lines of type `transitions`", "transition,", "note"]);
    trace(&["--object", "submarine"]).complained(0, &["note: nothing in this record matches"]);
    trace(&["--procedure", "gone.pdl"]).complained(0, &["note: nothing in this record matches"]);
    trace(&["--from", "50", "--to", "40"]).complained(2, &["`--from` is later than `--to`"]);
    trace(&["--from", "yesterday"]).complained(2, &["`--from yesterday` is not a time"]);
}

#[test]
fn a_reader_that_has_seen_enough_is_not_a_failure() {
    let desk = Desk::with_flight();
    let mut child =
        desk.command(&["trace", "flight.apex"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut first = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut first).unwrap();
    let ended = child.wait_with_output().unwrap();
    assert!(first.contains("0s"), "{first}");
    assert_eq!((ended.status.code(), String::from_utf8(ended.stderr).unwrap()), (Some(0), String::new()));
}

#[test]
fn sherpa_answers_on_a_port_of_its_own() {
    let desk = Desk::with_flight();
    let mut child = desk.command(&["serve", "flight.apex", "--port", "0"]).stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let address = line.split("http://").nth(1).and_then(|rest| rest.split('/').next()).unwrap_or_default().to_string();
    let mut answer = String::new();
    let mut stream = TcpStream::connect(&address).unwrap();
    write!(stream, "GET / HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
    stream.read_to_string(&mut answer).unwrap();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
}

#[test]
fn plans_are_printed_for_operators_for_programs_and_as_pdl() {
    let desk = Desk::new();
    let mission = mission("structure-watch");
    let plan = |more: &[&str]| desk.apex(&[&["plan", &mission, "--solver", "two-opt"], more].concat());
    let table = plan(&[]).well();
    assert!(table.out.lines().all(|line| line.chars().count() <= 100), "{}", table.out);
    table.told(&[
        "planned by two-opt",
        "expected cost of ignorance",
        "no plan that never waits can cost less than",
        "not visited:",
    ]);
    let json = plan(&["--json"]).well().json_lines();
    assert_eq!(json[0]["mission"], "Structure Watch");
    assert!(json[0]["work_units"].as_u64().unwrap() > 0 && json[0]["plan"].is_object(), "{}", json[0]);
    let surveillance = &json[0]["plan"]["Surveillance"];
    let number = |name: &str| surveillance[name].as_f64().unwrap();
    assert!(number("expected_cost_bound") > 0.0 && number("expected_cost_bound") <= number("expected_cost"));
    let pdl = plan(&["--format", "pdl"]).well();
    desk.write("plan.pdl", &pdl.out);
    desk.apex(&["check", "--fragment", "plan.pdl"]).well().told(&["procedure", " 0 errors"]);
    desk.apex(&["plan", &mission, "--solver", "magic"]).complained(2, &["no solver `magic`", "two-opt, wam", "help: "]);
}

#[test]
fn problems_are_printed_read_and_planned_alike() {
    let desk = Desk::new();
    let plan = |arguments: &[&str]| desk.apex(&[&["plan"], arguments].concat());
    let name = "small-fixed-uniform-4-globular@3";
    desk.write("four.json", &plan(&[name, "--problem"]).well().out);
    let options = ["--budget", "20ms", "--seed", "5", "--json"];
    let of_name = plan(&[&[name], &options[..]].concat()).well().json_lines();
    let of_file = plan(&[&["four.json"], &options[..]].concat()).well().json_lines();
    assert_eq!((of_name[0]["plan"].clone(), &of_file[0]["mission"]), (of_file[0]["plan"].clone(), &"four".into()));
    desk.write("bad.json", "{\"Surveillance\": {\n  \"targets\": 7 }}");
    plan(&["bad.json"]).complained(2, &["bad.json:2:14", "not a planning problem", "--problem"]);
    plan(&["small-fixed-wild-4-globular"]).complained(2, &["wild is not a spread of costs", "test-missions.md"]);
    plan(&["small-fixed-fixed-4-globular@x"]).complained(2, &["x is not a number", "@7"]);
    plan(&["four.json", "--format", "pdl"]).complained(2, &["only a mission's plan", "help: "]);
    plan(&["four.json", "--budget", "0s"]).complained(2, &["expected a duration greater than zero", "--budget 2s"]);
}

#[test]
fn a_mission_with_nothing_to_plan_is_reported_as_such() {
    let said = Desk::new().apex(&["plan", &mission("first-picture")]);
    said.complained(2, &["no plan was found", "there is no target to watch", "help: "]);
}
