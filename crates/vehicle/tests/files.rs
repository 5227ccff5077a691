//! Vehicle and sensor files: the shipped files are valid, and every mistake is reported with its field.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, reason = "a failed test should stop")]

use apex_vehicle::{
    Airframe, EnergyModel, Optics, Reserve, SHIPPED, SHIPPED_SENSORS, SensorModel, ShippedSensor, ShippedVehicle,
    VehicleFileError, VehicleModel,
};

/// Returns `text` in which `from`, which occurs once, is replaced by `to`.
#[track_caller]
fn changed(text: &str, from: &str, to: &str) -> String {
    assert_eq!(text.matches(from).count(), 1, "{from}");
    text.replace(from, to)
}

#[track_caller]
fn complains(error: &VehicleFileError, file: &str, path: &str, expected: &str) {
    assert_eq!(error.path, path, "{error}");
    assert!(error.to_string().contains(expected), "{error}");
    assert!(error.to_string().starts_with(file), "{error}");
}

#[track_caller]
fn rejects(name: &str, from: &str, to: &str, path: &str, expected: &str) {
    let text = changed(ShippedVehicle::find(name).unwrap().text, from, to);
    let error = VehicleModel::parse("my-uav.json", &text).expect_err(to);
    complains(&error, "vehicle file `my-uav.json`", path, expected);
}

#[track_caller]
fn rejects_sensor(name: &str, from: &str, to: &str, path: &str, expected: &str) {
    let text = changed(ShippedSensor::find(name).unwrap().text, from, to);
    let error = SensorModel::parse("my-camera.json", &text).expect_err(to);
    complains(&error, "sensor file `my-camera.json`", path, expected);
}

/// Returns the names of the files in a folder of the library.
fn files(folder: &str) -> Vec<String> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../library").join(folder);
    let entries = std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut files: Vec<String> = entries.map(|name| format!("library/{folder}/{name}")).collect();
    files.sort();
    files
}

#[test]
fn every_file_of_the_library_ships_under_its_name() {
    assert_eq!(files("vehicles"), SHIPPED.iter().map(|shipped| shipped.file).collect::<Vec<_>>());
    for shipped in SHIPPED {
        let model = VehicleModel::parse(shipped.file, shipped.text).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(model.name, shipped.name);
    }
    assert_eq!(files("sensors"), SHIPPED_SENSORS.iter().map(|shipped| shipped.file).collect::<Vec<_>>());
    for shipped in SHIPPED_SENSORS {
        let model = SensorModel::parse(shipped.file, shipped.text).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(model.name, shipped.name);
    }
}

#[test]
fn figures_are_those_of_the_file() {
    let predator = VehicleModel::named("Predator-B").unwrap();
    assert_eq!(predator.airframe, Airframe::FixedWing);
    let EnergyModel::Fuel(fuel) = &predator.energy else { panic!("fuel") };
    assert_eq!((predator.level_roll_deg_max, fuel.share), (3.0, [0.55, 0.0, 0.45]));
    assert_eq!(predator.scanner.unwrap().pixel_mrad, 1.25);
    assert_eq!((&*predator.cameras[0].name, predator.cameras[0].pan_deg_max), ("camera-1", 180.0));
    let Optics::LineScanner { modes } = &predator.sensors[0].model.optics else { panic!("scanner") };
    let figures: Vec<(f64, f64)> = modes.iter().map(|mode| (mode.pixel_mrad, mode.field_of_view_deg)).collect();
    assert_eq!(figures, [(2.5, 85.9), (1.25, 42.5), (1.25, 86.0)]);
    let rmax = VehicleModel::named("rmax").unwrap();
    assert_eq!((rmax.airframe, rmax.scanner, rmax.cameras[0].tilt_deg_min), (Airframe::Rotorcraft, None, -90.0));
}

