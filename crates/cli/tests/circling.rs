//! A mission of a fixed wing: it circles around its sites, in the plan and in flight.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

mod common;

use common::{Desk, mission};
use serde_json::{Value, json};

const RIDGES: &str = r#"(defapplication "Ridge Watch"
  :type native-sim
  :libraries ("vehicle" "aerial-observation")
  :vehicle (sim :model predator-b :at home)
  :duration 3h
  :targets "sites.geojson"
  :agents ((agent aircraft-1 :initial-task (watch the ridges for 150min))))

(solver two-opt (index (patrol the ridges)) :budget 20ms)

(procedure
  (index (watch the ridges for ?time))
  (step up (take off to 3000m))
  (step patrol (patrol the ridges) (waitfor (end ?up)))
  (step clock (wait ?time))
  (step finish (terminate) (waitfor (end ?clock))))
"#;

const DWELL_S: f64 = 60.0;

/// Writes a mission in calm air, with sites some 40 km apart.
fn ridges(desk: &Desk) {
    let mut features =
        vec![json!({"type": "Feature", "properties": {"id": "home", "kind": "base", "elevation_m": 1400},
        "geometry": {"type": "Point", "coordinates": [-120.1, 39.45]}})];
    for (id, latitude, longitude) in
        [("north-rim", 39.9, -120.2), ("saddle", 39.6, -119.8), ("gap", 39.2, -119.9), ("west-fork", 39.5, -120.7)]
    {
        features.push(json!({"type": "Feature", "geometry": {"type": "Point", "coordinates": [longitude, latitude]},
            "properties": {"id": id, "kind": "structure", "elevation_m": 2000, "dwell_s": DWELL_S}}));
    }
    desk.write("mission.pdl", RIDGES);
    desk.write("sites.geojson", &json!({"type": "FeatureCollection", "features": features}).to_string());
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn a_fixed_wing_looks_from_circles_and_is_never_later_than_its_plan_says() {
    let desk = Desk::new();
    ridges(&desk);
    let problem = json(&desk.apex(&["plan", ".", "--problem"]).well().out)["Surveillance"].clone();
    let names: Vec<&str> = problem["targets"].as_array().unwrap().iter().map(|t| t["name"].as_str().unwrap()).collect();
    let index = |name: &str| names.iter().position(|known| *known == name).unwrap();
    desk.apex(&["fly", ".", "--record", "f.apex", "--no-progress"]).well();
    let lines = desk.apex(&["trace", "f.apex", "--type", "event", "--json"]).well().json_lines();
    let seen: Vec<(f64, String)> = lines
        .iter()
        .filter_map(|line| {
            let (_, rest) = line.to_string().split_once("(observed ").map(|(a, b)| (a.to_string(), b.to_string()))?;
            Some((line["t"].as_f64()?, rest.split_once(')')?.0.to_string()))
        })
        .collect();
    assert!(seen.len() >= 8, "{seen:?} of {:?}", lines.first());
    let mut most_s = 0.0;
    for pair in seen.windows(2).filter(|pair| pair[0].1 != pair[1].1) {
        let way_s = problem["travel"]["between_s"][index(&pair[0].1)][index(&pair[1].1)].as_f64().unwrap();
        let (flown_s, planned_s) = (pair[1].0 - pair[0].0, way_s + DWELL_S);
        // Commands and reports occur at half seconds, so a flight may last up to 1 s longer than planned.
        assert!(flown_s <= planned_s + 1.0, "{pair:?}: {flown_s} of {planned_s}");
        // The plan is not too long either: by half a circle of 4.4 km and the radius at most, which a flight saves that meets the circle
        // early.
        assert!(flown_s >= planned_s - 230.0, "{pair:?}: {flown_s} of {planned_s}");
        most_s = f64::max(most_s, flown_s);
    }
    assert!(most_s > 400.0, "{most_s}");
}

#[test]
fn what_circles_cost_is_said_and_they_are_drawn() {
    let desk = Desk::new();
    ridges(&desk);
    let answer = json(&desk.apex(&["plan", ".", "--json"]).well().out);
    let turns = &answer["turns"];
    let (radius_m, ways) = (turns["radius_m"].as_f64().unwrap(), turns["ways"].as_f64().unwrap());
    // 1.3 times the tightest turn at 95.2 m/s and 85 % of 18 degrees of bank; half a circle of it takes 145 s.
    assert!((radius_m - 4_391.7).abs() < 1.0 && ways >= 8.0, "{turns}");
    let each_s = turns["time_s"].as_f64().unwrap() / ways;
    assert!((145.0..156.0).contains(&each_s), "{each_s}");
    desk.apex(&["plan", "."]).well().told(&["  turns of 4392 m make ", " s each"]);
    let map = json(&desk.apex(&["plan", ".", "--format", "geojson"]).well().out);
    let path = map["features"][0]["geometry"]["coordinates"].as_array().unwrap().clone();
    let near_m = |place: &Value, (longitude, latitude): (f64, f64)| {
        let east_m = (place[0].as_f64().unwrap() - longitude) * 111_200.0 * latitude.to_radians().cos();
        east_m.hypot((place[1].as_f64().unwrap() - latitude) * 111_200.0)
    };
    // The path is nowhere nearer to the site than the radius of its circle, and on the circle for the whole observation.
    let saddle: Vec<f64> = path.iter().map(|place| near_m(place, (-119.8, 39.6))).collect();
    let nearest_m = saddle.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((nearest_m - radius_m).abs() < 60.0, "{nearest_m} of {radius_m}");
    assert!(saddle.iter().filter(|m| (**m - radius_m).abs() < 60.0).count() >= 10, "{saddle:?}");
    let file = json(&desk.apex(&["plan", ".", "--format", "qgc"]).well().out);
    let items = file["mission"]["items"].as_array().unwrap();
    let loiters = items.iter().filter(|item| item["command"] == 19 && item["params"][0] == DWELL_S);
    assert!(loiters.count() >= 3, "{items:?}");
    let pdl = desk.apex(&["plan", ".", "--format", "pdl"]).well();
    // High enough above the sites for the camera: 4392 m / tan 70 degrees = 1598 m instead of the 1000 m of the vehicle file.
    pdl.told(&["(visit saddle around (39.6 -119.8 3598.0) for P1M with camera-1)"]);
    // A hovering vehicle turns on the spot: the output does not mention turns.
    let hovering = json(&desk.apex(&["plan", &mission("structure-watch"), "--budget", "2ms", "--json"]).well().out);
    assert_eq!(hovering["turns"], Value::Null);
}

#[test]
fn in_calm_air_altitudes_that_make_no_difference_are_still_ways_to_observe() {
    let desk = Desk::new();
    for file in ["fires.geojson", "airfields.geojson"] {
        desk.write(file, &std::fs::read_to_string(format!("{}/{file}", mission("western-states"))).unwrap());
    }
    let text = std::fs::read_to_string(format!("{}/mission.pdl", mission("western-states"))).unwrap();
    let calm: Vec<&str> = text
        .lines()
        .filter(|line| {
            [":airspace", ":forecast", ":weather", ":people", ":scenario"].iter().all(|key| !line.contains(key))
        })
        .collect();
    desk.write("mission.pdl", &calm.join("\n"));
    let answer = json(&desk.apex(&["plan", ".", "--budget", "20ms", "--json"]).well().out);
    assert!(answer["plan"]["SingleVisit"]["visits"].as_array().unwrap().len() > 8, "{}", answer["plan"]);
    // Each fire's lines are joined in their direction; the air is still here, so turns have a radius of 3.4 km.
    let turns = &answer["turns"];
    assert!((turns["radius_m"].as_f64().unwrap() - 3_378.2).abs() < 1.0 && turns["time_s"].as_f64().unwrap() > 300.0);
}
