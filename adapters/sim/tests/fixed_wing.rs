//! The fixed wing: leg times in wind, turns, lines, fuel, take-off and landing, turbulence.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test that fails should stop")]

mod common;

use apex_geo::{geodesy, wind as wind_query};
use apex_model::problem::Position;
use apex_model::quantity::{Quantity, unit_named};
use apex_model::value::Value;
use apex_runtime::ports::Vehicle;
use apex_sim::Start;
use common::{Run, form, location, predator, wind, word};

const RAD_PER_DEG: f64 = geodesy::RAD_PER_DEG;

fn cruising(wind_field: apex_model::problem::WindField) -> Run {
    let mut config = predator(Start::in_flight(40.0, -120.0, 7_010.0, 45.0));
    config.wind = wind_field;
    Run::new(config)
}

#[test]
fn a_long_leg_takes_the_time_that_geometry_and_wind_say() {
    let (from, to) = (Position::new(40.0, -120.0), Position::new(43.0, -114.5));
    for field in [wind(0.0, 0.0, 0.0), wind(30.0, 0.0, 0.0), wind(-20.0, -15.0, 0.0)] {
        let mut run = cruising(field.clone());
        run.carry_out(form("fly-to", [location(43.0, -114.5)]), 20_000.0).unwrap();
        let expected = wind_query::leg_time_s(from, to, 7_010.0, 95.2, &field, 0.0).unwrap();
        let flown = run.now.seconds();
        assert!((flown - expected).abs() < 0.003 * expected + 5.0, "{flown} against {expected}");
        assert!(geodesy::distance_m(run.world.position(), to) < 150.0);
    }
}

#[test]
fn a_turn_has_the_radius_that_bank_and_speed_give() {
    let mut run = cruising(wind(0.0, 0.0, 0.0));
    let radius = Value::Quantity(Quantity::of(4.0, unit_named("km").unwrap()));
    run.send(form("loiter", [location(40.05, -120.0), word(":radius"), radius]));
    run.wait_s(900.0);
    let centre = Position::new(40.05, -120.0);
    let settled: Vec<Value> =
        run.values("location").into_iter().filter(|(at, _)| *at > 500.0).map(|(_, v)| v).collect();
    assert!(settled.len() > 50);
    for place in settled {
        let items: Vec<f64> = place.as_list().unwrap().iter().map(|item| item.as_number().unwrap().0).collect();
        let distance = geodesy::distance_m(centre, Position::new(items[0], items[1]));
        assert!((distance - 4_000.0).abs() < 60.0, "{distance}");
    }
    // tan(bank) = v^2 / (g r)
    let bank = libm::atan(95.2 * 95.2 / (9.80665 * 4_000.0));
    assert!(
        (run.last_number("roll-angle").abs() - bank).abs() < 0.5 * RAD_PER_DEG,
        "{}",
        run.last_number("roll-angle")
    );
}

#[test]
fn a_line_is_flown_wings_level_on_the_line() {
    for field in [wind(0.0, 0.0, 0.0), wind(20.0, 10.0, 0.0)] {
        let mut run = cruising(field);
        let (a, b) = (Position::new(40.3, -119.8), Position::new(40.3, -120.2));
        let line = form("fly-line", [location(40.3, -119.8), location(40.3, -120.2)]);
        let share = run.carry_out(line, 6_000.0).unwrap();
        assert!(share.equals(&Value::Real(1.0)), "share level {share}");
        let phases = run.values("flight-phase");
        let began = phases.iter().rev().find(|(_, phase)| phase.to_string() == "line").unwrap().0;
        let on_line = |samples: Vec<(f64, f64)>| samples.into_iter().filter(move |(at, _)| *at >= began);
        let worst = on_line(run.numbers("roll-angle")).map(|(_, roll)| roll.abs()).fold(0.0, f64::max);
        assert!(worst < 3.0 * RAD_PER_DEG, "{}", worst / RAD_PER_DEG);
        for (_, place) in run.values("location").into_iter().filter(|(at, _)| *at >= began) {
            let items: Vec<f64> = place.as_list().unwrap().iter().map(|item| item.as_number().unwrap().0).collect();
            let (_, across) = geodesy::along_cross_track_m(a, b, Position::new(items[0], items[1]));
            assert!(across.abs() < 130.0, "{across} m off the line");
        }
    }
}

