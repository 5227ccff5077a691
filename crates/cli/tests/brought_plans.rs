//! `apex plan --plan FILE`: plans drawn or edited by hand, read back, checked and scored.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

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

/// Requests the file's plan as JSON.
fn again(desk: &Desk, what: &str, more: &[&str]) -> Said {
    plan(desk, what, &[&["--plan", "p.json", "--json"], more].concat())
}

#[test]
fn a_plan_that_is_brought_back_is_worth_the_same() {
    let desk = Desk::new();
    for what in [CELL, &mission("structure-watch"), &mission("western-states")] {
        let planned = answer(&plan(&desk, what, &["--json"]).well());
        // The whole answer, or only the plan; with its times, or with new ones.
        for (text, more) in [(planned.to_string(), &[][..]), (planned["plan"].to_string(), &["--retime"][..])] {
            desk.write("p.json", &text);
            let brought = answer(&again(&desk, what, more).well());
            let body = brought["plan"].as_object().unwrap().values().next().unwrap();
            assert_eq!(body["solver"], "human");
            let (value, before) = (brought["value"].as_f64().unwrap(), planned["value"].as_f64().unwrap());
            assert!((value - before).abs() < 1e-3 * before.abs(), "{what} {more:?}: {value} {before}");
            let times = if more.is_empty() { "its times as they are" } else { "its times computed again" };
            let reason = brought["reason"].as_str().unwrap();
            assert!(reason.contains("p.json") && reason.contains(times), "{reason}");
        }
    }
}

#[test]
fn an_edited_plan_is_printed_in_every_format() {
    let desk = Desk::new();
    let what = mission("structure-watch");
    desk.write("p.json", &plan(&desk, &what, &["--json"]).well().out);
    plan(&desk, &what, &["--plan", "p.json"]).well().told(&["planned by human", "read from p.json"]);
    for (format, phrase) in [("pdl", "(visit "), ("geojson", "FeatureCollection"), ("kml", "<kml"), ("qgc", "fileType")]
    {
        plan(&desk, &what, &["--plan", "p.json", "--format", format]).well().told(&[phrase]);
    }
    plan(&desk, &what, &["--plan", "p.json", "--json", "--out", "p.json"])
        .complained(2, &["p.json is the source of the plan"]);
}

/// Returns the members of the answer's plan. The plan is an object with one member, which names the kind of its problem.
fn body(answer: &Value) -> &Value {
    answer["plan"].as_object().unwrap().values().next().unwrap()
}

#[test]
fn what_a_plan_states_about_itself_is_computed_again() {
    let desk = Desk::new();
    for what in [&mission("structure-watch"), &mission("western-states")] {
        let planned = answer(&plan(&desk, what, &["--json"]).well());
        let mut boast = planned.clone();
        let of = boast["plan"].as_object_mut().unwrap().values_mut().next().unwrap();
        let number = |name: &str, of: &Value| of[name].as_f64().unwrap();
        if what.ends_with("western-states") {
            (of["benefits_bound"], of["score"]) = (of["benefits"].clone(), json!(1e6));
            (of["visits"][0]["worth"], of["visits"][1]["worth"]) = (json!(1e6), json!(0.0));
        } else {
            let cost = number("expected_cost", of);
            (of["expected_cost_bound"], of["expected_cost"]) = (json!(cost), json!(0.5 * cost));
            of["return_s"] = json!(1.0);
        }
        desk.write("p.json", &boast.to_string());
        let brought = answer(&again(&desk, what, &[]).well());
        assert!((number("value", &brought) - number("value", &planned)).abs() < 1e-6, "{brought}");
        assert!(number("gap", &brought) > 0.05 && number("gap", &planned) > 0.05, "{what}: {}", brought["bound"]);
        for name in ["score", "return_s", "expected_cost_bound"] {
            assert_eq!(body(&brought)[name], body(&planned)[name], "{name} of {what}");
        }
        let worths = |answer: &Value| [0, 1].map(|visit| body(answer)["visits"][visit]["worth"].clone());
        assert_eq!(worths(&brought), worths(&planned), "{what}");
    }
}

