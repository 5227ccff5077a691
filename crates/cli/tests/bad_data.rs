//! Missions with invalid data: every message states failure, place, reason and remedy; nothing is flown, and no file is left.

mod common;

use common::{Desk, Said};

/// Flies the mission in `m`, which must not work, and must leave no record.
#[track_caller]
fn refused(desk: &Desk, phrases: &[&str]) -> Said {
    let said = desk.apex(&["fly", "m", "--no-progress", "--record", "r.apex"]).complained(2, phrases);
    assert_eq!(desk.names(), ["m"], "nothing is left behind");
    said
}

/// Requires that `first-picture` with one change is refused with these phrases.
#[track_caller]
fn picture(file: &str, from: &str, to: &str, phrases: &[&str]) {
    let desk = Desk::with_mission("first-picture");
    desk.change(&format!("m/{file}"), from, to);
    refused(&desk, phrases);
}

/// Requires that `plain-watch` with one change is refused with these phrases.
#[track_caller]
fn watch(file: &str, from: &str, to: &str, phrases: &[&str]) {
    let desk = Desk::with_mission("plain-watch");
    desk.change(&format!("m/{file}"), from, to);
    refused(&desk, phrases);
}

const SPOT: &str = "[-122.0535, 37.4155]";

#[test]
fn impossible_coordinates_are_named_with_file_and_feature() {
    let feature = "targets.geojson: feature 1 `hangar-1`: impossible coordinates";
    picture("targets.geojson", SPOT, "[37.4155, -122.0535]", &[feature, "longitude first", "seem to be exchanged"]);
    picture("targets.geojson", SPOT, "[-222.0535, 37.4155]", &[feature, "longitude -222.0535", "between -180 and 180"]);
    picture("targets.geojson", SPOT, "[-122.0535, 97.4155]", &[feature, "latitude 97.4155", "between -90 and 90"]);
    picture(
        "targets.geojson",
        SPOT,
        "[-122.0535, 90]",
        &["`hangar-1`: latitude 90 is too near to a pole", "below 88 degrees"],
    );
    picture("targets.geojson", SPOT, "[-122.0535]", &["targets.geojson"]);
    picture("targets.geojson", SPOT, "[\"west\", 37.4155]", &["targets.geojson is not GeoJSON", "line 5 column"]);
    picture(
        "mission.pdl",
        ":at (37.4150 -122.0480)",
        ":at (97.4150 -122.0480)",
        &[
            "m/mission.pdl:6:3: the vehicle's start `:at (97.415 -122.048)` is not a place",
            "(LATITUDE LONGITUDE)",
            "hangar-1",
        ],
    );
}

#[test]
fn targets_that_are_not_targets_are_named() {
    let name = "targets.geojson: feature 1 `hangar-1`: ";
    let height = "\"height_m\": 60";
    picture("targets.geojson", height, "\"height_m\": \"tall\"", &[name, "`height_m` is \"tall\", not a number"]);
    picture(
        "targets.geojson",
        height,
        "\"height_m\": -3",
        &[name, "`height_m` is -3, which is not between 0 and 9000"],
    );
    picture("targets.geojson", "\"target\"", "\"castle\"", &[name, "unknown `kind`: `castle`", "known are fire,"]);
    let id = "\"id\": \"wind-tunnel\"";
    picture(
        "targets.geojson",
        id,
        "\"id\": \"hangar-1\"",
        &["two features have the id `hangar-1`", "feature 2", "the other one is m/targets.geojson: feature 1"],
    );
    for wrong in ["Wind tunnel", "wind\\u0000tunnel", "wind)tunnel"] {
        picture(
            "targets.geojson",
            id,
            &format!("\"id\": \"{wrong}\""),
            &["the id \"", "contains '", "help: write letters"],
        );
    }
    picture("targets.geojson", "\"Point\"", "\"LineString\"", &["targets.geojson"]);
    picture("targets.geojson", "FeatureCollection", "FeatureCollectoin", &["targets.geojson is not GeoJSON"]);
    let desk = Desk::with_mission("first-picture");
    desk.write("m/targets.geojson", "");
    refused(&desk, &["targets.geojson is not GeoJSON", "line 1 column 0", "help: export it"]);
    desk.write("m/targets.geojson", "{\"type\": \"FeatureCollection\", \"features\": []}");
    refused(&desk, &["targets.geojson holds no features"]);
}

