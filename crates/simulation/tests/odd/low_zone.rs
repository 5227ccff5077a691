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

/// Over the zone the aircraft is at 9.65 km, and the next fire is seen from 3 km: it descends at the end of the way. It descended where it
/// was, into the zone, because ways to lines were searched at the altitude of the line alone.
#[test]
fn a_fixed_wing_leaves_a_zone_below_it_before_it_descends() {
    let fire = |id: &str, longitude: f64| {
        let properties = format!(r#""id": "{id}", "kind": "fire", "acres": 4000, "value": 20"#);
        feature(&properties, &point(longitude, 37.4))
    };
    const DEEP: (f64, f64, f64, f64) = (-118.9, 37.1, -117.9, 37.7);
    let targets = collection(&[home(), fire("under", -118.4), fire("near", -120.6)]);
    let deep = r#""id": "deep", "kind": "restricted", "altitude_m_min": 0, "altitude_m_max": 9500"#;
    let options = ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration 5h :end-margin 20min \
                   :targets \"t.geojson\" :airspace \"z.geojson\"";
    let program = program(options, "7000m").replace("(step again (keep planning (see them)))", "");
    let visits = "(under near)";
    let program = program.replace("(see them) (waitfor (end ?up))", "(see them) (waitfor (end ?order))").replace(
        "(step survey",
        &format!("(step order (inform (plan-imposed {visits})) (waitfor (end ?up)))\n(step survey"),
    );
    let flown = fly(&program, &[("t.geojson", &targets), ("z.geojson", &collection(&[feature(deep, &area(DEEP))]))]);
    for target in ["under", "near"] {
        assert!(flown.observed_s(target).is_some(), "{target} was not observed:\n{}", flown.text());
    }
    assert_eq!(flown.inside(DEEP, 0.0, 9_500.0).len(), 0, "inside of the zone\n{}", flown.text());
    assert!(!flown.text().contains("has to be broken"), "{}", flown.text());
}

/// The middle of a fire whose outline crosses the 180th meridian was taken for longitude 0, and the zone for too far away to plan.
#[test]
fn outlines_across_the_180th_meridian_are_planned_and_avoided() {
    let ring = |(west, south, east, north): (f64, f64, f64, f64)| {
        format!(
            r#"{{"type": "Polygon", "coordinates": [[[{west}, {south}], [{east}, {south}], [{east}, {north}], [{west}, {north}], [{west}, {south}]]]}}"#
        )
    };
    let base = feature(r#""id": "home", "kind": "base", "elevation_m": 10"#, &point(179.8, -17.0));
    let across = feature(
        r#""id": "across", "kind": "fire", "value": 20, "resolution_m": 20"#,
        &ring((179.95, -17.4, -179.95, -17.3)),
    );
    let east = feature(
        r#""id": "east", "kind": "fire", "value": 20, "acres": 3000, "resolution_m": 20"#,
        &point(-179.5, -17.2),
    );
    let bar = feature(
        r#""id": "bar", "kind": "restricted", "altitude_m_max": 20000"#,
        &ring((179.98, -17.15, -179.7, -17.05)),
    );
    let options = ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration 5h \
                   :targets \"t.geojson\" :airspace \"z.geojson\"";
    let flown = fly(
        &program(options, "4000m"),
        &[("t.geojson", &collection(&[base, across, east])), ("z.geojson", &collection(&[bar]))],
    );
    for target in ["across", "east"] {
        assert!(flown.observed_s(target).is_some(), "{target} was not observed:\n{}", flown.text());
    }
    let inside = |at: &(f64, f64, f64, f64)| (-17.15..-17.05).contains(&at.1) && (at.2 > 179.98 || at.2 < -179.7);
    assert_eq!(flown.track().iter().filter(|at| inside(at)).count(), 0, "inside of the zone");
}
