//! Clearance from the ground.

use crate::prediction::{RouteSpan, Violation, first_violation};
use crate::response::climb_s;
use crate::route::Route;
use apex_geo::plane::Point;

/// Returns the margin in metres: height above the highest ground near, beyond the clearance.
pub fn terrain_m(altitude_m: f64, ground_m_max: f64, clearance_m: f64) -> f64 {
    altitude_m - ground_m_max - clearance_m
}

/// A rise of the ground ahead and the climb over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClimbOver {
    /// Height to climb.
    pub height_m: f64,
    /// Time that the climb takes; infinite if the vehicle cannot climb.
    pub climb_s: f64,
    /// Distance over ground that the climb takes.
    pub climb_m: f64,
    /// Time within which the climb must begin; negative if it is too late to climb straight ahead.
    pub latest_start_s: f64,
}

/// Returns the climb that keeps `clearance_m` over ground of `ground_m` that lies `distance_m` ahead.
pub fn climb_over(
    (altitude_m, ground_speed_mps, climb_mps): (f64, f64, f64),
    ground_m: f64,
    distance_m: f64,
    clearance_m: f64,
) -> ClimbOver {
    let height_m = (-terrain_m(altitude_m, ground_m, clearance_m)).max(0.0);
    let duration_s = climb_s(height_m, climb_mps);
    let climb_m = duration_s * ground_speed_mps;
    ClimbOver { height_m, climb_s: duration_s, climb_m, latest_start_s: (distance_m - climb_m) / ground_speed_mps }
}

/// Returns the earliest necessary climb along `route` that keeps `clearance_m` over all ground within the look-ahead; `None` if no ground
/// along it is too high. Sampled each second.
pub fn latest_climb(
    route: &Route,
    look_ahead_s: f64,
    clearance_m: f64,
    climb_mps: f64,
    mut ground_m: impl FnMut(Point) -> f64,
) -> Option<ClimbOver> {
    let until_s = route.end_s().min(look_ahead_s);
    let states = (0..=until_s.max(0.0) as u32).filter_map(|second| route.at(f64::from(second)));
    let climbs = states.filter_map(|state| {
        let height_m = -terrain_m(state.altitude_m, ground_m(state.point), clearance_m);
        let duration_s = climb_s(height_m.max(0.0), climb_mps);
        (height_m > 0.0).then_some(ClimbOver {
            height_m,
            climb_s: duration_s,
            climb_m: duration_s * route.speed_mps_max(),
            latest_start_s: state.after_s - duration_s,
        })
    });
    climbs.min_by(|a, b| a.latest_start_s.total_cmp(&b.latest_start_s))
}

/// Returns the first instant along `route` at which the clearance is lost; `ground_m` returns the highest ground near a point. Sampled
/// each second, because the ground may rise at any rate.
pub fn first_loss(
    route: &Route,
    look_ahead_s: f64,
    clearance_m: f64,
    mut ground_m: impl FnMut(Point) -> f64,
) -> Option<Violation> {
    first_violation(route, RouteSpan { from_s: 0.0, until_s: look_ahead_s }, f64::INFINITY, |state| {
        terrain_m(state.altitude_m, ground_m(state.point), clearance_m)
    })
}
