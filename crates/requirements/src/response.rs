//! Duration of a response, and whether it must begin now.

use crate::GRAVITY_M_S2;
use std::f64::consts::FRAC_PI_2;

/// Returns the radius of a turn with `bank_deg` in still air: `V^2 / (g tan bank)`. A bank of 0 or less gives infinity.
pub fn turn_radius_m(true_airspeed_mps: f64, bank_deg: f64) -> f64 {
    let tangent = libm::tan(bank_deg.to_radians());
    if tangent > 0.0 { true_airspeed_mps * true_airspeed_mps / (GRAVITY_M_S2 * tangent) } else { f64::INFINITY }
}

/// Returns the distance by which wind carries a vehicle during a quarter turn.
pub fn drift_m(turn_radius_m: f64, true_airspeed_mps: f64, tail_wind_mps: f64) -> f64 {
    if true_airspeed_mps > 0.0 { tail_wind_mps * FRAC_PI_2 * turn_radius_m / true_airspeed_mps } else { 0.0 }
}

/// Returns the radius over ground that a turn needs in the worst case: the radius in still air plus the drift of a quarter turn.
pub fn drifted_radius_m(turn_radius_m: f64, true_airspeed_mps: f64, wind_mps: f64) -> f64 {
    turn_radius_m + drift_m(turn_radius_m, true_airspeed_mps, wind_mps.max(0.0))
}

/// Returns the time at the present ground speed that turning away from an edge straight ahead needs: roll-in, turn radius, drift. A turn
/// cannot avoid an edge that is nearer than this in time.
pub fn turn_away_s(true_airspeed_mps: f64, turn_radius_m: f64, tail_wind_mps: f64, roll_in_s: f64) -> f64 {
    let ground_speed_mps = true_airspeed_mps + tail_wind_mps;
    if ground_speed_mps <= 0.0 {
        return 0.0;
    }
    let needed_m = drifted_radius_m(turn_radius_m, true_airspeed_mps, tail_wind_mps) + roll_in_s * ground_speed_mps;
    needed_m / ground_speed_mps
}

/// Returns the time that a climb over `height_m` takes; infinity if the vehicle cannot climb, 0 if no climb is needed.
pub fn climb_s(height_m: f64, climb_mps: f64) -> f64 {
    if height_m <= 0.0 {
        0.0
    } else if climb_mps > 0.0 {
        height_m / climb_mps
    } else {
        f64::INFINITY
    }
}

/// Returns the time at the present speed that stopping needs: `v / (2 a)`, since the distance is `v^2 / (2 a)`.
pub fn stop_s(speed_mps: f64, braking_m_s2: f64) -> f64 {
    if braking_m_s2 > 0.0 { speed_mps.max(0.0) / (2.0 * braking_m_s2) } else { f64::INFINITY }
}

/// Returns true if a response that takes `response_s` must begin now: the requirement is violated in `violation_s` (0: now), and is
/// checked every `loop_s`. One check may be missed.
pub fn must_act(violation_s: f64, response_s: f64, loop_s: f64) -> bool {
    violation_s <= response_s + 2.0 * loop_s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stopping_takes_half_the_time_that_the_distance_takes() {
        assert_eq!(stop_s(10.0, 2.0), 2.5, "25 m at 10 m/s");
        assert_eq!(climb_s(-5.0, 0.0), 0.0);
        assert_eq!(climb_s(5.0, 0.0), f64::INFINITY);
    }

    #[test]
    fn a_response_begins_two_checks_early() {
        assert!(must_act(34.8, 32.8, 1.0));
        assert!(!must_act(34.9, 32.8, 1.0));
        assert!(must_act(0.0, 0.0, 1.0), "what is violated is acted upon");
        assert!(!must_act(f64::INFINITY, 32.8, 1.0));
    }
}