#[test]
fn missing_data_are_reported_with_the_text_that_names_them_and_near_names() {
    let desk = Desk::with_mission("first-picture");
    desk.change("m/mission.pdl", "\"targets.geojson\"", "\"target.geojson\"");
    refused(
        &desk,
        &[
            "cannot read m/target.geojson",
            "m/mission.pdl:8:3 names it as `:targets \"target.geojson\"`",
            "help: m holds targets.geojson",
        ],
    );
}

#[test]
fn tables_are_read_strictly() {
    let file = "winds.csv";
    watch(
        file,
        "wind_speed_mps",
        "speed",
        &["m/winds.csv: missing columns: wind_speed_mps", "why: the first line names"],
    );
    watch(file, "south_deg", "south", &["m/winds.csv: unknown column `south`", "known are altitude_m_min"]);
    watch(file, "south_deg", "edr", &["m/winds.csv: the column `edr` is named twice", "have this name"]);
    watch(file, "300,3,0.05", "300,fast,0.05", &["m/winds.csv:2: `wind_speed_mps` is `fast`, not a number"]);
    watch(file, "300,3,0.05", "300,,0.05", &["m/winds.csv:2: `wind_speed_mps` is empty"]);
    watch(file, "300,3,0.05", "300,NaN,0.05", &["m/winds.csv:2: `wind_speed_mps` is NaN", "between 0 and 150"]);
    watch(file, "300,4.5,0.04", "400,4.5,0.04", &["m/winds.csv:3: `wind_from_deg` is 400", "between 0 and 360"]);
    watch(
        file,
        "300,3,0.05",
        "300,3,0.05,7",
        &["m/winds.csv:2 has ", " cells, the first line of the table ", "help: "],
    );
    watch(file, ",,,,0,200", "1,,,,0,200", &["m/winds.csv:2: an area needs all four edges"]);
    watch(file, ",,,,0,200", ",,,,300,200", &["m/winds.csv:2: the layer's upper face is not above its lower face"]);
    let desk = Desk::with_mission("plain-watch");
    desk.write("m/winds.csv", "");
    refused(&desk, &["m/winds.csv: missing columns: altitude_m_min"]);
}

#[test]
fn sites_and_zones_are_checked_like_targets() {
    let rate = "\"rate_per_h\": 0.06";
    watch("sites.geojson", rate, "\"rate_per_h\": -1", &["feature 2 `farmhouse`: `rate_per_h` is -1"]);
    let rates =
        |text: &str, phrases: &[&str]| watch("sites.geojson", rate, &format!("\"rates_per_h\": {text}"), phrases);
    rates("[]", &["feature 2 `farmhouse`: `rates_per_h` is empty", "help: write hours with events per hour"]);
    rates("[[0, -1]]", &["`rates_per_h` has [0, -1]; rates are between"]);
    rates("[[1, 2], [1, 3]]", &["`rates_per_h` has 1 h after 1 h; hours rise"]);
    rates("[[1, 2]], \"rate_per_h\": 3", &["`rate_per_h` and `rates_per_h` both state the rate"]);
    watch("sites.geojson", "\"saturating\"", "\"cheap\"", &["`farmhouse`", "unknown `cost`: `cheap`", "logistic"]);
    watch("obstacles.geojson", "\"Polygon\"", "\"Circle\"", &["m/obstacles.geojson is not GeoJSON", "why: "]);
}

#[test]
fn scripted_events_are_checked_before_the_flight() {
    let event = "{\"t\": 40, \"event\"";
    picture(
        "scenario.jsonl",
        event,
        "{\"t\": 40, \"evnt\"",
        &["m/scenario.jsonl:2: expected exactly one of", "help: "],
    );
    picture("scenario.jsonl", event, "{\"t\": 40, event", &["m/scenario.jsonl:2:11: this is not JSON"]);
    picture("scenario.jsonl", event, "{\"t\": \"soon\", \"event\"", &["m/scenario.jsonl:2: \"t\" is \"soon\""]);
    picture("scenario.jsonl", "camera-1)", "camera-1", &["m/scenario.jsonl:2: \"event\" cannot be read"]);
}

