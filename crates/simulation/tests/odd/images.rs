//! Images that are wanted on the ground within a time.

use crate::harness::{Flown, collection, feature, fly, point, program};
use apex_mission::report::MissionValue;

/// A fire 20 km from the base whose images are wanted within 10 min.
fn mapped(options: &str, files: &[(&str, &str)]) -> Flown {
    let fire = r#""id": "ridge", "kind": "fire", "elevation_m": 1500, "acres": 8000, "value": 100, "resolution_m": 12, "latency_min": [10, 60]"#;
    let base = r#""id": "home", "kind": "base", "elevation_m": 700"#;
    let targets = collection(&[feature(fire, &point(-118.2, 35.0)), feature(base, &point(-117.9, 34.9))]);
    let options = format!(
        ":vehicle (sim :model predator-b :at home) :start \"2026-08-01T18:00:00Z\" :duration 4h :targets \"t.geojson\" {options}"
    );
    let mut files = files.to_vec();
    files.push(("t.geojson", &targets));
    fly(&program(&options, "6000m"), &files)
}

/// Returns the timing factor as flown and as the plan predicted it, and the remarks.
fn timing(flown: &Flown) -> (f64, f64, String) {
    let MissionValue::Score(score) = &flown.outcome.report.value else { panic!("{}", flown.text()) };
    let look = &score.looks[0];
    (look.flown.factors.timing, look.predicted.as_ref().unwrap().timing, format!("{:?}", look.flown.remarks))
}

/// Score and plan agree about an image that is sent when it is taken: it arrives in time.
#[test]
fn an_image_that_is_sent_at_once_is_in_time_as_planned() {
    let world = r#"{"format": "apex-world-1", "downlink": {"over": "satellite", "rate_mbit_s": 1, "picture_mbit": 60, "store_mbit": 4000, "processing_s": 60}}"#;
    let options = ":images-on-ground 2min :modems ((satellite)) :world \"world.json\"";
    let flown = mapped(options, &[("world.json", world)]);
    assert!(!flown.said("image-on-ground").is_empty(), "{}", flown.text());
    let (as_flown, predicted, remarks) = timing(&flown);
    assert!(as_flown > 0.99 && predicted > 0.99, "{as_flown} {predicted}");
    assert!(!remarks.contains("Arrival"), "{remarks}");
}

/// Without a link images are read after the landing, which is later than full worth allows: as flown and as predicted.
#[test]
fn an_image_that_is_read_after_the_landing_is_late_as_planned() {
    let flown = mapped("", &[]);
    let (as_flown, predicted, remarks) = timing(&flown);
    let landed_s = flown.said("landed")[0].0;
    let visit = &flown.outcome.report.visits[0];
    let seen_s = 0.5 * (visit.begin.seconds() + visit.end.unwrap().seconds());
    let expected = 1.0 - ((landed_s - seen_s) / 60.0 - 10.0).max(0.0) / 50.0;
    assert!((as_flown - expected.max(0.0)).abs() < 0.05, "{as_flown}, by hand {expected}:\n{}", flown.text());
    assert!((predicted - as_flown).abs() < 0.15, "{as_flown}, the plan counts the way home: {predicted}");
    assert!(predicted < 0.95, "the plan must lose part of this factor, or the test shows nothing: {predicted}");
    assert!(!remarks.contains("Arrival"), "{remarks}");
}

/// Images of both fires are read after the landing, so the image of the fire that is seen first waits for the other. A plan that counted
/// only the way home of each would see the valuable fire first.
#[test]
fn images_wait_for_the_landing_of_the_plan() {
    let fire = |id: &str, value: i32, at: String| {
        let properties = format!(
            r#""id": "{id}", "kind": "fire", "elevation_m": 900, "acres": 4000, "value": {value}, "resolution_m": 20, "latency_min": [30, 150]"#
        );
        feature(&properties, &at)
    };
    let base = feature(r#""id": "home", "kind": "base", "elevation_m": 700"#, &point(-117.9, 34.9));
    let targets =
        collection(&[base, fire("valuable", 100, point(-118.9, 35.0)), fire("other", 30, point(-116.9, 35.0))]);
    let options = ":vehicle (sim :model predator-b :at home) :start \"2026-08-01T18:00:00Z\" :duration 5h \
                   :targets \"t.geojson\"";
    let flown = fly(&program(options, "6000m"), &[("t.geojson", &targets)]);
    let order: Vec<&str> = flown.outcome.report.visits.iter().map(|visit| visit.target.as_str()).collect();
    assert_eq!(order, ["other", "valuable"], "{}", flown.text());
    let MissionValue::Score(score) = &flown.outcome.report.value else { panic!("{}", flown.text()) };
    for look in &score.looks {
        let (predicted, flown_factor) = (look.predicted.as_ref().unwrap().timing, look.flown.factors.timing);
        assert!(
            (predicted - flown_factor).abs() < 0.1,
            "{}: {predicted}, flown {flown_factor}\n{}",
            look.id,
            flown.text()
        );
    }
    let first = score.looks.iter().find(|look| look.id.starts_with("other")).unwrap();
    assert!(
        first.flown.factors.timing < 0.7,
        "the plan must lose part of this factor, or the test shows nothing\n{}",
        flown.text()
    );
}
