//! Manoeuvres: every worked number and test vector of the reference, and properties.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test stops where it is surprised")]

mod support;

use apex_geo::plane::Point;
use apex_geo::wind::Wind;
use apex_observation::clarity::AttitudeHold;
use apex_observation::footprint::FlatGround;
use apex_observation::grid::{GridSettings, TargetGrid};
use apex_observation::manoeuvres::*;
use apex_observation::predict::{AirConditions, PredictedScanner, PredictionContext};
use apex_observation::sensor::{CameraSetting, Gimbal, RateLimits, RollLimits};
use apex_observation::target::WantedLook;
use proptest::prelude::*;
use std::collections::BTreeMap;
use support::{CENTRE, near, rectangle, wide_scanner};

const HOLD: AttitudeHold =
    AttitudeHold { roll_deg_per_edr: 10.0, natural_frequency_rad_s: Some(1.0), damping_ratio: 0.7 };

/// Predator B: 95 m/s, 18 degrees.
fn predator() -> Craft {
    Craft {
        name: "predator-b".to_string(),
        can_hover: false,
        true_airspeed_mps: 95.0,
        true_airspeed_mps_min: 60.0,
        true_airspeed_mps_max: 118.0,
        bank_deg: 18.0,
        acceleration_mps2: 1.0,
        braking_mps2: 1.0,
        yaw_rate_deg_s: 0.0,
        climb_mps_max: 6.0,
        descent_mps_max: 8.0,
        rearward_mps_max: 0.0,
        sideways_mps_max: 0.0,
        wind_mps_max: 20.0,
        settle_s: 5.0,
        hold: HOLD,
        drain: DrainTable { points: vec![(95.0, 62.3 / 3_600.0)] },
    }
}

/// A mapping fixed wing: 13 m/s, 35 degrees, 20 m of lead-in.
fn mapper() -> Craft {
    Craft {
        name: "mapper".to_string(),
        true_airspeed_mps: 13.0,
        true_airspeed_mps_min: 11.0,
        true_airspeed_mps_max: 30.0,
        bank_deg: 35.0,
        settle_s: 20.0 / 13.0,
        ..predator()
    }
}

/// A helicopter: 8 m/s, 1.5 m/s^2, 45 deg/s.
fn helicopter() -> Craft {
    Craft {
        name: "rmax".to_string(),
        can_hover: true,
        true_airspeed_mps: 8.0,
        true_airspeed_mps_min: 0.0,
        true_airspeed_mps_max: 20.6,
        bank_deg: 20.0,
        acceleration_mps2: 1.5,
        braking_mps2: 1.5,
        yaw_rate_deg_s: 45.0,
        climb_mps_max: 8.0,
        descent_mps_max: 8.0,
        rearward_mps_max: 10.0,
        sideways_mps_max: 10.0,
        wind_mps_max: 10.0,
        settle_s: 0.0,
        drain: DrainTable { points: vec![(0.0, 600.0), (10.0, 560.0), (20.0, 700.0)] },
        ..predator()
    }
}

/// A camera of 60 by 45 degrees that tilts from straight down to 10 degrees up.
fn camera(pans: bool) -> Instrument {
    Instrument::Camera(CameraSetting {
        name: "camera-1".to_string(),
        wide_deg: 60.0,
        high_deg: 45.0,
        pixel_mrad: 0.5,
        exposure_s: 0.001,
        interval_s_min: 1.0,
        mount: Gimbal {
            pan_deg: if pans { (-180.0, 180.0) } else { (0.0, 0.0) },
            tilt_deg: (-90.0, 10.0),
            rate_deg_s: 60.0,
            settle_s: 0.4,
        },
        is_stabilised: true,
        roll: RollLimits { valid_deg: 30.0, zero_deg: None },
        smear: RateLimits { full_pixels: 1.0, zero_pixels: 2.0 },
        sun_deg_min: None,
    })
}

fn scanner() -> Instrument {
    let mut setting = wide_scanner(&[12.5, 25.0]);
    setting.roll = Some(RollLimits { valid_deg: 3.0, zero_deg: None });
    Instrument::Scanner(PredictedScanner { setting, hold: HOLD })
}