#[test]
fn options_of_the_application_are_reported_with_their_place() {
    let (vehicle, duration, targets) = ("m/mission.pdl:6:3: ", "m/mission.pdl:7:3: ", "m/mission.pdl:8:3: ");
    let change = |from: &str, to: &str, phrases: &[&str]| picture("mission.pdl", from, to, phrases);
    change(
        ":duration",
        ":duratoin",
        &["m/mission.pdl:7:3", "no option `:duratoin`", "replace `:duratoin` by `:duration`"],
    );
    change(":duration", ":how-long", &[duration, "unknown option :how-long", "known are :vehicle"]);
    change("15min", "15m", &["m/mission.pdl:7:13", "a duration is needed here, but this is length"]);
    change("15min", "-15min", &[duration, "`:duration", "cannot be read"]);
    change(":duration 15min", ":seed pi", &[duration, "`:seed pi` cannot be read", "whole number"]);
    change(":duration 15min", ":start \"noon\"", &[duration, "`:start \"noon\"` cannot be read", "2007-09-08"]);
    change("\"targets.geojson\"", "targets", &[targets, "`:targets targets` cannot be read", "a string"]);
    change("(sim :model rmax", "(mavlink :model rmax", &[vehicle, "unknown kind of vehicle `mavlink`", "`sim`"]);
    change(
        ":model rmax",
        ":model concorde",
        &[vehicle, "unknown", "`concorde`", "fixed-wing-mapper, global-hawk, predator-b, quadrotor, rmax"],
    );
    change(":at (37.4150 -122.0480))", ":at moffett)", &[vehicle, "`:at moffett` is not a place", "wind-tunnel"]);
    change(":at (37.4150 -122.0480))", ")", &[vehicle, ":vehicle", "(sim :model NAME :at PLACE)"]);
    change(
        ":vehicle (sim :model rmax :at (37.4150 -122.0480))",
        "",
        &["m/mission.pdl:3:1: ", "names no vehicle", "`apex run`"],
    );
}

#[test]
fn figures_of_the_application_are_checked() {
    let place = "m/mission.pdl:7:19: ";
    let add = |option: &str, phrases: &[&str]| {
        picture("mission.pdl", ":duration 15min", &format!(":duration 15min {option}"), phrases);
    };
    add(":end-margin 15min", &[place, "`:end-margin P15M` cannot be read", "shorter than `:duration`"]);
    add(":end-margin 3m", &["a duration is needed here, but this is length"]);
    add(":zone-margin -3km", &[place, "`:zone-margin", "`:zone-margin 3km`"]);
    add(":obstacle-margin 3s", &[place, "`:obstacle-margin", "a length up to 1000km"]);
    add(":failure 3", &[place, "`:failure 3` cannot be read", "a list of keys", ":probability-per-hour 1e-4"]);
    add(":failure (:vehicle-cots 3)", &[place, "unknown key :vehicle-cots"]);
    add(":failure (:vehicle-share 1.5)", &[place, ":vehicle-share is 1.5; expected a number from 0 to 1"]);
    add(":failure (:mission-cost 3m)", &[place, ":mission-cost is 3m; expected a number"]);
    add(":failure (:mission-cost 3 :mission-cost 4)", &[place, ":mission-cost is given twice"]);
    add(":failure (:mission-cost)", &[place, "expected keys, each with a number"]);
}

/// Returns `structure-watch` with another outline of the radio mast.
#[track_caller]
fn mast(outline: &str, phrases: &[&str]) {
    let square = "[[[-121.1005, 37.4095], [-121.0982, 37.4095], [-121.0982, 37.4113], [-121.1005, 37.4113], [-121.1005, 37.4095]]]";
    let place = "obstacles.geojson: feature 1 `radio-mast`: ";
    watch("obstacles.geojson", square, outline, &[&[place], phrases].concat());
}

