//! `apex fork`: a recorded flight continued with changes.

mod common;

use common::Desk;

/// Returns a flight of the shipped mission over structures, recorded in `r.apex`.
fn flown() -> Desk {
    let desk = Desk::with_mission("plain-watch");
    desk.change("m/mission.pdl", ":budget 500ms", ":budget 20ms");
    desk.apex(&["fly", "m", "--until", "25min", "--record", "r.apex", "--no-progress"]).well();
    desk
}

/// Returns the whole trace of a record.
fn trace(desk: &Desk, record: &str) -> String {
    desk.apex(&["trace", record, "--json"]).well().out
}

#[test]
fn without_changes_the_forked_flight_is_the_recorded_one() {
    let desk = flown();
    // Before the plan arrives, during the first transit, and at the last instant.
    for at in ["0s", "100s", "12min", "25min"] {
        let fork = ["fork", "r.apex", "--at", at, "--until", "25min", "--output", "f.apex"];
        desk.apex(&fork).well().told(&["nothing is changed", "recorded", "forked"]);
        assert_eq!(trace(&desk, "f.apex"), trace(&desk, "r.apex"), "forked at {at}");
        desk.apex(&["replay", "f.apex"]).well().told(&["The record is confirmed: ", "the same planning problem"]);
    }
}

#[test]
fn a_fork_at_the_end_ends_for_the_same_reason() {
    let desk = Desk::with_flight();
    let ended = desk.apex(&["score", "flight.apex", "--json"]).well().json_lines().swap_remove(0)["end"].clone();
    let at = ended["t"].to_string();
    let fork = ["fork", "flight.apex", "--at", &*at, "--output", "f.apex", "--json"];
    let reports = desk.apex(&fork).well().json_lines().swap_remove(0);
    assert_eq!(reports["forked"]["end"], ended);
    assert_eq!(reports["recorded"], reports["forked"]);
}

#[test]
fn wind_and_seed_change_the_flight_after_the_instant_and_not_before() {
    let desk = flown();
    let lines = |record: &str| desk.apex(&["trace", record, "--json"]).well().json_lines();
    let recorded = lines("r.apex");
    for change in [["--wind-factor", "3"], ["--seed", "99"]] {
        let fork = ["fork", "r.apex", "--at", "10min", "--until", "25min", "--output", "f.apex"];
        desk.apex(&[&fork[..], &change[..]].concat()).well();
        let forked = lines("f.apex");
        assert_ne!(forked, recorded, "{change:?} has an effect");
        let first = forked.iter().zip(&recorded).find(|(a, b)| a != b).map(|(a, _)| a["t"].as_f64());
        assert!(first.flatten().is_none_or(|t| t > 600.0), "{change:?}: {first:?}");
        desk.apex(&["replay", "f.apex"]).well().told(&["The record is confirmed: "]);
    }
}

#[test]
fn an_imposed_plan_is_flown_and_asked_again_by_replay() {
    let desk = Desk::with_mission("plain-watch");
    desk.change("m/mission.pdl", ":budget 500ms", ":budget 20ms");
    desk.change("m/mission.pdl", "\"contingencies\"", "\"contingencies\" \"replanning\"");
    desk.change(
        "m/mission.pdl",
        "(step patrol (patrol the structures) (waitfor (end ?up)))",
        "(step patrol (patrol the structures) (waitfor (end ?up)) (restart-when (new plan)))\n  (step keep (keep planning (patrol the structures)))",
    );
    desk.apex(&["fly", "m", "--until", "20min", "--record", "r.apex", "--no-progress"]).well();
    let fork = ["fork", "r.apex", "--at", "10min", "--until", "20min", "--plan", "winery,clinic", "--output", "f.apex"];
    let said = desk.apex(&fork).well();
    said.told(&["plan winery, clinic"]);
    let plans = desk.apex(&["trace", "f.apex", "--type", "plan", "--json"]).well().json_lines();
    let last = plans.last().and_then(|line| line["summary"].as_str()).unwrap_or_default().to_string();
    assert!(plans.len() > 1 && last.contains("human") || last.contains("2"), "{plans:?}");
    desk.apex(&["replay", "f.apex"]).well().told(&["The record is confirmed: "]);
}

