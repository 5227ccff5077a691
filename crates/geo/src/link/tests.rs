//! Reference figures of link budgets, and properties of every budget.

use super::*;
use crate::geodesy::{self, Position, destination};
use proptest::prelude::*;

/// 915 MHz, 1 W, two antennas of 2 dBi, 6 dB of losses; the receiver needs -95 dBm, and 10 dB are kept for fading.
const TELEMETRY: RadioFigures = RadioFigures {
    frequency_hz: 915e6,
    power_dbm: 30.0,
    gains_dbi: 4.0,
    losses_db: 6.0,
    sensitivity_dbm: -95.0,
    fade_margin_db: 10.0,
};

fn antenna(position: Position, altitude_m: f64) -> Antenna {
    Antenna { position, altitude_m, height_m: altitude_m }
}

fn near(found: f64, wanted: f64) {
    assert!((found - wanted).abs() <= 0.05, "{found} instead of {wanted}");
}

#[test]
fn received_power_falls_by_twenty_decibels_per_decade() {
    for (kilometres, wanted) in [(1.0, -63.7), (5.0, -77.7), (20.0, -89.7)] {
        near(TELEMETRY.received_dbm(free_space_loss_db(915e6, 1e3 * kilometres)), wanted);
    }
    near(free_space_range_m(915e6, free_space_loss_db(915e6, 7_000.0)), 7_000.0);
}

#[test]
fn horizons_of_a_hand_held_antenna_and_of_an_aircraft() {
    assert!((radio_horizon_m(3.0, 60.0) - 39_000.0).abs() < 100.0);
    assert!((radio_horizon_m(10.0, 7_010.0) - 358_000.0).abs() < 100.0);
}

#[test]
fn an_edge_at_and_above_the_line() {
    let wave_m = wavelength_m(915e6);
    near(knife_edge_loss_db(0.0), 6.03);
    near(knife_edge_loss_db(knife_edge_nu(20.0, 1_000.0, 1_000.0, wave_m)), 19.9);
    near(knife_edge_loss_db(knife_edge_nu(50.0, 800.0, 1_200.0, wave_m)), 27.9);
    near(fresnel_clearance_m(1_000.0, 1_000.0, wave_m), 0.6 * 12.8);
    assert_eq!(knife_edge_loss_db(-0.78), 0.0);
    // The formula reaches zero where the edge leaves the beam.
    assert!(knife_edge_loss_db(-0.7799) < 0.02);
}

#[test]
fn the_margin_at_five_kilometres_and_behind_an_edge() {
    let received_dbm = TELEMETRY.received_dbm(free_space_loss_db(915e6, 5_000.0));
    near(TELEMETRY.margin_db(received_dbm), 7.3);
    let edge_db = knife_edge_loss_db(knife_edge_nu(20.0, 1_000.0, 1_000.0, wavelength_m(915e6)));
    // To a tenth: the reference adds rounded terms.
    let behind_db = TELEMETRY.margin_db(received_dbm - edge_db);
    assert!((behind_db + 12.6).abs() < 0.1, "{behind_db}");
}

#[test]
fn levels_are_decibels_over_the_sensitivity() {
    assert_eq!(RadioFigures::default(), TELEMETRY);
    for (margin_db, level) in [(-30.0, 0.0), (-10.0, 0.0), (0.0, 0.25), (30.0, 1.0), (50.0, 1.0)] {
        near(TELEMETRY.signal_level(margin_db), level);
    }
    near(TELEMETRY.margin_of_level_db(0.2), -2.0);
    let full = TELEMETRY.with_full_level_at(500.0);
    let margin_db = |distance_m: f64| full.margin_db(full.received_dbm(free_space_loss_db(915e6, distance_m)));
    near(full.signal_level(margin_db(500.0)), 1.0);
    near(full.signal_level(margin_db(5_000.0)), 0.5);
}

