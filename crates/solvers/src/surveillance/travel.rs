//! Travel times for surveillance problems from positions, speed and wind.

use apex_geo::geodesy::Position;
use apex_geo::wind::{WindField, leg_time_s};
use apex_model::problem::{TravelTimes, UNREACHABLE_S};

/// How the vehicle gets from place to place.
#[derive(Clone, Debug)]
pub struct Transit<'a> {
    /// Speed through the air.
    pub true_airspeed_mps: f64,
    /// Altitude of flight.
    pub altitude_m: f64,
    /// The wind.
    pub wind: &'a WindField,
    /// The time for which the wind is taken.
    pub time_s: f64,
}

/// Straight-line travel times in wind between `targets`, from `start` and to `base`. A leg that cannot be flown is
/// [`UNREACHABLE_S`].
pub fn travel_times(start: Position, targets: &[Position], base: Position, transit: &Transit<'_>) -> TravelTimes {
    let leg = |from: Position, to: Position| {
        leg_time_s(from, to, transit.altitude_m, transit.true_airspeed_mps, transit.wind, transit.time_s)
            .unwrap_or(UNREACHABLE_S)
    };
    TravelTimes {
        from_start_s: targets.iter().map(|target| leg(start, *target)).collect(),
        between_s: targets.iter().map(|from| targets.iter().map(|to| leg(*from, *to)).collect()).collect(),
        to_base_s: targets.iter().map(|target| leg(*target, base)).collect(),
    }
}
