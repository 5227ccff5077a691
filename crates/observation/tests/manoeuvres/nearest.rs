//! The nearest possible figure that a refusal states is possible: the manoeuvre with exactly this figure keeps the limit.

use super::fixtures::*;
use apex_observation::manoeuvres::*;
use apex_observation::sensor::{CameraSetting, Gimbal};

/// Returns the first number of a text that says what works.
fn stated(nearest: &str) -> Option<f64> {
    let number = nearest.contains(" works").then(|| nearest.split(' ').find_map(|word| word.parse().ok()));
    number.flatten()
}

/// Refuses `figure`, then tries what the refusal states; that may break another limit, but not the same one.
#[track_caller]
fn holds(of: impl Fn(f64) -> Manoeuvre, figure: f64, craft: &Craft, scene: &Scene) -> bool {
    let Err(refusal) = of(figure).fly(craft, &camera(true), scene) else { return false };
    let Some(nearest) = stated(&refusal.nearest) else { return false };
    if let Err(again) = of(nearest).fly(craft, &camera(true), scene) {
        assert_ne!(again.figure, refusal.figure, "{refusal}, and with that: {again}");
    }
    true
}

fn arced(arc: Arc) -> Manoeuvre {
    with(FlightPath::Arc(arc), AttitudeMode::Pointing, SpeedProfile::GroundSpeed(8.0), PayloadUse::Video)
}

fn flown(path: FlightPath, speed_mps: f64) -> Manoeuvre {
    with(path, AttitudeMode::Coordinated, SpeedProfile::Airspeed(speed_mps), PayloadUse::Video)
}

#[test]
fn what_a_refusal_calls_possible_is_possible() {
    let mut refused = [0; 8];
    for number in 0..60 {
        let step = f64::from(number);
        let (speed_mps, wind_mps) = (12.0 + 0.083 * step, 0.071 * step);
        let (craft, scene) = (mapper(), windy(wind_mps, 0.0));
        let square = |spacing_m: f64| ExpandingSquare { spacing_m, rounds: 2, height_m: 60.0, first_track_deg: None };
        let sector = |radius_m: f64| SectorSearch { radius_m, height_m: 60.0, first_track_deg: None };
        let spiral = |inner_radius_m: f64| Spiral {
            inner_radius_m,
            outer_radius_m: 900.0,
            spacing_m: 50.0,
            height_m: 60.0,
            from_deg: 0.0,
            clockwise: true,
            inward: false,
        };
        let paths: [&dyn Fn(f64) -> FlightPath; 4] = [
            &|figure| FlightPath::Orbit(orbit(figure, 100.0)),
            &|figure| FlightPath::ExpandingSquare(square(figure)),
            &|figure| FlightPath::SectorSearch(sector(figure)),
            &|figure| FlightPath::Spiral(spiral(figure)),
        ];
        for (count, path) in refused.iter_mut().zip(paths) {
            *count += usize::from(holds(|figure| flown(path(figure), speed_mps), 3.0, &craft, &scene));
        }
        let around = |speed_mps: f64| flown(FlightPath::Orbit(orbit(900.0, 100.0)), speed_mps);
        let slow = Craft { true_airspeed_mps_max: 20.0 + 0.013 * step, ..craft.clone() };
        refused[4] += usize::from(holds(around, 60.0, &slow, &still()));
        let helicopter = Craft { yaw_rate_deg_s: 10.0 + 0.37 * step, ..helicopter() };
        let arc = |speed_mps: f64| arced(Arc { speed_mps, ..arch() });
        refused[5] += usize::from(holds(
            arc,
            20.0 + step,
            &Craft { yaw_rate_deg_s: 90.0, ..helicopter.clone() },
            &windy(0.0, 0.11 * step),
        ));
        let turning = |yaw_rate_deg_s: f64| arced(Arc { yaw_rate_deg_s, ..arch() });
        refused[6] += usize::from(holds(turning, 80.0, &helicopter, &still()));
        let slowing = |acceleration_mps2: f64| arced(Arc { acceleration_mps2, ..arch() });
        let weak = Craft { braking_mps2: 0.01 + 0.007 * step, yaw_rate_deg_s: 90.0, ..helicopter };
        refused[7] += usize::from(holds(slowing, 9.0, &weak, &still()));
    }
    assert!(refused.iter().all(|count| *count > 20), "{refused:?}");
}

