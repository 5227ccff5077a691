//! Vehicle files: the shipped ones are valid, and every mistake is reported with its field.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, reason = "a failed test should stop")]

use apex_vehicle::{Airframe, SHIPPED, ShippedVehicle, VehicleFileError, VehicleModel};

fn text(name: &str) -> String {
    ShippedVehicle::find(name).unwrap().text.to_owned()
}

/// The error of a shipped file in which `from`, which occurs once, is replaced by `to`.
#[track_caller]
fn error(name: &str, from: &str, to: &str) -> VehicleFileError {
    let text = text(name);
    assert_eq!(text.matches(from).count(), 1, "{from}");
    VehicleModel::parse("my-uav.json", &text.replace(from, to)).expect_err(to)
}

#[track_caller]
fn rejects(name: &str, from: &str, to: &str, path: &str, expected: &str) {
    let error = error(name, from, to);
    assert_eq!(error.path, path, "{error}");
    assert!(error.to_string().contains(expected), "{error}");
    assert!(error.to_string().starts_with("vehicle file `my-uav.json`"), "{error}");
}

#[test]
fn every_file_of_the_library_ships_under_its_name() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../library/vehicles");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut files: Vec<String> = entries.map(|name| format!("library/vehicles/{name}")).collect();
    files.sort();
    let shipped: Vec<&str> = SHIPPED.iter().map(|shipped| shipped.file).collect();
    assert_eq!(files, shipped);
    for shipped in SHIPPED {
        assert_eq!(VehicleModel::parse(shipped.file, shipped.text).unwrap().name, shipped.name);
    }
}

#[test]
fn figures_are_those_of_the_file() {
    let predator = VehicleModel::named("Predator-B").unwrap();
    assert_eq!(predator.airframe, Airframe::FixedWing);
    assert_eq!((predator.level_roll_deg_max, predator.fuel.share), (3.0, [0.55, 0.0, 0.45]));
    assert_eq!(predator.scanner.unwrap().heights_m, [4_500.0, 5_500.0, 6_500.0, 7_500.0, 9_000.0]);
    let rmax = VehicleModel::named("rmax").unwrap();
    assert_eq!((rmax.airframe, rmax.scanner, rmax.cameras[0].tilt_deg_min), (Airframe::Rotorcraft, None, -90.0));
}

#[test]
fn an_unknown_model_is_answered_with_the_known_ones() {
    let message = VehicleModel::named("predator").unwrap_err();
    assert_eq!(message, "unknown vehicle model `predator`; did you mean `predator-b`? (known: predator-b, rmax)");
    assert!(!VehicleModel::named("concorde").unwrap_err().contains("mean"));
}

#[test]
fn a_text_that_is_not_json_is_reported_with_line_and_column() {
    rejects("rmax", "\"format\":", "\"format\"", "", "at line 2 column");
    let empty = VehicleModel::parse("my-uav.json", "[]").unwrap_err();
    assert_eq!((empty.expected.as_str(), empty.found.as_str()), ("an object", "a list of 0"));
}

#[test]
fn members_that_are_unknown_missing_or_repeated_are_named() {
    rejects("rmax", "\"ceiling_m\":", "\"cieling_m\":", "flight.cieling_m", "did you mean `ceiling_m`?");
    rejects("rmax", "\"planning\":", "\"plumage\":", "plumage", "known are format, name");
    rejects("rmax", "\"slew_rate_deg_s\": 30.0,", "", "cameras[0].slew_rate_deg_s", "found nothing");
    rejects("rmax", "\"report\": {", "\"report\": {\"cruise_s\": 5,", "report.cruise_s", "the member twice");
    rejects("rmax", "apex-vehicle-1", "apex-vehicle-9", "format", "expected \"apex-vehicle-1\"");
    rejects("rmax", "\"rotorcraft\"", "\"rotor-craft\"", "airframe", "did you mean \"rotorcraft\"?");
    rejects("rmax", "\"power_up_s\": 10.0", "\"power_up_s\": \"10 s\"", "cameras[0].power_up_s", "the text \"10 s\"");
    rejects("rmax", "[1.0, -0.35, 0.2]", "[1.0, 0.2]", "fuel.share", "three numbers");
}

