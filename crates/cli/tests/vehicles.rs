//! A mission with a user-defined vehicle file: flown, planned with, visible to PDL, stored in the record, and rejected with the name of
//! the wrong field.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

mod common;

use apex_vehicle::{ShippedSensor, ShippedVehicle};
use common::Desk;

/// Returns a shipped mission whose model `name` is replaced by the file `my-uav.json`, a copy of that model with one change.
fn desk(mission: &str, name: &str, from: &str, to: &str) -> Desk {
    let text = ShippedVehicle::find(name).unwrap().text;
    assert_eq!(text.matches(from).count(), 1, "{from}");
    let desk = Desk::with_mission(mission);
    desk.write("m/my-uav.json", &text.replace(from, to));
    desk.change("m/mission.pdl", &format!(":model {name}"), ":model \"my-uav.json\"");
    desk
}

fn trace(desk: &Desk) -> String {
    desk.apex(&["fly", "m", "--record", "r.apex", "--no-progress"]).well();
    desk.apex(&["trace", "r.apex"]).well().out
}

#[test]
fn a_copy_of_a_shipped_file_flies_like_the_shipped_model() {
    let shipped = Desk::with_mission("first-picture");
    let same = "\"airframe\": \"rotorcraft\"";
    let copied = trace(&desk("first-picture", "rmax", same, same));
    assert_eq!(trace(&shipped), copied);
    let slower = desk("first-picture", "rmax", "\"climb_penalty\": 0.3", "\"climb_penalty\": 0.9");
    assert_ne!(trace(&slower), copied, "the file decides");
    slower.apex(&["replay", "r.apex"]).well();
}

#[test]
fn the_record_holds_the_vehicle_file() {
    let own = desk("first-picture", "rmax", "\"note\": \"A helicopter", "\"note\": \"OUR OWN helicopter");
    trace(&own);
    let holds = |name: &str, words: &str| {
        let bytes = std::fs::read(own.path(name)).unwrap();
        bytes.windows(words.len()).any(|window| window == words.as_bytes())
    };
    assert!(holds("r.apex", "OUR OWN helicopter"));
    own.change("m/mission.pdl", "\"my-uav.json\"", "rmax");
    trace(&own);
    assert!(holds("r.apex", "library/vehicles/rmax.json"));
}

#[test]
fn programs_read_the_figures_of_the_missions_vehicle() {
    let own = desk(
        "western-states",
        "predator-b",
        "\"level_roll_deg_max\": {\"value\": 3.0",
        "\"level_roll_deg_max\": {\"value\": 2.5",
    );
    own.change(
        "m/mission.pdl",
        "(index (fly the mission))",
        "(index (fly the mission))\n  (step say (print +max-roll-angle-deviation+ +vehicle-ceiling+))",
    );
    own.apex(&["fly", "m", "--record", "r.apex", "--no-progress", "--until", "1s"]).well();
    own.apex(&["trace", "r.apex"]).well().told(&["2.5deg 15240m"]);
    // The record's own text of the figures, without the mission's folder.
    std::fs::remove_dir_all(own.path("m")).unwrap();
    own.apex(&["replay", "r.apex"]).well();
}

#[test]
fn plans_follow_the_vehicle_file_and_the_application() {
    let problem = |desk: &Desk| -> serde_json::Value {
        let printed = desk.apex(&["plan", "m", "--problem"]).well();
        serde_json::from_str::<serde_json::Value>(&printed.out).unwrap()["SingleVisit"].take()
    };
    let shipped = problem(&Desk::with_mission("western-states"));
    // The descent from 7,000 m to Edwards at 702 m, at half of 10 m/s, comes after the plan.
    let descent_s = 6_298.0 / 5.0;
    assert_eq!(shipped["end_s"], 82_800.0 - descent_s);
    assert_eq!((&shipped["zone_margin_m"], &shipped["failure"]["vehicle_cost"]), (&3_000.0.into(), &400.0.into()));
    let own = desk(
        "western-states",
        "predator-b",
        "\"duration_min\": {\"value\": 45.0",
        "\"duration_min\": {\"value\": 90.0",
    );
    own.change("m/mission.pdl", ":duration 24h", ":duration 24h :end-margin 2h :zone-margin 5km");
    own.change("m/mission.pdl", ":vehicle-cost 400", ":vehicle-cost 900");
    let changed = problem(&own);
    // The reserve at the landing is 45 and 90 minutes at 23,000 ft; the descent takes less than level flight for its duration.
    let kg = |problem: &serde_json::Value, field: &str| problem["vehicle"][field].as_f64().unwrap();
    let reserve_kg = kg(&changed, "fuel_reserve_kg") - kg(&shipped, "fuel_reserve_kg");
    // The climb takes 0.6 of the level flow in addition, at the fastest rate of 8 m/s; flying low takes more.
    let flow_kg_per_s = kg(&shipped, "fuel_flow_kg_per_s");
    let climb_kg = 0.6 * flow_kg_per_s * 6_298.0 / 8.0;
    let descent_kg = kg(&shipped, "fuel_reserve_kg") - reserve_kg - 1.2 * climb_kg;
    let level_kg = descent_s * flow_kg_per_s;
    assert!((reserve_kg - 48.0).abs() < 0.1, "{reserve_kg}");
    assert!((0.7 * level_kg..level_kg).contains(&descent_kg), "{descent_kg} of {level_kg}");
    assert_eq!((&changed["end_s"], &changed["zone_margin_m"]), (&(79_200.0 - descent_s).into(), &5_000.0.into()));
    assert_eq!(changed["failure"]["vehicle_cost"], 900.0);
    assert_eq!(changed["failure"]["mission_cost"], 300.0, "the other costs stay");
}

