//! Diagnoses in flight rest on the newest evidence: a stale pass neither clears a failed test nor stands against a newer failure.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a failed test should stop")]

#[path = "contingencies/flown.rs"]
#[allow(clippy::disallowed_methods, reason = "a distance that this test does not use")]
mod flown;
#[path = "support/shipped.rs"]
mod shipped;

use apex_mission::diagnosis::{ModelQuery, answer};

/// Flies `missions/diagnosis` with these faults of the world.
fn shipped_with(faults: &str) -> flown::Flown {
    let folder = shipped::copy_with("diagnosis", &[]);
    let world = format!("{{\"format\": \"apex-world-1\", \"faults\": [{faults}]}}");
    std::fs::write(folder.path().join("world.json"), world).unwrap();
    let mission = folder.path().to_path_buf();
    flown::fly_mission(&mission, folder)
}

fn health_at(flown: &flown::Flown, component: &str, at_s: f64) -> String {
    flown.word_at(&format!("(health {component})"), at_s)
}

/// The bus reports 28 V twice and then 12 V once. The sample of 20 s cleared the failure of 100 s.
#[test]
fn a_stale_sample_does_not_clear_a_failed_test() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "bus.json",
        r#"{"format": "apex-diagnosis-1", "name": "bus",
            "components": [{"name": "main-bus", "probability_per_hour": 5e-5}],
            "signals": [],
            "tests": [{"name": "bus-voltage", "needs": ["main-bus"],
                       "monitor": {"fails": "(voltage main-bus < 24)", "passes": "(voltage main-bus >= 24)"}}]}"#,
    );
    write("bus.pdl", &answer(&folder.path().join("bus.json"), ModelQuery::Pdl, false).unwrap());
    let voltages = [(10, 28), (20, 28), (100, 12), (150, 12), (200, 28), (210, 28), (250, 12)];
    let line = |(at_s, volts): (i32, i32)| {
        format!("{{\"t\": {at_s}, \"measurement\": \"(voltage main-bus)\", \"value\": {volts}}}\n")
    };
    write("scenario.jsonl", &voltages.map(line).concat());
    let feature = r#"{"type": "Feature", "properties": {"id": "site"}, "geometry": {"type": "Point", "coordinates": [-122.048, 37.42]}}"#;
    write("sites.geojson", &format!("{{\"type\": \"FeatureCollection\", \"features\": [{feature}]}}"));
    write(
        "mission.pdl",
        "(defapplication \"Bus\" :type native-sim :libraries (\"vehicle\" \"aerial-observation\") :files (\"bus.pdl\")
           :vehicle (sim :model rmax :at (37.415 -122.048)) :duration 10min :targets \"sites.geojson\"
           :scenario \"scenario.jsonl\" :diagnosis \"bus.json\" :agents ((agent uav-1 :initial-task (go))))
         (procedure (index (go))
           (step tests (watch the tests of bus))
           (step up (take off to 60m))
           (step stay (hover for 5min) (waitfor (end ?up)))
           (step finish (terminate) (waitfor (end ?stay))))",
    );
    let mission = folder.path().to_path_buf();
    let flown = flown::fly_mission(&mission, folder);
    let states: Vec<(f64, String)> = flown.words("(test-state bus-voltage)");
    let expected = [(0.0, "unknown"), (10.0, "passed"), (100.0, "failed"), (200.0, "passed"), (250.0, "failed")];
    assert_eq!(states, expected.map(|(at_s, word)| (at_s, word.to_string())), "{}", flown.story());
    flown.assert_replays();
}

/// The mount, which reports nothing without power, passed its test before the power failed. The pass stood against the failure, and the
/// failed voltage was left out of the diagnosis for the rest of the flight.
#[test]
fn a_pass_from_before_a_failure_does_not_contradict_it() {
    let flown = shipped_with(r#"{"fault": "payload-power", "at_s": 900}"#);
    for at_s in [901.0, 1_000.0, 4_000.0] {
        assert_eq!(health_at(&flown, "payload-converter", at_s), "bad", "{at_s}\n{}", flown.story());
        assert_ne!(health_at(&flown, "sensor-head", at_s), "bad", "{at_s}\n{}", flown.story());
    }
    assert_eq!(flown.word_at("(test-state gimbal-follows)", 1_000.0), "unknown");
    assert_eq!(flown.count("(tests-contradict"), 0, "{}", flown.story());
    let doubted = flown.said.iter().find(|(_, said)| said.starts_with("(test-doubted")).unwrap();
    assert!(doubted.0 == 900.0 && doubted.1.starts_with("(test-doubted gimbal-follows P4M42"), "{doubted:?}");
    // The aircraft serves the last four bridges as a relay.
    assert_eq!(flown.count("(relaying"), 4, "{}", flown.story());
    flown.assert_replays();
}

/// A detector without cooling gets too hot for pictures: the sensor head is not the cause.
#[test]
fn a_hot_detector_explains_missing_pictures() {
    let flown = shipped_with(r#"{"fault": "cooling", "of": "camera-1", "at_s": 300}"#);
    let hot_s = flown.words("(test-state frames-arrive)").into_iter().find(|(_, word)| word == "failed").unwrap().0;
    assert_eq!(health_at(&flown, "cooler", hot_s - 10.0), "bad", "the detector is warm\n{}", flown.story());
    assert_eq!(health_at(&flown, "sensor-head", hot_s - 10.0), "good");
    assert_eq!(health_at(&flown, "cooler", hot_s + 1.0), "bad");
    assert_ne!(health_at(&flown, "sensor-head", hot_s + 1.0), "bad", "{}", flown.story());
    assert!(flown.word_at("(candidates payload)", hot_s + 1.0).starts_with("((cooler/cooler-stopped)"));
    flown.assert_replays();
}
