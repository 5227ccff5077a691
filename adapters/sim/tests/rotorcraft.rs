//! The helicopter: hover, turns in place, camera, radio, endurance.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test that fails should stop")]

mod common;

use apex_geo::geodesy;
use apex_model::problem::Position;
use apex_model::time::Duration;
use apex_model::value::Value;
use apex_sim::{Modem, NamedPlace, Start};
use common::{Run, form, location, rmax, wind, word};

fn hovering(wind_field: apex_model::problem::WindField) -> Run {
    let mut config = rmax(Start::in_flight(36.5, -121.7, 60.0, 0.0));
    config.wind = wind_field;
    config.places.push(NamedPlace {
        name: "Barn".to_owned(),
        position: Position::new(36.502, -121.7),
        altitude_m: Some(4.0),
    });
    Run::new(config)
}

#[test]
fn it_flies_stops_and_hovers_for_the_time_asked() {
    let mut run = hovering(wind(5.0, 2.0, 0.0));
    let goal = Position::new(36.503, -121.7);
    run.carry_out(form("fly-to", [location(36.503, -121.7)]), 200.0).unwrap();
    let flown = run.now.seconds();
    let distance = geodesy::distance_m(Position::new(36.5, -121.7), goal);
    // 333 m with a tail wind of 2 m/s, plus getting going and stopping.
    assert!((distance / 14.0..distance / 14.0 + 25.0).contains(&flown), "{flown}");
    let begun = run.now.seconds();
    let duration = Value::Duration(Duration::from_seconds(45.0));
    run.carry_out(form("hover", [location(36.503, -121.7), word(":duration"), duration]), 100.0).unwrap();
    assert!((run.now.seconds() - begun - 45.0).abs() < 3.0);
    assert!(geodesy::distance_m(run.world.position(), goal) < 3.0);
    assert!(run.last_number("ground-speed") < 0.6);
}

#[test]
fn the_papers_camera_story() {
    let mut run = hovering(wind(0.0, 0.0, 0.0));
    let early = run.carry_out(form("take-picture", [word("camera-1")]), 1.0);
    assert!(early.unwrap_err().contains("not powered up"));
    run.carry_out(form("camera", [word("camera-1"), word("power-up")]), 20.0).unwrap();
    assert_eq!(run.event("(ready camera-1)"), Some(10.0));
    // The target is to the north; the nose is turned away first.
    run.carry_out(form("set-heading", [Value::Integer(150)]), 20.0).unwrap();
    run.carry_out(form("point-camera", [word("camera-1"), word("barn")]), 30.0).unwrap();
    let heading = geodesy::wrap_180(run.last_number("heading") / geodesy::RAD_PER_DEG);
    assert!(heading.abs() < 25.0, "{heading}");
    let tilt = run.last_number("camera-tilt") / geodesy::RAD_PER_DEG;
    assert!((tilt + 14.2).abs() < 1.5, "{tilt}");
    run.carry_out(form("take-picture", [word("camera-1")]), 5.0).unwrap();
    assert!(run.event("(image-in-memory barn)").is_some());
}

#[test]
fn powering_up_what_is_powered_says_ready_again_and_disturbs_nothing() {
    let mut run = hovering(wind(0.0, 0.0, 0.0));
    let power_up = || form("camera", [word("camera-1"), word("power-up")]);
    let ready = |run: &Run| {
        let is = |input: &&apex_runtime::ports::Input| matches!(&input.kind, apex_model::event::EventKind::Occurrence(form) if form.to_string() == "(ready camera-1)");
        run.inputs.iter().filter(is).map(|input| input.at.seconds()).collect::<Vec<f64>>()
    };
    run.carry_out(power_up(), 20.0).unwrap();
    run.wait_s(5.5);
    assert_eq!(run.carry_out(power_up(), 0.0).unwrap().to_string(), "camera-1");
    assert_eq!(ready(&run), [10.0, 15.5]);
    run.carry_out(form("point-camera", [word("camera-1"), word("barn")]), 30.0).unwrap();
    let picture = run.send(form("take-picture", [word("camera-1")]));
    run.wait_s(0.5);
    run.carry_out(power_up(), 0.0).unwrap();
    assert_eq!(ready(&run).len(), 3);
    run.await_answer(picture, 5.0).unwrap();
    run.carry_out(form("camera", [word("camera-1"), word("power-off")]), 0.0).unwrap();
    run.carry_out(power_up(), 20.0).unwrap();
    assert_eq!(ready(&run).len(), 4);
}