#[test]
fn a_figure_without_a_source_is_refused() {
    rejects(
        "rmax",
        "\"value\": 12.0, \"source\": \"simulation assumption\"",
        "\"value\": 12.0",
        "flight.true_airspeed_m_s_cruise",
        "without a source",
    );
    let bare = "{\"value\": 12.0, \"source\": \"simulation assumption\"}";
    rejects("rmax", bare, "12.0", "flight.true_airspeed_m_s_cruise", "12 without a source");
    rejects(
        "rmax",
        "\"report\": {\n    \"source\": \"simulation assumption\"",
        "\"report\": {\n    \"source\": \" \"",
        "report.source",
        "not blank",
    );
}

#[test]
fn figures_that_cannot_be_are_named_with_their_rule() {
    rejects("rmax", "\"value\": 12.0,", "\"value\": -12.0,", "flight.true_airspeed_m_s_cruise", "greater than zero");
    rejects(
        "rmax",
        "\"value\": 2500.0, \"source\": \"simulation assumption\"}",
        "\"value\": 0, \"source\": \"none\"}",
        "flight.ceiling_m",
        "found 0",
    );
    rejects(
        "predator-b",
        "\"value\": 18.0, \"source\": \"premise",
        "\"value\": 90, \"source\": \"premise",
        "flight.bank_deg_max",
        "at most 80",
    );
    rejects(
        "predator-b",
        "\"value\": 44.0",
        "\"value\": 96.0",
        "flight.indicated_airspeed_m_s_min",
        "at most `flight.true_airspeed_m_s_cruise`, 95.2, found 96",
    );
    rejects(
        "predator-b",
        "\"value\": 118.3",
        "\"value\": 90",
        "flight.true_airspeed_m_s_cruise",
        "true_airspeed_m_s_max",
    );
    rejects("predator-b", "\"value\": 0.08", "\"value\": 1.0", "planning.reserve_share", "from 0 to 0.9");
    rejects("predator-b", "\"value\": 7000.0", "\"value\": 20000", "planning.cruise_altitude_m", "`flight.ceiling_m`");
    rejects("predator-b", "[4500.0, 5500.0,", "[5500.0, 4500.0,", "scanner.heights_m", "rising order");
    rejects("predator-b", "\"value\": 120.0", "\"value\": 2000", "fuel.low_kg", "fuel.capacity_kg");
    rejects("predator-b", "[0.55, 0.0, 0.45]", "[0.55, 0.0, -0.55]", "fuel.share", "greater than zero");
    rejects("rmax", "\"value\": 8.2", "\"value\": 1.2e-5", "fuel.low_kg", "fuel.capacity_kg");
    rejects(
        "rmax",
        "\"value\": 10.0, \"source\": \"premise",
        "\"value\": -90, \"source\": \"premise",
        "cameras[0].tilt_deg_min",
        "less than `tilt_deg_max`",
    );
}

#[test]
fn figures_of_the_other_airframe_are_refused() {
    let braking = "\"braking_share\": {\"value\": 0.6, \"source\": \"x\"}, \"glide_ratio\"";
    rejects("predator-b", "\"glide_ratio\"", braking, "flight.braking_share", "nothing for a fixed wing");
    let slowest = "\"final_approach_m\": {\"value\": 9, \"source\": \"x\"}, \"glide_ratio\"";
    rejects("rmax", "\"glide_ratio\"", slowest, "flight.final_approach_m", "nothing for a rotorcraft");
}

#[test]
fn a_model_changed_in_memory_is_checked_like_a_file() {
    let mut model = VehicleModel::named("rmax").unwrap();
    model.fuel.capacity_kg = f64::NAN;
    assert_eq!(model.validate("rmax").unwrap_err().path, "fuel.capacity_kg");
    let mut model = VehicleModel::named("rmax").unwrap();
    model.cameras.push(model.cameras[0].clone());
    assert_eq!(model.validate("rmax").unwrap_err().path, "cameras[1].name");
}