#[test]
fn parallel_lines_are_flown_to_and_fro() {
    let mut run = cruising(wind(15.0, -5.0, 0.0));
    for index in 0..5 {
        let longitude = -120.0 + 0.05 * f64::from(index);
        let (south, north) = (location(40.2, longitude), location(40.5, longitude));
        let ends = if index % 2 == 0 { [south, north] } else { [north, south] };
        let share = run.carry_out(form("fly-line", ends), 4_000.0).unwrap().as_number().unwrap().0;
        assert!(share > 0.99, "line {index}: {share}");
    }
    assert!(run.now.seconds() < 6_000.0, "{}", run.now.seconds());
}

#[test]
fn turbulence_takes_the_wings_off_level_and_the_scan_with_it() {
    // Ten degrees of roll for each unit of EDR: sigma is 3 deg, and erf(1 / sqrt 2) of the time is within 3 deg.
    let mut run = cruising(wind(0.0, 0.0, 0.3));
    run.carry_out(form("scanner", [word("on")]), 1.0).unwrap();
    let share = run.carry_out(form("fly-line", [location(40.2, -120.0), location(41.2, -120.0)]), 9_000.0).unwrap();
    let share = share.as_number().unwrap().0;
    assert!((0.58..0.78).contains(&share), "{share}");
    let invalid = run.values("scan-valid").iter().filter(|(_, valid)| !valid.is_true()).count();
    assert!(invalid > 30, "{invalid}");
    let rolls = run.numbers("roll-angle");
    let squares: f64 = rolls.iter().map(|(_, roll)| (roll / RAD_PER_DEG) * (roll / RAD_PER_DEG)).sum();
    assert!(squares / rolls.len() as f64 > 4.0, "{}", squares / rolls.len() as f64);
}

#[test]
fn endurance_is_more_than_a_day_and_an_empty_tank_ends_the_flight() {
    let mut run = cruising(wind(0.0, 0.0, 0.0));
    run.wait_s(3_600.0);
    let hours = run.last_number("endurance-remaining") / 3_600.0;
    assert!((24.0..30.0).contains(&hours), "{hours}");
    let burnt = 1_769.0 - run.world.stored();
    assert!((60.0..70.0).contains(&burnt), "{burnt}");

    let mut config = predator(Start::in_flight(40.0, -120.0, 3_000.0, 45.0));
    config.start.fuel_share = Some(0.01);
    let mut run = Run::new(config);
    let flight = run.send(form("fly-to", [location(45.0, -120.0)]));
    run.wait_s(4_000.0);
    let empty = run.event("(fuel-exhausted aircraft-1)").unwrap();
    let down = run.event("(crashed aircraft-1)").unwrap();
    assert!((down - empty - 3_000.0 * 18.0 / 95.0).abs() < 150.0, "glided {} s", down - empty);
    assert_eq!(run.answer(flight).unwrap().1, Err("aircraft-1 has crashed".to_owned()));
    assert!(run.carry_out(form("land", [location(40.0, -120.0)]), 1.0).unwrap_err().contains("crashed"));
}

#[test]
fn it_takes_off_climbs_and_lands_into_the_wind() {
    let mut config = predator(Start::on_ground(34.905, -117.884, 702.0, 225.0));
    config.wind = wind(8.0, 0.0, 0.0);
    let mut run = Run::new(config);
    let early = run.carry_out(form("fly-to", [location(35.0, -118.0)]), 1.0);
    assert!(early.unwrap_err().contains("take off first"));
    run.carry_out(form("take-off", [Value::Real(2_000.0)]), 1_000.0).unwrap();
    assert!(run.event("(airborne aircraft-1)").unwrap() < 60.0);
    assert!((run.world.altitude_m() - 2_000.0).abs() < 11.0);
    let climbing = run.carry_out(form("fly-to", [Value::list([35.4, -118.4, 7_010.0].map(Value::Real))]), 4_000.0);
    climbing.unwrap();
    assert!((run.world.altitude_m() - 7_010.0).abs() < 45.0);
    run.carry_out(form("land", [location(34.905, -117.884)]), 6_000.0).unwrap();
    assert!(run.event("(landed aircraft-1)").is_some() && run.event("(crashed aircraft-1)").is_none());
    let heading = run.last_number("heading") / RAD_PER_DEG;
    assert!((heading - 270.0).abs() < 5.0, "landed towards {heading}");
    assert!(geodesy::distance_m(run.world.position(), Position::new(34.905, -117.884)) < 2_000.0);
    assert_eq!(run.values("on-ground").last().unwrap().1, Value::symbol("t"));
}