#[test]
fn reflection_counts_beyond_the_crossover() {
    let crossover_m = two_ray_crossover_m(915e6, 3.0, 60.0);
    assert!((crossover_m - 6_904.0).abs() < 1.0, "{crossover_m}");
    let beyond = |factor: f64| two_ray_loss_db(915e6, factor * crossover_m, 3.0, 60.0);
    near(beyond(10.0) - beyond(1.0), 40.0);
    near(beyond(1.0) - beyond(0.1), 20.0);
    // In closed form, where both ends are far below the distance.
    near(two_ray_loss_db(915e6, 20_000.0, 3.0, 60.0), 40.0 * libm::log10(20_000.0) - 20.0 * libm::log10(180.0));
}

#[test]
fn a_ridge_across_the_path_costs_what_its_edge_costs() {
    let station = Position::new(47.0, -114.0);
    let aircraft = destination(station, 70.0, 2_000.0);
    let (low, high) = (antenna(station, 100.0), antenna(aircraft, 100.0));
    // One sample in the middle is 20 m above the line, less the bulge of 6 cm; the ground is far below.
    let ridge = |position: Position| {
        let along_m = geodesy::distance_m(station, position);
        if (along_m - 1_000.0).abs() < 1.0 { 120.0 } else { -1_000.0 }
    };
    let loss_db = TELEMETRY.loss_db(&low, &high, ridge) - TELEMETRY.loss_db(&low, &high, |_| -1_000.0);
    near(loss_db, 19.9);
}

#[test]
fn beyond_the_horizon_the_earth_itself_is_the_edge() {
    let station = Position::new(10.0, 20.0);
    let budget = |distance_m: f64| {
        let aircraft = destination(station, 45.0, distance_m);
        TELEMETRY.loss_db(&antenna(station, 10.0), &antenna(aircraft, 1_000.0), |_| 0.0)
            - free_space_loss_db(915e6, distance_m)
    };
    let horizon_m = radio_horizon_m(10.0, 1_000.0);
    assert!(budget(0.3 * horizon_m) < 0.1);
    // At the horizon the line grazes the sea.
    assert!((budget(horizon_m) - 6.03).abs() < 0.5, "{}", budget(horizon_m));
    assert!(budget(1.3 * horizon_m) > 15.0);
}

proptest! {
    #[test]
    fn more_distance_and_higher_ground_never_help(
        distance_m in 50.0..60_000.0f64,
        farther in 1.0..1.5f64,
        altitude_m in 20.0..5_000.0f64,
        hill_m in 0.0..2_000.0f64,
        azimuth_deg in 0.0..360.0f64,
    ) {
        let station = Position::new(38.0, -120.0);
        let loss_db = |distance_m: f64, hill_m: f64| {
            let aircraft = destination(station, azimuth_deg, distance_m);
            TELEMETRY.loss_db(&antenna(station, 3.0), &antenna(aircraft, altitude_m), |_| hill_m)
        };
        let found = loss_db(distance_m, 0.0);
        prop_assert!(found.is_finite());
        prop_assert!(loss_db(distance_m, hill_m) >= found - 1e-9);
        prop_assert!(two_ray_loss_db(915e6, farther * distance_m, 3.0, altitude_m) >= two_ray_loss_db(915e6, distance_m, 3.0, altitude_m));
        prop_assert!(found >= free_space_loss_db(915e6, distance_m) - 1e-6);
    }

    #[test]
    fn the_loss_is_the_same_in_both_directions(
        distance_m in 200.0..20_000.0f64,
        altitude_m in 20.0..3_000.0f64,
        seed in 0.0..10.0f64,
    ) {
        let station = Position::new(38.0, -120.0);
        let aircraft = destination(station, 200.0, distance_m);
        let hills = |position: Position| 200.0 + 150.0 * libm::sin(300.0 * position.latitude_deg + seed);
        let (low, high) = (antenna(station, 250.0), antenna(aircraft, altitude_m));
        let (up, down) = (TELEMETRY.loss_db(&low, &high, hills), TELEMETRY.loss_db(&high, &low, hills));
        prop_assert!((up - down).abs() < 1e-3, "{up} {down}");
    }
}