fn still() -> Scene {
    Scene::still(CENTRE, 0.0)
}

fn windy(east_mps: f64, north_mps: f64) -> Scene {
    Scene { wind: Wind { east_mps, north_mps, edr: 0.0 }, ..still() }
}

fn with(path: FlightPath, attitude: AttitudeMode, speed: SpeedProfile, payload: PayloadUse) -> Manoeuvre {
    Manoeuvre { path, attitude, speed, payload, data: DataHandling::Store }
}

fn scanned(path: FlightPath) -> Manoeuvre {
    with(path, AttitudeMode::Coordinated, SpeedProfile::Airspeed(95.0), PayloadUse::LineScan)
}

fn forecast(
    manoeuvre: &Manoeuvre,
    craft: &Craft,
    instrument: &Instrument,
    scene: &Scene,
    size: (f64, f64),
    want_m: f64,
) -> Forecast {
    let target = rectangle("field", size, vec![WantedLook::new("look", 100.0, want_m)]);
    let grid = TargetGrid::new(&target, GridSettings::default()).unwrap();
    let first = BTreeMap::new();
    let prediction = PredictionContext {
        zero_unix_s: support::ZERO_UNIX_S,
        ground: &FlatGround { elevation_m: 0.0 },
        conditions: &AirConditions::STILL,
        seen: None,
        products: &[],
        first_valid_s: &first,
        is_explained: false,
    };
    manoeuvre.forecast(craft, instrument, scene, &ForecastContext { target: &target, grid: &grid, prediction }).unwrap()
}

fn box_of(width_m: f64, depth_m: f64) -> Vec<(f64, f64)> {
    let (x, y) = (0.5 * width_m, 0.5 * depth_m);
    vec![(-x, -y), (x, -y), (x, y), (-x, y)]
}

fn sweep(width_m: f64, depth_m: f64, height_m: f64, swath_m: f64, sidelap: f64, track_deg: Option<f64>) -> Sweep {
    Sweep { corners: box_of(width_m, depth_m), height_m, swath_m, sidelap, track_deg, run_in_m: 0.0 }
}

fn orbit(radius_m: f64, height_m: f64) -> Orbit {
    Orbit { radius_m, height_m, turns: 1.0, from_deg: 180.0, clockwise: true }
}

fn arch() -> Arc {
    Arc {
        azimuth_deg: 0.0,
        shape: ArcShape::Arch { radius_m: 80.0 },
        from_elevation_deg: 30.0,
        speed_mps: 8.0,
        turn_speed_mps: 1.0,
        yaw_rate_deg_s: 45.0,
        acceleration_mps2: 1.5,
    }
}

#[test]
fn turn_radii_are_those_of_the_reference() {
    near(predator().turn_radius_m(95.0), 2_832.0, 1.0);
    near(mapper().turn_radius_m(15.0), 33.0, 0.5);
    near(mapper().turn_radius_m(13.0), 24.6, 0.1);
}

#[test]
fn a_turn_between_lines_takes_what_the_reference_says() {
    let craft = Craft { settle_s: 0.0, ..predator() };
    for (spacing_m, expected_s) in
        [(2_000.0, 192.4), (4_000.0, 159.1), (5_664.0, 95.0), (8_000.0, 118.2), (11_190.0, 151.8)]
    {
        let first = (Point { x: 0.0, y: 0.0 }, Point { x: 0.0, y: 10_000.0 });
        let second = (Point { x: spacing_m, y: 10_000.0 }, Point { x: spacing_m, y: 0.0 });
        near(turn_s(first, second, 95.0, &craft, &still()), expected_s, 0.15);
    }
}

#[test]
fn two_lines_of_a_predator_take_379_6_seconds() {
    // E3 with lead-ins of 5 s: lines at 2,000 and 6,000 m across an 8,000 m wide target, so 4,000 m apart.
    let path = sweep(8_000.0, 10_000.0, 6_000.0, 4_000.0, 0.0, Some(0.0));
    let flown = scanned(FlightPath::Sweep(path)).fly(&predator(), &scanner(), &still()).unwrap();
    near(flown.time_s, 379.6, 0.5);
}

