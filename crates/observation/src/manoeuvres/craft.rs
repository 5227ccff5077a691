//! The vehicle's properties for manoeuvres: speeds, turns, accelerations, and the drain at each airspeed.
//!
//! Callers convert vehicle files to these figures. Units are in the names; wind is over ground, airspeeds are true.

use crate::clarity::AttitudeHold;
use apex_geo::geodesy::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// Standard acceleration of gravity, m/s^2.
pub const GRAVITY_MPS2: f64 = 9.806_65;

/// A vehicle that flies manoeuvres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Craft {
    /// Name, for refusals.
    pub name: String,
    /// True if it can stand still over ground and turn in place.
    pub can_hover: bool,
    /// True airspeed flown where a manoeuvre demands no other.
    pub true_airspeed_mps: f64,
    /// Slowest true airspeed at the altitude; 0 for a vehicle that hovers.
    pub true_airspeed_mps_min: f64,
    /// Fastest true airspeed.
    pub true_airspeed_mps_max: f64,
    /// Bank that turns are planned with; used by fixed wings.
    pub bank_deg: f64,
    /// Greatest change of speed, and of the direction of flight for a vehicle that hovers.
    pub acceleration_mps2: f64,
    /// Deceleration that stops are planned with.
    pub braking_mps2: f64,
    /// Turn rate in place; 0 for a vehicle that cannot hover.
    pub yaw_rate_deg_s: f64,
    /// Fastest climb.
    pub climb_mps_max: f64,
    /// Fastest descent.
    pub descent_mps_max: f64,
    /// Fastest airspeed tail first; 0 for a vehicle that cannot.
    pub rearward_mps_max: f64,
    /// Fastest airspeed sideways; 0 for a vehicle that cannot.
    pub sideways_mps_max: f64,
    /// Strongest wind in which it hovers.
    pub wind_mps_max: f64,
    /// Time of straight flight before a line, on which the wings come level; 0 for a vehicle that hovers.
    pub settle_s: f64,
    /// Pitch of level flight at cruise speed, nose up: what looks straight down in the body looks ahead by it. 0 for a vehicle that hovers.
    pub level_pitch_deg: f64,
    /// Response of the attitude to turbulence.
    pub hold: AttitudeHold,
    /// Consumption of energy.
    pub drain: DrainTable,
}

/// Drain of fuel (kg/s) or battery (W) in level flight by true airspeed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrainTable {
    /// Airspeed in m/s and drain per second, in order of airspeed; at least one pair.
    pub points: Vec<(f64, f64)>,
}

impl DrainTable {
    /// Returns the drain per second at a true airspeed: linear between the points, constant beyond them; 0 for an empty table.
    pub fn per_s(&self, true_airspeed_mps: f64) -> f64 {
        let after = self.points.partition_point(|(airspeed, _)| *airspeed <= true_airspeed_mps);
        match (after.checked_sub(1).and_then(|before| self.points.get(before)), self.points.get(after)) {
            (Some((low, from)), Some((high, to))) => from + (to - from) * (true_airspeed_mps - low) / (high - low),
            (Some((_, only)), None) | (None, Some((_, only))) => *only,
            (None, None) => 0.0,
        }
    }
}

impl Craft {
    /// Returns the radius of a turn through the air at `true_airspeed_mps` with the bank of planned turns: `V^2 / (g tan phi)`. For a
    /// vehicle that hovers, the radius at which the turn accelerates by [`Craft::braking_mps2`].
    pub fn turn_radius_m(&self, true_airspeed_mps: f64) -> f64 {
        if self.can_hover {
            true_airspeed_mps * true_airspeed_mps / self.braking_mps2
        } else {
            true_airspeed_mps * true_airspeed_mps / (GRAVITY_MPS2 * libm::tan(self.bank_deg * RAD_PER_DEG))
        }
    }

    /// Returns the least radius of a circle over ground in a wind: `(V + w)^2 / (g tan phi)`.
    pub fn circle_radius_m_min(&self, true_airspeed_mps: f64, wind_mps: f64) -> f64 {
        self.turn_radius_m(true_airspeed_mps + wind_mps)
    }
}

/// Returns the bank of a circle over ground: `tan phi = gs^2 / (g r cos crab)`, in degrees.
pub fn circle_bank_deg(ground_speed_mps: f64, radius_m: f64, crab_rad: f64) -> f64 {
    let tangent = ground_speed_mps * ground_speed_mps / (GRAVITY_MPS2 * radius_m * libm::cos(crab_rad));
    libm::atan(tangent) / RAD_PER_DEG
}
