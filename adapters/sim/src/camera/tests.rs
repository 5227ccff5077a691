//! Cameras point straight down, to every side, and during flight past a target; a slew that cannot end fails in time.

use super::*;
use crate::motion::moved;
use apex_model::problem::Position;
use apex_model::value::Value;

const DEG: f64 = RAD_PER_DEG;

fn model(pan_deg_max: f64) -> CameraModel {
    CameraModel {
        name: "camera-1".to_owned(),
        tilt_deg_min: -90.0,
        tilt_deg_max: 10.0,
        pan_deg_max,
        slew_rate_deg_s: 40.0,
        field_of_view_deg: 20.0,
        power_up_s: 10.0,
        picture_s: 0.5,
        interval_s_min: 0.5,
    }
}

const TARGET: Position = Position { latitude_deg: 36.5, longitude_deg: -121.7 };

fn aim() -> Aim {
    let spot = Spot { position: TARGET, altitude_m: None, thing_altitude_m: Some(0.0), given: Value::symbol("barn") };
    Aim::At(spot, 0.0)
}

/// Returns the state of a vehicle north and east of the target, `height_m` above it.
fn state(north_m: f64, east_m: f64, height_m: f64, heading_deg: f64) -> State {
    State {
        position: moved(TARGET, north_m, east_m),
        altitude_m: height_m,
        heading_rad: heading_deg * DEG,
        true_airspeed: 0.0,
        bank_rad: 0.0,
        roll_rad: 0.0,
        pitch_rad: 0.0,
        roll_rate_rad_s: 0.0,
        yaw_rate_rad_s: 0.0,
        vertical_speed: 0.0,
        north: 0.0,
        east: 0.0,
        stored: 1.0,
        drain_per_s: 0.0,
        engine_running: true,
        on_ground: false,
        flight_time_s: 0.0,
        distance_flown_m: 0.0,
    }
}

/// Slews from a level sight line ahead. Returns the seconds until the camera points, if it does before the deadline, and the deadline.
fn slew(camera: &mut Camera, state: &State) -> (Option<f64>, f64) {
    camera.state = CameraState::Ready;
    let deadline_s = camera.begin_slew(aim(), state, None);
    let mut elapsed_s = 0.0;
    while elapsed_s < deadline_s {
        elapsed_s += 0.2;
        if camera.follow(state, 0.2) == Pointing::Aligned {
            return (Some(elapsed_s), deadline_s);
        }
    }
    (None, deadline_s)
}

#[test]
fn a_target_straight_below_is_pointed_at_with_and_without_pan() {
    for pan_deg_max in [0.0, 30.0, 180.0] {
        // Centimetres and metres away from straight down, on every side.
        for (north_m, east_m) in [(0.0, 0.0), (0.06, -0.02), (-0.3, 0.1), (-1.5, 1.5), (2.5, -1.0), (0.0, 3.0)] {
            for heading_deg in [0.0, 77.0, 180.0, 299.0] {
                let mut camera = Camera::new(model(pan_deg_max));
                let (after_s, deadline_s) = slew(&mut camera, &state(north_m, east_m, 60.0, heading_deg));
                let case = format!("pan {pan_deg_max}, {north_m} {east_m}, {heading_deg}");
                // 90 degrees at 40 deg/s, then settling and one step.
                assert!(after_s.is_some_and(|after_s| after_s < 3.1), "{case}: {after_s:?} of {deadline_s}");
                assert!(camera.error_rad < 3.1 * DEG, "{case}: {}", camera.error_rad / DEG);
            }
        }
    }
}

/// Returns the angle from the sight line to the target, computed from coordinates instead of tilt and pan.
fn miss_deg(camera: &Camera, north_m: f64, east_m: f64, height_m: f64, heading_deg: f64) -> f64 {
    let azimuth = heading_deg * DEG + camera.pan_rad;
    let line = [cos(camera.tilt_rad) * cos(azimuth), cos(camera.tilt_rad) * sin(azimuth), -sin(camera.tilt_rad)];
    let to = [-north_m, -east_m, height_m];
    let length = sqrt(to.iter().map(|x| x * x).sum::<f64>());
    let dot: f64 = line.iter().zip(to).map(|(a, b)| a * b).sum();
    libm::acos((dot / length).clamp(-1.0, 1.0)) / DEG
}

#[test]
fn the_sight_line_is_on_the_target_in_every_direction() {
    for (north_m, east_m) in [(300.0, 0.0), (-100.0, 250.0), (0.0, -40.0), (-12.0, 5.0)] {
        let heading_deg = 33.0;
        let mut camera = Camera::new(model(180.0));
        assert!(slew(&mut camera, &state(north_m, east_m, 60.0, heading_deg)).0.is_some(), "{north_m} {east_m}");
        let miss_deg = miss_deg(&camera, north_m, east_m, 60.0, heading_deg);
        assert!(miss_deg < 1.0, "{north_m} {east_m}: {miss_deg}");
        assert!((miss_deg - camera.error_rad / DEG).abs() < 1e-3, "{miss_deg} {}", camera.error_rad / DEG);
    }
}

#[test]
fn it_tracks_while_an_aircraft_flies_straight_over() {
    for pan_deg_max in [0.0, 180.0] {
        // 25 m/s at 120 m, 4 m aside: 12 degrees a second overhead.
        let mut camera = Camera::new(model(pan_deg_max));
        let at = |along_m: f64| state(along_m, 4.0, 120.0, 0.0);
        assert!(slew(&mut camera, &at(-400.0)).0.is_some());
        let mut lost = Vec::new();
        for step in 0..400 {
            let along_m = -400.0 + 5.0 * f64::from(step) / 2.0;
            // A mount that cannot tilt beyond straight down loses a target behind it, unless it pans.
            if camera.follow(&at(along_m), 0.1) == Pointing::OutOfView {
                lost.push(along_m);
            }
        }
        if pan_deg_max > 0.0 {
            assert!(lost.len() <= 1, "{lost:?}");
            assert_eq!(camera.state, CameraState::Pointing);
            assert!(miss_deg(&camera, 597.5, 4.0, 120.0, 0.0) < 1.0);
        } else {
            assert!(lost.len() == 1 && lost[0] > 15.0 && lost[0] < 30.0, "half of 20 degrees behind: {lost:?}");
        }
    }
}

#[test]
fn a_slew_that_cannot_end_fails_by_its_deadline_with_the_reason() {
    // To the right of a mount that only tilts, and behind the stops of another.
    for (pan_deg_max, north_m, east_m, angle) in [(0.0, 0.0, -300.0, "78.7"), (30.0, 300.0, 0.0, "")] {
        let mut camera = Camera::new(model(pan_deg_max));
        let here = state(north_m, east_m, 60.0, 0.0);
        let (after_s, deadline_s) = slew(&mut camera, &here);
        assert!(after_s.is_none() && deadline_s < 8.0, "{after_s:?} {deadline_s}");
        let reason = camera.fail_slew(&here);
        assert!(reason.starts_with("camera-1 does not point at barn in time: its sight line is"), "{reason}");
        assert!(reason.contains("the mount cannot come closer than") && reason.contains(angle), "{reason}");
        assert_eq!((camera.state, camera.aim.is_none()), (CameraState::Ready, true));
    }
}