#[test]
fn a_mapping_flight_has_12_lines_and_takes_13_7_minutes() {
    let side_m = libm::sqrt(600_000.0);
    assert_eq!(Sweep::line_count(side_m, 149.4, 59.8), 12);
    assert_eq!(Sweep::line_count(149.0, 149.4, 59.8), 1);
    let path = Sweep { run_in_m: 20.0, ..sweep(side_m, side_m, 120.0, 149.4, 0.6, Some(0.0)) };
    let lines = path.lines(0.0, &still()).unwrap();
    assert_eq!(lines.len(), 12);
    near((lines[1].0.x - lines[0].0.x).abs(), 56.8, 0.6);
    // The reference counts the turn between adjacent lines as half a circle and a straight: 84.9 m.
    let radius_m = mapper().turn_radius_m(13.0);
    near(std::f64::consts::PI * radius_m + 56.8 - 2.0 * radius_m, 84.9, 0.2);
    let whole_s: f64 = lines.iter().map(|(from, to)| to.minus(*from).length() / 13.0).sum::<f64>() + 11.0 * 84.9 / 13.0;
    near(whole_s / 60.0, 13.7, 0.05);
    // What is flown takes as long, with turns by Dubins: lead-ins are part of the lines here.
    let craft = Craft { settle_s: 0.0, ..mapper() };
    let manoeuvre = with(
        FlightPath::Sweep(path),
        AttitudeMode::Coordinated,
        SpeedProfile::Airspeed(13.0),
        PayloadUse::StillsEvery(24.9),
    );
    near(manoeuvre.fly(&craft, &camera(false), &still()).unwrap().time_s / 60.0, 13.7, 0.05);
    // 32 pictures on each line of 775 m.
    assert_eq!(12 * ((side_m / 24.9) as usize + 1), 384);
}

#[test]
fn lines_across_the_wind_are_quicker_than_along_it() {
    let time_s = |track_deg: f64| {
        let side_m = libm::sqrt(600_000.0);
        let path = Sweep { run_in_m: 20.0, ..sweep(side_m, side_m, 120.0, 149.4, 0.6, Some(track_deg)) };
        let scene = windy(0.0, -6.0);
        let lines = path.lines(track_deg, &scene).unwrap();
        let on_line = |(from, to): &(Point, Point)| {
            let step = to.minus(*from);
            let track_deg = libm::atan2(step.x, step.y).to_degrees();
            step.length() / apex_geo::wind::triangle(track_deg, 13.0, scene.wind).unwrap().ground_speed_mps
        };
        lines.iter().map(on_line).sum::<f64>() / 60.0
    };
    near(time_s(0.0), 15.9, 0.1);
    near(time_s(90.0), 14.1, 0.1);
    // The direction that is chosen is the one across.
    let path = sweep(800.0, 800.0, 120.0, 149.4, 0.6, None);
    let lines = path.best_lines(13.0, &mapper(), &windy(0.0, -6.0)).unwrap();
    let step = lines[0].1.minus(lines[0].0);
    assert!(step.y.abs() < 0.1 * step.x.abs(), "{step:?}");
}

#[test]
fn the_zaca_fire_takes_4_wide_or_8_narrow_lines() {
    let side_m = libm::sqrt(240_207.0 * 4_046.856_4);
    assert_eq!(Sweep::line_count(side_m, 11_190.0, 0.85 * 11_190.0), 4);
    assert_eq!(Sweep::line_count(side_m, 4_667.0, 0.85 * 4_667.0), 8);
    let path = sweep(side_m, side_m, 6_000.0, 11_190.0, 0.15, Some(0.0));
    let craft = Craft { settle_s: 0.0, ..predator() };
    let flown = scanned(FlightPath::Sweep(path)).fly(&craft, &scanner(), &still()).unwrap();
    near(flown.time_s / 60.0, 27.0, 0.8);
}