#[test]
fn outlines_of_airspace_that_are_impossible_are_reported_with_their_corners() {
    mast(
        "[[[-121.1005, 37.4095], [-121.0982, 37.4113], [-121.0982, 37.4095], [-121.1005, 37.4113], [-121.1005, 37.4095]]]",
        &["a ring crosses itself: the edges after its positions 1 and 3 cross", "in order"],
    );
    mast("[[[-121.1, 37.4], [-121.0, 37.5], [-121.1, 37.4]]]", &["a ring has 2 corners", "three or more"]);
    mast(
        "[[[-121.1, 37.4], [-121.1, 37.5], [-121.1, 37.6], [-121.1, 37.4]]]",
        &["its polygon encloses no area", "three or more corners around an area"],
    );
    let inner = "[[-121.0995, 37.41], [-121.099, 37.41], [-121.099, 37.4105], [-121.0995, 37.41]]";
    let outer = "[[-121.1005, 37.4095], [-121.0982, 37.4095], [-121.0982, 37.4113], [-121.1005, 37.4095]]";
    mast(&format!("[{outer}, {inner}]"), &["airspace with a hole", "without holes"]);
    let band = "\"altitude_m_max\": 215";
    let reversed = format!("{band}, \"active_h\": [[5, 2]]");
    watch("obstacles.geojson", band, &reversed, &["`radio-mast`", "the span [5, 2] ends before it begins"]);
}

#[test]
fn a_start_and_a_target_inside_an_obstacle_are_reported() {
    let desk = Desk::with_mission("plain-watch");
    let mast =
        "[-121.1005, 37.4095], [-121.0982, 37.4095], [-121.0982, 37.4113], [-121.1005, 37.4113], [-121.1005, 37.4095]";
    // Around the farm house, at (37.41671 -121.10048).
    let farm = "[-121.102, 37.416], [-121.099, 37.416], [-121.099, 37.4175], [-121.102, 37.4175], [-121.102, 37.416]";
    desk.change("m/obstacles.geojson", mast, farm);
    desk.apex(&["plan", "m", "--budget", "50ms"]).well().told(&["farmhouse", "inside restricted area Radio mast"]);
    let desk = Desk::with_mission("plain-watch");
    let pad = "[-121.106, 37.404], [-121.104, 37.404], [-121.104, 37.406], [-121.106, 37.406], [-121.106, 37.404]";
    desk.change("m/obstacles.geojson", mast, pad);
    desk.apex(&["plan", "m"])
        .complained(2, &["the requirement `airspace` cannot be met from the start", "restricted zone `Radio mast`"]);
}

/// A sign or an order of coordinates that is wrong moves a zone to the other side of the Earth: that is doubted, and shuts no way.
#[test]
fn a_zone_on_the_other_side_of_the_earth_is_doubted_and_shuts_no_way() {
    let desk = Desk::with_mission("western-states");
    let outline = "[-117.93, 35.68], [-117.45, 35.68], [-117.42, 36.14], [-117.88, 36.2], [-117.93, 35.68]";
    desk.change("m/airspace.geojson", outline, &outline.replace("-117", "117"));
    desk.apex(&["check", "m"]).well().told(&[
        "zone R-2505 China Lake is",
        "from the start and from every target",
        "check the order and the signs of its coordinates",
    ]);
}

/// A landing distance of 120 m, meant in nautical miles, kept an aircraft in the air for hours: it cannot circle within that.
#[test]
fn a_landing_distance_in_which_the_vehicle_cannot_circle_is_refused() {
    let desk = Desk::with_mission("western-states");
    desk.change("m/mission.pdl", ":landing-distance 220nm", ":landing-distance 120");
    desk.apex(&["plan", "m", "--budget", "50ms"]).complained(
        2,
        &[
            "m/mission.pdl:17:3: the requirement `landing-distance` cannot be met from the start",
            "predator-b needs",
            "to circle at the landing place",
        ],
    );
}

#[test]
fn what_is_not_a_mission_is_distinguished() {
    let desk = Desk::with_greetings();
    for command in ["fly", "plan"] {
        desk.apex(&[command, "greetings.pdl"]).complained(2, &["no (defapplication ..)", "apex run"]);
    }
    desk.apex(&["fly", "nowhere"]).complained(2, &["cannot read nowhere", "why: "]);
    desk.apex(&["plan", "nowhere"])
        .complained(2, &["there is no mission, file or test mission called nowhere", "why: "]);
    assert_eq!(desk.names(), ["go.jsonl", "greetings.pdl"]);
    picture("mission.pdl", "(step up", "(step up (", &["error[", "m/mission.pdl:", "fix: "]);
}

