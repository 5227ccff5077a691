//! `apex plan --format`: one plan in the formats for operators, the executive, maps and ground stations.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

mod common;

use common::{Desk, mission};
use serde_json::Value;

/// A mission of two targets, a zone and a wait, small enough to be written down whole.
const TWO: &str = include_str!("plan_output/two.json");

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// Compares the text with a committed file; `UPDATE=1` rewrites it.
#[track_caller]
fn golden(name: &str, text: &str) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/plan_output").join(name);
    if std::env::var_os("UPDATE").is_some_and(|update| update == "1") {
        std::fs::write(&path, text).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text, "{name} differs; UPDATE=1 rewrites it");
}

#[test]
fn a_small_plan_in_every_format() {
    let desk = Desk::new();
    desk.write("two.json", TWO);
    for format in ["geojson", "kml", "qgc"] {
        let said = desk.apex(&["plan", "two.json", "--budget", "2ms", "--format", format]).well();
        golden(&format!("two.{format}"), &said.out);
    }
}

/// 22 fires in wind and among zones that change. The scores with these seeds are above 1,100; the bound of the benefits is 1,262.5.
#[test]
fn fires_in_changing_wind_are_planned_well() {
    let desk = Desk::new();
    for seed in ["3", "4"] {
        let said = desk.apex(&["plan", &mission("western-states"), "--budget", "3s", "--seed", seed, "--json"]).well();
        let plan = &json(&said.out)["plan"]["SingleVisit"];
        let score = plan["benefits"].as_f64().unwrap() - plan["costs"].as_f64().unwrap();
        assert!(score > 1_100.0, "{score} with seed {seed}");
    }
}

#[test]
fn the_files_name_says_the_format() {
    let desk = Desk::new();
    desk.write("two.json", TWO);
    let plan = |out: &str| desk.apex(&["plan", "two.json", "--budget", "2ms", "--out", out]).well();
    for (file, begins) in [
        ("a.geojson", "{\"type\": \"FeatureCollection\""),
        ("a.KML", "<?xml"),
        ("a.plan", "{\n  \"fileType\": \"Plan\""),
        ("a.json", "{\"bound\""),
        ("a.txt", "2 of 2 targets"),
    ] {
        assert_eq!(plan(file).out, "");
        let text = desk.read(file);
        assert!(text.starts_with(begins), "{file}: {text}");
    }
    assert!(plan("-").out.starts_with("2 of 2 targets"));
    desk.apex(&["plan", "two.json", "--problem", "--out", "problem.json"]).well();
    assert_eq!(json(&desk.read("problem.json")), json(TWO));
}

#[test]
fn the_fires_on_a_map() {
    let desk = Desk::new();
    let plan = |format| desk.apex(&["plan", &mission("western-states"), "--budget", "20ms", "--format", format]).well();
    let geojson: geojson::FeatureCollection = plan("geojson").out.parse().unwrap();
    let of_kind = |kind: &str| {
        let property = |feature: &&geojson::Feature, name| {
            feature.property(name).and_then(|value| value.as_str().map(str::to_string))
        };
        geojson.features.iter().filter(|feature| property(feature, "kind").as_deref() == Some(kind)).collect::<Vec<_>>()
    };
    let counts = ["path", "start", "base", "restricted", "permitted"].map(|kind| of_kind(kind).len());
    assert_eq!(counts, [1, 1, 1, 8, 1]);
    let (targets, left_out) = (of_kind("target"), of_kind("left-out"));
    assert_eq!(targets.len() + left_out.len(), 22);
    for target in &targets {
        let number = |name: &str| target.property(name).and_then(Value::as_f64).unwrap();
        let factors =
            number("value") * number("coverage") * number("resolution") * number("clarity") * number("timing");
        assert!((factors - number("worth")).abs() < 1e-6, "{target:?}");
        assert!(number("arrive_s") <= number("begin_s") && number("begin_s") < number("end_s"));
        assert!(target.property("begin_utc").unwrap().as_str().unwrap().starts_with("2007-09-0"));
    }
    assert!(left_out.iter().all(|target| target.property("left_out").is_some()));

    let plan = json(&plan("qgc").out);
    let items = plan["mission"]["items"].as_array().unwrap();
    let commands: Vec<u64> = items.iter().map(|item| item["command"].as_u64().unwrap()).collect();
    assert_eq!((commands[0], *commands.last().unwrap()), (22, 21), "from take-off to landing");
    for (index, item) in items.iter().enumerate() {
        assert_eq!(item["doJumpId"], index + 1);
        assert_eq!((&item["frame"], &item["AltitudeMode"]), (&0.into(), &2.into()), "above mean sea level");
    }
    let polygons = plan["geoFence"]["polygons"].as_array().unwrap();
    assert_eq!(polygons.iter().filter(|polygon| polygon["inclusion"] == true).count(), 1);
    assert_eq!(polygons.len(), 9, "a flight of a day meets every zone while it is active");
    let near = ["plan", &mission("western-states"), "--budget", "20ms", "--visits", "zaca,lick", "--format", "qgc"];
    let near = json(&desk.apex(&near).well().out);
    let polygons = near["geoFence"]["polygons"].as_array().unwrap();
    assert_eq!(polygons.len(), 7, "the temporary zones are not active yet");
}