#[test]
fn lines_nearer_than_two_turn_radii_are_flown_in_another_order_where_that_is_quicker() {
    let path = sweep(12_000.0, 20_000.0, 3_000.0, 1_500.0, 0.0, Some(0.0));
    let craft = predator();
    let lines = path.best_lines(95.0, &craft, &still()).unwrap();
    let jumps = lines.windows(2).map(|pair| (pair[1].0.x - pair[0].0.x).abs());
    let greatest = jumps.fold(0.0, f64::max);
    assert!(greatest > 4_000.0, "{greatest}");
    // All lines are flown, each once.
    let mut across: Vec<i64> = lines.iter().map(|(from, _)| from.x.round() as i64).collect();
    across.sort_unstable();
    across.dedup();
    assert_eq!(across.len(), 8);
}

#[test]
fn a_line_aside_sees_10_m_pixels_at_30_degrees_from_6_000_m() {
    let path =
        StandOff { track_deg: 0.0, side: Side::Right, height_m: 6_000.0, look_angle_deg: 30.0, length_m: 10_000.0 };
    near(path.offset_m(), 3_464.0, 0.5);
    near(path.pixel_m(1.25e-3), 10.0, 1e-9);
    let flown = scanned(FlightPath::StandOff(path)).fly(&predator(), &scanner(), &still()).unwrap();
    // The target is to the right of a flight to the north: the line lies west of it.
    near(flown.poses[1].point.x, -3_464.0, 0.5);
    near(flown.time_s, 10_475.0 / 95.0, 0.01);
}

#[test]
fn straight_over_takes_its_length_and_lead_in() {
    let path = StraightOver { track_deg: 90.0, height_m: 6_000.0, length_m: 10_000.0, run_out_m: 0.0 };
    let manoeuvre = scanned(FlightPath::StraightOver(path));
    near(manoeuvre.fly(&predator(), &scanner(), &still()).unwrap().time_s, 10_475.0 / 95.0, 0.01);
    // E1: one centre line over 10 x 8 km from 6,000 m.
    let found = forecast(&manoeuvre, &predator(), &scanner(), &still(), (10_000.0, 8_000.0), 10.0);
    near(found.points, 99.5, 0.1);
    near(found.factors.resolution, 0.9946, 0.002);
}

#[test]
fn a_spiral_has_the_length_of_the_reference() {
    let spiral = Spiral {
        inner_radius_m: 100.0,
        outer_radius_m: 600.0,
        spacing_m: 100.0,
        height_m: 60.0,
        from_deg: 0.0,
        clockwise: true,
        inward: false,
    };
    near(spiral.length_m(), 11_010.0, 1.0);
    near(spiral.length_m_about(), 10_996.0, 1.0);
    let manoeuvre = with(
        FlightPath::Spiral(spiral),
        AttitudeMode::Coordinated,
        SpeedProfile::Airspeed(8.0),
        PayloadUse::StillsEvery(30.0),
    );
    let flown = manoeuvre.fly(&helicopter(), &camera(false), &still()).unwrap();
    near(flown.length_m, 11_010.0, 11.0);
}

#[test]
fn a_scanner_sees_nothing_valid_on_a_tight_spiral() {
    let spiral = |radius_m: f64| Spiral {
        inner_radius_m: radius_m,
        outer_radius_m: radius_m + 10_000.0,
        spacing_m: 5_000.0,
        height_m: 6_000.0,
        from_deg: 0.0,
        clockwise: true,
        inward: false,
    };
    let refusal = scanned(FlightPath::Spiral(spiral(5_000.0))).fly(&predator(), &scanner(), &still()).unwrap_err();
    assert_eq!(refusal.limit, 3.0);
    assert_eq!(
        refusal.to_string(),
        "`spiral`: a bank of 10.4 degrees breaks the limit of 3 degrees: lines of the scanner are valid only with the \
         wings level; a radius of 17560 m works, or a sweep"
    );
    assert!(scanned(FlightPath::Spiral(spiral(17_600.0))).fly(&predator(), &scanner(), &still()).is_ok());
}