#[test]
fn a_check_reads_the_data_of_the_mission() {
    let desk = Desk::with_mission("first-picture");
    let good = desk.apex(&["check", "m"]).well();
    assert!(!good.out.contains("in the data"), "{}", good.out);
    desk.change("m/targets.geojson", SPOT, "[37.4155, -122.0535]");
    let said = desk.apex(&["check", "m"]);
    assert_eq!(said.code, Some(2), "{said:?}");
    let said = said.told(&[
        "error: m/targets.geojson: feature 1 `hangar-1`: impossible coordinates",
        "0 errors, 0 warnings",
        "1 error in the data of the mission",
    ]);
    assert_eq!(said.err, "");
    let lines = desk.apex(&["check", "m", "--json"]).json_lines();
    let error = lines.iter().find(|line| line["severity"] == "error").unwrap();
    assert!(error["file"].as_str().unwrap().contains("targets.geojson"), "{error}");
    assert!(!error["help"].as_array().unwrap().is_empty(), "{error}");
    // A fragment has no data.
    desk.apex(&["check", "m", "--fragment"]).well();
}

#[test]
fn a_check_reads_the_world_file_of_the_mission() {
    let desk = Desk::with_mission("plain-watch");
    desk.change("m/mission.pdl", "  :duration 1h\n", "  :duration 1h\n  :world \"world.json\"\n");
    desk.write("m/world.json", r#"{"format": "apex-world-1", "faults": [{"fault": "engine", "at_s": 60}]}"#);
    desk.apex(&["check", "m"]).well();
    desk.write("m/world.json", r#"{"format": "apex-world-1", "faults": [{"fault": "engine"}]}"#);
    let said = desk.apex(&["check", "m"]);
    assert_eq!(said.code, Some(2), "{said:?}");
    said.told(&["m/world.json is not a world of this mission", "`rate_per_h`", "1 error in the data of the mission"]);
    desk.write("m/world.json", "{\n  \"fautls\": []\n}");
    desk.apex(&["check", "m"]).told(&["m/world.json:2:", "unknown field `fautls`"]);
}

/// Feet for metres, and a height above ground for an altitude.
#[test]
fn altitudes_of_take_offs_lie_between_start_and_ceiling() {
    for altitude in ["130000m", "-20m"] {
        let desk = Desk::with_mission("first-picture");
        desk.change("m/mission.pdl", "take off to 40m", &format!("take off to {altitude}"));
        let expected =
            ["is not possible", "m/mission.pdl:21", "the start is at", "the ceiling of", "above mean sea level"];
        desk.apex(&["check", "m"]).complained(2, &[]).told(&expected);
    }
}

/// The sign of a longitude: the target lies in China.
#[test]
fn targets_that_the_vehicle_cannot_reach_are_doubted() {
    let desk = Desk::with_mission("first-picture");
    desk.change("m/targets.geojson", SPOT, "[122.0535, 37.4155]");
    let doubt =
        ["warning: target hangar-1 is 9", " km from the start, and the vehicle flies ", "the signs of its coordinates"];
    desk.apex(&["check", "m"]).told(&doubt);
}

/// Properties with another unit, case or order of parts have no effect, and neither have messages about targets that do not exist.
#[test]
fn properties_and_messages_without_effect_that_resemble_others_are_doubted() {
    let desk = Desk::with_mission("western-states");
    desk.change("m/fires.geojson", "\"resolution_m\"", "\"resolution\"");
    desk.change("m/airspace.geojson", "\"altitude_m_max\"", "\"altitude_max_m\"");
    let events = [
        (10_800, "(target-gone domke)"),
        (10_801, "(target-gone domke)"),
        (10_802, "(target-gon domke-lake)"),
        (10_803, "(new-target domke-lakes)"),
        (10_804, "(new-value domke-lake)"),
        (600_001, "(stop)"),
        (600_000, "(go)"),
    ];
    let line = |(t, event): &(u32, &str)| format!("{{\"t\": {t}, \"event\": \"{event}\"}}\n");
    std::fs::write(desk.path("m/scenario.jsonl"), events.iter().map(line).collect::<String>()).unwrap();
    let said = desk.apex(&["check", "m"]).well().told(&[
        "fires.geojson: the property `resolution` of ",
        "has no effect: did you mean `resolution_m`?",
        "airspace.geojson: the property `altitude_max_m` of ",
        "did you mean `altitude_m_max`?",
        "scenario.jsonl: `(target-gone domke)` at 3:00:00: domke is not a target of this mission\n",
        "scenario.jsonl: `(target-gon domke-lake)` at 3:00:02: did you mean `target-gone`?",
        "`(new-target domke-lakes)` at 3:00:03: domke-lakes is not a target of this mission; did you mean `domke-lake`?",
        "`(new-value domke-lake)` at 3:00:04: (new-value domke-lake ..) has no number from 0 to",
        "scenario.jsonl: 2 inputs come after the end of the mission, at ",
        "; the first of them at 166:40:00",
    ]);
    assert_eq!(said.out.matches("(target-gone domke)").count(), 1, "a repeated message is reported once");
    // The names of looks are names of targets, and a property without a value is none.
    let looks = Desk::with_mission("day-and-night");
    let fires: serde_json::Value = serde_json::from_str(&looks.read("m/fires.geojson")).unwrap();
    let with_looks = fires["features"].as_array().unwrap().iter().find(|fire| fire["properties"]["looks"].is_array());
    let properties = &with_looks.expect("a fire with looks")["properties"];
    let name = format!("{}/{}", properties["id"].as_str().unwrap(), properties["looks"][0]["id"].as_str().unwrap());
    std::fs::write(looks.path("m/more.jsonl"), line(&(60, &format!("(new-value {name} 5)")))).unwrap();
    looks.change("m/mission.pdl", ":duration 21h", ":duration 21h\n  :scenario \"more.jsonl\"");
    looks.change("m/fires.geojson", "\"properties\": {", "\"properties\": {\"resolution\": null, ");
    assert!(!looks.apex(&["check", "m"]).well().out.contains("warning: "));
    let unchanged = Desk::with_mission("western-states");
    let checked = unchanged.apex(&["check", "m"]).well();
    assert!(!checked.out.contains("did you mean") && !checked.err.contains("did you mean"), "{checked:?}");
}

/// A mission shorter than the usual end margin of an hour is planned, with half of its duration as the margin.
#[test]
fn a_short_mission_has_a_shorter_end_margin() {
    let desk = Desk::with_mission("stand-off");
    desk.change("m/mission.pdl", "  :end-margin 5min\n", "");
    desk.apex(&["plan", "m", "--budget", "200ms"]).well();
}

/// A goal of data acquisition is read by the check, and not first in flight.
#[test]
fn an_acquisition_goal_without_a_unit_is_refused_by_the_check() {
    let desk = Desk::with_mission("stand-off");
    desk.change("m/mission.pdl", "(acquire ?place :product stills :resolution 10cm", "(acquire plume :resolution 0.1");
    desk.apex(&["check", "m"]).complained(2, &[]).told(&[
        "m/mission.pdl:27",
        "cannot be pursued",
        "`:resolution` of the goal",
        "a length for one pixel",
    ]);
}

/// In a wind that is as fast as the vehicle, plans find no ways; the check says why.
#[test]
fn a_forecast_wind_against_which_the_vehicle_does_not_advance_is_doubted() {
    let desk = Desk::with_mission("western-states");
    let winds = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps\n0,1000,270,5\n1000,8000,270,120\n";
    std::fs::write(desk.path("m/strong.csv"), winds).unwrap();
    let program = desk.read("m/mission.pdl");
    let line = program.lines().find(|line| line.trim_start().starts_with(":forecast")).unwrap();
    desk.change("m/mission.pdl", line, "  :forecast \"strong.csv\"");
    desk.apex(&["check", "m"])
        .told(&["warning: the forecast wind over ", " is 120.0 m/s, and `predator-b` cruises at "]);
}