#[test]
fn an_hour_of_hover_is_what_the_fuel_gives() {
    let mut run = hovering(wind(0.0, 0.0, 0.0));
    run.wait_s(4_000.0);
    let empty = run.event("(fuel-exhausted rmax-1)").unwrap();
    assert!((3_400.0..3_900.0).contains(&empty), "{empty}");
}

#[test]
fn the_signal_fades_with_distance_and_comes_back() {
    let mut config = rmax(Start::in_flight(36.5, -121.7, 60.0, 90.0));
    config.modems.push(Modem::at_station("900MHzModem", Position::new(36.5, -121.7), 100.0));
    let mut run = Run::new(config);
    run.wait_s(20.0);
    let near = run.last_number("signal-level");
    run.carry_out(form("fly-to", [location(36.5, -121.66)]), 600.0).unwrap();
    let far = run.last_number("signal-level");
    assert!(near > 0.85 && far < near - 0.3, "{near} {far}");
}

#[test]
fn it_lands_on_the_spot_and_takes_off_again() {
    let mut run = hovering(wind(3.0, 0.0, 0.0));
    run.carry_out(form("land", [location(36.5005, -121.7)]), 300.0).unwrap();
    assert!(geodesy::distance_m(run.world.position(), Position::new(36.5005, -121.7)) < 3.0);
    run.wait_s(30.0);
    assert!(run.last_number("height-above-ground").abs() < 0.1);
    run.carry_out(form("take-off", [Value::Real(30.0)]), 60.0).unwrap();
    assert!((run.world.altitude_m() - 30.0).abs() < 7.0, "{}", run.world.altitude_m());
}

