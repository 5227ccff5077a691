//! Violations of a path: every zone that it violates, so that an operator is warned of each before the flight.

use super::limits::Limits;
use super::straight::{LATE_S, LATE_SHARE};
use super::{Request, Way};
use apex_geo::geodesy;
use apex_geo::plane::{self, Plane, Point};
use apex_model::problem::{AirspaceZone, Position, ZoneKind};

/// Pieces of a leg are at most this long.
const PIECE_M: f64 = 250.0;
const PIECES_MAX: f64 = 5_000.0;

impl Limits {
    /// Returns the names of the restricted zones that the path approaches within `clearance_m` while they are active, in the mission's
    /// order, then `permitted area` if the path may leave that. For a path with turns, `clearance_m` counts only around both ends, where
    /// the vehicle chooses its turns itself; otherwise everywhere. Bound: O(corners x pieces).
    pub(super) fn crossed(&self, request: &Request, way: &Way, (clearance_m, has_turns): (f64, bool)) -> Vec<String> {
        let samples = samples(request, way, self.true_airspeed_mps);
        let clearance_at_m = |place: Position| {
            let is_end = [request.from, request.to].iter().any(|end| geodesy::distance_m(*end, place) <= clearance_m);
            if is_end || !has_turns { clearance_m } else { 0.0 }
        };
        let altitudes_m = [request.from_altitude_m, way.altitude_m, request.to_altitude_m];
        let low_m = altitudes_m.iter().copied().fold(f64::INFINITY, f64::min);
        let high_m = altitudes_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let holds = |zone: &AirspaceZone, from_s: f64, until_s: f64| {
            zone.altitude_m_min <= high_m
                && low_m < zone.altitude_m_max
                && zone.active.from_s <= until_s
                && zone.active.until_s > from_s
        };
        let of_kind = |kind: ZoneKind| self.zones.iter().filter(move |zone| zone.kind == kind).map(Outline::of);
        let restricted: Vec<Outline<'_>> = of_kind(ZoneKind::Restricted).collect();
        let permitted: Vec<Outline<'_>> = of_kind(ZoneKind::Permitted).collect();
        let mut names: Vec<String> = Vec::new();
        for outline in &restricted {
            let is_entered = samples.iter().any(|(place, from_s, until_s)| {
                holds(outline.zone, *from_s, *until_s) && outline.reaches(*place, -clearance_at_m(*place))
            });
            if is_entered && !names.contains(&outline.zone.name) {
                names.push(outline.zone.name.clone());
            }
        }
        let is_left = |(place, from_s, until_s): &(Position, f64, f64)| {
            !permitted.iter().any(|outline| {
                holds(outline.zone, *from_s, *until_s) && outline.reaches(*place, -clearance_at_m(*place))
            })
        };
        if !permitted.is_empty() && samples.iter().any(is_left) {
            names.push("permitted area".to_string());
        }
        names
    }
}

/// A zone's outline on a plane.
struct Outline<'a> {
    zone: &'a AirspaceZone,
    plane: Plane,
    corners: Vec<Point>,
}

impl<'a> Outline<'a> {
    fn of(zone: &'a AirspaceZone) -> Outline<'a> {
        let plane = Plane::around(&zone.corners);
        let corners = zone.corners.iter().filter_map(|corner| plane.project(*corner)).collect();
        Outline { zone, plane, corners }
    }

    /// Returns true if the place is inside, or outside by at most `clearance_m`; with a negative clearance, inside by at least that.
    fn reaches(&self, place: Position, clearance_m: f64) -> bool {
        let Some(point) = self.plane.project(place) else { return false };
        let edge_m = plane::segment_to_edges(point, point, &self.corners);
        let outside_m = if plane::inside(point, &self.corners) { -edge_m } else { edge_m };
        outside_m <= clearance_m
    }
}

/// Returns positions on the path, each with the earliest and the latest time at which the vehicle may be there.
fn samples(request: &Request, way: &Way, true_airspeed_mps: f64) -> Vec<(Position, f64, f64)> {
    let mut points = vec![request.from];
    points.extend_from_slice(&way.via);
    points.push(request.to);
    let mut found = Vec::new();
    let mut flown_m = 0.0;
    for (from, to) in points.iter().zip(points.iter().skip(1)) {
        let length_m = geodesy::distance_m(*from, *to);
        let pieces = libm::ceil(length_m / PIECE_M).clamp(1.0, PIECES_MAX);
        for piece in 0..=pieces as usize {
            let share = piece as f64 / pieces;
            let after_s = (flown_m + share * length_m) / true_airspeed_mps;
            let at_s = request.at_s + way.hold_s + after_s;
            let late_s = LATE_S + LATE_SHARE * after_s;
            found.push((geodesy::interpolate(*from, *to, share), at_s - late_s, at_s + late_s));
        }
        flown_m += length_m;
    }
    found
}
