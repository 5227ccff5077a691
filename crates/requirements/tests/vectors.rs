//! Guard vectors: situations with figures computed by hand, independently of this crate's route and search.

#![allow(clippy::unwrap_used, reason = "a failed test should stop")]

use apex_geo::plane::{Plane, Point};
use apex_geo::wind::Wind;
use apex_model::problem::{AirspaceZone, FOREVER_S, Position, TimeWindow, ZoneKind};
use apex_requirements::margin::sensor::Detector;
use apex_requirements::margin::terrain::climb_over;
use apex_requirements::margin::zone::{LocalZone, ZoneBuffer};
use apex_requirements::margin::{energy, landing, link, terrain};
use apex_requirements::response::{drift_m, must_act, turn_away_s, turn_radius_m};
use apex_requirements::route::{Motion, Route};

const BUFFER: ZoneBuffer = ZoneBuffer { horizontal_m: 500.0, vertical_m: 150.0, time_s: 0.0 };
const ROLL_IN_S: f64 = 3.0;
const SPEED_MPS: f64 = 95.0;

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found}, expected {expected} within {tolerance}");
}

fn bank_18_m() -> f64 {
    turn_radius_m(SPEED_MPS, 18.0)
}

/// Returns a zone whose near edge lies 8,000 m north of the vehicle, 20 km deep and 40 km wide.
fn zone_ahead(plane: &Plane, altitude_m: (f64, f64), active: TimeWindow) -> LocalZone {
    let corners = [(-20e3, 8e3), (20e3, 8e3), (20e3, 28e3), (-20e3, 28e3)];
    let zone = AirspaceZone {
        name: "ahead".into(),
        kind: ZoneKind::Restricted,
        corners: corners.iter().map(|(x, y)| plane.position(Point { x: *x, y: *y })).collect(),
        altitude_m_min: altitude_m.0,
        altitude_m_max: altitude_m.1,
        active,
    };
    LocalZone::new(0, &zone, plane).unwrap()
}

fn north(tail_mps: f64, length_m: f64) -> Route {
    let wind = Wind { north_mps: tail_mps, ..Wind::default() };
    let motion =
        Motion { true_airspeed_mps: SPEED_MPS, wind, turn_radius_m: bank_18_m(), climb_mps: 6.0, descent_mps: 6.0 };
    let start = Point::default();
    Route::begin(start, Point { x: 0.0, y: 1.0 }, (7_000.0, 7_000.0), motion).straight(Point { x: 0.0, y: length_m })
}

fn plane() -> Plane {
    Plane::new(Position::new(37.0, -117.0))
}

#[test]
fn g1_a_zone_ahead_is_turned_away_from_in_time() {
    near(bank_18_m(), 2_832.0, 1.0);
    let zone = zone_ahead(&plane(), (0.0, 18_000.0), TimeWindow::ALWAYS);
    let entry_s = |tail_mps: f64| zone.first_entry(&north(tail_mps, 40e3), &BUFFER, 0.0, 0.0, 300.0).unwrap().after_s;
    let away_s = |tail_mps: f64| turn_away_s(SPEED_MPS, bank_18_m(), tail_mps, ROLL_IN_S);
    near(entry_s(0.0), 78.9, 0.1);
    near(away_s(0.0) * 95.0 + 500.0, 3_617.0, 1.0);
    near(entry_s(0.0) - away_s(0.0), 46.1, 0.1);
    near(drift_m(bank_18_m(), SPEED_MPS, 20.0), 936.5, 1.0);
    near(away_s(20.0) * 115.0 + 500.0, 4_614.0, 1.0);
    near(entry_s(20.0) - away_s(20.0), 29.4, 0.1);
    // The rule acts from 46.1 s - 2 checks on.
    assert!(!must_act(entry_s(0.0) - 44.0, away_s(0.0), 1.0) && must_act(entry_s(0.0) - 44.3, away_s(0.0), 1.0));
}

