//! `apex plan --plan FILE`: plans that people draw or edit, read back, checked and scored.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops where it is surprised")]

mod common;

use common::{Desk, Said, mission};
use serde_json::{Value, json};

const CELL: &str = "small-fixed-fixed-6-uniform";

fn answer(said: &Said) -> Value {
    serde_json::from_str(&said.out).unwrap()
}

fn plan(desk: &Desk, what: &str, more: &[&str]) -> Said {
    desk.apex(&[&["plan", what, "--budget", "300ms", "--bound-budget", "50ms"], more].concat())
}

/// Asks for the file's plan as JSON.
fn again(desk: &Desk, what: &str, more: &[&str]) -> Said {
    plan(desk, what, &[&["--plan", "p.json", "--json"], more].concat())
}

#[test]
fn a_plan_that_is_brought_back_is_worth_the_same() {
    let desk = Desk::new();
    for what in [CELL, &mission("structure-watch"), &mission("western-states")] {
        let planned = answer(&plan(&desk, what, &["--json"]).well());
        // The whole answer, or the plan by itself; times as they are, or made anew.
        for (text, more) in [(planned.to_string(), &[][..]), (planned["plan"].to_string(), &["--retime"][..])] {
            desk.write("p.json", &text);
            let brought = answer(&again(&desk, what, more).well());
            let body = brought["plan"].as_object().unwrap().values().next().unwrap();
            assert_eq!(body["solver"], "human");
            let (value, before) = (brought["value"].as_f64().unwrap(), planned["value"].as_f64().unwrap());
            assert!((value - before).abs() < 1e-3 * before.abs(), "{what} {more:?}: {value} {before}");
            assert!(brought["reason"].as_str().unwrap().contains("p.json"), "{brought}");
        }
    }
}

#[test]
fn an_edited_plan_is_printed_in_every_format() {
    let desk = Desk::new();
    let what = mission("structure-watch");
    desk.write("p.json", &plan(&desk, &what, &["--json"]).well().out);
    plan(&desk, &what, &["--plan", "p.json"]).well().told(&["planned by human", "somebody brought it in p.json"]);
    for (format, phrase) in [("pdl", "(visit "), ("geojson", "FeatureCollection"), ("kml", "<kml"), ("qgc", "fileType")]
    {
        plan(&desk, &what, &["--plan", "p.json", "--format", format]).well().told(&[phrase]);
    }
    plan(&desk, &what, &["--plan", "p.json", "--json", "--out", "p.json"])
        .complained(2, &["p.json is what the plan is made from"]);
}

/// A plan of a few visits once, with a change.
fn edited(desk: &Desk, change: impl FnOnce(&mut Value)) {
    let mut planned = answer(&plan(desk, CELL, &["--json"]).well());
    let body = &mut planned["plan"]["Surveillance"];
    body["cycle"] = json!([]);
    body["visits"].as_array_mut().unwrap().truncate(5);
    change(body);
    desk.write("p.json", &planned.to_string());
}

#[test]
fn every_broken_rule_is_named_and_times_can_be_made_anew() {
    let desk = Desk::new();
    edited(&desk, |body| {
        let visits = body["visits"].as_array_mut().unwrap();
        visits.swap(1, 3);
        visits[4]["end_s"] = json!(visits[4]["arrive_s"].as_f64().unwrap() + 1.0);
    });
    let said = again(&desk, CELL, &[]);
    said.complained(
        2,
        &[
            "the plan in p.json breaks ",
            "before it can be there, on visit 3",
            "too briefly, on visit 5",
            "add `--retime`",
        ],
    );
    let mended = answer(&again(&desk, CELL, &["--retime"]).well());
    assert_eq!(mended["plan"]["Surveillance"]["visits"].as_array().unwrap().len(), 5);
    // Who comes later than need be waits: that is a plan as well.
    edited(&desk, |body| body["visits"][4]["end_s"] = json!(body["visits"][4]["end_s"].as_f64().unwrap() + 5.0));
    again(&desk, CELL, &[]).well();
}

#[test]
fn what_is_no_plan_for_the_problem_is_told() {
    let desk = Desk::new();
    let refused = |text: &str, phrases: &[&str]| {
        desk.write("p.json", text);
        for more in [&[][..], &["--retime"]] {
            again(&desk, CELL, more).complained(2, phrases);
        }
    };
    refused("{\"Surveillance\": ", &["p.json:1:", "this is no plan", "apex plan PROBLEM --json"]);
    refused("[]", &["p.json:1:", "this is no plan"]);
    refused("{\"plan\": {\"Surveillance\": {}}}", &["this is no plan", "missing field `solver`"]);
    let fires = answer(&plan(&desk, &mission("western-states"), &["--json"]).well());
    refused(
        &fires.to_string(),
        &["p.json is no plan for small-fixed-fixed-6-uniform", "it is a plan of single visits"],
    );
    edited(&desk, |body| body["visits"][2]["target"] = json!("atlantis"));
    refused(&desk.read("p.json"), &["visit 3 is of `atlantis`, and there is no such target", "--problem"]);
    again(&desk, CELL, &["--visits", "a"]).complained(2, &["cannot be used with"]);
    again(&desk, CELL, &["--solver", "wam"]).complained(2, &["cannot be used with"]);
    plan(&desk, CELL, &["--retime"]).complained(2, &["--plan"]);
    plan(&desk, CELL, &["--plan", "none.json"]).complained(2, &["none.json"]);
}
