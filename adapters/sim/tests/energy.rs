//! Energy: the consumed amount is the integral of the reported rate, endurances are as stated, and an empty battery ends the flight.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a failed test should stop")]

mod common;

use apex_model::value::Value;
use apex_sim::{SimulatedWorld, Start, WorldConfig};
use apex_vehicle::{JOULES_PER_WH, SHIPPED, VehicleModel};
use common::{Run, form, location};

fn start(model: &VehicleModel, airborne: bool) -> WorldConfig {
    let mut start = Start::in_flight(36.5, -121.7, 60.0, 90.0);
    start.airborne = airborne;
    if !airborne {
        start.altitude_m = 0.0;
    }
    WorldConfig::new("uav-1", model.clone(), start)
}

/// Each sample holds until the next.
fn integral(samples: &[(f64, f64)]) -> f64 {
    samples.windows(2).map(|pair| pair[0].1 * (pair[1].0 - pair[0].0)).sum()
}

/// A flight with take-off, transit, hover and return.
#[test]
fn the_integral_of_the_reported_power_is_the_energy_used() {
    for (name, store, flow) in [("quadrotor", "battery-charge", "battery-power"), ("rmax", "fuel", "fuel-flow")] {
        let model = VehicleModel::named(name).unwrap();
        let mut run = Run::new(start(&model, false));
        run.carry_out(form("take-off", [Value::Real(60.0)]), 120.0).unwrap();
        run.carry_out(form("fly-to", [location(36.52, -121.7)]), 600.0).unwrap();
        run.wait_s(300.0);
        run.carry_out(form("fly-to", [location(36.5, -121.7)]), 600.0).unwrap();
        let unit = if name == "quadrotor" { model.stored_full() } else { 1.0 };
        let left = run.numbers(store);
        let used = (left[0].1 - left[left.len() - 1].1) * unit;
        let drained = integral(&run.numbers(flow));
        assert!(used > 0.1 * model.stored_full(), "{name}: a flight worth measuring, {used}");
        assert!((drained / used - 1.0).abs() < 0.02, "{name}: {drained} drained, {used} used");
    }
}

/// From full to empty at cruise and in hover, within 15 % of the figures that the sources state.
#[test]
fn endurances_are_the_stated_ones() {
    for shipped in SHIPPED.iter().filter(|shipped| ["quadrotor", "fixed-wing-mapper", "rmax"].contains(&shipped.name)) {
        let model = VehicleModel::named(shipped.name).unwrap();
        let near = |found_s: f64, stated_min: f64, what: &str| {
            assert!(
                (found_s / 60.0 / stated_min - 1.0).abs() < 0.15,
                "{} {what}: {} min",
                shipped.name,
                found_s / 60.0
            );
        };
        let mut cruise = Run::new(start(&model, true));
        cruise.send(form("fly-to", [location(38.5, -121.7)]));
        cruise.wait_s(6_000.0);
        near(cruise.event("(fuel-exhausted uav-1)").unwrap(), model.endurance.cruise_min, "cruise");
        let Some(hover_min) = model.endurance.hover_min else { continue };
        let mut hover = Run::new(start(&model, true));
        hover.wait_s(6_000.0);
        near(hover.event("(fuel-exhausted uav-1)").unwrap(), hover_min, "hover");
    }
}

/// The reported endurance falls by one second each second, is correct on the ground, and is near the time then flown.
#[test]
fn endurance_remaining_is_what_remains() {
    let model = VehicleModel::named("quadrotor").unwrap();
    let mut run = Run::new(start(&model, true));
    run.wait_s(4_000.0);
    let empty_s = run.event("(fuel-exhausted uav-1)").unwrap();
    let told = run.numbers("endurance-remaining");
    for (at_s, left_s) in told.iter().filter(|(at_s, _)| (20.0..empty_s - 20.0).contains(at_s)) {
        assert!((at_s + left_s - empty_s).abs() < 20.0, "{at_s}: {left_s} of {}", empty_s - at_s);
    }
    let parked = waited(&model);
    let told = parked.numbers("endurance-remaining");
    assert!((told[0].1 / empty_s - 1.0).abs() < 0.05, "{told:?}, {empty_s}");
    assert!(parked.numbers("fuel").is_empty(), "a battery is not reported as fuel");
}

fn waited(model: &VehicleModel) -> Run {
    let mut run = Run::new(start(model, false));
    run.wait_s(1.0);
    run
}

#[test]
fn a_quadrotor_without_charge_falls_and_a_battery_holds_what_its_file_says() {
    let model = VehicleModel::named("quadrotor").unwrap();
    let mut config = start(&model, true);
    config.start.altitude_m = 100.0;
    config.start.fuel_share = Some(0.1);
    let full = SimulatedWorld::new(start(&model, true)).unwrap().stored();
    assert!((full / JOULES_PER_WH - 548.0).abs() < 1e-9, "{full}");
    let mut run = Run::new(config);
    run.wait_s(600.0);
    let (empty, down) = (run.event("(fuel-exhausted uav-1)").unwrap(), run.event("(crashed uav-1)").unwrap());
    assert!((3.0..12.0).contains(&(down - empty)), "{} s from 100 m", down - empty);
}