/// Returns a camera with this mount.
fn mounted(pan_deg: (f64, f64), tilt_deg: (f64, f64)) -> Instrument {
    match camera(true) {
        Instrument::Camera(setting) => {
            let mount = Gimbal { pan_deg, tilt_deg, ..setting.mount };
            Instrument::Camera(CameraSetting { mount, ..setting })
        }
        scanner => scanner,
    }
}

#[test]
fn an_orbit_whose_target_the_camera_cannot_see_is_refused_with_the_reason() {
    let refused = |craft: &Craft, instrument: &Instrument, radius_m: f64| {
        let circle = flown(FlightPath::Orbit(orbit(radius_m, 100.0)), craft.true_airspeed_mps);
        circle.track(craft, instrument, &still()).err().map(|refusal| refusal.to_string())
    };
    // A camera that is fixed downward: neither a small nor a large circle works.
    let fixed = mounted((0.0, 0.0), (-90.0, -90.0));
    for radius_m in [10.0, 31.0, 300.0] {
        let why = refused(&mapper(), &fixed, radius_m).unwrap();
        assert!(why.contains("does not pan") && why.contains("no orbit works"), "{why}");
        let why = refused(&helicopter(), &fixed, radius_m).unwrap();
        assert!(why.contains("tilts from -90 to -90 degrees") && why.contains("no orbit works"), "{why}");
    }
    assert_eq!(refused(&mapper(), &mounted((-180.0, 180.0), (-90.0, 10.0)), 300.0), None);
    // A mount that tilts up to 45 degrees below the horizon sees as far aside as it is high; one that tilts down to it, no nearer.
    let steep = mounted((-180.0, 180.0), (-90.0, -45.0));
    let why = refused(&helicopter(), &steep, 150.0).unwrap();
    assert!(why.contains("a look angle of 56.3 degrees") && why.contains("a radius of 99 m works"), "{why}");
    assert_eq!(refused(&helicopter(), &steep, 99.0), None);
    let flat = mounted((-180.0, 180.0), (-45.0, 10.0));
    let why = refused(&helicopter(), &flat, 50.0).unwrap();
    assert!(why.contains("a radius of 100 m works"), "{why}");
    assert_eq!(refused(&helicopter(), &flat, 100.0), None);
}

/// Returns the refusal of a manoeuvre.
#[track_caller]
fn refused(manoeuvre: &Manoeuvre, craft: &Craft, instrument: &Instrument, scene: &Scene) -> Refusal {
    manoeuvre.fly(craft, instrument, scene).unwrap_err()
}

/// A ground speed of a path that turns is flown against the wind, too.
#[test]
fn a_ground_speed_that_is_called_possible_is_possible_in_every_direction() {
    let around = |speed_mps: f64| {
        let circle = FlightPath::Orbit(orbit(300.0, 100.0));
        with(circle, AttitudeMode::Pointing, SpeedProfile::GroundSpeed(speed_mps), PayloadUse::Video)
    };
    let (craft, scene) = (helicopter(), windy(6.0, 0.0));
    let why = refused(&around(18.0), &craft, &camera(false), &scene);
    assert_eq!(why.nearest, "a ground speed of 14.6 m/s works in this wind");
    assert!(around(14.6).fly(&craft, &camera(false), &scene).is_ok());
    assert!(around(14.8).fly(&craft, &camera(false), &scene).is_err());
    let weak = Craft { true_airspeed_mps_max: 5.0, ..craft };
    assert_eq!(refused(&around(1.0), &weak, &camera(false), &scene).nearest, "wait for less wind");
}