#[test]
fn an_orbit_banks_as_the_reference_says() {
    let path = orbit(100.0, 100.0);
    near(path.look_angle_deg(), 45.0, 1e-9);
    near(path.slant_m(), 141.42, 0.01);
    let (upwind, downwind) = path.bank_deg(15.0, 5.0);
    near(upwind, 5.8, 0.05);
    near(downwind, 22.2, 0.05);
    let craft = Craft { true_airspeed_mps: 15.0, ..mapper() };
    near(craft.circle_radius_m_min(15.0, 5.0), 58.0, 0.5);
    let manoeuvre =
        with(FlightPath::Orbit(path), AttitudeMode::Coordinated, SpeedProfile::Airspeed(15.0), PayloadUse::Video);
    let flown = manoeuvre.fly(&craft, &camera(true), &windy(5.0, 0.0)).unwrap();
    near(flown.bank_deg_max, 22.2, 0.6);
    near(flown.time_s, path.period_s(15.0, windy(5.0, 0.0).wind).unwrap(), 0.2);
    let tight = Manoeuvre { path: FlightPath::Orbit(orbit(50.0, 100.0)), ..manoeuvre };
    let refusal = tight.fly(&craft, &camera(true), &windy(5.0, 0.0)).unwrap_err();
    near(refusal.limit, 58.0, 0.5);
    assert_eq!(refusal.nearest, "58 m works");
}

#[test]
fn the_arc_of_the_reference_takes_28_5_seconds_and_tracks_all_of_the_time() {
    let figures = arch().figures(45.0);
    near(figures.length_m, 167.6, 0.1);
    near(figures.tilt_rate_deg_s, 5.7, 0.05);
    near(figures.turn_drift_m, 4.0, 1e-9);
    near(figures.turn_drift_deg, 2.9, 0.05);
    near(figures.time_s, 28.5, 0.1);
    assert_eq!((figures.tracked_share, figures.tracked_share_without_turn), (1.0, 0.5));
    assert_eq!(Arc::limit_elevation_deg(-90.0, 0.0), 90.0);
    assert_eq!(Arc::limit_elevation_deg(-90.0, 5.0), 85.0);
    assert_eq!(Arc::limit_elevation_deg(-80.0, 0.0), 80.0);
    // As flown it begins and ends at rest: half of 8 m/s over 1.5 m/s^2 more at both ends.
    let manoeuvre =
        with(FlightPath::Arc(arch()), AttitudeMode::Pointing, SpeedProfile::GroundSpeed(8.0), PayloadUse::Video);
    let found = forecast(&manoeuvre, &helicopter(), &camera(false), &still(), (20.0, 20.0), 1.0);
    near(found.time_s, figures.time_s + 8.0 / 1.5, 0.6);
    assert_eq!(found.tracked_share, 1.0);
    // Nose first, the target leaves the picture half a field of view after the limit: at 112.5 of 150 degrees.
    let stubborn = Manoeuvre { attitude: AttitudeMode::Fixed { heading_deg: 0.0 }, ..manoeuvre };
    let found = forecast(&stubborn, &helicopter(), &camera(false), &still(), (20.0, 20.0), 1.0);
    assert!((0.5..0.8).contains(&found.tracked_share), "{}", found.tracked_share);
}

#[test]
fn a_level_pass_tilts_9_5_degrees_a_second_overhead() {
    let level = Arc { shape: ArcShape::Level { height_m: 60.0 }, speed_mps: 10.0, turn_speed_mps: 10.0, ..arch() };
    near(level.figures(45.0).tilt_rate_deg_s, 9.5, 0.06);
}

#[test]
fn an_arc_is_refused_where_vehicle_mount_or_wind_do_not_permit_it() {
    let manoeuvre = |arc: Arc| {
        with(FlightPath::Arc(arc), AttitudeMode::Pointing, SpeedProfile::GroundSpeed(8.0), PayloadUse::Video)
    };
    let refused =
        |arc: Arc, craft: &Craft, scene: &Scene| manoeuvre(arc).fly(craft, &camera(false), scene).unwrap_err();
    let plane = refused(arch(), &Craft { can_hover: false, ..helicopter() }, &still());
    assert!(plane.to_string().contains("does not pan"), "{plane}");
    let slow = refused(arch(), &Craft { climb_mps_max: 3.0, ..helicopter() }, &still());
    assert_eq!(slow.nearest, "a speed of 3.5 m/s works, or a level pass");
    let head = refused(Arc { shape: ArcShape::Level { height_m: 60.0 }, ..arch() }, &helicopter(), &windy(0.0, -5.0));
    assert_eq!(head.figure, "an airspeed tail first");
    assert_eq!(head.nearest, "a speed of 5.0 m/s works, or a motion towards 180 degrees, with the wind");
    let quick = refused(
        Arc { shape: ArcShape::Level { height_m: 60.0 }, yaw_rate_deg_s: 90.0, ..arch() },
        &helicopter(),
        &still(),
    );
    assert_eq!(quick.nearest, "45 deg/s works");
}

