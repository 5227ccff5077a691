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
    desk.apex(&["fork", "r.apex", "--at", "5min", "--wind-factor", "-1"]).complained(2, &["--wind-factor"]);
    desk.apex(&["fork", "r.apex", "--at", "5min", "--output", "r.apex"]).complained(2, &["`--output`"]);
    desk.write("early.jsonl", "{\"t\": 10, \"event\": \"(target-gone barn)\"}\n");
    desk.apex(&["fork", "r.apex", "--at", "5min", "--inputs", "early.jsonl"]).complained(2, &["is not after"]);
    desk.apex(&["fork", "r.apex", "--at", "5min", "--seed", "3", "--until", "6min", "--output", "f.apex"]).well();
    desk.apex(&["fork", "f.apex", "--at", "5min"]).complained(2, &["it is itself a fork (seed 3)"]);
}