/// Checks the keys and types that QGroundControl's public description of the format (developer guide, "Plan File Format") requires.
fn is_a_plan_file(plan: &Value) {
    let whole = |value: &Value, key: &str| assert!(value[key].is_u64(), "{key} of {value}");
    let number = |value: &Value| value.as_f64().is_some_and(f64::is_finite);
    assert_eq!((&plan["fileType"], &plan["version"]), (&"Plan".into(), &1.into()));
    assert!(plan["groundStation"].is_string());
    let mission = &plan["mission"];
    assert_eq!(mission["version"], 2);
    ["firmwareType", "vehicleType", "globalPlanAltitudeMode"].iter().for_each(|key| whole(mission, key));
    assert!(number(&mission["cruiseSpeed"]) && number(&mission["hoverSpeed"]));
    let place = |value: &Value, count: usize| {
        let numbers = value.as_array().unwrap();
        assert!(numbers.len() == count && numbers.iter().all(number), "{value}");
        assert!(numbers[0].as_f64().unwrap().abs() <= 90.0 && numbers[1].as_f64().unwrap().abs() <= 180.0, "{value}");
    };
    place(&mission["plannedHomePosition"], 3);
    let items = mission["items"].as_array().unwrap();
    assert!(!items.is_empty(), "a plan has an item at least");
    for (index, item) in items.iter().enumerate() {
        assert_eq!(item["type"], "SimpleItem");
        assert!(item["autoContinue"].is_boolean());
        ["command", "doJumpId", "frame"].iter().for_each(|key| whole(item, key));
        assert_eq!(item["doJumpId"], index + 1);
        let params = item["params"].as_array().unwrap();
        assert!(params.len() == 7 && params.iter().all(|param| param.is_null() || number(param)), "{item}");
        // Altitudes above home or above mean sea level; items without a place have none.
        let modes = [(0, Some(2)), (3, Some(1)), (2, None)];
        let expected = modes.iter().find(|(frame, _)| item["frame"] == *frame).unwrap().1;
        if let Some(mode) = expected {
            assert_eq!(item["AltitudeMode"], mode, "{item}");
            assert!(number(&item["Altitude"]) && item["AMSLAltAboveTerrain"].is_null(), "{item}");
            assert_eq!(item["Altitude"], params[6]);
            place(&Value::Array(params[4..6].to_vec()), 2);
        }
        if item["command"] == 177 {
            assert!((1..=items.len() as u64).contains(&params[0].as_u64().unwrap()), "a jump to an item: {item}");
        }
    }
    let fence = &plan["geoFence"];
    assert_eq!((&fence["version"], &plan["rallyPoints"]["version"]), (&2.into(), &2.into()));
    assert!(fence["circles"].is_array() && plan["rallyPoints"]["points"].is_array());
    for polygon in fence["polygons"].as_array().unwrap() {
        assert!(polygon["version"] == 1 && polygon["inclusion"].is_boolean(), "{polygon}");
        let corners = polygon["polygon"].as_array().unwrap();
        assert!(corners.len() >= 3, "{polygon}");
        corners.iter().for_each(|corner| place(corner, 2));
    }
}

