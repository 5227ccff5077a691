//! Zones just above what is to be seen, and aircraft that fly low because they are slow.

use crate::harness::{area, collection, feature, fly, home, point, program};

const ABOVE: (f64, f64, f64, f64) = (-120.995, 37.407, -120.985, 37.413);

/// The zone begins 80 m above the ground, below the altitude at which the quadrotor cruises. It flies in below, and out below.
#[test]
fn a_target_below_a_zone_is_visited_from_below() {
    let tank =
        r#""id": "tank", "kind": "inspection", "elevation_m": 100, "height_m": 10, "value": 10, "resolution_m": 0.02"#;
    let mast =
        r#""id": "mast", "kind": "inspection", "elevation_m": 110, "height_m": 40, "value": 20, "resolution_m": 0.02"#;
    let targets = collection(&[home(), feature(tank, &point(-120.99, 37.41)), feature(mast, &point(-121.01, 37.415))]);
    let zone =
        feature(r#""id": "above", "kind": "restricted", "altitude_m_min": 180, "altitude_m_max": 1000"#, &area(ABOVE));
    let options = ":vehicle (sim :model quadrotor :at home) :start \"2026-05-12T18:30:00Z\" :duration 1h :end-margin 5min \
                   :targets \"t.geojson\" :airspace \"z.geojson\" :zone-margin 20m";
    let flown = fly(&program(options, "220m"), &[("t.geojson", &targets), ("z.geojson", &collection(&[zone]))]);
    for target in ["mast", "tank"] {
        assert!(flown.observed_s(target).is_some(), "{target} was not observed:\n{}", flown.text());
    }
    assert!(!flown.inside(ABOVE, 100.0, 179.0).is_empty(), "below the zone");
    assert_eq!(flown.inside(ABOVE, 180.0, 1_000.0).len(), 0, "inside of the zone");
    assert!(!flown.text().contains("has to be broken"), "{}", flown.text());
}

/// Pixels of 3 cm need 99 m above the ground, less than the 100 m below which the simulator refuses fast fixed wings.
#[test]
fn a_mapping_aircraft_flies_as_low_as_it_plans() {
    let tank =
        r#""id": "tank", "kind": "inspection", "elevation_m": 100, "height_m": 20, "value": 10, "resolution_m": 0.03"#;
    let targets = collection(&[home(), feature(tank, &point(-120.98, 37.43))]);
    let options = ":vehicle (sim :model fixed-wing-mapper :at home) :start \"2026-05-12T18:30:00Z\" :duration 50min \
                   :end-margin 5min :targets \"t.geojson\"";
    let flown = fly(&program(options, "220m"), &[("t.geojson", &targets)]);
    assert!(flown.observed_s("tank").is_some(), "{}", flown.text());
    assert!(!flown.text().contains("was not observed"), "{}", flown.text());
}
