//! Violations of a path: every zone that it violates, so that an operator is warned of each before the flight.

use super::limits::{Limits, PERMITTED};
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
                holds(outline.zone, *from_s, *until_s) && outline.reaches(*place, clearance_at_m(*place))
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
            names.push(PERMITTED.to_string());
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mission;
    use apex_model::problem::TimeWindow;

    /// Distance of the zone's southern edge from a path to the east, m.
    const OFF_M: f64 = 2_000.0;

    /// Returns the zones that are named for a path of 100 km whose whole length, or one of whose ends, is [`OFF_M`] from a zone.
    fn named(kind: ZoneKind, near_an_end: bool, clearance_m: f64, has_turns: bool) -> Vec<String> {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/western-states");
        let mut limits = Limits::of(&Mission::load(&folder).unwrap());
        let from = Position::new(40.0, -120.0);
        let to = geodesy::destination(from, 90.0, 100_000.0);
        let (begin_m, width_m) = if near_an_end { (-2_000.0, 4_000.0) } else { (40_000.0, 20_000.0) };
        let corner = |east_m: f64, north_m: f64| {
            geodesy::destination(geodesy::interpolate(from, to, east_m / 100_000.0), 0.0, north_m)
        };
        let north_m = if kind == ZoneKind::Permitted { -100_000.0 } else { OFF_M };
        let until_m = if kind == ZoneKind::Permitted { OFF_M } else { 50_000.0 };
        let (west_m, east_m) =
            if kind == ZoneKind::Permitted { (-200_000.0, 300_000.0) } else { (begin_m, begin_m + width_m) };
        limits.zones = vec![AirspaceZone {
            name: "Z".to_string(),
            kind,
            corners: vec![
                corner(west_m, north_m),
                corner(east_m, north_m),
                corner(east_m, until_m),
                corner(west_m, until_m),
            ],
            altitude_m_min: 0.0,
            altitude_m_max: 20_000.0,
            active: TimeWindow { from_s: 0.0, until_s: 1e9 },
        }];
        let request = Request {
            from,
            from_altitude_m: 7_000.0,
            from_track_rad: None,
            at_s: 0.0,
            to,
            to_altitude_m: 7_000.0,
            to_track_rad: None,
            circle_radius_m: 0.0,
            stay_s: 0.0,
        };
        let way =
            Way { via: Vec::new(), altitude_m: 7_000.0, hold_s: 0.0, hold_around: None, time_s: 1_000.0, broken: None };
        limits.crossed(&request, &way, (clearance_m, has_turns))
    }

    #[test]
    fn a_zone_within_the_clearance_counts_where_the_vehicle_chooses_its_turns() {
        let none: [&str; 0] = [];
        let restricted =
            |near_an_end, clearance_m, has_turns| named(ZoneKind::Restricted, near_an_end, clearance_m, has_turns);
        // A path without turns is flown with those of the vehicle: everywhere.
        assert_eq!(restricted(false, 3_000.0, false), ["Z"]);
        assert_eq!(restricted(false, 1_000.0, false), none);
        // A path with its turns keeps to them away from its ends.
        assert_eq!(restricted(false, 3_000.0, true), none);
        assert_eq!(restricted(true, 3_000.0, true), ["Z"]);
        assert_eq!(restricted(true, 1_000.0, true), none);
        // A permitted area is left where its edge is within the clearance.
        assert_eq!(named(ZoneKind::Permitted, false, 3_000.0, false), ["permitted area"]);
        assert_eq!(named(ZoneKind::Permitted, false, 1_000.0, false), none);
    }
}