#[test]
fn plan_files_have_every_key_that_ground_stations_ask_for() {
    let desk = Desk::new();
    desk.write("two.json", TWO);
    let (fires, structures) = (mission("western-states"), mission("structure-watch"));
    let questions: [&[&str]; 4] =
        [&["two.json"], &[&fires], &[&structures], &["small-fixed-fixed-4-two-cluster", "--height", "60m"]];
    for question in questions {
        let plan = desk.apex(&[&["plan"], question, &["--budget", "20ms", "--format", "qgc"]].concat()).well();
        is_a_plan_file(&json(&plan.out));
    }
}

#[test]
fn rounds_are_jumps_and_every_visit_is_kept() {
    let desk = Desk::new();
    let name = "small-fixed-fixed-4-two-cluster";
    let plan = |format: &[&str]| {
        desk.apex(&[&["plan", name, "--solver", "two-opt", "--budget", "20ms"], format].concat()).well()
    };
    let answer = json(&plan(&["--json"]).out);
    let visits = answer["plan"]["Surveillance"]["visits"].as_array().unwrap().len();
    let cycle = answer["plan"]["Surveillance"]["cycle"].as_array().unwrap().len();
    let plan = json(&plan(&["--format", "qgc", "--height", "200ft"]).out);
    let items = plan["mission"]["items"].as_array().unwrap();
    let jump = items.iter().find(|item| item["command"] == 177).unwrap();
    let (to, times) = (jump["params"][0].as_u64().unwrap() as usize, jump["params"][1].as_u64().unwrap() as usize);
    let looks = items.iter().filter(|item| item["command"] == 19).count();
    assert_eq!(to, 2, "the first visit follows the take-off");
    assert_eq!(looks + times * cycle, visits);
    assert_eq!(items.last().unwrap()["command"], 20, "back to where it began");
    assert!(
        items
            .iter()
            .filter(|item| item["frame"] == 3)
            .all(|item| (item["Altitude"].as_f64().unwrap() - 60.96).abs() < 1e-9)
    );
}

#[test]
fn a_printed_procedure_is_checked_and_flown() {
    let desk = Desk::with_mission("plain-watch");
    desk.apex(&["plan", "m", "--budget", "20ms", "--out", "m/plan.pdl"]).well();
    desk.apex(&["check", "m/plan.pdl"]).well().told(&[" 0 errors, 0 warnings"]);
    desk.change("m/mission.pdl", "(solver auto (index (patrol the structures)) :budget 500ms)", "");
    desk.change("m/mission.pdl", ":duration 1h", ":duration 1h :files (\"plan.pdl\")");
    desk.apex(&["fly", "m", "--record", "flown.apex", "--no-progress"]).well().told(&["of flight"]);
    let why = desk.apex(&["why", "flown.apex", "patrol", "--at", "20min"]).well();
    why.told(&["Its method: procedure", "plan.pdl"]);
    // The flown order is the planned one.
    let planned: Vec<String> = desk
        .read("m/plan.pdl")
        .lines()
        .filter_map(|line| line.split("(visit ").nth(1)?.split(' ').next().map(str::to_string))
        .collect();
    let trace = desk.apex(&["trace", "flown.apex", "--json"]).well();
    let seen: Vec<String> = trace
        .out
        .lines()
        .filter_map(|line| line.split("(observed ").nth(1)?.split(')').next().map(str::to_string))
        .collect();
    let mut flown: Vec<String> = seen;
    flown.dedup();
    assert!(flown.len() > 10, "{flown:?}");
    assert_eq!(flown, planned[..flown.len()]);
}

#[test]
fn printed_fires_are_checked() {
    let desk = Desk::new();
    desk.apex(&["plan", &mission("western-states"), "--budget", "5ms", "--out", "fires.pdl"]).well();
    desk.apex(&["check", "fires.pdl"]).well().told(&[" 0 errors, 0 warnings"]);
}