/// A camera that does not pan sees nothing aside of a vehicle that flies along its course.
#[test]
fn what_is_advised_for_a_camera_without_pan_needs_no_pan() {
    let line = StandOff { track_deg: 0.0, side: Side::Left, height_m: 100.0, look_angle_deg: 20.0, length_m: 80.0 };
    let stand_off = flown(FlightPath::StandOff(line), 13.0);
    let why = refused(&stand_off, &mapper(), &camera(false), &still());
    assert_eq!((why.figure.as_str(), why.nearest.as_str()), ("a pan range", "fly straight over the target, or sweep"));
    assert!(stand_off.fly(&mapper(), &camera(true), &still()).is_ok());
    let place = VantagePoint { azimuth_deg: 0.0, look_angle_deg: 45.0, slant_m: 100.0, dwell_s: 5.0 };
    let place = flown(FlightPath::VantagePoint(place), 13.0);
    assert_eq!(refused(&place, &mapper(), &camera(false), &still()).nearest, "fly straight over the target");
    let why = refused(&place, &mapper(), &camera(true), &still());
    assert!(
        holds(|radius_m| flown(FlightPath::Orbit(orbit(radius_m, 100.0)), 13.0), 3.0, &mapper(), &still()),
        "{why}"
    );
    let radius_m = why.nearest.split(' ').find_map(|word| word.parse().ok()).unwrap();
    assert!(flown(FlightPath::Orbit(orbit(radius_m, 100.0)), 13.0).fly(&mapper(), &camera(true), &still()).is_ok());
    // A mount that tilts no higher than 45 degrees below the horizon.
    let steep = mounted((-180.0, 180.0), (-90.0, -45.0));
    let aside = |look_angle_deg: f64| flown(FlightPath::StandOff(StandOff { look_angle_deg, ..line }), 13.0);
    assert_eq!(refused(&aside(60.0), &mapper(), &steep, &still()).nearest, "45 degrees works");
    assert!(aside(45.0).fly(&mapper(), &steep, &still()).is_ok());
}

/// An inner radius that works may be greater than the outer one of the form: then both are stated.
#[test]
fn a_spiral_that_is_too_small_is_refused_with_both_radii() {
    let spiral = |inner_radius_m: f64, outer_radius_m: f64| {
        let path = Spiral {
            inner_radius_m,
            outer_radius_m,
            spacing_m: 500.0,
            height_m: 1_000.0,
            from_deg: 0.0,
            clockwise: true,
            inward: false,
        };
        flown(FlightPath::Spiral(path), 95.0)
    };
    let numbers = |why: Refusal| -> Vec<f64> { why.nearest.split(' ').filter_map(|word| word.parse().ok()).collect() };
    let [inner_m, outer_m] = numbers(refused(&spiral(800.0, 2_300.0), &predator(), &camera(true), &still()))[..] else {
        panic!("two radii are expected");
    };
    assert!(spiral(inner_m, outer_m).fly(&predator(), &camera(true), &still()).is_ok());
    let why = refused(&spiral(4_000.0, 3_000.0), &predator(), &camera(true), &still());
    assert_eq!((why.figure.as_str(), why.nearest.as_str()), ("an outer radius", "an outer radius of 4500 m works"));
    assert!(spiral(4_000.0, 4_500.0).fly(&predator(), &camera(true), &still()).is_ok());
}

#[test]
fn limits_are_printed_on_their_possible_side() {
    assert_eq!(
        [rounded_up(57.4, 0), rounded_up(58.0, 0), rounded_up(0.0123, 3), rounded_up(-89.6, 0)],
        ["58", "58", "0.013", "-89"]
    );
    assert_eq!(
        [rounded_down(57.6, 0), rounded_down(1.1, 1), rounded_down(0.04, 1), rounded_down(-20.4, 0)],
        ["57", "1.1", "0.04", "-21"]
    );
}
