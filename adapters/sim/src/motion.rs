//! The vehicle's state, its demands, and the functions shared by fixed wings and rotorcraft: climb, moving over the ellipsoid.

use crate::path::Path;
use apex_geo::geodesy::RAD_PER_DEG;
use apex_model::problem::Position;
use apex_vehicle::VehicleModel;
use libm::{atan2, cos, exp, fmod, sin, sqrt};
use std::f64::consts::{PI, TAU};

/// Position and motion of the vehicle. Angles in radians, clockwise from north; speeds in m/s.
#[derive(Clone, Debug)]
pub(crate) struct State {
    pub(crate) position: Position,
    pub(crate) altitude_m: f64,
    pub(crate) heading_rad: f64,
    pub(crate) true_airspeed: f64,
    /// Bank of the turn alone; turbulence is added in `roll_rad`.
    pub(crate) bank_rad: f64,
    pub(crate) roll_rad: f64,
    pub(crate) pitch_rad: f64,
    pub(crate) roll_rate_rad_s: f64,
    pub(crate) yaw_rate_rad_s: f64,
    pub(crate) vertical_speed: f64,
    /// Velocity over ground.
    pub(crate) north: f64,
    pub(crate) east: f64,
    /// Energy on board: kg of fuel or J of the battery.
    pub(crate) stored: f64,
    /// Present consumption: kg/s or W.
    pub(crate) drain_per_s: f64,
    pub(crate) engine_running: bool,
    pub(crate) on_ground: bool,
    pub(crate) flight_time_s: f64,
    pub(crate) distance_flown_m: f64,
}

impl State {
    /// Returns the speed over ground.
    pub(crate) fn ground_speed(&self) -> f64 {
        sqrt(self.north * self.north + self.east * self.east)
    }

    /// Returns the direction of the velocity over ground; the heading where there is none.
    pub(crate) fn track_rad(&self) -> f64 {
        if self.ground_speed() < 0.2 { self.heading_rad } else { wrap_tau(atan2(self.east, self.north)) }
    }
}

/// Demanded motion of the vehicle.
#[derive(Clone, Debug)]
pub(crate) struct Demand {
    pub(crate) path: Path,
    pub(crate) altitude_m: f64,
    pub(crate) true_airspeed: f64,
    /// Direction in which a rotorcraft points its nose; `None`: along its track.
    pub(crate) nose_rad: Option<f64>,
}

/// Returns `angle` wrapped to 0..2pi.
pub(crate) fn wrap_tau(angle: f64) -> f64 {
    let wrapped = fmod(angle, TAU);
    if wrapped < 0.0 { wrapped + TAU } else { wrapped }
}

/// Returns `angle` wrapped to -pi..pi.
pub(crate) fn wrap_pi(angle: f64) -> f64 {
    wrap_tau(angle + PI) - PI
}

/// Returns the completed share of a first-order lag after `elapsed_s`: exact for any step.
pub(crate) fn lag(elapsed_s: f64, time_constant_s: f64) -> f64 {
    1.0 - exp(-elapsed_s / time_constant_s)
}

/// Moves `position` by metres north and east, with the ellipsoid's radii of curvature at the middle of the move. For moves of a kilometre
/// the error is below a millimetre.
pub(crate) fn moved(position: Position, north_m: f64, east_m: f64) -> Position {
    const SEMI_MAJOR_M: f64 = 6_378_137.0;
    const ECCENTRICITY_SQUARED: f64 = 0.006_694_379_990_141_316;
    let radii = |latitude_deg: f64| {
        let sine = sin(latitude_deg * RAD_PER_DEG);
        let factor = 1.0 - ECCENTRICITY_SQUARED * sine * sine;
        let across = SEMI_MAJOR_M / sqrt(factor);
        (across * (1.0 - ECCENTRICITY_SQUARED) / factor, across)
    };
    let (meridian, _) = radii(position.latitude_deg);
    let middle_deg = position.latitude_deg + 0.5 * north_m / meridian / RAD_PER_DEG;
    let (meridian, across) = radii(middle_deg);
    let latitude_deg = (position.latitude_deg + north_m / meridian / RAD_PER_DEG).clamp(-89.9, 89.9);
    let parallel_m = across * cos(middle_deg * RAD_PER_DEG);
    let longitude_deg = apex_geo::geodesy::wrap_180(position.longitude_deg + east_m / parallel_m / RAD_PER_DEG);
    Position { latitude_deg, longitude_deg }
}

