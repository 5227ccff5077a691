//! Independent check of turns: along a path over ground it computes the heading through the air and its rate of change.

use super::single_visit::ground_speed_mps;
use apex_geo::geodesy::{self, Position, RAD_PER_DEG};
use apex_geo::wind;
use apex_model::problem::SingleVisitProblem;
use std::f64::consts::{PI, TAU};

/// Relative tolerance of the turn rate: a path is planned with the mean wind of its leg, and is stored as points.
const TURN_TOLERANCE: f64 = 0.25;
/// Tolerance of a change of heading, for the spacing of the points and the wind between them.
const HEADING_TOLERANCE_RAD: f64 = 0.06;
/// Greatest corner between two pieces of any length, in radians: on a path whose points deviate from the curve by a thousandth of its
/// radius, corners are 0.09 rad.
const CORNER_RAD_MAX: f64 = 0.12;
/// Length in metres below which a piece is too short to show a direction.
const SHORT_M: f64 = 0.5;

/// Returns the flown positions: the path, or the route if turns are not limited.
pub(super) fn flown<'a>(problem: &SingleVisitProblem, route: &'a [Position], path: &'a [Position]) -> &'a [Position] {
    if problem.vehicle.turn_radius_m > 0.0 && !path.is_empty() { path } else { route }
}

/// Returns the direction of a line at its start, or at its end if `behind`; `None` for a line without length.
pub(super) fn track_rad(line: Option<&(Position, Position)>, behind: bool) -> Option<f64> {
    let (from, to) = line?;
    let (length_m, azimuth_deg) = if behind { geodesy::inverse(*to, *from) } else { geodesy::inverse(*from, *to) };
    (length_m > 1.0).then_some((azimuth_deg + if behind { 180.0 } else { 0.0 }) * RAD_PER_DEG)
}

/// Returns the direction in which a path ends; `None` if it has no length.
pub(super) fn end_track_rad(flown: &[Position]) -> Option<f64> {
    let end = flown.last()?;
    let before = flown.iter().rev().find(|before| geodesy::distance_m(**before, *end) > SHORT_M)?;
    track_rad(Some(&(*before, *end)), true)
}

/// A piece of a path: in which direction the air is flown through, and for how long.
struct CheckedPiece {
    heading_rad: f64,
    lasts_s: f64,
}

/// Checks that the vehicle can turn as tightly as `flown` does, and from and to the directions of its `ends`.
pub(super) fn check(
    problem: &SingleVisitProblem,
    flown: &[Position],
    depart_s: f64,
    ends: (Option<f64>, Option<f64>),
    name: &str,
    found: &mut Vec<String>,
) {
    let vehicle = &problem.vehicle;
    if vehicle.turn_radius_m <= 0.0 {
        return;
    }
    let mut pieces: Vec<CheckedPiece> = Vec::new();
    let still = CheckedPiece { heading_rad: 0.0, lasts_s: 0.0 };
    // A path is planned for the wind at its beginning: if the wind changes on the way, the vehicle flies another path.
    let air = |track_rad: f64, place: Position| heading_rad(problem, track_rad, place, depart_s);
    if let (Some(track_rad), Some(place)) = (ends.0, flown.first()) {
        pieces.push(CheckedPiece { heading_rad: air(track_rad, *place), ..still });
    }
    for (from, to) in flown.iter().zip(flown.iter().skip(1)) {
        let (length_m, azimuth_deg) = geodesy::inverse(*from, *to);
        if length_m < SHORT_M {
            continue;
        }
        let middle = geodesy::midpoint(*from, *to);
        let lasts_s = length_m / ground_speed_mps(problem, *from, *to, middle, depart_s);
        let arrives_deg = geodesy::inverse(*to, *from).1 + 180.0;
        // A long piece is a great circle: its direction changes on the way.
        for (track_deg, place) in [(azimuth_deg, *from), (arrives_deg, *to)] {
            let heading_rad = air(track_deg * RAD_PER_DEG, place);
            pieces.push(CheckedPiece { heading_rad, lasts_s: 0.5 * lasts_s });
        }
    }
    if let (Some(track_rad), Some(place)) = (ends.1, flown.last()) {
        pieces.push(CheckedPiece { heading_rad: air(track_rad, *place), lasts_s: 0.0 });
    }
    let rate = vehicle.true_airspeed_mps / vehicle.turn_radius_m * (1.0 + TURN_TOLERANCE);
    let tight = pieces.iter().zip(pieces.iter().skip(1)).any(|(before, after)| {
        let turn_rad = (after.heading_rad - before.heading_rad).rem_euclid(TAU);
        let turn_rad = if turn_rad > PI { TAU - turn_rad } else { turn_rad };
        turn_rad > (rate * (before.lasts_s + after.lasts_s)).min(CORNER_RAD_MAX) + HEADING_TOLERANCE_RAD
    });
    if tight {
        found.push(format!("turns more tightly than {:.0} m on the way to {name}", vehicle.turn_radius_m));
    }
}

/// Returns the heading through the air whose velocity and the local wind add up to the track.
fn heading_rad(problem: &SingleVisitProblem, track_rad: f64, place: Position, time_s: f64) -> f64 {
    let vehicle = &problem.vehicle;
    let here = wind::at(&problem.wind, place, vehicle.cruise_altitude_m, time_s);
    let (east, north) = (libm::sin(track_rad), libm::cos(track_rad));
    let across = (east * here.north_mps - north * here.east_mps) / vehicle.true_airspeed_mps;
    track_rad + libm::asin(across.clamp(-1.0, 1.0))
}