#[test]
fn a_cycle_stays_one_when_its_times_are_computed_again() {
    let desk = Desk::new();
    let mut planned = answer(&plan(&desk, CELL, &["--json", "--solver", "two-opt"]).well());
    let visits = body(&planned)["visits"].as_array().unwrap().len();
    let cycle = body(&planned)["cycle"].clone();
    // A cycle whose visits were removed in part is an edited plan, no longer a cycle; a cycle without visits is computed from its order.
    for (kept, cycle, visits) in [(visits, &cycle, visits), (2, &json!([]), 2), (0, &cycle, visits)] {
        planned["plan"]["Surveillance"]["visits"].as_array_mut().unwrap().truncate(kept);
        desk.write("p.json", &planned.to_string());
        let brought = answer(&again(&desk, CELL, &["--retime"]).well());
        let made = body(&brought)["visits"].as_array().unwrap().len();
        assert_eq!((&body(&brought)["cycle"], made), (cycle, visits), "of {kept} visits");
        assert!(brought["work_units"].as_u64().unwrap() > 0, "times take work");
    }
}

#[test]
fn what_is_left_out_says_why() {
    let desk = Desk::with_mission("plain-watch");
    // This position of the barn is inside the quarry.
    desk.change("m/sites.geojson", "[-121.09709, 37.41851]", "[-121.089, 37.412]");
    let mut planned = answer(&plan(&desk, "m", &["--json", "--visits", "winery,school,clinic"]).well());
    planned["plan"]["Surveillance"]["left_out"] = json!([{"target": "chapel", "reason": "closed on Sundays"}]);
    desk.write("p.json", &planned.to_string());
    for more in [&[][..], &["--retime"]] {
        let brought = answer(&again(&desk, "m", more).well());
        let reason = |name: &str| {
            let left_out = body(&brought)["left_out"].as_array().unwrap().iter();
            let reasons: Vec<&str> =
                left_out.filter(|each| each["target"] == name).map(|each| each["reason"].as_str().unwrap()).collect();
            assert_eq!(reasons.len(), 1, "{name} {more:?}");
            reasons[0].to_string()
        };
        assert!(reason("barn").contains("Quarry"), "{}", reason("barn"));
        if more.is_empty() {
            assert_eq!(reason("chapel"), "closed on Sundays");
            assert_eq!(reason("museum"), "the given plan does not visit it");
        }
    }
}

/// Stores a plan of a few visits once, with a change.
fn edited(desk: &Desk, change: impl FnOnce(&mut Value)) {
    let mut planned = answer(&plan(desk, CELL, &["--json"]).well());
    let body = &mut planned["plan"]["Surveillance"];
    body["cycle"] = json!([]);
    body["visits"].as_array_mut().unwrap().truncate(5);
    change(body);
    desk.write("p.json", &planned.to_string());
}

#[test]
fn every_broken_rule_is_named_and_times_can_be_computed_again() {
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
    // A vehicle that arrives later than necessary waits: the plan is valid.
    edited(&desk, |body| body["visits"][4]["end_s"] = json!(body["visits"][4]["end_s"].as_f64().unwrap() + 5.0));
    again(&desk, CELL, &[]).well();
}

#[test]
fn broken_rules_are_counted_and_not_all_named() {
    let desk = Desk::new();
    edited(&desk, |body| {
        let visit = &mut body["visits"][4];
        visit["end_s"] = json!(visit["arrive_s"].as_f64().unwrap() + 1.0);
    });
    again(&desk, CELL, &[]).complained(2, &["the plan in p.json breaks 1 rule\n", "too briefly, on visit 5"]);
    let mut planned = answer(&plan(&desk, CELL, &["--json"]).well());
    let body = &mut planned["plan"]["Surveillance"];
    body["cycle"] = json!([]);
    let visits = body["visits"].as_array_mut().unwrap();
    visits.truncate(25);
    for visit in visits {
        visit["end_s"] = json!(visit["arrive_s"].as_f64().unwrap() + 1.0);
    }
    desk.write("p.json", &planned.to_string());
    let said = again(&desk, CELL, &[]).complained(2, &["breaks 25 rules\n", "too briefly, on visit 20", "and 5 more"]);
    assert!(!said.err.contains("on visit 21"), "{}", said.err);
}