#[test]
fn what_cannot_be_forked_is_refused_with_the_reason() {
    let desk = flown();
    desk.apex(&["fork", "r.apex", "--at", "2h"]).complained(2, &["lies outside of the record"]);
    desk.apex(&["fork", "r.apex", "--at", "5min", "--plan", "castle"])
        .complained(2, &["`castle`", "name targets among"]);
    desk.apex(&["fork", "r.apex", "--at", "5min", "--plan", "home"]).complained(2, &["`home`", "name targets among"]);
    desk.apex(&["fork", "r.apex", "--at", "5min", "--until", "4min"])
        .complained(2, &["the end at 0:04:00 is before 0:05:00"]);
    desk.apex(&["fork", "r.apex", "--at", "5min", "--wind-factor", "-1"]).complained(2, &["--wind-factor"]);
    desk.apex(&["fork", "r.apex", "--at", "5min", "--output", "r.apex"]).complained(2, &["`--output`"]);
    desk.write("early.jsonl", "{\"t\": 10, \"event\": \"(target-gone barn)\"}\n");
    desk.apex(&["fork", "r.apex", "--at", "5min", "--inputs", "early.jsonl"]).complained(2, &["is not after"]);
    desk.apex(&["fork", "r.apex", "--at", "5min", "--seed", "3", "--until", "6min", "--output", "f.apex"]).well();
    desk.apex(&["fork", "f.apex", "--at", "5min"]).complained(2, &["it is itself a fork (seed 3)"]);
}

#[test]
fn a_refused_fork_leaves_an_older_record_as_it_was() {
    let desk = flown();
    desk.write("early.jsonl", "{\"t\": 10, \"event\": \"(target-gone barn)\"}\n");
    desk.apex(&["fork", "r.apex", "--at", "5min", "--until", "6min", "--output", "f.apex"]).well();
    let before = std::fs::read(desk.path("f.apex")).unwrap();
    for change in [["--plan", "castle"], ["--inputs", "early.jsonl"]] {
        let fork = ["fork", "r.apex", "--at", "5min", "--output", "f.apex"];
        desk.apex(&[&fork[..], &change[..]].concat()).complained(2, &["help: "]);
        assert!(std::fs::read(desk.path("f.apex")).unwrap() == before, "{change:?}");
    }
}

/// Sends a request to a server at `address` and returns its answer.
#[cfg(unix)]
#[allow(clippy::unwrap_used, reason = "a test without a server has failed")]
fn answer(address: &str, method: &str, body: &str) -> String {
    use std::io::{Read, Write};
    let mut stream = std::net::TcpStream::connect(address).unwrap();
    let length = body.len();
    write!(
        stream,
        "{method} /api/forks HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nContent-Type: application/json\r\n\
         Content-Length: {length}\r\n\r\n{body}"
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

#[test]
#[cfg(unix)]
fn a_server_refuses_at_once_what_cannot_be_forked() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};
    let desk = flown();
    let mut command = desk.command(&["serve", "r.apex", "--port", "0"]);
    let mut server = command.stdout(Stdio::piped()).spawn().unwrap();
    let mut said = String::new();
    BufReader::new(server.stdout.take().unwrap()).read_line(&mut said).unwrap();
    let address = said.split("http://").nth(1).unwrap().split('/').next().unwrap().trim().to_string();
    for (body, reason) in [
        ("{\"at_ns\": 9000000000000}", "lies outside of the record"),
        ("{\"at_ns\": -1}", "lies outside of the record"),
        ("{\"at_ns\": 300000000000, \"plan\": [\"castle\"]}", "`castle`"),
        ("{\"at_ns\": 300000000000, \"inputs\": [{\"t\": 10, \"event\": \"(target-gone barn)\"}]}", "is not after"),
    ] {
        let told = answer(&address, "POST", body);
        assert!(told.starts_with("HTTP/1.1 422") && told.contains(reason), "{body}: {told}");
    }
    let listed = answer(&address, "GET", "");
    assert!(listed.ends_with("[]"), "{listed}");
    assert!(Command::new("kill").args(["-TERM", &server.id().to_string()]).status().unwrap().success());
    server.wait().unwrap();
    assert_eq!(desk.names(), ["m", "r.apex"]);
}