#[test]
fn an_unknown_model_is_answered_with_the_known_ones() {
    let message = VehicleModel::named("predator").unwrap_err();
    let known = "fixed-wing-mapper, global-hawk, predator-b, quadrotor, rmax";
    assert_eq!(message, format!("unknown vehicle model `predator`; did you mean `predator-b`? (known: {known})"));
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
    rejects("rmax", "\"cruise_s\": 5.0", "\"note\": \"x\"", "report.cruise_s", "found nothing");
    rejects("rmax", "\"report\": {", "\"report\": {\"cruise_s\": 5,", "report.cruise_s", "the member twice");
    rejects("rmax", "\"rotorcraft\"", "\"rotor-craft\"", "airframe", "did you mean \"rotorcraft\"?");
    rejects("rmax", "\"cruise_s\": 5.0", "\"cruise_s\": \"5 s\"", "report.cruise_s", "the text \"5 s\"");
    rejects("rmax", "apex-vehicle-2", "apex-vehicle-1", "format", "expected \"apex-vehicle-2\"");
    rejects("rmax", "[1.0, -0.35, 0.2]", "[1.0, 0.2]", "fuel.share", "three numbers");
}

#[test]
fn a_figure_without_a_source_is_refused() {
    rejects(
        "rmax",
        "\"value\": 12.0, \"source\": \"assumption\"",
        "\"value\": 12.0",
        "flight.true_airspeed_m_s_cruise",
        "without a source",
    );
    let bare = "{\"value\": 12.0, \"source\": \"assumption\"}";
    rejects("rmax", bare, "12.0", "flight.true_airspeed_m_s_cruise", "12 without a source");
    rejects(
        "rmax",
        "\"report\": {\n    \"source\": \"assumption\"",
        "\"report\": {\n    \"source\": \" \"",
        "report.source",
        "not blank",
    );
}

