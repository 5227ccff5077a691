//! Properties of manoeuvres.

use crate::fixtures::*;
use apex_geo::plane::Point;
use apex_geo::wind::Wind;
use apex_observation::manoeuvres::*;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Every point of the searched square is within half a spacing of a leg, except outside of corners, by an independent, naive
    /// distance.
    #[test]
    fn every_point_of_an_expanding_square_is_within_half_a_spacing(
        spacing_m in 20.0..500.0_f64, rounds in 1_u32..7, first_deg in 0.0..360.0_f64,
        along in -1.0..1.0_f64, across in -1.0..1.0_f64,
    ) {
        let square = ExpandingSquare { spacing_m, rounds, height_m: 50.0, first_track_deg: Some(first_deg) };
        let corners = square.corners(&still());
        // The part enclosed by whole turns of the square.
        let reach_m = spacing_m * f64::from((rounds - 1) / 2);
        let (sine, cosine) = (libm::sin(first_deg.to_radians()), libm::cos(first_deg.to_radians()));
        let (a, b) = (along * reach_m, across * reach_m);
        let point = Point { x: a * sine + b * cosine, y: a * cosine - b * sine };
        let distance = |from: Point, to: Point| {
            let step = to.minus(from);
            let share = (point.minus(from).dot(step) / step.dot(step)).clamp(0.0, 1.0);
            point.minus(from.plus(share, step)).length()
        };
        let nearest = corners.windows(2).map(|pair| distance(pair[0], pair[1])).fold(f64::INFINITY, f64::min);
        // Outside of a corner, or of the datum, within the square of half a spacing: at most the distance of the point that is as far from
        // it as from two legs, (2 - sqrt 2) S.
        let corner = corners.iter().map(|corner| point.minus(*corner).length()).fold(f64::INFINITY, f64::min);
        let is_outside = corner < std::f64::consts::FRAC_1_SQRT_2 * spacing_m;
        let most = if is_outside { 2.0 - std::f64::consts::SQRT_2 } else { 0.5 };
        prop_assert!(reach_m == 0.0 || nearest <= most * spacing_m + 1e-6, "{nearest} of {spacing_m}");
    }

    /// With reversed wind the same path can be flown backwards: a circle takes as long, and so does a line there and back.
    #[test]
    fn a_reversed_wind_is_symmetric(east in -8.0..8.0_f64, north in -8.0..8.0_f64, radius_m in 80.0..400.0_f64) {
        let manoeuvre = with(FlightPath::Orbit(orbit(radius_m, 100.0)), AttitudeMode::Coordinated, SpeedProfile::Airspeed(20.0), PayloadUse::Video);
        let craft = Craft { true_airspeed_mps: 20.0, bank_deg: 50.0, ..mapper() };
        let one = manoeuvre.fly(&craft, &camera(true), &windy(east, north)).unwrap();
        let other = manoeuvre.fly(&craft, &camera(true), &windy(-east, -north)).unwrap();
        prop_assert!((one.time_s - other.time_s).abs() < 1e-6 * one.time_s, "{} {}", one.time_s, other.time_s);
        let line = |track_deg: f64| {
            let path = StraightOver { track_deg, height_m: 100.0, length_m: 500.0, run_out_m: 0.0 };
            with(FlightPath::StraightOver(path), AttitudeMode::Coordinated, SpeedProfile::Airspeed(20.0), PayloadUse::Video)
        };
        let out = line(30.0).fly(&craft, &camera(true), &windy(east, north)).unwrap();
        let back = line(210.0).fly(&craft, &camera(true), &windy(-east, -north)).unwrap();
        prop_assert!((out.time_s - back.time_s).abs() < 1e-6 * out.time_s);
    }

    /// Wind makes a circle longer, from any side.
    #[test]
    fn wind_makes_an_orbit_longer(wind in 0.0..9.0_f64, more in 0.1..5.0_f64) {
        let path = orbit(300.0, 100.0);
        let at = |speed: f64| path.period_s(20.0, Wind { east_mps: speed, north_mps: 0.0, edr: 0.0 }).unwrap();
        prop_assert!(at(wind + more) > at(wind));
    }

    /// A line that sees more to both sides does not see less of the target.
    #[test]
    fn coverage_grows_with_the_height_and_so_the_swath(height_m in 500.0..4_000.0_f64, more in 1.05..1.6_f64) {
        let covered = |height_m: f64| {
            let path = StraightOver { track_deg: 0.0, height_m, length_m: 6_000.0, run_out_m: 0.0 };
            forecast(&scanned(FlightPath::StraightOver(path)), &predator(), &scanner(), &still(), (20_000.0, 6_000.0), 20.0).factors.coverage
        };
        let (low, high) = (covered(height_m), covered(height_m * more));
        prop_assert!(high >= low - 1e-9, "{low} {high}");
        let swath_m = 2.0 * height_m * libm::tan(43.0_f64.to_radians());
        prop_assert!((low - swath_m / 20_000.0).abs() < 0.01, "{low} of {}", swath_m / 20_000.0);
    }

    /// Poses follow each other in time, within the vehicle's speed, and their distances agree with their speeds.
    #[test]
    fn poses_are_continuous(spacing_m in 60.0..300.0_f64, rounds in 1_u32..6, east in -4.0..4.0_f64, north in -4.0..4.0_f64) {
        let square = ExpandingSquare { spacing_m, rounds, height_m: 50.0, first_track_deg: None };
        let manoeuvre = with(FlightPath::ExpandingSquare(square), AttitudeMode::Coordinated, SpeedProfile::Airspeed(8.0), PayloadUse::Video);
        let flown = manoeuvre.fly(&helicopter(), &camera(false), &windy(east, north)).unwrap();
        let mut length_m = 0.0;
        for pair in flown.poses.windows(2) {
            let (moved_m, lasts_s) = (pair[1].point.minus(pair[0].point).length(), pair[1].time_s - pair[0].time_s);
            prop_assert!(lasts_s > 0.0);
            prop_assert!((moved_m - pair[0].ground_speed_mps * lasts_s).abs() < 1e-6);
            prop_assert!(pair[0].true_airspeed_mps <= 20.6 + 1e-6);
            length_m += moved_m;
        }
        prop_assert!((length_m - square.length_m()).abs() < 1e-6 * length_m);
    }
}
