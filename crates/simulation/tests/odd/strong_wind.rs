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

/// The wind is twice as strong as forecast on the way home, and rises when the aircraft is far away. It was in the air when the mission
/// ended.
#[test]
fn an_aircraft_turns_for_home_in_time_by_the_wind_that_it_measures() {
    let fire = |id: &str, longitude: f64| {
        let properties = format!(r#""id": "{id}", "kind": "fire", "acres": 4000, "value": 20"#);
        feature(&properties, &point(longitude, 37.4))
    };
    let targets = collection(&[home(), fire("near", -120.0), fire("far", -118.5), fire("farther", -117.2)]);
    let options = ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration 3h :end-margin 10min \
                   :targets \"t.geojson\" :forecast \"w.csv\" :weather \"a.csv\"";
    let header = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr,from_h,until_h";
    let flown = fly(
        &program(options, "4000m"),
        &[
            ("t.geojson", &targets),
            ("w.csv", &format!("{header}\n0,20000,270,15,0.01,0,9\n")),
            ("a.csv", &format!("{header}\n0,20000,270,15,0.01,0,0.7\n0,20000,270,40,0.01,0.7,9\n")),
        ],
    );
    let text = flown.text();
    assert!(flown.outcome.end.reason.is_success(), "{text}");
    let landed_s = flown.said("landed").last().unwrap_or_else(|| panic!("{text}")).0;
    assert!((8_000.0..10_800.0).contains(&landed_s), "{landed_s}\n{text}");
    let alarms = flown.said("requirement-at-risk");
    assert!(
        alarms.iter().any(|(_, alarm)| alarm.starts_with("(requirement-at-risk mission-end \"home\"")),
        "{alarms:?}\n{text}"
    );
    assert!(flown.observed_s("near").is_some(), "{text}");
}
