//! Motion of a rotorcraft, which can hover, fly in any direction within its airspeed, and turn in place.

use crate::atmosphere::GRAVITY;
use crate::motion::{Demand, State, climb, moved, wrap_pi, wrap_tau};
use crate::path::{Path, bearing, course};
use apex_geo::geodesy::RAD_PER_DEG;
use apex_geo::wind::{Wind, triangle};
use apex_vehicle::VehicleModel;
use libm::{atan, cos, sin, sqrt};

/// Speed over ground above which the nose follows the track.
const TRACK_SPEED: f64 = 1.5;
/// Distance to a point below which the speed decreases in proportion.
const NEAR_M: f64 = 3.0;

/// Advances `state` by `dt` seconds. Returns true if the vehicle hovers without motion, so that the next step may be long.
pub(crate) fn fly(state: &mut State, demand: &Demand, model: &VehicleModel, wind: Wind, dt: f64) -> bool {
    let level = climb(state, model, demand.altitude_m, dt);
    let (north, east) = wanted_velocity(state, demand, model, wind);
    let still = accelerate(state, model, wind, (north, east), dt);
    let facing = face(state, demand, model, dt);
    level && still && facing
}

/// Returns the radius within which the vehicle can circle at `true_airspeed`.
pub(crate) fn turn_radius_m(model: &VehicleModel, true_airspeed: f64) -> f64 {
    true_airspeed * true_airspeed / (model.braking_share * model.acceleration_m_s2_max)
}

fn wanted_velocity(state: &State, demand: &Demand, model: &VehicleModel, wind: Wind) -> (f64, f64) {
    let braking = model.braking_share * model.acceleration_m_s2_max;
    let (course_rad, speed_max) = match &demand.path {
        Path::Straight => return (0.0, 0.0),
        Path::Point(point) | Path::Hover(point) => {
            let (azimuth_rad, distance_m) = bearing(state.position, *point);
            (azimuth_rad, if distance_m < NEAR_M { distance_m / 2.0 } else { sqrt(2.0 * braking * distance_m) })
        }
        path @ Path::Circle(circle) => {
            let Some(course) = course(path, state, 0.0) else { return (0.0, 0.0) };
            // A course slightly inwards compensates for the lag of the turn.
            (course.course_rad, sqrt(braking * circle.radius_m))
        }
        path @ Path::Paced(_, speed) => {
            let Some(course) = course(path, state, 0.0) else { return (0.0, 0.0) };
            (course.course_rad, *speed)
        }
        path @ (Path::Line(_) | Path::Leg(..)) => {
            let Some(course) = course(path, state, 0.0) else { return (0.0, 0.0) };
            (course.course_rad, f64::INFINITY)
        }
    };
    let airspeed = demand.true_airspeed.min(model.true_airspeed_m_s_max);
    let made_good = triangle(course_rad / RAD_PER_DEG, airspeed, wind).map_or(0.0, |good| good.ground_speed_mps);
    let speed = made_good.min(speed_max);
    (speed * cos(course_rad), speed * sin(course_rad))
}

/// Changes the velocity over ground within the limits of acceleration and airspeed, and moves.
fn accelerate(state: &mut State, model: &VehicleModel, wind: Wind, wanted: (f64, f64), dt: f64) -> bool {
    let (mut air_north, mut air_east) = (wanted.0 - wind.north_mps, wanted.1 - wind.east_mps);
    let airspeed = sqrt(air_north * air_north + air_east * air_east);
    let limit = model.true_airspeed_m_s_max;
    if airspeed > limit {
        (air_north, air_east) = (air_north * limit / airspeed, air_east * limit / airspeed);
    }
    let (north, east) = (air_north + wind.north_mps, air_east + wind.east_mps);
    let (change_north, change_east) = (north - state.north, east - state.east);
    let change = sqrt(change_north * change_north + change_east * change_east);
    let share = if change > 0.0 { (model.acceleration_m_s2_max * dt / change).min(1.0) } else { 0.0 };
    let (old_north, old_east) = (state.north, state.east);
    state.north += share * change_north;
    state.east += share * change_east;
    let (move_north, move_east) = (0.5 * (old_north + state.north) * dt, 0.5 * (old_east + state.east) * dt);
    state.position = moved(state.position, move_north, move_east);
    state.distance_flown_m += sqrt(move_north * move_north + move_east * move_east);
    let (air_north, air_east) = (state.north - wind.north_mps, state.east - wind.east_mps);
    state.true_airspeed = sqrt(air_north * air_north + air_east * air_east);
    tilt(
        state,
        model,
        share * change_north / dt + model.drag_per_s * air_north,
        share * change_east / dt + model.drag_per_s * air_east,
    );
    change < 0.05 && state.ground_speed() < 0.1
}

/// Sets pitch and bank to those that give the horizontal acceleration.
fn tilt(state: &mut State, model: &VehicleModel, north: f64, east: f64) {
    let (sine, cosine) = (sin(state.heading_rad), cos(state.heading_rad));
    let (forward, right) = (north * cosine + east * sine, east * cosine - north * sine);
    let most = model.bank_deg_max * RAD_PER_DEG;
    state.pitch_rad = -atan(forward / GRAVITY).clamp(-most, most);
    state.bank_rad = atan(right / GRAVITY).clamp(-most, most);
}

/// Turns the nose towards the demanded heading. Returns true if it points there.
fn face(state: &mut State, demand: &Demand, model: &VehicleModel, dt: f64) -> bool {
    let along_track = (state.ground_speed() > TRACK_SPEED).then(|| state.track_rad());
    let wanted = demand.nose_rad.or(along_track).unwrap_or(state.heading_rad);
    let most = model.yaw_rate_deg_s_max * RAD_PER_DEG * dt;
    let error = wrap_pi(wanted - state.heading_rad);
    let turned = error.clamp(-most, most);
    state.heading_rad = wrap_tau(state.heading_rad + turned);
    state.yaw_rate_rad_s = turned / dt;
    error.abs() < 0.01
}
