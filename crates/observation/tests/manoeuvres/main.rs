//! Manoeuvres: every worked number and test vector of the reference, and properties.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test that cannot continue fails")]

mod fixtures;
mod nearest;
mod properties;
#[path = "../support/mod.rs"]
mod support;

use apex_geo::plane::Point;
use apex_observation::manoeuvres::*;
use fixtures::*;
use support::near;

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
    // The flown path takes as long, with Dubins turns; the lines here include the lead-ins.
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
    // The chosen direction is the one across.
    let path = sweep(800.0, 800.0, 120.0, 149.4, 0.6, None);
    let lines = path.best_lines(13.0, &mapper(), &windy(0.0, -6.0)).unwrap();
    let step = lines[0].1.minus(lines[0].0);
    assert!(step.y.abs() < 0.1 * step.x.abs(), "{step:?}");
}

#[test]
fn the_direction_along_a_long_area_is_found_whatever_its_number_of_corners() {
    // An ellipse of 10 km by 1 km with its length towards 120 degrees.
    let (sine, cosine) = (libm::sin(120_f64.to_radians()), libm::cos(120_f64.to_radians()));
    let corner = |place: u32| {
        let angle = std::f64::consts::TAU * f64::from(place) / 200.0;
        let (along, across) = (5_000.0 * libm::cos(angle), 500.0 * libm::sin(angle));
        (along * sine + across * cosine, along * cosine - across * sine)
    };
    let path = Sweep { corners: (0..200).map(corner).collect(), ..sweep(1.0, 1.0, 120.0, 149.4, 0.0, None) };
    let lines = path.best_lines(13.0, &mapper(), &still()).unwrap();
    let step = lines[0].1.minus(lines[0].0);
    let track_deg = libm::atan2(step.x, step.y).to_degrees().rem_euclid(180.0);
    near(track_deg, 120.0, 3.0);
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
         wings level; a radius of 17561 m works, or a sweep"
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
    assert_eq!(refusal.nearest, "59 m works");
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
    // As flown it begins and ends at rest: half of the time for 8 m/s at 1.5 m/s^2 more at both ends.
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
    assert_eq!(slow.nearest, "a speed of 3.4 m/s works, or a level pass");
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
    assert_eq!(
        (refusal.figure.as_str(), refusal.nearest.as_str()),
        ("a true airspeed", "a ground speed of 30.0 m/s works in this wind")
    );
    let stream = DataHandling::Stream { picture_bit: 8e6, link_bit_s: 1e6 };
    let loud = Manoeuvre { data: stream, payload: PayloadUse::Video, ..wrong };
    assert_eq!(
        loud.fly(&mapper(), &camera(false), &still()).unwrap_err().nearest,
        "take a picture every 8.0 s, store the data, or process it on board"
    );
}

/// Pictures leave in sequence: a link that is slower than the camera is late by all that waits.
#[test]
fn data_reach_the_ground_by_their_handling() {
    let taken_s = [100.0, 102.0, 104.0, 130.0];
    assert_eq!(DataHandling::Store.arrivals_s(taken_s), None);
    let stream = DataHandling::Stream { picture_bit: 2e6, link_bit_s: 2e6 };
    assert_eq!(stream.arrivals_s(taken_s), Some(vec![101.0, 103.0, 105.0, 131.0]));
    let slow = DataHandling::Stream { picture_bit: 16e6, link_bit_s: 2e6 };
    assert_eq!(slow.arrivals_s(taken_s), Some(vec![108.0, 116.0, 124.0, 138.0]));
    let product = DataHandling::Process { delay_s: 60.0, product_bit: 8e6, link_bit_s: 1e6 };
    assert_eq!(product.arrivals_s(taken_s), Some(vec![168.0, 176.0, 184.0, 198.0]));
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