#[test]
fn a_pirouette_takes_9_pictures_of_a_ring() {
    let path = Pirouette { height_m: 60.0, depression_deg: 30.0, overlap: 0.3, from_deg: 0.0, dwell_s: 2.0 };
    assert_eq!(path.frames(60.0), 9);
    let (inner, outer) = path.ring_m(45.0);
    near(inner, 46.0, 0.1);
    near(outer, 456.0, 0.3);
    let manoeuvre = with(
        FlightPath::Pirouette(path),
        AttitudeMode::Pointing,
        SpeedProfile::Airspeed(8.0),
        PayloadUse::StillsInterval(2.0),
    );
    let found = forecast(&manoeuvre, &helicopter(), &camera(false), &still(), (160.0, 160.0), 1.0);
    assert_eq!(found.pictures, 9);
    near(found.time_s, 9.0 * 2.0 + 320.0 / 45.0, 0.01);
    // The hole in the middle is not seen. Its corners are those of pictures: its radius is 46 m in their middle.
    let hole = std::f64::consts::PI * inner * inner / (160.0 * 160.0);
    near(1.0 - found.factors.coverage, hole, 0.05);
    let refusal = manoeuvre.fly(&helicopter(), &camera(false), &windy(12.0, 0.0)).unwrap_err();
    assert_eq!((refusal.value, refusal.limit), (12.0, 10.0));
}

#[test]
fn a_strafe_keeps_the_distance_of_its_pixels() {
    near(Strafe::distance_m_for(0.02, 0.5e-3), 40.0, 1e-9);
    let path = Strafe { track_deg: 90.0, length_m: 120.0, distance_m: 40.0, height_m: 20.0, speed_mps: 5.0 };
    near(path.depression_deg(), 26.565, 0.001);
    let manoeuvre = with(
        FlightPath::Strafe(path),
        AttitudeMode::Fixed { heading_deg: 180.0 },
        SpeedProfile::GroundSpeed(5.0),
        PayloadUse::StillsEvery(10.0),
    );
    let flown = manoeuvre.fly(&helicopter(), &camera(false), &still()).unwrap();
    near(flown.time_s, 120.0 / 5.0 + 5.0 / 1.5, 0.05);
    // It flies east with the facade to the south of it.
    near(flown.poses[0].point.y, 40.0, 1e-6);
    let fast = Manoeuvre { path: FlightPath::Strafe(Strafe { speed_mps: 12.0, ..path }), ..manoeuvre };
    assert_eq!(fast.fly(&helicopter(), &camera(false), &still()).unwrap_err().nearest, "a speed of 10.0 m/s works");
}

#[test]
fn a_vantage_point_with_the_sun_behind_is_best() {
    let needs = VantageNeeds {
        wanted_m: 0.1,
        pixel_rad: 0.5e-3,
        look_angle_deg: (30.0, 60.0),
        sun_deg: Some((200.0, 40.0)),
        wind_mps_max: 10.0,
    };
    let at = |azimuth_deg: f64, look_angle_deg: f64, slant_m: f64| {
        VantagePoint { azimuth_deg, look_angle_deg, slant_m, dwell_s: 20.0 }.score(&needs, (1.0, 1.0), 2.0)
    };
    let best = at(200.0, 45.0, 100.0);
    near(best.product(), 0.8, 1e-9);
    assert_eq!(at(20.0, 45.0, 100.0).sun, 0.0);
    assert_eq!(at(200.0, 70.0, 100.0).angle, 0.0);
    // 0.5 mrad at 200 m, seen at 45 degrees: 0.141 m of 0.1 wanted.
    near(at(200.0, 45.0, 200.0).resolution, 0.586, 0.001);
    let hidden = VantagePoint { azimuth_deg: 200.0, look_angle_deg: 45.0, slant_m: 100.0, dwell_s: 20.0 };
    assert_eq!(hidden.score(&needs, (0.0, 1.0), 2.0).product(), 0.0);
    near(hidden.height_m(), 70.71, 0.01);
}