#[test]
fn what_cannot_be_printed_is_reported_with_what_to_do() {
    let desk = Desk::new();
    let plan = |arguments: &[&str]| desk.apex(&[&["plan"], arguments].concat());
    desk.write("two.json", TWO);
    let test = "small-fixed-fixed-4-uniform";
    plan(&[test, "--format", "svg"]).complained(2, &["'svg'", "geojson", "kml", "qgc"]);
    plan(&[test, "--format", "kml", "--json"]).complained(2, &["cannot be used with"]);
    plan(&[test, "--format", "pdl"]).complained(2, &["only a mission's plan", "help: "]);
    plan(&[test, "--format", "qgc", "--budget", "1ms"]).complained(2, &["its altitudes are unknown", "--height 60m"]);
    plan(&[test, "--format", "qgc", "--height", "-3m"]).complained(2, &["`--height -3m` is not a length", "60m"]);
    plan(&[test, "--format", "qgc", "--height", "3s"]).complained(2, &["is not a length above 0"]);
    plan(&[test, "--height", "60m"]).complained(2, &["--format qgc"]);
    plan(&[test, "--budget", "1ms", "--out", "none/a.kml"])
        .complained(1, &["cannot write none/a.kml", "the folder does not exist"]);
    plan(&[test, "--budget", "1ms", "--out", "."]).complained(2, &[". is a folder", "name a file"]);
    plan(&["two.json", "--out", "two.json"]).complained(2, &["two.json is the source of the plan"]);
    assert_eq!(desk.read("two.json"), TWO);
    let tour = "NAME: three\nTYPE: ATSP\nDIMENSION: 3\nEDGE_WEIGHT_TYPE: EXPLICIT\nEDGE_WEIGHT_FORMAT: FULL_MATRIX\nEDGE_WEIGHT_SECTION\n0 1 2\n3 0 4\n5 6 0\nEOF\n";
    desk.write("three.atsp", tour);
    plan(&["three.atsp", "--budget", "1ms", "--format", "kml"])
        .complained(2, &["three has no places", "lie at one point", "--format table"]);
    plan(&["three.atsp", "--format", "qgc"]).complained(2, &["not places on Earth"]);
    plan(&["three.atsp", "--budget", "1ms", "--format", "table"]).well();
}

#[test]
fn a_surveillance_plan_is_drawn_around_obstacles() {
    let desk = Desk::with_mission("plain-watch");
    let out = desk.apex(&["plan", "m", "--budget", "20ms", "--format", "geojson"]).well().out;
    let drawn: Value = serde_json::from_str(&out).unwrap();
    let of = |kind: &str| -> Vec<Value> {
        let features = drawn["features"].as_array().unwrap().iter();
        features.filter(|feature| feature["properties"]["kind"] == kind).cloned().collect()
    };
    let number = |value: &Value| value.as_f64().unwrap();
    let path = of("path")[0]["geometry"]["coordinates"].as_array().unwrap().clone();
    let visits: usize =
        of("target").iter().filter_map(|target| target["properties"]["observations"].as_u64()).sum::<u64>() as usize;
    assert!(path.len() > visits + 1, "{} points for {visits} visits: no bends", path.len());
    for pair in path.windows(2) {
        for step in 0..=100 {
            let share = f64::from(step) / 100.0;
            let at = |index: usize| number(&pair[0][index]) * (1.0 - share) + number(&pair[1][index]) * share;
            let (x, y, altitude_m) = (at(0), at(1), at(2));
            for zone in of("restricted") {
                let facts = &zone["properties"];
                let ring = zone["geometry"]["coordinates"][0].as_array().unwrap();
                let crossings = ring.windows(2).filter(|edge| {
                    let (x0, y0, x1, y1) =
                        (number(&edge[0][0]), number(&edge[0][1]), number(&edge[1][0]), number(&edge[1][1]));
                    (y0 > y) != (y1 > y) && x < x0 + (x1 - x0) * (y - y0) / (y1 - y0)
                });
                let high =
                    number(&facts["altitude_m_min"]) <= altitude_m && altitude_m < number(&facts["altitude_m_max"]);
                assert!(!high || crossings.count() % 2 == 0, "({y} {x}) lies in {}", facts["name"]);
            }
        }
    }
}

