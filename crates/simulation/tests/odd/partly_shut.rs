//! Fires of which a part lies below a zone that stays closed at every altitude.

use crate::harness::{Flown, area, collection, feature, fly, home, point, program};
use apex_mission::report::MissionValue;
use apex_runtime::target_state::TargetState;

/// Flies to a fire next to a zone that is never open.
fn survey(fire: &str, ground: &str, zone: (f64, f64, f64, f64), margin: &str) -> Flown {
    let properties = format!(r#""id": "fire", "kind": "fire", "value": 20, "resolution_m": 10{fire}"#);
    let targets = collection(&[home(), feature(&properties, ground)]);
    let shut = r#""id": "shut", "kind": "restricted", "altitude_m_max": 30000"#;
    let options = format!(
        ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration 6h :targets \"t.geojson\" \
         :airspace \"z.geojson\" :zone-margin {margin}"
    );
    let zones = collection(&[feature(shut, &area(zone))]);
    let flown = fly(&program(&options, "5000m"), &[("t.geojson", &targets), ("z.geojson", &zones)]);
    assert!(flown.outcome.end.reason.is_success(), "{}", flown.text());
    assert!(flown.inside(zone, 0.0, 30_000.0).is_empty(), "inside of the zone:\n{}", flown.text());
    flown
}

/// Coverage and points as predicted and as flown.
fn scored(flown: &Flown) -> [(f64, f64); 2] {
    let MissionValue::Score(score) = &flown.outcome.report.value else { panic!("{}", flown.text()) };
    let look = &score.looks[0];
    let predicted = look.predicted.as_ref().unwrap_or_else(|| panic!("{}", flown.text()));
    [(predicted.quality.coverage.factor, predicted.worth), (look.flown.factors.coverage, look.flown.points)]
}

/// Half of a fire, a corner of one, and all of a small one lie below a zone. Each was left out, because each sweep met the zone. The open
/// ground, and what the scanner sees below the zone from outside of it, justify a visit now; the plan names the zone.
#[test]
fn a_fire_that_a_zone_shuts_in_part_is_seen_from_outside() {
    let east = (-120.5, 37.2, -119.5, 37.8);
    let circle = |acres: u32| format!(r#", "acres": {acres}"#);
    for (fire, ground, zone, margin, least) in [
        (circle(20_000), point(-120.5, 37.5), east, "3km", 12.0),
        (String::new(), area((-120.6, 37.4, -120.3, 37.6)), (-120.4, 37.5, -119.5, 38.0), "3km", 12.0),
        (circle(500), point(-120.45, 37.5), east, "1km", 8.0),
    ] {
        let flown = survey(&fire, &ground, zone, margin);
        let [(coverage, worth), (seen, points)] = scored(&flown);
        assert!(points > least && (points - worth).abs() < 0.05 * worth, "{worth} {points}\n{}", flown.text());
        assert!((coverage - seen).abs() < 0.02, "{coverage} {seen}");
    }
    let flown = survey(&circle(20_000), &point(-120.5, 37.5), east, "3km");
    let planned = flown.target_details("fire", TargetState::Planned);
    assert!(
        planned
            .iter()
            .any(|detail| detail.contains("; coverage ") && detail.ends_with(", zone shut closes part of the ground")),
        "{planned:?}"
    );
}

/// Ground deep inside of a zone is left out, with the reason.
#[test]
fn a_fire_far_inside_of_a_zone_is_left_out() {
    let targets =
        |id: &str, at: String| feature(&format!(r#""id": "{id}", "kind": "fire", "acres": 500, "value": 20"#), &at);
    let targets = collection(&[home(), targets("in", point(-120.0, 37.5)), targets("free", point(-120.9, 37.9))]);
    let shut = r#""id": "shut", "kind": "restricted", "altitude_m_max": 30000"#;
    let options = ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration 6h :targets \"t.geojson\" \
                   :airspace \"z.geojson\"";
    let zones = collection(&[feature(shut, &area((-120.5, 37.2, -119.5, 37.8)))]);
    let flown = fly(&program(options, "5000m"), &[("t.geojson", &targets), ("z.geojson", &zones)]);
    assert!(flown.left_out("in").contains("zone shut closes 0 to 30000 m"), "{}", flown.text());
    assert!(flown.observed_s("free").is_some(), "{}", flown.text());
}