#[test]
fn figures_that_cannot_be_are_named_with_their_rule() {
    rejects("rmax", "\"value\": 12.0,", "\"value\": -12.0,", "flight.true_airspeed_m_s_cruise", "greater than 0");
    rejects(
        "rmax",
        "\"value\": 2500.0, \"source\": \"assumption\"}",
        "\"value\": 0, \"source\": \"none\"}",
        "flight.ceiling_m",
        "found 0",
    );
    rejects(
        "predator-b",
        "\"value\": 18.0, \"source\": \"premise",
        "\"value\": 90, \"source\": \"premise",
        "flight.bank_deg_max",
        "at most 60",
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
    rejects("predator-b", "\"value\": 7000.0", "\"value\": 20000", "planning.cruise_altitude_m", "`flight.ceiling_m`");
    rejects("predator-b", "\"value\": 15240.0", "\"value\": 1e9", "flight.ceiling_m", "at most 50000");
    rejects("predator-b", "\"value\": 118.3", "\"value\": 2300", "flight.true_airspeed_m_s_max", "at most 1000");
    rejects("predator-b", "[0.55, 0.0, 0.45]", "[0.55, 0.0, -0.55]", "fuel.share", "greater than zero");
    rejects("rmax", "\"value\": 8.2", "\"value\": 1.2e-5", "fuel.capacity_kg", "expected energy for at least 1000 m");
    rejects(
        "predator-b",
        "\"value\": 36.0",
        "\"value\": 44.0",
        "flight.indicated_airspeed_m_s_stall",
        "less than `flight.indicated_airspeed_m_s_min`, 44",
    );
}

#[test]
fn energy_has_one_store_one_power_and_one_reserve() {
    let both = "\"reserve\": {\n    \"share\": {\"value\": 0.1, \"source\": \"x\"},";
    rejects("rmax", "\"reserve\": {", both, "reserve", "either `duration_min` or `share`, found both");
    rejects("quadrotor", "\"battery\":", "\"fuel\": {}, \"battery\":", "battery", "no battery in addition to `fuel`");
    rejects("quadrotor", "\"rotor\":", "\"wing\": {}, \"rotor\":", "battery", "either `rotor` or `wing`, found both");
    rejects("quadrotor", "\"value\": 548.0", "\"value\": 54.8", "endurance.cruise_min", "within 15 % of 6.1");
    rejects("quadrotor", "\"value\": 55.0", "\"value\": 90.0", "endurance.hover_min", "within 15 % of 55");
    rejects("quadrotor", "[0.6, 0.8, 1.0]", "[0.6, 0.8]", "battery.temperature_share", "3 shares");
    rejects("quadrotor", "[-10.0, 0.0, 20.0]", "[0, 0, 20]", "battery.temperature_c", "each greater than");
    rejects(
        "rmax",
        "\"duration_min\": {\"value\": 5.0",
        "\"duration_min\": {\"value\": 75.0",
        "reserve.duration_min",
        "95 % of the capacity, found 102 %",
    );
    let hover = "\"endurance\": {\n    \"hover_min\": {\"value\": 1, \"source\": \"x\"},";
    rejects("predator-b", "\"endurance\": {", hover, "endurance.hover_min", "nothing for a fixed wing");
}

#[test]
fn sensors_are_named_by_reference_and_mode() {
    rejects("rmax", "\"rmax-camera\"", "\"rmx-camera\"", "sensors[0].sensor", "did you mean `rmax-camera`?");
    rejects("predator-b", ", \"mode\": \"1.25 mrad wide\"", "", "sensors[0].mode", "`2.5 mrad`, `1.25 mrad`");
    rejects("predator-b", "\"1.25 mrad wide\"", "\"1.5 mrad\"", "sensors[0].mode", "found the text \"1.5 mrad\"");
    rejects("rmax", "\"rmax-camera\"", "\"rmax-camera\", \"mode\": \"x\"", "sensors[0].mode", "kind video");
    let twice = "\"sensors\": [{\"name\": \"camera-1\", \"sensor\": \"rmax-camera\"},";
    rejects("rmax", "\"sensors\": [", twice, "sensors[1].name", "`camera-1` again");
    let two = "\"sensors\": [{\"name\": \"other\", \"sensor\": \"ams-wildfire\", \"mode\": \"2.5 mrad\"},";
    rejects("predator-b", "\"sensors\": [", two, "sensors[1].sensor", "one line scanner at most");
    let roll = "\"level_roll_deg_max\": {\"value\": 3.0";
    let steeper = "\"level_roll_deg_max\": {\"value\": 3.5";
    rejects("predator-b", roll, steeper, "flight.level_roll_deg_max", "`motion.roll_deg_valid` of `ams-wildfire`, 3");
}

/// The caller supplies the text of a sensor that is a file, and errors in it name that file.
#[test]
fn a_sensor_file_is_asked_for_by_its_reference() {
    let text = changed(ShippedVehicle::find("rmax").unwrap().text, "\"rmax-camera\"", "\"eye.json\"");
    let camera = ShippedSensor::find("mapping-camera").unwrap().text;
    let read = |camera: Result<Option<(String, String)>, String>| {
        VehicleModel::parse_with("my-uav.json", &text, &mut |reference: &str| {
            assert_eq!(reference, "eye.json");
            camera.clone()
        })
    };
    let model = read(Ok(Some(("m/eye.json".into(), camera.into())))).unwrap();
    assert_eq!(model.sensors[0].model.name, "mapping-camera");
    let error = read(Err("no such file".into())).unwrap_err();
    complains(&error, "vehicle file `my-uav.json`", "sensors[0].sensor", "no such file");
    let broken = changed(camera, "\"focal_mm\"", "\"focal_cm\"");
    let error = read(Ok(Some(("m/eye.json".into(), broken)))).unwrap_err();
    complains(&error, "sensor file `m/eye.json`", "frame.focal_cm", "did you mean `focal_mm`?");
    complains(
        &read(Ok(None)).unwrap_err(),
        "vehicle file `my-uav.json`",
        "sensors[0].sensor",
        "unknown sensor `eye.json`",
    );
}

#[test]
fn figures_that_no_sensor_can_have_are_named_with_their_rule() {
    let scanner = "ams-wildfire";
    rejects_sensor(scanner, "\"value\": 42.5", "\"value\": 0", "modes[1].field_of_view_deg", "greater than 0");
    rejects_sensor(scanner, "\"value\": 42.5", "\"value\": 170.5", "modes[1].field_of_view_deg", "at most 170");
    rejects_sensor(scanner, "\"value\": 42.5", "\"value\": 0.05", "modes[1].pixel_mrad", "the field of view, 0.05");
    rejects_sensor(scanner, "\"value\": 2.5,", "\"value\": -2.5,", "modes[0].pixel_mrad", "greater than zero");
    rejects_sensor(scanner, "\"name\": \"1.25 mrad\"", "\"name\": \"2.5 mrad\"", "modes[1].name", "again");
    rejects_sensor(
        scanner,
        "\"start_up_s\": {\"value\": 0.0",
        "\"start_up_s\": {\"value\": -1",
        "start_up_s",
        "not negative",
    );
    rejects_sensor(
        scanner,
        "\"roll_deg_zero\": {\"value\": 3.0",
        "\"roll_deg_zero\": {\"value\": 2.0",
        "motion.roll_deg_valid",
        "`motion.roll_deg_zero`, 2",
    );
    rejects_sensor(
        scanner,
        "\"kind\": \"line-scanner\"",
        "\"kind\": \"frame\"",
        "modes",
        "nothing for a sensor of kind frame",
    );
    rejects_sensor(scanner, "\"motion\": {", "\"mount\": {}, \"motion\": {", "mount", "nothing for a line scanner");
    let camera = "rmax-camera";
    rejects_sensor(
        camera,
        "\"value\": 10.0, \"source\": \"premise",
        "\"value\": -90, \"source\": \"premise",
        "mount.tilt_deg_min",
        "less than `mount.tilt_deg_max`, -90",
    );
    rejects_sensor(camera, "\"by_day\": true", "\"by_day\": false", "bands[0]", "by day or by night");
    rejects_sensor(camera, "\"by_day\": true", "\"by_day\": 1", "bands[0].by_day", "true or false");
    rejects_sensor(camera, "\"to_um\": 0.7", "\"to_um\": 0.3", "bands[0].from_um", "less than `to_um`");
    rejects_sensor(camera, "\"store_bytes\": 4e10", "\"store_bytes\": 4e3", "data.image_bytes", "`data.store_bytes`");
    rejects_sensor(
        "mapping-camera",
        "\"focal_mm\": {\"value\": 10.6",
        "\"focal_mm\": {\"value\": 0.106",
        "frame.focal_mm: field of view in degrees",
        "at most 170",
    );
    rejects_sensor(
        "mapping-camera",
        "\"tilt_deg\": -90.0",
        "\"tilt_deg\": -90.0, \"settle_s\": 1",
        "mount.settle_s",
        "fixed mount",
    );
}

/// A 20 megapixel camera at 120 m: 2.73 cm and 149.4 m x 99.6 m; pixels and swaths of the scanner from 6,000 m.
#[test]
fn derived_figures_are_those_of_the_geometry() {
    let mapper = VehicleModel::named("fixed-wing-mapper").unwrap();
    let sight = mapper.sight(&mapper.sensors[0], 120.0);
    assert!((sight.nadir_pixel_m - 0.0273).abs() < 1e-4 && (sight.swath_m - 149.4).abs() < 0.1, "{sight:?}");
    assert!((mapper.height_for_resolution_m(&mapper.sensors[0], 0.0273) - 120.0).abs() < 0.1);
    let predator = VehicleModel::named("predator-b").unwrap();
    let scanner = &predator.sensors[0];
    let sight = predator.sight(scanner, 6_000.0);
    assert!((sight.nadir_pixel_m - 7.5).abs() < 1e-9 && (sight.edge_pixel_m - 14.02).abs() < 0.01, "{sight:?}");
    assert!((sight.swath_m - 11_190.0).abs() < 1.0, "{sight:?}");
    assert!((sight.scan_rate_hz_min.unwrap() - 95.2 / 7.5).abs() < 1e-9, "{sight:?}");
    let heights = predator.gap_free_heights(scanner.scanner_mode().unwrap());
    assert!((heights[1].height_m - 6_092.8).abs() < 0.1, "{heights:?}");
    assert!((apex_vehicle::derived::turn_radius_m(95.0, 18.0) - 2_832.0).abs() < 1.0);
}

/// A frame camera straight down records strips: four fifths of the picture's width.
#[test]
fn a_frame_camera_straight_down_records_strips() {
    let mapper = VehicleModel::named("fixed-wing-mapper").unwrap();
    let scanner = mapper.scanner.as_ref().unwrap();
    let strip_m = 2.0 * 120.0 * libm::tan((scanner.field_of_view_deg / 2.0).to_radians());
    assert!((strip_m - 0.8 * 149.4).abs() < 0.1, "{strip_m}");
    assert_eq!(VehicleModel::named("rmax").unwrap().scanner, None, "a video camera records no strips");
    rejects("rmax", "\"report\":", "\"scanner\": {}, \"report\":", "scanner", "a known member");
}

/// Reserve and low energy follow from each vehicle's own figures.
#[test]
fn reserves_follow_from_the_vehicle() {
    for (name, reserve, low) in [("predator-b", 48.0, 136.5), ("rmax", 0.557, 0.967), ("global-hawk", 150.0, 479.0)] {
        let model = VehicleModel::named(name).unwrap();
        assert!((model.reserve() / reserve - 1.0).abs() < 0.01, "{name}: {}", model.reserve());
        assert!((model.low() / low - 1.0).abs() < 0.01, "{name}: {}", model.low());
    }
    let quadrotor = VehicleModel::named("quadrotor").unwrap();
    assert_eq!(quadrotor.reserve, Reserve::Share(0.2));
    assert!((quadrotor.low() - 0.25 * quadrotor.stored_full()).abs() < 1.0);
}

/// The battery's drain in hover, at 12 m/s and at 5 m/s is within 15 % of 598, 560 and 580 W, the figures of an M300 class quadrotor;
/// cold makes part of the energy unusable.
#[test]
fn the_battery_of_the_quadrotor_is_as_stated() {
    let quadrotor = VehicleModel::named("quadrotor").unwrap();
    for (speed, watt) in [(0.0, 598.0), (12.0, 560.0), (5.0, 580.0)] {
        let drain = quadrotor.drain_per_s(speed, 0.0, 0.0);
        assert!((drain / watt - 1.0).abs() < 0.15, "{speed}: {drain}");
    }
    let full = quadrotor.stored_full();
    assert_eq!(quadrotor.available(full, 20.0), full);
    assert!((quadrotor.available(full, 0.0) / full - 0.8).abs() < 1e-9);
    assert!((quadrotor.available(full, 10.0) / full - 0.9).abs() < 1e-9);
    assert_eq!(quadrotor.available(0.3 * full, -20.0), 0.0);
    assert!(quadrotor.drain_per_s(0.0, 0.0, 3.0) > quadrotor.drain_per_s(0.0, 0.0, 0.0));
    assert!(quadrotor.drain_per_s(0.0, 3_000.0, 0.0) > quadrotor.drain_per_s(0.0, 0.0, 0.0), "thin air");
}

#[test]
fn figures_of_the_other_airframe_are_refused() {
    let braking = "\"braking_share\": {\"value\": 0.6, \"source\": \"x\"}, \"glide_ratio\"";
    rejects("predator-b", "\"glide_ratio\"", braking, "flight.braking_share", "nothing for a fixed wing");
    let slowest = "\"final_approach_m\": {\"value\": 9, \"source\": \"x\"}, \"glide_ratio\"";
    rejects("rmax", "\"glide_ratio\"", slowest, "flight.final_approach_m", "nothing for a rotorcraft");
}

/// Each of them passed before, and the vehicle did not land, or stalled in cruise.
#[test]
fn figures_with_which_no_flight_ends_are_refused() {
    let refused = |path: &str, expected: &str, change: &dyn Fn(&mut VehicleModel)| {
        let mut model = VehicleModel::named("predator-b").unwrap();
        change(&mut model);
        let error = model.validate("own").unwrap_err();
        assert_eq!(error.path, path, "{error}");
        assert!(error.to_string().contains(expected), "{error}");
    };
    refused("flight.final_approach_m", "at most 50000", &|model| model.final_approach_m = 500_000.0);
    refused("flight.final_approach_height_m", "half of flight.final_approach_m", &|model| {
        model.final_approach_height_m = 20_000.0;
    });
    refused("flight.yaw_rate_deg_s_max", "at most 1000", &|model| model.yaw_rate_deg_s_max = 1e9);
    refused("planning.visit_height_m", "flight.ceiling_m", &|model| model.planning.visit_height_m = 1e9);
    // 44 m/s indicated are 63 m/s at 7,000 m, whose air has 0.48 of the density at sea level.
    refused("flight.true_airspeed_m_s_cruise", "at least 63.", &|model| {
        model.true_airspeed_m_s_cruise = 50.0;
        let EnergyModel::Fuel(fuel) = &mut model.energy else { panic!("no tank") };
        fuel.speed_m_s_reference = 50.0;
    });
}

#[test]
fn a_model_changed_in_memory_is_checked_like_a_file() {
    let mut model = VehicleModel::named("rmax").unwrap();
    let EnergyModel::Fuel(fuel) = &mut model.energy else { panic!("fuel") };
    fuel.capacity_kg = f64::NAN;
    assert_eq!(model.validate("rmax").unwrap_err().path, "fuel.capacity_kg");
    let mut model = VehicleModel::named("rmax").unwrap();
    model.sensors.push(model.sensors[0].clone());
    assert_eq!(model.validate("rmax").unwrap_err().path, "sensors[1].name");
}