#[test]
fn names_that_nothing_has_are_reported_with_the_nearest() {
    let desk = Desk::with_mission("plain-watch");
    let plan = |name: &str, phrases: &[&str]| {
        desk.apex(&["plan", name]).complained(2, phrases);
    };
    plan(
        "nonsense-cell@3",
        &["called nonsense-cell@3", "small-clustered-fixed-8-two-cluster@7", "test-missions.md", "this folder holds m"],
    );
    plan(
        "small-fixed-fixd-12-uniform@3",
        &["fixd is not a spread of costs", "did you mean the test mission `small-fixed-fixed-12-uniform@3`?"],
    );
    plan("smal-fixed-fixed-8-uniform", &["does not begin with a scale", "`small-fixed-fixed-8-uniform`"]);
    plan(&"a-".repeat(5000), &["SCALE-RATE"]);
    plan("missing/mission.pdl", &["cannot read missing/mission.pdl", "folder missing does not exist"]);
}

#[test]
fn the_visits_of_an_operator_are_scored_like_any_other_plan_and_can_be_flown() {
    let desk = Desk::with_mission("plain-watch");
    let by_hand = ["plan", "m", "--visits", "barn,winery,farmhouse", "--repeat"];
    let table = desk.apex(&by_hand).well();
    table.told(&["planned by human", "no plan that never waits can cost less"]);
    desk.apex(&["plan", "m", "--visits", "barn,wineri"])
        .complained(2, &["there is no target `wineri`", "winery", "write the names of targets as in the mission"]);
    desk.apex(&["plan", "m", "--visits", "barn", "--solver", "wam"]).complained(2, &["cannot be used with"]);
    let printed = [by_hand.as_slice(), &["--out", "m/plan.pdl"]].concat();
    desk.apex(&printed).well();
    desk.change("m/mission.pdl", "  :targets", "  :files (\"plan.pdl\")\n  :targets");
    desk.change("m/mission.pdl", "(solver auto (index (patrol the structures)) :budget 500ms)", "");
    desk.apex(&["fly", "m", "--until", "10min", "--record", "r.apex", "--no-progress"]).well();
    desk.apex(&["trace", "r.apex", "--type", "selected"]).well().told(&["plan.pdl"]);
}

#[test]
fn proofs_have_a_budget_of_their_own() {
    let desk = Desk::new();
    let cell = "medium-clustered-uniform-24-two-cluster";
    let plan = |more: &[&str]| desk.apex(&[&["plan", cell, "--budget", "5ms"], more].concat());
    let answer = |more: &[&str]| json(&plan(&[&["--json"], more].concat()).well().out);
    let (short, none) = (answer(&["--bound-budget", "1s"]), answer(&["--bound-budget", "0s"]));
    let number = |answer: &Value, name: &str| answer[name].as_f64().unwrap();
    for answer in [&short, &none] {
        assert_eq!(answer["bound_complete"], false, "{answer}");
        assert!(number(answer, "bound") <= number(answer, "value"));
    }
    assert!(number(&short, "bound") > 1.2 * number(&none, "bound"), "{short} {none}");
    let used = number(&short, "bound_work_units");
    assert!(used > 100_000.0 && used < 1_300_000.0, "{used}");
    assert_eq!(answer(&["--bound-budget", "1s"])["bound"], short["bound"]);
    plan(&["--bound-budget", "1ms"])
        .well()
        .told(&["bounds proven so far in ", "a greater `--bound-budget` may prove more"]);
    plan(&["--bound-budget", "-1s"]).complained(2, &["`--bound-budget -1s` is before the start"]);
    plan(&["--bound-budget", "soon"]).complained(2, &["`--bound-budget soon` is not a time"]);
    let four = ["plan", "small-fixed-fixed-3-uniform", "--budget", "5ms"];
    assert_eq!(json(&desk.apex(&[&four[..], &["--json"]].concat()).well().out)["bound_complete"], true);
    desk.apex(&four).well().told(&["bounds proven in ", " units of work"]);
}