#[test]
fn a_command_stopped_leaves_the_aircraft_circling() {
    let mut run = cruising(wind(0.0, 0.0, 0.0));
    let first = run.send(form("fly-to", [location(44.0, -120.0)]));
    run.wait_s(60.0);
    let second = run.send(form("fly-to", [location(36.0, -120.0)]));
    run.wait_s(60.0);
    assert!(run.answer(first).unwrap().1.unwrap_err().starts_with("superseded by (fly-to (36.0 -120.0))"));
    let here = run.world.position();
    apex_runtime::ports::Vehicle::withdraw(&mut run.world, second, run.now);
    run.wait_s(3_000.0);
    assert!(geodesy::distance_m(here, run.world.position()) < 12_000.0);
    assert_eq!(run.answer(second), None);
    assert_eq!(run.values("flight-phase").last().unwrap().1.to_string(), "loitering");
}

#[test]
fn altitude_and_speed_are_setpoints_of_their_own() {
    let mut run = cruising(wind(0.0, 0.0, 0.0));
    let flight = run.send(form("fly-to", [location(44.0, -120.0)]));
    let feet = Value::Quantity(Quantity::of(180.0, unit_named("FL").unwrap()));
    run.carry_out(form("set-altitude", [feet]), 600.0).unwrap();
    assert!((run.world.altitude_m() - 5_486.4).abs() < 11.0);
    let knots = Value::Quantity(Quantity::of(200.0, unit_named("kt").unwrap()));
    run.carry_out(form("set-speed", [knots]), 60.0).unwrap();
    assert!((run.last_number("true-airspeed") - 102.9).abs() < 1.5);
    assert_eq!(run.answer(flight), None);
}

/// The way kept its altitude, and the setpoint took effect at its end.
#[test]
fn a_set_altitude_replaces_the_altitudes_of_a_way() {
    for (head, ends) in
        [("fly-to", vec![location(44.0, -120.0)]), ("join-line", vec![location(44.0, -120.0), location(44.3, -120.0)])]
    {
        let mut run = cruising(wind(0.0, 0.0, 0.0));
        let before_m = run.world.altitude_m();
        let way = Value::list([Value::list([43.9, -120.0, before_m].map(Value::Real))]);
        let flight = run.send(form(head, ends.into_iter().chain([word(":via"), way])));
        run.wait_s(30.0);
        run.carry_out(form("set-altitude", [Value::Real(before_m - 500.0)]), 600.0).unwrap();
        run.wait_s(120.0);
        assert!((run.world.altitude_m() - before_m + 500.0).abs() < 11.0, "{head}: {}", run.world.altitude_m());
        assert_eq!(run.answer(flight), None, "{head} continues");
    }
}

#[test]
fn a_joined_line_is_flown_on_without_a_second_turn() {
    let mut run = cruising(wind(10.0, -10.0, 0.0));
    let ends = || [location(40.3, -119.8), location(40.3, -120.2)];
    run.carry_out(form("join-line", ends()), 3_000.0).unwrap();
    assert!(geodesy::distance_m(run.world.position(), Position::new(40.3, -119.8)) < 150.0);
    run.carry_out(form("scanner", [word("on")]), 0.0).unwrap();
    let begun = run.now.seconds();
    run.carry_out(form("fly-line", ends()), 1_000.0).unwrap();
    let length = geodesy::distance_m(Position::new(40.3, -119.8), Position::new(40.3, -120.2));
    let flown = run.now.seconds() - begun;
    assert!((flown - length / 84.0).abs() < 15.0, "{flown} s for {length} m");
}

