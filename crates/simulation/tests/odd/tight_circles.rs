//! Circles and turns that a way needs in addition to its legs, next to zones and at the end of the reach of landing places.

use crate::harness::{Flown, area, collection, feature, fly, home, point, program};
use apex_geo::geodesy;
use apex_model::problem::Position;

const START: &str =
    ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration 5h :targets \"t.geojson\"";
const NORTH: (f64, f64, f64, f64) = (-121.6, 37.94, -120.4, 38.3);

/// Stops the test unless the flight kept every requirement and had no reason to turn away.
fn keeps_everything(flown: &Flown, case: &str) {
    let text = flown.text();
    assert!(!text.contains("has to be broken") && !text.contains("at risk"), "{case}: {text}");
}

/// From 10 to 14.4 km the climb rate falls from 3.3 to 1.2 m/s: the climb takes 36 minutes, twice as long as at the rate that plans count.
/// The rest of it took place on circles around the place, which the wind carried into the zone 4 km north of it.
#[test]
fn a_long_climb_takes_place_where_it_has_space() {
    let zone = feature(r#""id": "north", "kind": "restricted", "altitude_m_max": 20000"#, &area(NORTH));
    let options = format!("{START} :airspace \"z.geojson\" :forecast \"w.csv\"");
    let program = format!(
        "(defapplication \"Odd\" :type native-sim :libraries (\"vehicle\" \"aerial-observation\" \"contingencies\") {options}\n \
         :agents ((agent uav-1 :initial-task (fly the mission))))\n\
         (procedure (index (fly the mission))\n\
           (step up (take off to 10000m))\n\
           (step go (fly to (37.9 -121.0 14400)) (waitfor (end ?up)))\n\
           (step back (fly to (37.4 -121.0 9000)) (waitfor (end ?go)))\n\
           (step safe (guard the flight))\n\
           (step finish (terminate) (waitfor (end ?back))))\n"
    );
    let wind = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n0,20000,180,10,0.02\n";
    let files =
        [("t.geojson", &collection(&[home()])), ("z.geojson", &collection(&[zone])), ("w.csv", &wind.to_string())];
    let flown = fly(&program, &files.map(|(name, text)| (name, text.as_str())));
    assert!(flown.inside(NORTH, 0.0, 20_000.0).is_empty(), "inside of the zone\n{}", flown.text());
    keeps_everything(&flown, "climb");
    let is_there = |at: &(f64, f64, f64, f64)| at.1 > 37.88 && at.3 > 14_300.0;
    assert!(flown.track().iter().any(is_there), "{}", flown.text());
}

/// Both lines over the fire are within reach of the base, but the turn from one to the other is not.
#[test]
fn lines_are_planned_with_the_turns_between_them() {
    const REACH_M: f64 = 110_000.0;
    let base = Position { latitude_deg: 37.4, longitude_deg: -121.0 };
    for north_m in [90_000.0, 97_500.0, 99_000.0] {
        let middle = geodesy::destination(base, 0.0, north_m);
        let corners = (0..=24).map(|number| {
            let corner = geodesy::destination(middle, 15.0 * f64::from(number % 24), 10_700.0);
            format!("[{}, {}]", corner.longitude_deg, corner.latitude_deg)
        });
        let ring = corners.collect::<Vec<_>>().join(", ");
        let fire = feature(
            r#""id": "far", "kind": "fire", "value": 50, "resolution_m": 8, "elevation_m": 300"#,
            &format!(r#"{{"type": "Polygon", "coordinates": [[{ring}]]}}"#),
        );
        let options = format!("{START} :landing-distance 110km");
        let flown = fly(&program(&options, "6000m"), &[("t.geojson", &collection(&[home(), fire]))]);
        let case = format!("{north_m} m");
        keeps_everything(&flown, &case);
        let off_m =
            |at: &(f64, f64, f64, f64)| geodesy::distance_m(base, Position { latitude_deg: at.1, longitude_deg: at.2 });
        let farthest_m = flown.track().iter().map(off_m).fold(0.0, f64::max);
        println!("{case}: {farthest_m:.0} m from the base");
        assert!(farthest_m < REACH_M, "{case}: {farthest_m}\n{}", flown.text());
        let is_told = || flown.left_out("far").contains("leaves the reach of the emergency landing places");
        assert!(flown.observed_s("far").is_some() || (north_m > 95_000.0 && is_told()), "{case}: {}", flown.text());
    }
}

/// The fire lies next to the zone, too near to climb to the cruise altitude on the way home, and everything below the zone is open.
#[test]
fn a_flight_returns_below_a_zone() {
    let base = feature(r#""id": "home", "kind": "base", "elevation_m": 300"#, &point(25.0, 40.0));
    let fire = r#""id": "below", "kind": "fire", "acres": 300, "value": 68, "resolution_m": 8, "elevation_m": 300"#;
    let fire = feature(fire, &point(24.80, 39.33));
    let ring = "[[[25.0386, 39.6802], [25.2807, 39.5723], [25.2807, 39.3564], [25.0386, 39.2485], [24.7964, 39.3564], \
                [24.7964, 39.5723], [25.0386, 39.6802]]]";
    for low_m in [5_000, 6_000, 7_000] {
        let zone = feature(
            &format!(
                r#""id": "above", "kind": "restricted", "altitude_m_min": {low_m}, "altitude_m_max": {}"#,
                low_m + 4_000
            ),
            &format!(r#"{{"type": "Polygon", "coordinates": {ring}}}"#),
        );
        let options = format!("{START} :airspace \"z.geojson\" :landing-distance 110km");
        let files = [("t.geojson", &collection(&[base.clone(), fire.clone()])), ("z.geojson", &collection(&[zone]))];
        let flown = fly(&program(&options, "6000m"), &files.map(|(name, text)| (name, text.as_str())));
        assert!(flown.observed_s("below").is_some(), "{low_m} m: {}", flown.text());
        keeps_everything(&flown, &format!("{low_m} m"));
    }
}
