//! Changes of altitude: climbs that a plan counts on its way past a zone, hills on the way of a helicopter, and an altitude that is commanded
//! while a helicopter flies to its picture.

use crate::harness::{collection, feature, fly, point, program};
use apex_mission::report::MissionValue;
use std::fmt::Write;

const ZONE: &str = r#"{"type": "Polygon", "coordinates": [[[-118.5, 34.8], [-118.2, 34.8], [-118.2, 35.3], [-118.5, 35.3], [-118.5, 34.8]]]}"#;
const FIRST: &str = r#"{"type": "Polygon", "coordinates": [[[-119.15, 34.59], [-119.23, 34.58], [-119.2, 34.46], [-119.15, 34.47], [-119.15, 34.59]]]}"#;
const SECOND: &str = r#"{"type": "Polygon", "coordinates": [[[-119.33, 34.45], [-119.37, 34.47], [-119.39, 34.42], [-119.33, 34.44], [-119.33, 34.45]]]}"#;

/// The way to the first fire bends around a zone, and its lines are flown 4,000 m higher than the aircraft is: it climbs on the whole way.
#[test]
fn a_climb_past_a_zone_is_flown_in_the_time_of_the_plan() {
    let options = ":vehicle (sim :model predator-b :at home) :start \"2026-08-01T02:00:00Z\" :duration 8h :targets \"t.geojson\" \
                   :airspace \"z.geojson\" :forecast \"w.csv\" :landing-distance 150nm";
    let fire = |id: &str, more: &str, shape: &str| {
        feature(&format!(r#""id": "{id}", "kind": "fire", "value": 100, "elevation_m": 800, {more}"#), shape)
    };
    let targets = [
        feature(r#""id": "home", "kind": "base", "elevation_m": 702"#, &point(-117.884, 34.905)),
        fire("first", r#""resolution_m": 20"#, FIRST),
        fire("second", r#""resolution_m": 10, "after": ["first"]"#, SECOND),
    ];
    let zone = [feature(r#""id": "range", "kind": "restricted", "altitude_m_max": 9000"#, ZONE)];
    let wind = "wind_from_deg,wind_speed_mps,altitude_m_min,altitude_m_max,edr\n90,15,0,20000,0.1\n";
    let files = [("t.geojson", collection(&targets)), ("z.geojson", collection(&zone)), ("w.csv", wind.to_string())];
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let flown = fly(&program(options, "6000m"), &files);
    assert_eq!(flown.check().violations(), 0, "{}", flown.text());
    let visits = &flown.outcome.report.visits;
    let visit = visits.iter().find(|visit| visit.target == "first").unwrap();
    let planned_s = flown.planned_begin_s("first");
    let began_s = visit.begin.seconds();
    assert!((began_s - planned_s).abs() <= 180.0, "planned for {planned_s} s, begun at {began_s} s\n{}", flown.text());
}

/// A hill of 100 m between two places that are photographed from 40 m.
fn hill(to: (f64, f64)) -> String {
    let mut text =
        "ncols 100\nnrows 60\nxllcenter -121.14\nyllcenter 37.4\ncellsize 0.0005\nNODATA_value -9999\n".to_string();
    for row in (0..60).rev() {
        for column in 0..100 {
            let (north, east) = (37.4 + 0.0005 * f64::from(row) - to.0, -121.14 + 0.0005 * f64::from(column) - to.1);
            let from_top_m = (111_195.0 * north).hypot(88_300.0 * east);
            write!(text, "{:.1} ", 5.0 + 95.0 * (-0.5 * (from_top_m / 250.0).powi(2)).exp()).unwrap();
        }
        text.push('\n');
    }
    text
}

#[test]
fn a_helicopter_that_climbs_before_a_hill_raises_no_alarm() {
    let options = ":vehicle (sim :model rmax :at home) :start \"2026-08-18T20:00:00Z\" :duration 60min :end-margin 5min \
                   :targets \"t.geojson\" :terrain \"g.asc\"";
    let site = |id: &str, place: (f64, f64)| {
        let properties = format!(r#""id": "{id}", "kind": "inspection", "value": 10, "resolution_m": 0.03"#);
        feature(&properties, &point(place.1, place.0))
    };
    let targets = [
        feature(r#""id": "home", "kind": "base""#, &point(-121.1238, 37.4113)),
        site("east", (37.4082, -121.1074)),
        site("north", (37.4221, -121.12)),
    ];
    let flown =
        fly(&program(options, "60m"), &[("t.geojson", &collection(&targets)), ("g.asc", &hill((37.4152, -121.1137)))]);
    assert_eq!(flown.said("requirement-at-risk"), [], "{}", flown.text());
    let MissionValue::Score(score) = &flown.outcome.report.value else { panic!("{}", flown.text()) };
    assert!(score.score > 19.0, "{}", flown.text());
}

/// A response to a requirement changes the altitude in the same way.
#[test]
fn a_picture_is_taken_from_its_altitude_whatever_is_commanded_on_the_way() {
    let text = "(defapplication \"Odd\" :type native-sim :libraries (\"vehicle\" \"aerial-observation\") \
         :vehicle (sim :model rmax :at home) :duration 20min :end-margin 1min :targets \"t.geojson\" \
         :agents ((agent uav-1 :initial-task (fly the mission))))\n\
         (procedure (index (fly the mission))\n\
           (step up (take off to 60m))\n\
           (step see (visit barn at (46.009 8.0 44) for 2s with camera-1) (waitfor (end ?up)))\n\
           (step pause (wait 20s) (waitfor (end ?up)))\n\
           (step higher (set altitude 160m) (waitfor (end ?pause)))\n\
           (step home (return to home at 60m) (waitfor (end ?see)))\n\
           (step finish (terminate) (waitfor (end ?home))))\n";
    let targets = [
        feature(r#""id": "home", "kind": "base""#, &point(8.0, 46.0)),
        feature(r#""id": "barn", "kind": "structure""#, &point(8.0, 46.009)),
    ];
    let flown = fly(text, &[("t.geojson", &collection(&targets))]);
    let taken_s = flown.said("image-taken")[0].0;
    let highest_m = flown.track().iter().map(|at| at.3).fold(0.0, f64::max);
    assert!(highest_m > 150.0, "it was on its way up: {highest_m} m");
    let altitude_m = flown.track().iter().rfind(|at| at.0 <= taken_s).unwrap().3;
    assert!((altitude_m - 44.0).abs() <= 5.0, "taken from {altitude_m} m\n{}", flown.text());
}