/// Paces of samples between two times: position and attitude, and the rest.
fn paces(run: &Run, attribute: &str, from_s: f64, until_s: f64) -> Vec<f64> {
    let times: Vec<f64> =
        run.numbers(attribute).into_iter().map(|(at, _)| at).filter(|at| (from_s..until_s).contains(at)).collect();
    times.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

#[test]
fn a_target_straight_below_is_seen_in_seconds_and_attitude_is_dense_meanwhile() {
    let mut run = hovering(wind(4.0, -2.0, 0.1));
    run.carry_out(form("fly-to", [location(36.502, -121.7)]), 200.0).unwrap();
    run.carry_out(form("camera", [word("camera-1"), word("power-up")]), 20.0).unwrap();
    run.wait_s(10.0);
    let begun = run.now.seconds();
    assert!(paces(&run, "roll-angle", begun - 8.0, begun).iter().all(|pace| *pace > 0.9), "no sensor is in use");
    let target = run.carry_out(form("point-camera", [word("camera-1"), word("barn")]), 10.0).unwrap();
    assert_eq!(target.to_string(), "barn");
    // 90 degrees of tilt at 30 degrees per second, and settling.
    assert!((3.0..4.5).contains(&(run.now.seconds() - begun)), "{}", run.now.seconds() - begun);
    assert!((run.last_number("camera-tilt") / geodesy::RAD_PER_DEG + 90.0).abs() < 3.0);
    run.carry_out(form("take-picture", [word("camera-1")]), 5.0).unwrap();
    let (taken, stored) =
        (run.event("(image-taken camera-1 barn)").unwrap(), run.event("(image-in-memory barn)").unwrap());
    assert!((stored - taken - 0.5).abs() < 1e-9, "{taken} {stored}");
    run.wait_s(20.0);
    let now = run.now.seconds();
    for attribute in ["roll-angle", "camera-tilt"] {
        let paces = paces(&run, attribute, begun, now);
        assert!(paces.iter().all(|pace| *pace < 0.2001), "{attribute}: {paces:?}");
    }
    let rest = paces(&run, "ground-speed", begun + 5.0, now);
    assert!(!rest.is_empty() && rest.iter().all(|pace| *pace > 0.5), "{rest:?}");
    run.carry_out(form("camera", [word("camera-1"), word("power-off")]), 0.0).unwrap();
    let off = run.now.seconds();
    run.wait_s(20.0);
    assert!(paces(&run, "roll-angle", off + 1.0, run.now.seconds()).iter().all(|pace| *pace > 0.9));
}

#[test]
fn it_lands_off_field_and_below_itself_and_takes_off_from_there() {
    let mut run = hovering(wind(3.0, -4.0, 0.0));
    run.carry_out(form("fly-to", [location(36.503, -121.702)]), 200.0).unwrap();
    let above = run.world.position();
    assert_eq!(run.carry_out(form("land", [word("here")]), 120.0).unwrap().to_string(), "here");
    assert!(geodesy::distance_m(run.world.position(), above) < 3.0);
    assert!(run.event("(landed rmax-1)").is_some() && run.event("(crashed rmax-1)").is_none());
    run.carry_out(form("take-off", [Value::Real(30.0)]), 60.0).unwrap();
    run.carry_out(form("land", [location(36.504, -121.703)]), 200.0).unwrap();
    assert!(geodesy::distance_m(run.world.position(), Position::new(36.504, -121.703)) < 3.0);
}

/// Returns the instants of pictures, and the aircraft's position at each, from samples of the same instant.
fn pictures(run: &Run) -> Vec<(f64, Position)> {
    let latitudes = run.numbers("latitude");
    let longitudes = run.numbers("longitude");
    let at = |numbers: &[(f64, f64)], time_s: f64| {
        numbers.iter().rev().find(|(at, _)| *at <= time_s).map_or(f64::NAN, |(_, si)| si / geodesy::RAD_PER_DEG)
    };
    let is = |input: &&apex_runtime::ports::Input| matches!(&input.kind, apex_model::event::EventKind::Occurrence(form) if form.to_string().starts_with("(image-taken camera-1"));
    let times = run.inputs.iter().filter(is).map(|input| input.at.seconds());
    times.map(|time_s| (time_s, Position::new(at(&latitudes, time_s), at(&longitudes, time_s)))).collect()
}

/// Only a list that begins with `along` is a direction; any other one is a wrong location.
#[test]
fn a_camera_is_pointed_in_a_fixed_direction() {
    let mut run = hovering(wind(0.0, 0.0, 0.0));
    let camera = || word("camera-1");
    run.carry_out(form("camera", [camera(), word("power-up")]), 20.0).unwrap();
    let along = |parts: &[f64]| form("along", parts.iter().map(|part| Value::Real(*part)));
    let wrong = run.carry_out(form("point-camera", [camera(), along(&[90.0])]), 1.0).unwrap_err();
    assert!(wrong.contains("a direction is (along AZIMUTH TILT)"), "{wrong}");
    let elsewhere = form("elsewhere", [Value::Real(1.0)]);
    let wrong = run.carry_out(form("point-camera", [camera(), elsewhere]), 1.0).unwrap_err();
    assert!(wrong.contains("is not a location"), "{wrong}");
    run.carry_out(form("point-camera", [camera(), along(&[90.0, -30.0])]), 30.0).unwrap();
    assert!((run.last_number("camera-tilt") / geodesy::RAD_PER_DEG + 30.0).abs() < 1.0);
}

#[test]
fn pictures_by_time_keep_their_interval_and_stop() {
    let mut run = hovering(wind(0.0, 0.0, 0.0));
    let camera = || word("camera-1");
    let interval =
        |s: f64| form("take-pictures", [camera(), word(":interval"), Value::Duration(Duration::from_seconds(s))]);
    run.carry_out(form("camera", [camera(), word("power-up")]), 20.0).unwrap();
    run.carry_out(form("point-camera", [camera(), word("down")]), 10.0).unwrap();
    assert!(run.carry_out(interval(0.0), 1.0).unwrap_err().contains("not greater than zero"));
    let both = form("take-pictures", [camera(), word(":every"), Value::Real(5.0), word(":interval"), Value::Real(5.0)]);
    assert!(run.carry_out(both, 1.0).unwrap_err().contains("give one of them"));
    run.carry_out(interval(7.0), 1.0).unwrap();
    // The vehicle hovers: no distance is flown.
    run.carry_out(form("wait", [Value::Duration(Duration::from_seconds(100.0))]), 110.0).unwrap();
    let taken = pictures(&run);
    // One at the beginning, and one every 7 s of about 100 s.
    assert!((14..=16).contains(&taken.len()), "{}", taken.len());
    let gaps_s: Vec<f64> = taken.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    assert!(gaps_s.iter().all(|gap_s| (gap_s - 7.0).abs() < 0.3), "{gaps_s:?}");
    run.carry_out(form("stop-pictures", [camera()]), 1.0).unwrap();
    run.carry_out(form("wait", [Value::Duration(Duration::from_seconds(20.0))]), 30.0).unwrap();
    assert_eq!(pictures(&run).len(), taken.len());
}

#[test]
fn pictures_by_distance_keep_their_distance_and_stop() {
    let mut run = hovering(wind(0.0, 0.0, 0.0));
    let camera = || word("camera-1");
    let every = |metres: f64| form("take-pictures", [camera(), word(":every"), Value::Real(metres)]);
    assert!(run.carry_out(every(30.0), 1.0).unwrap_err().contains("not powered up"));
    run.carry_out(form("camera", [camera(), word("power-up")]), 20.0).unwrap();
    assert!(run.carry_out(every(30.0), 1.0).unwrap_err().contains("use point-camera first"));
    run.carry_out(form("point-camera", [camera(), word("down")]), 10.0).unwrap();
    assert!((run.last_number("camera-tilt") / geodesy::RAD_PER_DEG + 90.0).abs() < 1.0);
    assert!(run.carry_out(every(-1.0), 1.0).unwrap_err().contains("not greater than zero"));
    run.carry_out(form("join-line", [location(36.5, -121.7), location(36.505, -121.7)]), 60.0).unwrap();
    run.carry_out(every(30.0), 1.0).unwrap();
    run.carry_out(form("fly-line", [location(36.5, -121.7), location(36.505, -121.7)]), 200.0).unwrap();
    let taken = pictures(&run);
    // 555 m at one picture every 30 m, and one at the beginning.
    assert!((18..=20).contains(&taken.len()), "{}", taken.len());
    let gaps_m: Vec<f64> = taken.windows(2).map(|pair| geodesy::distance_m(pair[0].1, pair[1].1)).collect();
    let mean_m = gaps_m.iter().sum::<f64>() / gaps_m.len() as f64;
    assert!((mean_m - 30.0).abs() < 1.0, "{mean_m}");
    assert!(gaps_m.iter().all(|gap_m| (gap_m - 30.0).abs() < 5.0), "{gaps_m:?}");
    run.carry_out(form("stop-pictures", [camera()]), 1.0).unwrap();
    run.carry_out(form("fly-to", [location(36.5, -121.7)]), 200.0).unwrap();
    assert_eq!(pictures(&run).len(), taken.len());
    // The camera rests: no dense samples, no pictures of nothing.
    run.carry_out(form("camera", [camera(), word("rest")]), 1.0).unwrap();
    assert!(run.carry_out(every(30.0), 1.0).unwrap_err().contains("use point-camera first"));
}

#[test]
fn a_count_of_pictures_is_answered_after_the_last() {
    let mut run = hovering(wind(0.0, 0.0, 0.0));
    run.carry_out(form("camera", [word("camera-1"), word("power-up")]), 20.0).unwrap();
    run.carry_out(form("point-camera", [word("camera-1"), word("barn")]), 30.0).unwrap();
    let begun = run.now.seconds();
    let count = |count: Value| form("take-picture", [word("camera-1"), word(":count"), count]);
    assert!(run.carry_out(count(Value::Real(1.5)), 1.0).unwrap_err().contains("not a whole number"));
    run.carry_out(count(Value::Integer(3)), 10.0).unwrap();
    assert_eq!(pictures(&run).len(), 3);
    assert!((run.now.seconds() - begun - 1.5).abs() < 0.5, "{}", run.now.seconds() - begun);
}
