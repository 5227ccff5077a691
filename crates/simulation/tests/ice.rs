//! Ice in a cloud whose extent the aircraft does not know: contingency and requirement leave its level, and flight commands do not lead
//! back into it. The recorded flight is compared.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a failed test should stop")]
#![allow(clippy::disallowed_methods, reason = "this check computes distances apart from the product")]

#[path = "contingencies/flown.rs"]
mod flown;

use flown::{Flight, Flown};

/// Four legs through the cloud, each at the altitude of ice, and back.
const THROUGH: &str = "(step up (take off to 4500m)) (step a (fly to (37.4 -117.0 4500))) (step b (fly to (37.6 -117.0 4500))) \
     (step c (fly to (37.8 -117.0 4500))) (step d (fly to (37.9 -117.0 4500))) (step e (fly to (37.6 -117.1 4500))) \
     (step home (return to home at 4500m))";

/// At 4,500 m the air is 14 degrees below freezing. The cloud begins 17 km north of home.
const CLOUD: &str = r#""clouds": [{"latitude_deg": 37.6, "longitude_deg": -117.0, "radius_m": 50000, "base_m": 3000, "top_m": 6500, "cover": 0.9}]"#;

fn fly(guards: &'static str, options: &'static str) -> Flown {
    let flown = Flight { guards, work: THROUGH, world: CLOUD, options, ..Flight::default() }.fly();
    assert_eq!(flown.count("(landed uav-1)"), 1, "{}", flown.story());
    flown.assert_replays();
    flown
}

/// Returns the greatest exposure, and the time in ice, in seconds.
fn exposure_s(flown: &Flown) -> (f64, f64) {
    let exposures = flown.numbers("(ice-exposure uav-1)");
    let most_s = exposures.iter().map(|(_, seconds)| *seconds).fold(0.0, f64::max);
    (most_s, exposures.windows(2).map(|pair| (pair[1].1 - pair[0].1).max(0.0)).sum())
}

/// The contingency returned to the altitude of ice above the cloud, six times in one cloud.
#[test]
fn a_cloud_with_ice_is_left_once() {
    let (_, careless_s) = exposure_s(&fly("", ""));
    assert!(careless_s > 1_000.0, "{careless_s}");
    let flown = fly("(step guard (guard against icing))", "");
    let (most_s, total_s) = exposure_s(&flown);
    assert!(total_s < 400.0 && most_s < 400.0, "{total_s} s in ice, {most_s} s at most\n{}", flown.story());
    assert_eq!(flown.count("(icing-met uav-1"), 1, "{}", flown.story());
    assert!(flown.count("(icing-left uav-1)") <= 1, "{}", flown.story());
}

/// The response ended when its altitude was reached, and the next command led back; the response after it led down into the ice.
#[test]
fn the_requirement_keeps_the_aircraft_off_the_ice() {
    let flown = fly("(step guard (guard the flight))", ":requirements ((icing :at-most 4min))");
    let (most_s, total_s) = exposure_s(&flown);
    assert!(most_s <= 240.0, "{most_s} s at most, {total_s} s in ice\n{}", flown.story());
    assert!(flown.count("(requirement-at-risk icing") <= 6, "{}", flown.story());
    assert_eq!(flown.count("(responding icing land"), 0, "{}", flown.story());
}
