//! Wind that is measured: ways home below strong wind, surveillance, and segments that are flown again.

use crate::harness::{area, collection, feature, fly, home, point, program};

const HEADER: &str = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr,from_h,until_h";

/// Wind from the west up to 7.9 km, and above.
fn layers(low_mps: u32, high_mps: u32) -> String {
    format!(
        "{HEADER}\n0,7000,270,{low_mps},0.01,0,9\n7000,7900,270,{low_mps},0.01,0,9\n\
         7900,8600,270,{high_mps},0.01,0,9\n8600,20000,270,{high_mps},0.01,0,9\n"
    )
}

/// The zone makes the lines so high that the wind there is 55 m/s; at cruise altitude, where plans fly home, it is 26. The way home was
/// counted at the altitude of the lines: the requirement turned the aircraft home after 51 minutes and without any observation, with more than
/// half of the remaining time to spare.
#[test]
fn the_way_home_counts_at_cruise_altitude() {
    let wide = r#""id": "wide", "kind": "fire", "acres": 170000, "value": 40, "resolution_m": 20"#;
    let targets = collection(&[home(), feature(wide, &point(-118.4, 37.4))]);
    let deep = r#""id": "deep", "kind": "restricted", "altitude_m_min": 0, "altitude_m_max": 9000"#;
    let zones = collection(&[feature(deep, &area((-118.45, 37.35, -118.35, 37.45)))]);
    let options = ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration 190min :end-margin 20min \
                   :targets \"t.geojson\" :airspace \"z.geojson\" :forecast \"w.csv\" :weather \"a.csv\"";
    let (forecast, actual) = (layers(12, 25), layers(26, 55));
    let data = [
        ("t.geojson", targets.as_str()),
        ("z.geojson", zones.as_str()),
        ("w.csv", forecast.as_str()),
        ("a.csv", actual.as_str()),
    ];
    let flown = fly(&program(options, "7000m"), &data);
    assert!(!flown.outcome.report.visits.is_empty(), "{}", flown.text());
    assert!(flown.said("requirement-at-risk").iter().all(|(at_s, _)| *at_s > 4_500.0), "{}", flown.text());
    let landed_s = flown.said("landed").last().unwrap_or_else(|| panic!("{}", flown.text())).0;
    assert!(landed_s < 190.0 * 60.0, "{landed_s}\n{}", flown.text());
}