#[test]
fn an_expanding_square_of_5_rounds_is_6_km_long() {
    let square = ExpandingSquare { spacing_m: 200.0, rounds: 5, height_m: 60.0, first_track_deg: None };
    assert_eq!(square.length_m(), 6_000.0);
    assert_eq!(square.side_m(), 1_200.0);
    let corners = square.corners(&windy(0.0, 3.0));
    // Into the wind from the south.
    near(corners[1].y, -200.0, 1e-9);
    assert_eq!(corners.len(), 11);
    let manoeuvre = with(
        FlightPath::ExpandingSquare(square),
        AttitudeMode::Coordinated,
        SpeedProfile::Airspeed(13.0),
        PayloadUse::StillsEvery(20.0),
    );
    assert!(manoeuvre.fly(&mapper(), &camera(true), &still()).is_ok());
    let refusal = scanned(FlightPath::ExpandingSquare(square)).fly(&predator(), &scanner(), &still()).unwrap_err();
    assert_eq!(refusal.nearest, "5665 m works");
}

#[test]
fn a_sector_search_passes_its_datum_and_has_9_legs() {
    let sector = SectorSearch { radius_m: 500.0, height_m: 60.0, first_track_deg: None };
    assert_eq!(sector.length_m(), 4_500.0);
    let corners = sector.corners(&still());
    assert_eq!(corners.len(), 10);
    for datum in [0, 3, 6, 9] {
        near(corners[datum].length(), 0.0, 1e-6);
    }
    let outer: Vec<f64> = [1, 2, 4, 5, 7, 8].iter().map(|index| corners[*index].length()).collect();
    assert!(outer.iter().all(|length| (length - 500.0).abs() < 1e-6), "{outer:?}");
}

#[test]
fn search_effort_gives_the_published_probabilities() {
    use search_effort::{coverage_factor, parallel_probability, random_probability};
    near(random_probability(1.0), 0.632, 5e-4);
    near(parallel_probability(1.0), 0.790, 5e-4);
    near(random_probability(2.0), 0.865, 5e-4);
    near(parallel_probability(2.0), 0.988, 5e-4);
    near(coverage_factor(200.0, 6_000.0, 1.2e6), 1.0, 1e-12);
}

#[test]
fn sensors_and_manoeuvres_that_do_not_fit_are_refused() {
    let over = StraightOver { track_deg: 0.0, height_m: 100.0, length_m: 200.0, run_out_m: 0.0 };
    let wrong = with(
        FlightPath::StraightOver(over),
        AttitudeMode::Coordinated,
        SpeedProfile::Airspeed(13.0),
        PayloadUse::LineScan,
    );
    let refusal = wrong.fly(&mapper(), &camera(false), &still()).unwrap_err();
    assert_eq!(refusal.nearest, "record stills or video with the camera");
    let pointing = Manoeuvre { attitude: AttitudeMode::Pointing, payload: PayloadUse::Video, ..wrong.clone() };
    assert!(pointing.fly(&mapper(), &camera(false), &still()).is_err());
    assert!(pointing.fly(&mapper(), &camera(true), &still()).is_ok());
    let slow = Manoeuvre { payload: PayloadUse::Video, speed: SpeedProfile::GroundSpeed(40.0), ..wrong.clone() };
    let refusal = slow.fly(&mapper(), &camera(false), &still()).unwrap_err();
    assert_eq!((refusal.figure.as_str(), refusal.nearest.as_str()), ("a true airspeed", "30.0 m/s works"));
    let stream = DataHandling::Stream { rate_bit_s: 8e6, link_bit_s: 1e6 };
    let loud = Manoeuvre { data: stream, payload: PayloadUse::Video, ..wrong };
    assert_eq!(
        loud.fly(&mapper(), &camera(false), &still()).unwrap_err().nearest,
        "store the data, or process it on board"
    );
}

