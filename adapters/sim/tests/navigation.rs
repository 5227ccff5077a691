//! Failing navigation moves the flight, not only its reports.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test that fails should stop")]

mod common;

use apex_geo::geodesy;
use apex_model::event::EventKind;
use apex_model::planned::Location;
use apex_model::problem::Position;
use apex_model::value::Value;
use apex_sim::{FaultKind, FaultSpec, LivingWorld};
use apex_sim::{Start, WorldConfig};
use common::{Run, form, location, predator, wind};

/// A flight to the north along the meridian of the start, with a navigation failure from 60 s on.
fn northwards(by: Option<f64>, for_s: Option<f64>, change: impl Fn(&mut WorldConfig)) -> Run {
    let mut config = predator(Start::in_flight(40.0, -100.0, 4_000.0, 0.0));
    let fault = FaultSpec { fault: FaultKind::Navigation, of: None, by, at_s: Some(60.0), rate_per_h: None, for_s };
    config.living = Some(LivingWorld { format: "apex-world-1".into(), faults: vec![fault], ..LivingWorld::default() });
    change(&mut config);
    let mut run = Run::new(config);
    run.wait_s(1.0);
    run.send(form("fly-line", [location(40.01, -100.0), location(41.0, -100.0)]));
    run
}

/// Metres east of the meridian of the flight.
fn east_m(at: Position) -> f64 {
    let (distance_m, azimuth_deg) = geodesy::inverse(Position::new(at.latitude_deg, -100.0), at);
    distance_m * libm::sin(azimuth_deg.to_radians())
}

fn places(run: &Run, attribute: &str) -> Vec<(f64, Position)> {
    let of = run.values(attribute).into_iter();
    of.map(|(at_s, value)| (at_s, Location::from_value(&value).unwrap().position)).collect()
}

#[test]
fn an_aircraft_that_believes_to_drift_east_flies_west_of_its_line() {
    let mut run = northwards(Some(5.0), None, |_| {});
    run.wait_s(58.0);
    assert!(east_m(run.world.position()).abs() < 1.0, "on the line before: {}", east_m(run.world.position()));
    assert!(run.values("truth-location").is_empty(), "nothing to tell before");
    run.wait_s(242.0);
    // Drift of 5 m/s since 60 s; the line is held by the estimated position, with a lag of some seconds.
    let true_m = east_m(run.world.position());
    assert!((true_m + 5.0 * 241.0).abs() < 60.0, "{true_m} m");
    let believed = places(&run, "location");
    assert!(east_m(believed.last().unwrap().1).abs() < 60.0, "it reports to be on its line");
    let (told_s, told) = *places(&run, "truth-location").last().unwrap();
    assert_eq!(told_s, believed.last().unwrap().0, "with each report");
    assert!((east_m(told) - true_m).abs() < 50.0 && (east_m(told) + 5.0 * (told_s - 60.0)).abs() < 60.0);
}

#[test]
fn the_aircraft_returns_to_its_line_when_the_failure_is_over() {
    let mut run = northwards(Some(5.0), Some(120.0), |_| {});
    run.wait_s(179.0);
    assert!(east_m(run.world.position()) < -500.0);
    run.wait_s(1.0);
    let jump_m = east_m(run.world.position());
    run.wait_s(120.0);
    assert!(jump_m < -500.0, "the truth does not jump: {jump_m}");
    assert!(east_m(run.world.position()).abs() < 30.0, "{}", east_m(run.world.position()));
    let last_told_s = places(&run, "truth-location").last().unwrap().0;
    assert!(last_told_s <= 181.0, "{last_told_s}");
}

/// Reckoning from the wind that was known when the position was lost: a wind that shifts carries the aircraft off.
#[test]
fn an_aircraft_without_position_is_off_by_what_the_wind_has_changed() {
    let still = |run: &mut Run| {
        run.wait_s(300.0);
        east_m(run.world.position())
    };
    let steady_m = still(&mut northwards(None, None, |config| config.wind = wind(10.0, 0.0, 0.0)));
    assert!(steady_m.abs() < 10.0, "the wind is as it was: {steady_m} m");
    let mut run = northwards(None, None, |config| {
        config.wind = wind(4.0, 0.0, 0.0);
        let mut later = config.wind.layers[0];
        later.wind_east_mps = 12.0;
        later.from_s = 100.0;
        config.wind.layers[0].until_s = 100.0;
        config.wind.layers.push(later);
    });
    let shifted_m = still(&mut run);
    // 8 m/s for the 201 s after the change, which a step of 10 s may meet late.
    assert!((shifted_m - 8.0 * 201.0).abs() < 100.0, "{shifted_m} m");
    assert!(places(&run, "location").iter().all(|(at_s, _)| *at_s < 60.0), "no position is reported");
    let told = places(&run, "truth-location");
    assert!(told.len() > 10 && told.iter().all(|(at_s, _)| *at_s >= 60.0));
    let state = run.values("navigation-state");
    assert_eq!(state.last().unwrap().1, Value::symbol("lost"));
    let faults = run.inputs.iter().filter(
        |input| matches!(&input.kind, EventKind::Occurrence(form) if form.to_string() == "(truth-fault navigation)"),
    );
    assert_eq!(faults.count(), 1);
}
