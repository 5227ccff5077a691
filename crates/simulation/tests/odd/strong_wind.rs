//! Wind that is stronger than forecast, and stronger than the vehicle.

use crate::harness::{collection, feature, fly, home, point, program};

/// The quadrotor flies 17 m/s at most and the wind rises to 18: no way leads home, so it lands where it is. It tried to fly home until its
/// battery was empty, and crashed.
#[test]
fn a_rotorcraft_that_cannot_get_home_against_the_wind_lands_in_time() {
    let mast = r#""id": "mast", "kind": "inspection", "elevation_m": 100, "value": 20, "resolution_m": 0.05"#;
    let tank = r#""id": "tank", "kind": "inspection", "elevation_m": 100, "value": 20, "resolution_m": 0.05"#;
    let targets = collection(&[home(), feature(mast, &point(-120.98, 37.415)), feature(tank, &point(-120.96, 37.41))]);
    let options = ":vehicle (sim :model quadrotor :at home) :start \"2026-05-12T18:30:00Z\" :duration 1h :end-margin 5min \
                   :targets \"t.geojson\" :forecast \"w.csv\" :weather \"a.csv\"";
    let header = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr,from_h,until_h";
    let flown = fly(
        &program(options, "180m"),
        &[
            ("t.geojson", &targets),
            ("w.csv", &format!("{header}\n0,5000,250,5,0.05,0,2\n")),
            ("a.csv", &format!("{header}\n0,5000,250,5,0.05,0,0.06\n0,5000,250,18,0.05,0.06,2\n")),
        ],
    );
    assert_eq!(flown.said("crashed"), [], "{}", flown.text());
    let landed = flown.said("landed");
    assert!(landed.first().is_some_and(|(at_s, _)| *at_s < 900.0), "{landed:?}\n{}", flown.text());
    let noted = flown.outcome.report.notes.iter().filter(|note| note.text.starts_with("energy at risk")).count();
    assert!((1..=3).contains(&noted), "one note for each response:\n{}", flown.text());
}