/// The re-flight of the paper: the line's command is withdrawn, a part of the line is joined and flown again, then the whole line is
/// commanded again, at once or after some seconds.
#[test]
fn after_a_refly_the_line_continues_without_a_circle() {
    let (from, to) = (Position::new(40.3, -119.8), Position::new(40.3, -120.4));
    let ends = || [location(40.3, -119.8), location(40.3, -120.4)];
    let length_m = geodesy::distance_m(from, to);
    for (east, north) in [(0.0, 0.0), (12.0, 9.0), (-20.0, 0.0)] {
        // The part may end before, at or after the place where the line was left.
        for (past_m, pause_s) in [(0.0, 0.0), (-1_500.0, 0.0), (1_500.0, 0.0), (0.0, 2.0), (1_500.0, 1.3)] {
            let mut run = cruising(wind(east, north, 0.0));
            let first = run.send(form("fly-line", ends()));
            run.wait_s(600.0);
            let left_m = geodesy::distance_m(from, run.world.position());
            run.world.withdraw(first, run.now);
            run.wait_s(3.0);
            let on_line = |along_m: f64| geodesy::interpolate(from, to, along_m / length_m);
            let (a, b) = (on_line(left_m - 4_000.0), on_line(left_m + past_m));
            let part = || [location(a.latitude_deg, a.longitude_deg), location(b.latitude_deg, b.longitude_deg)];
            run.carry_out(form("join-line", part()), 2_000.0).unwrap();
            run.carry_out(form("fly-line", part()), 2_000.0).unwrap();
            let speed = run.last_number("ground-speed");
            let begun = run.now.seconds();
            run.wait_s(pause_s);
            let share = run.carry_out(form("fly-line", ends()), 3_000.0).unwrap().as_number().unwrap().0;
            let flown_s = run.now.seconds() - begun;
            let rest_s = (length_m - left_m - past_m) / speed;
            let case = format!("wind {east} {north}, {past_m} m past the break, {pause_s} s later");
            assert!((-20.0..60.0).contains(&(flown_s - rest_s)), "{case}: {flown_s} s for {rest_s}");
            assert!(share > 0.98, "{case}: {share}");
            assert_eq!(run.answer(first), None);
        }
    }
}

#[test]
fn a_line_broken_off_twice_is_still_taken_up_where_it_was_left() {
    let mut run = cruising(wind(5.0, 5.0, 0.0));
    let ends = || [location(40.3, -119.8), location(40.3, -120.4)];
    run.send(form("fly-line", ends()));
    run.wait_s(600.0);
    let left_m = geodesy::distance_m(Position::new(40.3, -119.8), run.world.position());
    run.carry_out(form("fly-to", [location(40.5, -120.0)]), 2_000.0).unwrap();
    run.send(form("fly-line", ends()));
    run.wait_s(60.0);
    run.carry_out(form("fly-to", [location(40.5, -120.2)]), 2_000.0).unwrap();
    run.carry_out(form("fly-line", ends()), 2_000.0).unwrap();
    let phases = run.values("flight-phase");
    let is_line = |(_, phase): &&(f64, Value)| phase.to_string() == "line";
    let begun = phases.iter().rev().skip_while(|each| !is_line(each)).take_while(is_line).last().unwrap().0;
    let flown_s = run.now.seconds() - begun;
    let whole_m = geodesy::distance_m(Position::new(40.3, -119.8), Position::new(40.3, -120.4));
    let rest_s = (whole_m - left_m) / 90.0;
    assert!(left_m > 10_000.0 && (flown_s - rest_s).abs() < 15.0, "{flown_s} s for {rest_s}");
}

/// Six degrees off the line, as after a short part in wind: the aircraft corrects its course along the line. Another join takes minutes.
#[test]
fn a_line_is_taken_up_a_few_degrees_off_its_course() {
    let (from, to) = (Position::new(40.3, -119.8), Position::new(40.3, -120.4));
    let ends = || [location(40.3, -119.8), location(40.3, -120.4)];
    for side_deg in [-6.0, 6.0] {
        let mut run = cruising(wind(5.0, 5.0, 0.0));
        run.send(form("fly-line", ends()));
        run.wait_s(600.0);
        let (left_m, _) = geodesy::along_cross_track_m(from, to, run.world.position());
        let left = geodesy::interpolate(from, to, left_m / geodesy::distance_m(from, to));
        for back_m in [40_000.0, 20_000.0, 0.0] {
            let back_deg = geodesy::azimuth_deg(left, from) + side_deg;
            let place = geodesy::destination(left, back_deg, back_m);
            run.carry_out(form("fly-to", [location(place.latitude_deg, place.longitude_deg)]), 2_000.0).unwrap();
        }
        let begun = run.now.seconds();
        run.carry_out(form("fly-line", ends()), 2_000.0).unwrap();
        let rest_s = (geodesy::distance_m(from, to) - left_m) / 89.0;
        let flown_s = run.now.seconds() - begun;
        assert!((flown_s - rest_s).abs() < 30.0, "{side_deg} degrees: {flown_s} s for {rest_s}");
    }
}

