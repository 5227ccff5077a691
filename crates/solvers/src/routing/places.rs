//! Places of a single-visit problem: positions, altitudes, directions, and travel times that are given as numbers.

use apex_geo::geodesy::{self, Position, RAD_PER_DEG};
use apex_model::problem::{Manoeuvre, SingleVisitProblem, TravelTimes, UNREACHABLE_S};

/// Key of a place among stored paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum PointKey {
    /// The start.
    Start,
    /// The base.
    Base,
    /// Begin of a manoeuvre (target, manoeuvre).
    Entry(usize, usize),
    /// End of a manoeuvre (target, manoeuvre).
    Exit(usize, usize),
}

/// Returns a travel time given as a number; `None` if there is no way.
pub(super) fn given_s(travel: &TravelTimes, from: PointKey, to: PointKey, depart_s: f64) -> Option<f64> {
    let time_s = match (from, to) {
        (PointKey::Start, PointKey::Entry(to, _)) => travel.start_to_at(to, depart_s),
        (PointKey::Exit(from, _), PointKey::Entry(to, _)) => travel.between_at(from, to, depart_s),
        (PointKey::Exit(from, _), PointKey::Base) => travel.to_base_at(from, depart_s),
        _ => UNREACHABLE_S,
    };
    (time_s < UNREACHABLE_S).then_some(time_s)
}

/// Returns the least given travel time over all departures; infinite if no way exists.
pub(super) fn given_s_min(travel: &TravelTimes, from: PointKey, to: PointKey) -> f64 {
    let time_s = match (from, to) {
        (PointKey::Start, PointKey::Entry(to, _)) => travel.start_to_s_min(to),
        (PointKey::Exit(from, _), PointKey::Entry(to, _)) => travel.between_s_min(from, to),
        (PointKey::Exit(from, _), PointKey::Base) => travel.to_base_s_min(from),
        _ => UNREACHABLE_S,
    };
    if time_s < UNREACHABLE_S { time_s } else { f64::INFINITY }
}

/// Returns the direction of the line that a manoeuvre begins or ends with. A place without one is flown over in the
/// direction from the start, so that a vehicle that turns back over it pays for the turn; start and base are left and
/// met in any direction (`None`).
pub(super) fn track_rad(problem: &SingleVisitProblem, node: PointKey) -> Option<f64> {
    let target = match node {
        PointKey::Start | PointKey::Base => return None,
        PointKey::Entry(target, _) | PointKey::Exit(target, _) => problem.targets.get(target)?,
    };
    line_track_rad(problem, node).or_else(|| {
        let (length_m, azimuth_deg) = geodesy::inverse(target.position, problem.start);
        Some(if length_m > 1.0 { (azimuth_deg + 180.0) * RAD_PER_DEG } else { 0.0 })
    })
}

/// Returns the direction of the line that a manoeuvre begins or ends with; `None` if it has none.
pub(super) fn line_track_rad(problem: &SingleVisitProblem, node: PointKey) -> Option<f64> {
    let lines = |target: usize, manoeuvre: usize| {
        problem.targets.get(target)?.manoeuvres.get(manoeuvre).map(|manoeuvre| &manoeuvre.lines)
    };
    let (here, there, back) = match node {
        PointKey::Start | PointKey::Base => return None,
        PointKey::Entry(target, it) => lines(target, it)?.first().map(|(from, to)| (*from, *to, false))?,
        PointKey::Exit(target, manoeuvre) => lines(target, manoeuvre)?.last().map(|(from, to)| (*to, *from, true))?,
    };
    let (length_m, azimuth_deg) = geodesy::inverse(here, there);
    let track_deg = if back { azimuth_deg + 180.0 } else { azimuth_deg };
    (length_m > 1.0).then_some(track_deg * RAD_PER_DEG)
}

/// Returns the position of a node and its altitude.
pub(super) fn place(problem: &SingleVisitProblem, node: PointKey) -> (Position, f64) {
    let cruise_m = problem.vehicle.cruise_altitude_m;
    let of = |target: usize, manoeuvre: usize, entry: bool| {
        let target = problem.targets.get(target);
        let manoeuvre = target.and_then(|target| target.manoeuvres.get(manoeuvre));
        let overhead = target.map_or(problem.start, |target| target.position);
        let begins = |m: &Manoeuvre| m.entry.or(m.lines.first().map(|(from, _)| *from));
        let position = manoeuvre.and_then(|m| if entry { begins(m) } else { m.lines.last().map(|(_, to)| *to) });
        (position.unwrap_or(overhead), manoeuvre.map_or(cruise_m, |manoeuvre| manoeuvre.altitude_m))
    };
    match node {
        PointKey::Start => (problem.start, problem.start_altitude_m),
        PointKey::Base => (problem.base.unwrap_or(problem.start), cruise_m),
        PointKey::Entry(target, manoeuvre) => of(target, manoeuvre, true),
        PointKey::Exit(target, manoeuvre) => of(target, manoeuvre, false),
    }
}
