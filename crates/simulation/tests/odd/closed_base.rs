//! A base that is closed for a while in the middle of the flight.

use crate::harness::{area, collection, feature, fly, home, point, program};

const CLOSED: (f64, f64, f64, f64) = (-121.001, 37.399, -120.999, 37.401);

/// A target is added while the base is closed. The new plan waits until the base opens, and keeps the targets of the old plan.
#[test]
fn a_base_that_opens_again_does_not_end_the_mission() {
    let target = |id: &str, more: &str, at: String| {
        feature(&format!(r#""id": "{id}", "kind": "inspection", "elevation_m": 100, "resolution_m": 0.05{more}"#), &at)
    };
    let targets = collection(&[
        home(),
        target("mast", r#", "value": 20, "windows_h": [[0.1, 0.2]]"#, point(-121.01, 37.415)),
        target("tank", r#", "value": 10"#, point(-120.99, 37.41)),
        target("mill", r#", "value": 10, "announced": "by-event""#, point(-121.005, 37.41)),
    ]);
    let zone = feature(
        r#""id": "closed", "kind": "restricted", "altitude_m_max": 1000, "active_h": [[0.05, 0.45]]"#,
        &area(CLOSED),
    );
    let options = ":vehicle (sim :model quadrotor :at home) :start \"2026-05-12T18:30:00Z\" :duration 1h :end-margin 5min \
                   :targets \"t.geojson\" :airspace \"z.geojson\" :zone-margin 20m :scenario \"s.jsonl\"";
    let flown = fly(
        &program(options, "180m"),
        &[
            ("t.geojson", &targets),
            ("z.geojson", &collection(&[zone])),
            ("s.jsonl", r#"{"t": 300, "event": "(new-target mill)"}"#),
        ],
    );
    for target in ["mast", "tank", "mill"] {
        assert!(flown.observed_s(target).is_some(), "{target} was not observed:\n{}", flown.text());
    }
    let closed = flown.inside(CLOSED, 0.0, 1_000.0).into_iter().filter(|at_s| (180.0..1_620.0).contains(at_s)).count();
    assert_eq!(closed, 0, "inside of the closed zone");
    assert!(flown.said("landed").iter().any(|(at_s, _)| *at_s > 1_620.0), "{}", flown.text());
}