/// Time constants of altitude capture and of climb.
pub(crate) const ALTITUDE_CAPTURE_S: f64 = 6.0;
const CLIMB_LAG_S: f64 = 2.0;
/// Fastest sink without an engine: the approximate rate at which a vehicle that does not glide falls.
const FALL_M_S: f64 = 25.0;
/// Steepest descent without engine, in units of the sink of the best glide.
const STEEPEST: f64 = 2.0;

/// Climbs or descends for `dt` towards `altitude_m`, or sinks without an engine. Returns true if the climb is steady: at the altitude, or
/// so far from it that a long step cannot pass it.
pub(crate) fn climb(state: &mut State, model: &VehicleModel, altitude_m: f64, dt: f64) -> bool {
    let error_m = altitude_m - state.altitude_m;
    let up = model.climb().rate_m_s(state.altitude_m);
    let mut wanted = (error_m / ALTITUDE_CAPTURE_S.max(dt)).clamp(-model.descent_rate_m_s_max, up);
    if !state.engine_running {
        // A glide can be steepened, by a slip or by brakes, and not stretched.
        let sink = (state.true_airspeed.max(6.0) / model.glide_ratio).min(FALL_M_S);
        wanted = wanted.clamp(-STEEPEST * sink, -sink);
    }
    let before = state.vertical_speed;
    state.vertical_speed += (wanted - before) * lag(dt, CLIMB_LAG_S);
    state.altitude_m += 0.5 * (before + state.vertical_speed) * dt;
    let on_it = error_m.abs() < 0.5 && state.vertical_speed.abs() < 0.1;
    if on_it {
        state.altitude_m = altitude_m;
        state.vertical_speed = 0.0;
    }
    on_it || (error_m.abs() > 30.0 * state.vertical_speed.abs() + 60.0 && (wanted - state.vertical_speed).abs() < 0.2)
}

/// Returns the drain of fuel or battery now, kg/s or W.
pub(crate) fn drain_per_s(state: &State, model: &VehicleModel) -> f64 {
    if !state.engine_running {
        return 0.0;
    }
    if state.on_ground && state.true_airspeed < 1.0 {
        return model.drain_idle_per_s();
    }
    model.drain_per_s(state.true_airspeed, state.altitude_m, state.vertical_speed)
}

/// Returns the flight time until fuel or battery are empty, s: in level flight as fast and as high as now; parked, with the drain that
/// plans count on.
pub(crate) fn endurance_s(state: &State, model: &VehicleModel, temperature_c: f64) -> f64 {
    let drain = if state.on_ground {
        model.drain_planned_per_s(state.altitude_m)
    } else {
        model.drain_per_s(state.true_airspeed, state.altitude_m, 0.0)
    };
    model.available(state.stored, temperature_c) / drain
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_geo::geodesy;

    #[test]
    fn a_short_move_is_the_geodesic() {
        let from = Position::new(44.0, -119.0);
        for azimuth_deg in [0.0, 37.0, 90.0, 200.0] {
            let there = geodesy::destination(from, azimuth_deg, 950.0);
            let azimuth_rad = azimuth_deg * RAD_PER_DEG;
            let mine = moved(from, 950.0 * cos(azimuth_rad), 950.0 * sin(azimuth_rad));
            assert!(geodesy::distance_m(there, mine) < 0.1, "{azimuth_deg}");
        }
    }

    #[test]
    fn a_lag_does_not_depend_on_the_step() {
        let mut value = 0.0;
        for _ in 0..10 {
            value += (1.0 - value) * lag(0.1, 2.0);
        }
        assert!((value - lag(1.0, 2.0)).abs() < 1e-12);
    }

    #[test]
    fn angles_wrap() {
        assert!((wrap_pi(3.0 * PI / 2.0) + PI / 2.0).abs() < 1e-12);
        assert!((wrap_tau(-0.5) - (TAU - 0.5)).abs() < 1e-12);
    }
}
