//! A fixed wing in the air: coordinated turns with limits on bank and roll rate, first-order lags, wind drift.

use crate::atmosphere::{Air, GRAVITY};
use crate::motion::{Demand, State, climb, lag, moved, wrap_pi, wrap_tau};
use crate::path::course;
use apex_geo::geodesy::RAD_PER_DEG;
use apex_geo::wind::{Wind, triangle};
use apex_vehicle::VehicleModel;
use apex_vehicle::derived::GROUND_ACCELERATION;
use libm::{atan, cos, sin, sqrt, tan};

/// Commanded turn rate per radian of heading error.
const HEADING_GAIN_PER_S: f64 = 0.25;
/// Time constants of bank and speed.
const BANK_LAG_S: f64 = 0.6;
const SPEED_LAG_S: f64 = 5.0;
/// Heading error and bank below which the vehicle counts as flying straight.
const STRAIGHT_RAD: f64 = 0.006;
const LEVEL_RAD: f64 = 0.02;

/// Returns the radius of a turn that can be held at `true_airspeed` over a full circle in this wind.
pub(crate) fn turn_radius_m(model: &VehicleModel, true_airspeed: f64, wind: Wind) -> f64 {
    let speed = true_airspeed + sqrt(wind.east_mps * wind.east_mps + wind.north_mps * wind.north_mps);
    speed * speed / (GRAVITY * tan(model.turns.bank_share * model.bank_deg_max * RAD_PER_DEG))
}

/// Returns the slowest true airspeed at an altitude.
pub(crate) fn true_airspeed_min(model: &VehicleModel, altitude_m: f64) -> f64 {
    model.indicated_airspeed_m_s_min * Air::at(altitude_m).true_per_indicated()
}

/// Flies `state` for `dt`. Returns true if nothing is changing, so that the next step may be long.
pub(crate) fn fly(state: &mut State, demand: &Demand, model: &VehicleModel, wind: Wind, dt: f64) -> bool {
    let level = climb(state, model, demand.altitude_m, dt);
    let true_per_indicated = Air::at(state.altitude_m).true_per_indicated();
    let slowest = model.indicated_airspeed_m_s_min * true_per_indicated;
    let speed_held = hold_speed(state, demand.true_airspeed, slowest, model, dt);
    let straight = turn(state, demand, model, wind, dt);
    let climb_angle = (state.vertical_speed / state.true_airspeed.max(1.0)).clamp(-0.5, 0.5);
    let indicated = state.true_airspeed / true_per_indicated;
    let slowness = model.indicated_airspeed_m_s_min / indicated.max(1.0);
    state.pitch_rad = climb_angle + VehicleModel::level_pitch_rad(slowness);
    level && speed_held && straight
}

/// Accelerates towards `true_airspeed`, within the limits of speed at this altitude.
fn hold_speed(state: &mut State, true_airspeed: f64, slowest: f64, model: &VehicleModel, dt: f64) -> bool {
    let wanted = true_airspeed.clamp(slowest.min(model.true_airspeed_m_s_max), model.true_airspeed_m_s_max);
    let error = wanted - state.true_airspeed;
    let most = model.acceleration_m_s2_max * dt;
    state.true_airspeed += (error * lag(dt, SPEED_LAG_S)).clamp(-most, most);
    error.abs() < 0.3
}

/// Turns towards the path and moves over ground. Returns true on a straight, level course.
fn turn(state: &mut State, demand: &Demand, model: &VehicleModel, wind: Wind, dt: f64) -> bool {
    let (old_heading, old_bank) = (state.heading_rad, state.bank_rad);
    let speed = state.true_airspeed.max(1.0);
    let wanted = course(&demand.path, state, turn_radius_m(model, speed, wind));
    let (error_rad, rate_rad_s) = wanted.map_or((0.0, 0.0), |course| {
        let track_deg = course.course_rad / RAD_PER_DEG;
        let crab = triangle(track_deg, speed, wind);
        let heading_rad = crab.map_or(course.course_rad, |crab| crab.heading_deg * RAD_PER_DEG);
        // In a tailwind the heading turns more slowly than the course, in a headwind faster.
        let tail = wind.north_mps * cos(course.course_rad) + wind.east_mps * sin(course.course_rad);
        let forward = speed * cos(wrap_pi(heading_rad - course.course_rad)).max(0.1);
        (wrap_pi(heading_rad - state.heading_rad), course.rate_rad_s * (forward - tail) / forward)
    });
    let straight = rate_rad_s == 0.0 && error_rad.abs() < STRAIGHT_RAD && state.bank_rad.abs() < LEVEL_RAD;
    if straight {
        let change = error_rad * lag(dt, 1.0 / HEADING_GAIN_PER_S);
        state.heading_rad = wrap_tau(state.heading_rad + change);
        state.bank_rad = atan(speed * change / (dt * GRAVITY));
    } else {
        let most = model.bank_deg_max * RAD_PER_DEG;
        let rate = HEADING_GAIN_PER_S * error_rad + rate_rad_s;
        let bank = atan(speed * rate / GRAVITY).clamp(-most, most);
        let step = model.roll_rate_deg_s_max * RAD_PER_DEG * dt;
        state.bank_rad += ((bank - old_bank) * lag(dt, BANK_LAG_S)).clamp(-step, step);
        let turned = GRAVITY * tan(0.5 * (old_bank + state.bank_rad)) / speed * dt;
        state.heading_rad = wrap_tau(state.heading_rad + turned);
    }
    let turned = wrap_pi(state.heading_rad - old_heading);
    state.yaw_rate_rad_s = turned / dt;
    let middle = old_heading + 0.5 * turned;
    drift(state, middle, wind, dt);
    straight
}

/// Moves over ground: the air's velocity plus the wind's.
fn drift(state: &mut State, heading_rad: f64, wind: Wind, dt: f64) {
    let level =
        sqrt((state.true_airspeed * state.true_airspeed - state.vertical_speed * state.vertical_speed).max(0.0));
    let (north, east) = (level * cos(heading_rad) + wind.north_mps, level * sin(heading_rad) + wind.east_mps);
    state.position = moved(state.position, north * dt, east * dt);
    state.distance_flown_m += sqrt(north * north + east * east) * dt;
    state.north = level * cos(state.heading_rad) + wind.north_mps;
    state.east = level * sin(state.heading_rad) + wind.east_mps;
}

/// Rolls on the ground for `dt`, towards `speed`.
pub(crate) fn roll(state: &mut State, model: &VehicleModel, speed: f64, dt: f64) {
    let most = GROUND_ACCELERATION * model.acceleration_m_s2_max * dt;
    let before = state.true_airspeed;
    state.true_airspeed += (speed - before).clamp(-most, most);
    let middle = 0.5 * (before + state.true_airspeed);
    let (north, east) = (cos(state.heading_rad), sin(state.heading_rad));
    state.position = moved(state.position, middle * north * dt, middle * east * dt);
    (state.north, state.east) = (state.true_airspeed * north, state.true_airspeed * east);
    state.vertical_speed = 0.0;
    state.bank_rad = 0.0;
    state.pitch_rad = 0.0;
    state.yaw_rate_rad_s = 0.0;
}