#[test]
fn a_wrong_vehicle_file_is_refused_with_its_field() {
    let refused = |from: &str, to: &str, phrases: &[&str]| {
        let desk = desk("first-picture", "rmax", from, to);
        desk.apex(&["fly", "m", "--no-progress", "--record", "r.apex"]).complained(2, phrases);
        assert_eq!(desk.names(), ["m"], "no record is left behind");
    };
    refused(
        "\"value\": 2500.0, \"source\": \"assumption\"}",
        "\"value\": -1, \"source\": \"none\"}",
        &[
            "vehicle file `m/my-uav.json`: invalid `flight.ceiling_m`",
            "why: expected a number greater than 0 and at most 50000, found -1",
            "help: correct the figure",
        ],
    );
    refused("\"glide_ratio\"", "\"glide_ration\"", &["invalid `flight.glide_ration`", "did you mean `glide_ratio`?"]);
    let missing = Desk::with_mission("first-picture");
    missing.change("m/mission.pdl", ":model rmax", ":model \"their-uav.json\"");
    let said = missing.apex(&["fly", "m", "--no-progress"]).complained(2, &["cannot read m/their-uav.json"]);
    assert!(said.err.contains("names it as `:model \"their-uav.json\"`"), "{}", said.err);
}

/// A mission brings a sensor: its bytes are in the record, and its errors name its file.
#[test]
fn a_vehicle_file_names_sensor_files_next_to_it() {
    let own = desk("first-picture", "rmax", "\"sensor\": \"rmax-camera\"", "\"sensor\": \"eye.json\"");
    let camera = ShippedSensor::find("rmax-camera").unwrap().text.replace("The tilt camera", "OUR OWN tilt camera");
    own.write("m/eye.json", &camera);
    trace(&own);
    let bytes = std::fs::read(own.path("r.apex")).unwrap();
    assert!(bytes.windows(19).any(|window| window == b"OUR OWN tilt camera"));
    own.apex(&["vehicle", "m/my-uav.json"]).well().told(&["camera-1", "rmax-camera (video)"]);
    own.write("m/eye.json", &camera.replace("\"settle_s\": {\"value\": 0.4", "\"settle_s\": {\"value\": -0.4"));
    let phrases = ["sensor file `m/eye.json`: invalid `mount.settle_s`", "not negative, found -0.4"];
    own.apex(&["fly", "m", "--no-progress"]).complained(2, &phrases);
    std::fs::remove_file(own.path("m/eye.json")).unwrap();
    own.apex(&["fly", "m", "--no-progress"]).complained(2, &["`sensors[0].sensor`", "cannot read m/eye.json"]);
    own.apex(&["replay", "r.apex"]).well();
}

#[test]
fn figures_that_follow_from_a_vehicle_are_printed() {
    let desk = Desk::new();
    desk.apex(&["vehicle"]).well().told(&["quadrotor  library/vehicles/quadrotor.json"]);
    let printed = desk.apex(&["vehicle", "predator-b", "quadrotor"]).well();
    printed.told(&[
        "endurance in cruise        1658 min",
        "reserve                    48.02 kg, 45 min of cruise",
        "from 7620 m              pixel 9.525 m below",
        "at 12.5 lines/s          no gaps from 6093 m up",
        "endurance in hover         55 min",
    ]);
    desk.apex(&["vehicle", "quadrotr"]).complained(2, &["did you mean `quadrotor`?"]);
    desk.apex(&["vehicle", "none.json"]).complained(2, &["cannot read none.json"]);
    for path in ["vehicles/rmax.toml", "rmax.toml", "vehicles/rmax"] {
        let names = format!("`{path}` names no vehicle");
        desk.apex(&["vehicle", path]).complained(2, &[&names, "ends in .json", "`apex vehicle` lists them"]);
    }
}

#[test]
fn fires_need_a_scanner_or_a_camera() {
    let text = ShippedVehicle::find("predator-b").unwrap().text;
    let scanner = "{\"name\": \"scanner\", \"sensor\": \"ams-wildfire\", \"mode\": \"1.25 mrad wide\"}";
    let camera = "{\"name\": \"camera-1\", \"sensor\": \"predator-turret\"}";
    assert!(text.contains(scanner) && text.contains(camera));
    let own = Desk::with_mission("western-states");
    own.write("m/my-uav.json", &text.replace(&format!("{scanner},"), "").replace(camera, ""));
    own.change("m/mission.pdl", ":model predator-b", ":model \"my-uav.json\"");
    let said = own.apex(&["plan", "m"]);
    said.complained_of(&["no way to observe it: the vehicle `predator-b` carries no line scanner and no camera"]);
    own.apex(&["check", "m"])
        .told(&["warning: the vehicle `predator-b` carries no line scanner and no camera: it cannot observe"]);
}