#[test]
fn a_line_broken_off_for_a_refly_is_taken_up_where_it_was_left() {
    let mut run = cruising(wind(5.0, 5.0, 0.0));
    let (from, to) = (Position::new(40.3, -119.8), Position::new(40.3, -120.4));
    let ends = || [location(40.3, -119.8), location(40.3, -120.4)];
    let first = run.send(form("fly-line", ends()));
    run.wait_s(600.0);
    let (left_m, _) = geodesy::along_cross_track_m(from, to, run.world.position());
    assert!((10_000.0..40_000.0).contains(&left_m), "{left_m}");
    let back = geodesy::interpolate(from, to, (left_m - 2_000.0) / geodesy::distance_m(from, to));
    let here = run.world.position();
    let segment = [location(back.latitude_deg, back.longitude_deg), location(here.latitude_deg, here.longitude_deg)];
    run.carry_out(form("fly-line", segment), 2_000.0).unwrap();
    assert!(run.answer(first).unwrap().1.is_err());
    let begun = run.now.seconds();
    run.carry_out(form("fly-line", ends()), 2_000.0).unwrap();
    let rest_s = (geodesy::distance_m(from, to) - left_m) / 89.0;
    assert!((run.now.seconds() - begun - rest_s).abs() < 30.0, "{} s for {rest_s}", run.now.seconds() - begun);
    run.carry_out(form("fly-line", ends()), 3_000.0).unwrap();
    assert!(run.now.seconds() - begun > 2.0 * rest_s, "a finished line begins at its beginning again");
}

/// Returns the least distance to a place before the answer, and the distance at the answer.
fn reached(run: &mut Run, goal: Position, altitude_m: Option<f64>, seconds: f64) -> (f64, f64) {
    let place = [Some(goal.latitude_deg), Some(goal.longitude_deg), altitude_m];
    let place = Value::list(place.into_iter().flatten().map(Value::Real));
    let id = run.send(form("fly-to", [place]));
    let mut least_m = f64::INFINITY;
    let end = run.now.seconds() + seconds;
    while run.answer(id).is_none() {
        run.wait_s(1.0);
        least_m = least_m.min(geodesy::distance_m(run.world.position(), goal));
        assert!(run.now.seconds() < end, "not reached: {least_m}");
    }
    let answer = run.answer(id).unwrap().1.unwrap();
    let items: Vec<f64> = answer.as_list().unwrap().iter().map(|item| item.as_number().unwrap().0).collect();
    (least_m, geodesy::distance_m(Position::new(items[0], items[1]), goal))
}

#[test]
fn a_place_is_reached_within_200_m_wherever_it_is() {
    for (east, north) in [(0.0, 0.0), (18.0, -12.0)] {
        for azimuth_deg in [0.0, 60.0, 120.0, 180.0, 240.0, 300.0] {
            // Far away, one turn away, inside the turning circle, and nearly below.
            for distance_m in [30_000.0, 7_000.0, 2_500.0, 600.0] {
                let mut run = cruising(wind(east, north, 0.05));
                let goal = geodesy::destination(run.world.position(), azimuth_deg, distance_m);
                let (_, at_answer_m) = reached(&mut run, goal, None, 3_000.0);
                assert!(at_answer_m <= 200.0, "{east} {north} {azimuth_deg} {distance_m}: {at_answer_m}");
            }
        }
    }
    // The same after a climb on a circle around the place.
    let mut run = cruising(wind(5.0, 5.0, 0.0));
    let goal = geodesy::destination(run.world.position(), 90.0, 15_000.0);
    let (_, at_answer_m) = reached(&mut run, goal, Some(9_000.0), 6_000.0);
    assert!(at_answer_m <= 200.0 && (run.world.altitude_m() - 9_000.0).abs() < 45.0, "{at_answer_m}");
}