#[test]
fn data_reach_the_ground_by_their_handling() {
    assert_eq!(DataHandling::Store.on_ground_s(100.0), None);
    assert_eq!(DataHandling::Stream { rate_bit_s: 1e6, link_bit_s: 2e6 }.on_ground_s(100.0), Some(100.0));
    let product = DataHandling::Process { delay_s: 60.0, product_bit: 8e6, link_bit_s: 1e6 };
    assert_eq!(product.on_ground_s(100.0), Some(168.0));
}

#[test]
fn energy_is_the_drain_at_the_airspeed_over_the_time() {
    let manoeuvre = with(
        FlightPath::VantagePoint(VantagePoint { azimuth_deg: 0.0, look_angle_deg: 40.0, slant_m: 80.0, dwell_s: 20.0 }),
        AttitudeMode::Pointing,
        SpeedProfile::Airspeed(8.0),
        PayloadUse::Video,
    );
    let flown = manoeuvre.fly(&helicopter(), &camera(false), &windy(5.0, 0.0)).unwrap();
    // Hovering in a wind of 5 m/s drains as flying at 5 m/s: 580 W.
    near(flown.energy, 580.0 * 20.0, 1e-6);
    // The pipeline of the reference: 65, 83 and 97 Wh.
    let quad = DrainTable { points: vec![(0.0, 598.0), (5.0, 580.0), (12.0, 560.0)] };
    near(quad.per_s(12.0) * 5_000.0 / 12.0 / 3_600.0, 65.0, 0.5);
    near(quad.per_s(0.0) * 25.0 * 20.0 / 3_600.0, 83.0, 0.5);
    near(quad.per_s(5.0) * 3_000.0 / 5.0 / 3_600.0, 97.0, 0.5);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Every point of the square that is searched is within half a spacing of a leg, but for a corner at the datum: an independent, naive distance.
    #[test]
    fn every_point_of_an_expanding_square_is_within_half_a_spacing(
        spacing_m in 20.0..500.0_f64, rounds in 1_u32..7, first_deg in 0.0..360.0_f64,
        along in -1.0..1.0_f64, across in -1.0..1.0_f64,
    ) {
        let square = ExpandingSquare { spacing_m, rounds, height_m: 50.0, first_track_deg: Some(first_deg) };
        let corners = square.corners(&still());
        // The part that whole turns of the square enclose.
        let reach_m = spacing_m * f64::from((rounds - 1) / 2);
        let (sine, cosine) = (first_deg.to_radians().sin(), first_deg.to_radians().cos());
        let (a, b) = (along * reach_m, across * reach_m);
        let point = Point { x: a * sine + b * cosine, y: a * cosine - b * sine };
        let distance = |from: Point, to: Point| {
            let step = to.minus(from);
            let share = (point.minus(from).dot(step) / step.dot(step)).clamp(0.0, 1.0);
            point.minus(from.plus(share, step)).length()
        };
        let nearest = corners.windows(2).map(|pair| distance(pair[0], pair[1])).fold(f64::INFINITY, f64::min);
        // Behind the beginning, three legs are farther: the point as far from the datum as from two legs, (2 - sqrt 2) S.
        let most = if point.length() >= spacing_m { 0.5 } else { 2.0 - std::f64::consts::SQRT_2 };
        prop_assert!(reach_m == 0.0 || nearest <= most * spacing_m + 1e-6, "{nearest} of {spacing_m}");
    }

    /// The wind from the other side takes the same path backwards: a circle takes as long, a line and back, too.
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

    /// No wind makes a circle quicker.
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
        let swath_m = 2.0 * height_m * 43.0_f64.to_radians().tan();
        prop_assert!((low - swath_m / 20_000.0).abs() < 0.01, "{low} of {}", swath_m / 20_000.0);
    }

    /// Poses follow each other in time, no faster than the vehicle, and their distances are what their speeds say.
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