#[test]
fn g2_a_zone_that_becomes_active_later_is_flown_through_before() {
    let active = TimeWindow { from_s: 600.0, until_s: FOREVER_S };
    let zone = zone_ahead(&plane(), (0.0, 18_000.0), active);
    let entry = |look_ahead_s: f64, speed_error: f64| {
        zone.first_entry(&north(0.0, 60e3), &BUFFER, 0.0, speed_error, look_ahead_s)
    };
    // The buffered zone ends 28,500 m ahead: through after 300 s.
    assert_eq!(entry(1_000.0, 0.0), None);
    assert_eq!(entry(1_000.0, 0.05), None);
    // Only an arrival spread that reaches 600 s would meet it: at half the speed the vehicle is still inside.
    let slow = zone.first_entry(&north(0.0, 60e3), &BUFFER, 20.0, 0.99, 1_000.0).unwrap();
    near(slow.after_s, 580.0 / 1.99, 0.1);
    // An aircraft that is there at 500 s of mission time is inside when the zone begins.
    let inside = zone.first_entry(&north(0.0, 60e3), &BUFFER, 400.0, 0.0, 1_000.0).unwrap();
    near(inside.after_s, 200.0, 0.1);
}

#[test]
fn g3_a_zone_far_below_is_not_a_reason_to_divert() {
    let zone = zone_ahead(&plane(), (0.0, 1_900.0), TimeWindow::ALWAYS);
    assert_eq!(zone.first_entry(&north(0.0, 40e3), &BUFFER, 0.0, 0.05, 300.0), None);
    let above = Point { x: 0.0, y: 18_000.0 };
    near(zone.keep_out_m(above, 7_000.0, &BUFFER), 5_100.0 - 150.0, 1e-6);
    let without = ZoneBuffer { horizontal_m: 0.0, vertical_m: 0.0, time_s: 0.0 };
    near(zone.keep_out_m(above, 7_000.0, &without), 5_100.0, 1e-6);
}

#[test]
fn g4_a_head_wind_puts_the_field_out_of_gliding_reach() {
    let glide = landing::Glide { ratio: 18.0, airspeed_mps: 62.0 };
    let margin_m = |tail_mps: f64| landing::glide_m(glide, 4_000.0, 300.0, tail_mps, 60_000.0);
    near(margin_m(0.0), 6_600.0, 1.0);
    near(margin_m(-10.0), -4_200.0, 60.0);
    for (tail_mps, reach_km) in [(0.0, 108.0), (-10.0, 90.6), (-20.0, 73.1), (10.0, 125.4)] {
        near(landing::glide_reach_m(glide, 6_000.0, tail_mps) / 1e3, reach_km, 0.05);
    }
}

#[test]
fn g5_a_slow_way_home_uses_the_reserve() {
    let (per_s, reserve_kg) = (62.3 / 3600.0, 0.75 * 62.3);
    let margin_kg = |ground_speed_mps: f64| energy::energy(200.0, reserve_kg, per_s, 400.0 * 1852.0, ground_speed_mps);
    near(margin_kg(95.0), 18.3, 0.1);
    near(margin_kg(75.0), -17.7, 0.1);
    assert_eq!(margin_kg(0.0), f64::NEG_INFINITY);
    let seconds = energy::energy_s(200.0, reserve_kg, per_s, 400.0 * 1852.0, 95.0);
    near(seconds * per_s, 18.3, 0.1);
}

#[test]
fn g6_an_edge_on_the_line_of_sight_breaks_the_link() {
    // -77.7 dBm at 5 km and 915 MHz; an edge 20 m above the line costs 19.9 dB.
    near(link::link_db(-77.7, -95.0, 10.0), 7.3, 1e-9);
    near(link::link_db(-77.7 - 19.9, -95.0, 10.0), -12.6, 1e-9);
}

#[test]
fn g7_a_warm_detector_pauses_before_its_limit() {
    let detector = Detector { power_w: 60.0, conductance_w_k: 2.0, capacity_j_k: 3_000.0, limit_c: 45.0 };
    near(detector.time_to_limit_s(30.0, 20.0).unwrap(), 2_079.0, 1.0);
    assert_eq!(detector.temperature_k(30.0), 15.0);
}

#[test]
fn g8_a_ridge_is_climbed_over_in_time() {
    near(terrain::terrain_m(2_000.0, 1_900.0, 300.0), -200.0, 1e-9);
    let climb = climb_over((2_000.0, 95.0, 6.0), 1_900.0, 12_000.0, 300.0);
    near(climb.climb_m, 3_167.0, 1.0);
    near(climb.latest_start_s, 93.0, 0.1);
}

#[test]
fn g9_a_battery_near_its_floor_returns() {
    let (capacity_wh, power_w) = (548.0, 598.0);
    let left_wh = 0.3 * capacity_wh;
    let margin_s = energy::energy_s(left_wh, 0.2 * capacity_wh, power_w / 3600.0, 3_000.0, 10.0);
    near(margin_s / 60.0, 0.5, 0.01);
}