#[test]
fn attitude_is_dense_while_the_scanner_is_on() {
    let mut run = cruising(wind(0.0, 0.0, 0.2));
    run.wait_s(30.0);
    run.carry_out(form("scanner", [word("on")]), 1.0).unwrap();
    run.wait_s(60.0);
    let begun = 31.0;
    let gaps = |run: &Run, attribute: &str, from: f64| {
        let times: Vec<f64> = run.numbers(attribute).iter().map(|(at, _)| *at).filter(|at| *at >= from).collect();
        times
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .fold((f64::INFINITY, 0.0_f64), |(low, high), gap| (low.min(gap), high.max(gap)))
    };
    for attribute in ["roll-angle", "pitch-angle", "heading", "altitude"] {
        let (low, high) = gaps(&run, attribute, begun);
        assert!(low > 0.19 && high < 0.21, "{attribute}: {low} to {high}");
    }
    assert_eq!(
        run.values("location").iter().filter(|(at, _)| *at >= begun).count(),
        run.numbers("roll-angle").iter().filter(|(at, _)| *at >= begun).count()
    );
    let (low, high) = gaps(&run, "ground-speed", begun);
    assert!(low > 0.9 && high < 1.1, "{low} to {high}");
    run.carry_out(form("scanner", [word("off")]), 1.0).unwrap();
    let off = run.now.seconds();
    run.wait_s(60.0);
    assert!(gaps(&run, "roll-angle", off + 1.0).0 > 0.9);
    assert_eq!(run.last_number("truth-edr"), 0.2);
}

#[test]
fn a_slew_that_the_mount_cannot_end_fails_by_its_deadline() {
    let mut config = predator(Start::in_flight(40.0, -120.0, 3_000.0, 0.0));
    config.model.cameras[0].pan_deg_max = 0.0;
    let mut run = Run::new(config);
    run.send(form("fly-to", [location(41.0, -120.0)]));
    run.carry_out(form("camera", [word("camera-1"), word("power-up")]), 60.0).unwrap();
    // Three kilometres to the right: a tilt-only mount never sees it while the aircraft flies north.
    let here = run.world.position();
    let aside = geodesy::destination(here, 90.0, 3_000.0);
    let begun = run.now.seconds();
    let target = location(aside.latitude_deg, aside.longitude_deg);
    let reason = run.carry_out(form("point-camera", [word("camera-1"), target]), 30.0).unwrap_err();
    // At most 90 degrees at 40 degrees per second, settling of 0.4 s, a margin of 2 s.
    let took = run.now.seconds() - begun;
    assert!((2.0..4.7).contains(&took), "{took}");
    assert!(
        reason.contains("the mount cannot come closer than") && reason.contains("turn or fly another way"),
        "{reason}"
    );
    assert_eq!(run.values("camera-state").last().unwrap().1.to_string(), "ready");
    // A target ahead comes into view, and stays in view until it is behind.
    let ahead = geodesy::destination(here, 0.0, 4_000.0);
    let target = location(ahead.latitude_deg, ahead.longitude_deg);
    run.carry_out(form("point-camera", [word("camera-1"), target]), 10.0).unwrap();
    run.wait_s(90.0);
    let lost = run.inputs.iter().find(|input| matches!(&input.kind, apex_model::event::EventKind::Occurrence(form) if form.to_string().starts_with("(out-of-view camera-1")));
    assert!(lost.is_some());
}

/// At the bend a turn ended whose chord was flown instead, so the place is 9 degrees to the side of the track and 1.6 km ahead. An
/// aircraft that turned towards it would pass it at 250 m and circle back.
#[test]
fn a_short_leg_after_a_bend_is_followed_to_its_end() {
    let mut run = {
        let mut config = predator(Start::in_flight(40.585_890_9, -116.021_259, 4_353.0, 299.0));
        config.wind = wind(7.679, -6.272, 0.0);
        Run::new(config)
    };
    let bend = Value::list([location(40.591_072, -116.028_489)]);
    let goal = Position::new(40.602_34, -116.039_99);
    let hop = form("fly-to", [location(goal.latitude_deg, goal.longitude_deg), word(":via"), bend]);
    run.carry_out(hop, 400.0).unwrap();
    assert!(run.now.seconds() < 60.0, "{} s for two kilometres", run.now.seconds());
    assert!(geodesy::distance_m(run.world.position(), goal) < 200.0);
}