#[test]
fn a_plan_of_endless_visits_is_not_looked_at() {
    let desk = Desk::new();
    edited(&desk, |body| {
        let visit = body["visits"][0].clone();
        body["visits"] = json!(vec![visit; 100_001]);
    });
    again(&desk, CELL, &[]).complained(2, &["it has 100001 visits, more than 100000"]);
}

#[test]
fn what_is_not_a_plan_for_the_problem_is_reported() {
    let desk = Desk::new();
    let refused = |text: &str, phrases: &[&str]| {
        desk.write("p.json", text);
        for more in [&[][..], &["--retime"]] {
            again(&desk, CELL, more).complained(2, phrases);
        }
    };
    refused("{\"Surveillance\": ", &["p.json:1:", "this is not a plan", "apex plan PROBLEM --json"]);
    refused("[]", &["p.json:1:", "this is not a plan"]);
    refused("{\"plan\": {\"Surveillance\": {}}}", &["this is not a plan", "missing field `solver`"]);
    let fires = answer(&plan(&desk, &mission("western-states"), &["--json"]).well());
    refused(
        &fires.to_string(),
        &["p.json is not a plan for small-fixed-fixed-6-uniform", "it is a plan of single visits"],
    );
    edited(&desk, |body| body["visits"][2]["target"] = json!("atlantis"));
    refused(&desk.read("p.json"), &["visit 3 names `atlantis`, which is not a target", "--problem"]);
    again(&desk, CELL, &["--visits", "a"]).complained(2, &["cannot be used with"]);
    again(&desk, CELL, &["--solver", "wam"]).complained(2, &["cannot be used with"]);
    plan(&desk, CELL, &["--retime"]).complained(2, &["--plan"]);
    plan(&desk, CELL, &["--plan", "none.json"]).complained(2, &["none.json"]);
}

/// The second look is wanted half an hour after the first at most, and its worth falls to nothing in two hours more.
#[test]
fn visits_that_an_operator_names_state_the_interval_that_they_keep() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path("m")).unwrap();
    desk.write(
        "m/mission.pdl",
        "(defapplication \"Two looks\" :type native-sim :libraries (\"vehicle\" \"aerial-observation\") \
         :vehicle (sim :model predator-b :at home) :duration 6h :targets \"t.geojson\" \
         :agents ((agent uav-1 :initial-task (fly the mission))))\n\
         (procedure (index (fly the mission)) (step up (take off to 6000m)))\n",
    );
    desk.write(
        "m/t.geojson",
        r#"{"type": "FeatureCollection", "features": [
 {"type": "Feature", "properties": {"id": "home", "kind": "base", "elevation_m": 702},
  "geometry": {"type": "Point", "coordinates": [-117.884, 34.905]}},
 {"type": "Feature", "properties": {"id": "fire", "kind": "fire", "acres": 1500, "elevation_m": 700, "resolution_m": 12, "looks": [
  {"id": "one", "value": 40, "windows_h": [[0.3, 0.6]]},
  {"id": "two", "value": 50, "windows_h": [[1.6, 1.8]], "interval_h": [0.1, 0.5], "interval_ramp_min": 120}]},
  "geometry": {"type": "Point", "coordinates": [-118.4, 35.2]}}]}"#,
    );
    let answer = answer(&plan(&desk, "m", &["--visits", "fire/one,fire/two", "--json"]).well());
    let visits = answer["plan"].as_object().unwrap().values().next().unwrap()["visits"].as_array().unwrap();
    let number = |index: usize, key: &str| visits[index][key].as_f64().unwrap();
    let middle_s = |index: usize| 0.5 * (number(index, "begin_s") + number(index, "end_s"));
    let expected = 1.0 - ((middle_s(1) - middle_s(0)) / 3_600.0 - 0.5) / 2.0;
    assert!((number(1, "timing") - expected).abs() < 0.01 && (0.5..0.8).contains(&expected), "{expected}: {visits:?}");
    assert!(number(1, "worth") < 0.85 * 50.0 && number(0, "timing") == 1.0, "{visits:?}");
}
