//! Oblique pictures while the sun is low.

use crate::harness::{collection, feature, fly, home, point, program};

/// The sun 10 minutes before 02:40 UTC on 13 May 2026 at 37.4 N 121 W: azimuth and elevation in degrees, by the formula of
/// `/docs/reference/observation.md` worked out apart from the product.
const SUN: (f64, f64) = (289.5, 4.6);
/// Half of the field of view of the quadrotor's camera (36 mm at a focal length of 35 mm), and the keep-out angle of its file.
const KEPT_DEG: f64 = 27.2 + 5.0;

/// Returns the angle between a sight line and the sun.
fn off_the_sun_deg(azimuth_deg: f64, elevation_deg: f64) -> f64 {
    let (azimuth, elevation) = ((azimuth_deg - SUN.0).to_radians(), elevation_deg.to_radians());
    let sun = SUN.1.to_radians();
    (elevation.sin() * sun.sin() + elevation.cos() * sun.cos() * azimuth.cos()).acos().to_degrees()
}

/// The target lies in the direction of the sun, so that the nearest side to look from is the one that looks into it.
#[test]
fn a_plan_looks_from_the_side_that_keeps_the_camera_off_the_sun() {
    let (latitude, longitude) = (37.401_85, -121.006_39);
    let mast = r#""id": "mast", "kind": "inspection", "elevation_m": 100, "value": 20, "resolution_m": 0.1, "look_angle_deg": [64, 80]"#;
    let targets = collection(&[home(), feature(mast, &point(longitude, latitude))]);
    let options = ":vehicle (sim :model quadrotor :at home) :start \"2026-05-13T02:32:00Z\" :duration 30min :end-margin 5min \
                   :targets \"t.geojson\"";
    let flown = fly(&program(options, "150m"), &[("t.geojson", &targets)]);
    let (taken_s, _) = flown.said("image-taken").first().cloned().unwrap_or_else(|| panic!("{}", flown.text()));
    let at = flown.track().into_iter().rev().find(|at| at.0 <= taken_s).unwrap();
    let (north_m, east_m) =
        ((latitude - at.1) * 111_000.0, (longitude - at.2) * 111_000.0 * latitude.to_radians().cos());
    let azimuth_deg = east_m.atan2(north_m).to_degrees();
    let elevation_deg = -(at.3 - 100.0).atan2(north_m.hypot(east_m)).to_degrees();
    let kept_deg = off_the_sun_deg(azimuth_deg, elevation_deg);
    assert!(
        kept_deg >= KEPT_DEG - 0.5,
        "{kept_deg:.1} degrees off the sun, looking to {azimuth_deg:.0} {elevation_deg:.0}"
    );
    // The way from home leads towards the sun: a camera that looks along this way looks too near to the sun.
    assert!(
        off_the_sun_deg(290.0, elevation_deg) < KEPT_DEG,
        "the test must have something to avoid: {elevation_deg:.0}"
    );
    let alarms: Vec<_> =
        flown.said("requirement-at-risk").into_iter().filter(|(_, text)| text.contains(" sun ")).collect();
    assert_eq!(alarms, []);
}

/// The files of the cameras that ship state what they endure: the camera is switched off in time without a requirement of the mission.
#[test]
fn a_camera_that_gets_hot_is_switched_off_by_the_figures_of_its_file() {
    let world = r#"{"format": "apex-world-1", "faults": [{"fault": "cooling", "of": "camera-1", "at_s": 60}]}"#;
    let program = "(defapplication \"Hot\" :type native-sim :libraries (\"vehicle\" \"aerial-observation\" \"contingencies\")\n \
         :vehicle (sim :model quadrotor :at home) :duration 1h :targets \"t.geojson\" :world \"world.json\"\n \
         :agents ((agent uav-1 :initial-task (fly the mission))))\n\
         (procedure (index (fly the mission))\n\
           (step on (power-up camera-1))\n\
           (step up (take off to 160m))\n\
           (step safe (guard the flight))\n\
           (step stay (hover for 20min) (waitfor (end ?up)))\n\
           (step down (land here) (waitfor (end ?stay)))\n\
           (step finish (terminate) (waitfor (end ?down))))\n";
    let flown = fly(program, &[("t.geojson", &collection(&[home()])), ("world.json", world)]);
    assert!(!flown.said("requirement-at-risk").is_empty(), "{}", flown.text());
    let hottest_k = flown.numbers("detector-temperature").into_iter().fold(0.0, f64::max);
    assert!((318.0..323.65).contains(&hottest_k), "{hottest_k}");
}
