//! View of the world for flight orders, with derived radii, stopping places and the path to an airfield.

use crate::arguments::Spot;
use crate::fixed_wing;
use crate::motion::{State, moved, wrap_pi};
use crate::path::{Circle, Line, bearing};
use crate::rotorcraft;
use apex_geo::geodesy::{self, RAD_PER_DEG};
use apex_geo::wind::Wind;
use apex_model::problem::Position;
use apex_model::time::Time;
use apex_vehicle::{Airframe, VehicleModel};
use libm::atan2;
use std::f64::consts::PI;

/// Altitude error at which a fixed wing or a rotorcraft counts as on its altitude.
const ALTITUDE_M: (f64, f64) = (40.0, 2.0);

/// Minimum height above ground of a commanded altitude: fixed wing (or this time at cruise speed, if less), rotorcraft.
const HEIGHT_M_MIN: (f64, f64) = (100.0, 2.0);
const HEIGHT_S_MIN: f64 = 2.0;

/// Part of the world that a flight order reads.
pub(crate) struct Situation<'a> {
    pub(crate) model: &'a VehicleModel,
    pub(crate) state: &'a State,
    pub(crate) wind: Wind,
    pub(crate) ground_m: f64,
    pub(crate) now: Time,
    pub(crate) altitude_m: f64,
    pub(crate) true_airspeed: f64,
}

impl Situation<'_> {
    /// Returns true for a fixed wing.
    pub(crate) fn fixed(&self) -> bool {
        self.model.airframe == Airframe::FixedWing
    }

    /// Returns true on the commanded altitude, and always without a running engine, because the vehicle then cannot hold an altitude.
    pub(crate) fn at_altitude(&self) -> bool {
        let within = if self.fixed() { ALTITUDE_M.0 } else { ALTITUDE_M.1 };
        (self.altitude_m - self.state.altitude_m).abs() <= within || !self.state.engine_running
    }

    /// Returns the maximum speed over ground here.
    pub(crate) fn ground_speed_max(&self) -> f64 {
        let wind = libm::sqrt(self.wind.east_mps * self.wind.east_mps + self.wind.north_mps * self.wind.north_mps);
        self.true_airspeed.max(self.state.true_airspeed) + wind
    }

    /// Returns the minimum height above ground of a commanded altitude.
    pub(crate) fn height_m_min(&self) -> f64 {
        let fixed_m = HEIGHT_M_MIN.0.min(HEIGHT_S_MIN * self.model.true_airspeed_m_s_cruise);
        if self.fixed() { fixed_m } else { HEIGHT_M_MIN.1 }
    }

    /// Returns true for a rotorcraft in a wind in which it cannot stay over one place.
    pub(crate) fn is_adrift(&self) -> bool {
        let wind = libm::hypot(self.wind.east_mps, self.wind.north_mps);
        !self.fixed() && wind >= self.model.true_airspeed_m_s_max
    }

    /// Returns the radius of the tightest circle here.
    pub(crate) fn turn_radius_m(&self) -> f64 {
        let speed = self.true_airspeed.max(self.state.true_airspeed);
        match self.model.airframe {
            Airframe::FixedWing => fixed_wing::turn_radius_m(self.model, speed, self.wind),
            Airframe::Rotorcraft => rotorcraft::turn_radius_m(self.model, self.true_airspeed.min(6.0)),
        }
    }

    /// Returns the radius of the circle flown without a command.
    pub(crate) fn loiter_radius_m(&self) -> f64 {
        self.model.turns.circle_width * self.turn_radius_m()
    }

    /// Returns a circle round `centre`, in the direction that needs the smaller turn.
    pub(crate) fn circle(&self, centre: Position, radius_m: f64) -> Circle {
        let aside = wrap_pi(bearing(self.state.position, centre).0 - self.state.track_rad());
        Circle { centre, radius_m, clockwise: aside >= 0.0 }
    }

    /// Returns the place at which a rotorcraft can stop.
    pub(crate) fn stopping_place(&self) -> Position {
        let speed = self.state.ground_speed();
        let seconds = 0.5 * speed / (self.model.braking_share * self.model.acceleration_m_s2_max);
        moved(self.state.position, self.state.north * seconds, self.state.east * seconds)
    }
}

/// Returns the final approach to an airfield: in the direction `course_rad` if given, otherwise into the wind; without wind, from the
/// direction of the vehicle.
pub(crate) fn final_approach(at: &Spot, course_rad: Option<f64>, here: &Situation) -> Line {
    let wind = here.wind;
    let calm = wind.east_mps * wind.east_mps + wind.north_mps * wind.north_mps < 1.0;
    let chosen_rad =
        if calm { bearing(here.state.position, at.position).0 } else { atan2(-wind.east_mps, -wind.north_mps) };
    let course_rad = course_rad.unwrap_or(chosen_rad);
    let threshold = geodesy::destination(at.position, (course_rad + PI) / RAD_PER_DEG, here.model.final_approach_m);
    Line::new(threshold, at.position)
}
