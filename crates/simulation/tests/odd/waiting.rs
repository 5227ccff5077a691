//! Time windows: targets that are added while the aircraft waits for one, and reasons that name the right one.

use crate::harness::{collection, feature, fly, home, point, program};

/// The first fire is wanted three hours after the start; the second becomes known meanwhile, and is seen in the time that would be waited.
#[test]
fn what_becomes_known_during_a_wait_is_planned_at_once() {
    let base = feature(r#""id": "home", "kind": "base", "elevation_m": 700"#, &point(-117.9, 34.9));
    let late = r#""id": "late", "kind": "fire", "elevation_m": 900, "acres": 4000, "value": 60, "resolution_m": 20, "windows_h": [[3, 3.6]]"#;
    let added = r#""id": "added", "kind": "fire", "elevation_m": 900, "acres": 4000, "value": 60, "resolution_m": 20, "announced": "by-event""#;
    let targets = collection(&[base, feature(late, &point(-118.6, 35.2)), feature(added, &point(-117.6, 35.3))]);
    let options = ":vehicle (sim :model predator-b :at home) :start \"2026-08-01T18:00:00Z\" :duration 6h \
                   :targets \"t.geojson\" :scenario \"s.jsonl\"";
    let flown = fly(
        &program(options, "6000m"),
        &[("t.geojson", &targets), ("s.jsonl", r#"{"t": 3600, "event": "(new-target added)"}"#)],
    );
    let (added_s, late_s) = (flown.observed_s("added"), flown.observed_s("late"));
    let (Some(added_s), Some(late_s)) = (added_s, late_s) else { panic!("{}", flown.text()) };
    assert!(added_s < 2.0 * 3_600.0, "seen at {added_s} s, an hour after it was added:\n{}", flown.text());
    assert!((3.0..3.6).contains(&(late_s / 3_600.0)), "{late_s}");
}

/// A fixed wing circles until the window opens, and leaves the circle so that it crosses the beginning of the first line at that instant.
/// An aircraft that left only when the window opens would begin 4.5 minutes late in still air.
#[test]
fn a_line_that_is_waited_for_begins_at_its_instant() {
    let header = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr,from_h,until_h";
    for (wind, bearing_deg) in [(0, 0.0), (0, 100.0), (15, 200.0), (15, 300.0)] {
        let base = feature(r#""id": "home", "kind": "base", "elevation_m": 700"#, &point(-117.9, 34.9));
        let fire = r#""id": "fire", "kind": "fire", "elevation_m": 900, "acres": 4000, "value": 60, "resolution_m": 10, "windows_h": [[2, 2.6]]"#;
        let (north, east) = (0.35 * f64::to_radians(bearing_deg).cos(), 0.4 * f64::to_radians(bearing_deg).sin());
        let targets = collection(&[base, feature(fire, &point(-117.9 + east, 34.9 + north))]);
        let winds = format!("{header}\n0,20000,250,{wind},0.05,,\n");
        let options = ":vehicle (sim :model predator-b :at home) :start \"2026-08-01T18:00:00Z\" :duration 6h \
                       :targets \"t.geojson\" :forecast \"w.csv\" :weather \"w.csv\"";
        let flown = fly(&program(options, "6000m"), &[("t.geojson", &targets), ("w.csv", &winds)]);
        let visit = &flown.outcome.report.visits[0];
        let planned_s = visit.predicted.as_ref().unwrap().begin_s;
        let late_s = visit.begin.seconds() - planned_s;
        assert!((2.0 * 3_600.0..2.05 * 3_600.0).contains(&planned_s), "{planned_s}");
        assert!(late_s.abs() <= 15.0, "wind {wind}, bearing {bearing_deg}: {late_s:.0} s late\n{}", flown.text());
    }
}

/// The far target has no window, so the end of the mission is the reason for which it is left out.
#[test]
fn a_target_without_windows_is_not_left_out_for_a_window() {
    let target = |id: &str, more: &str, at: String| {
        feature(&format!(r#""id": "{id}", "kind": "inspection", "elevation_m": 100, "resolution_m": 0.05{more}"#), &at)
    };
    let targets = collection(&[
        home(),
        target("mast", r#", "value": 20, "windows_h": [[0.1, 0.12]]"#, point(-121.01, 37.415)),
        target("far", r#", "value": 10"#, point(-120.96, 37.42)),
    ]);
    let options = ":vehicle (sim :model quadrotor :at home) :start \"2026-05-12T18:30:00Z\" :duration 13min :end-margin 1min \
                   :targets \"t.geojson\"";
    let flown = fly(&program(options, "180m"), &[("t.geojson", &targets)]);
    assert!(flown.observed_s("mast").is_some(), "{}", flown.text());
    let why = flown.left_out("far");
    assert!(why.contains("more than the end of the mission leaves"), "{why}");
}
