//! Zones to keep out of, and areas to keep in: prisms over polygons of a local plane.
//!
//! Bound: O(edges) per margin; the edge of an area of several polygons costs O(edges^2) once.

use crate::prediction::{Violation, active_span, first_violation};
use crate::route::Route;
use apex_geo::plane::{Plane, Point, edges, inside, point_to_segment};
use apex_model::problem::{AirspaceZone, ZoneKind};

/// Distances that must be kept from the faces of a zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneBuffer {
    /// From its edges.
    pub horizontal_m: f64,
    /// From its lower and upper face.
    pub vertical_m: f64,
    /// Time before the zone becomes active and after it ends.
    pub time_s: f64,
}

/// A zone on a local plane.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalZone {
    /// Index of the zone among the given ones.
    pub number: usize,
    kind: ZoneKind,
    corners: Vec<Point>,
    /// Lower and upper face, above mean sea level.
    altitude_m: (f64, f64),
    /// Active time, in seconds of mission time.
    active_s: (f64, f64),
}

/// Returns the lower face; negative infinity for a face at or below sea level, which is the ground: no distance is kept from it.
fn lower_face_m(zone: &AirspaceZone) -> f64 {
    if zone.altitude_m_min > 0.0 { zone.altitude_m_min } else { f64::NEG_INFINITY }
}

impl LocalZone {
    /// Returns the zone on `plane`; `None` if a corner is too far from the plane's centre to be projected.
    pub fn new(number: usize, zone: &AirspaceZone, plane: &Plane) -> Option<LocalZone> {
        let corners: Option<Vec<Point>> = zone.corners.iter().map(|corner| plane.project(*corner)).collect();
        Some(LocalZone {
            number,
            kind: zone.kind,
            corners: corners?,
            altitude_m: (lower_face_m(zone), zone.altitude_m_max),
            active_s: (zone.active.from_s, zone.active.until_s),
        })
    }

    /// Returns true if the zone is one to keep out of.
    pub fn is_restricted(&self) -> bool {
        self.kind == ZoneKind::Restricted
    }

    /// Returns the lower and upper face above mean sea level.
    pub fn altitude_m(&self) -> (f64, f64) {
        self.altitude_m
    }

    /// Returns true if the zone is active at `at_s` of mission time.
    pub fn is_active(&self, at_s: f64) -> bool {
        self.active_s.0 <= at_s && at_s < self.active_s.1
    }

    /// Returns the distance from the edge, negative inside.
    fn edge_m(&self, point: Point) -> f64 {
        let least_m =
            edges(&self.corners).fold(f64::INFINITY, |least, (a, b)| least.min(point_to_segment(point, a, b)));
        if inside(point, &self.corners) { -least_m } else { least_m }
    }

    /// Returns the distance from the nearer face, negative between them.
    fn gap_m(&self, altitude_m: f64) -> f64 {
        (self.altitude_m.0 - altitude_m).max(altitude_m - self.altitude_m.1)
    }

    /// Returns the margin in metres of a restricted zone: the horizontal or the vertical distance beyond the buffer, whichever is larger,
    /// because either suffices. 1-Lipschitz in the position.
    pub fn keep_out_m(&self, point: Point, altitude_m: f64, buffer: &ZoneBuffer) -> f64 {
        let vertical_m = self.gap_m(altitude_m) - buffer.vertical_m;
        if vertical_m > 0.0 {
            // Far above or below, the edge matters only if it is farther still.
            return vertical_m.max(self.edge_m(point) - buffer.horizontal_m);
        }
        (self.edge_m(point) - buffer.horizontal_m).max(vertical_m)
    }

    /// Returns the nearest point of the edge.
    pub fn nearest_edge(&self, point: Point) -> Point {
        let on = |a: Point, b: Point| {
            let along = b.minus(a);
            let squared = along.dot(along);
            let share = if squared > 0.0 { (point.minus(a).dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
            a.plus(share, along)
        };
        let nearest = edges(&self.corners)
            .map(|(a, b)| on(a, b))
            .min_by(|a, b| a.minus(point).length().total_cmp(&b.minus(point).length()));
        nearest.unwrap_or(point)
    }

    /// Returns the first entry into the zone, extended by the buffer, along `route`; `now_s` is the present mission time, `speed_error`
    /// the relative error of the speed. `None` if there is none within `look_ahead_s`.
    pub fn first_entry(
        &self,
        route: &Route,
        buffer: &ZoneBuffer,
        now_s: f64,
        speed_error: f64,
        look_ahead_s: f64,
    ) -> Option<Violation> {
        let span = active_span(self.active_s, now_s, buffer.time_s, speed_error, look_ahead_s)?;
        first_violation(route, span, route.speed_mps_max(), |state| {
            self.keep_out_m(state.point, state.altitude_m, buffer)
        })
    }
}

/// The union of the areas to keep in at an altitude and an instant.
#[derive(Clone, Debug, PartialEq)]
pub struct KeepIn {
    polygons: Vec<(Vec<Point>, (f64, f64))>,
    /// The edge of the union.
    edge: Vec<(Point, Point)>,
}

/// Distance outside of an edge at which the continuation of the area is tested.
const OUTSIDE_M: f64 = 1.0;

impl KeepIn {
    /// Returns the union of the permitted zones among `zones` that are active at `at_s` and contain `altitude_m`; `None` if there is no
    /// permitted zone: everything is then permitted.
    pub fn new(zones: &[LocalZone], altitude_m: f64, at_s: f64) -> Option<KeepIn> {
        let permitted = || zones.iter().filter(|zone| !zone.is_restricted());
        permitted().next()?;
        let here = permitted().filter(|zone| zone.is_active(at_s) && zone.gap_m(altitude_m) <= 0.0);
        let polygons: Vec<_> = here.map(|zone| (zone.corners.clone(), zone.altitude_m)).collect();
        let edge = union_edge(&polygons);
        Some(KeepIn { polygons, edge })
    }

    /// Returns the margin in metres: the distance inside the union beyond the buffer; negative outside. 1-Lipschitz in the position.
    pub fn keep_in_m(&self, point: Point, altitude_m: f64, buffer: &ZoneBuffer) -> f64 {
        let holding = self.polygons.iter().filter(|(corners, _)| inside(point, corners));
        let gaps_m = holding.map(|(_, (low_m, high_m))| (altitude_m - low_m).min(high_m - altitude_m));
        let edge_m = self.edge.iter().fold(f64::INFINITY, |least, (a, b)| least.min(point_to_segment(point, *a, *b)));
        match gaps_m.reduce(f64::max) {
            Some(gap_m) => (edge_m - buffer.horizontal_m).min(gap_m - buffer.vertical_m),
            None if edge_m.is_finite() => -edge_m - buffer.horizontal_m,
            None => f64::NEG_INFINITY,
        }
    }

    /// Returns the ends of the nearest segment of the edge; `None` if the union is empty.
    pub fn nearest_edge(&self, point: Point) -> Option<(Point, Point)> {
        let distance_m = |edge: &(Point, Point)| point_to_segment(point, edge.0, edge.1);
        self.edge.iter().copied().min_by(|a, b| distance_m(a).total_cmp(&distance_m(b)))
    }
}

/// Returns the parts of the polygons' edges that no other polygon continues.
fn union_edge(polygons: &[(Vec<Point>, (f64, f64))]) -> Vec<(Point, Point)> {
    let mut found = Vec::new();
    for (number, (corners, _)) in polygons.iter().enumerate() {
        let others = || polygons.iter().enumerate().filter(move |(other, _)| *other != number).map(|(_, (all, _))| all);
        for (a, b) in edges(corners) {
            let mut cuts = vec![0.0, 1.0];
            cuts.extend(others().flat_map(|other| edges(other).filter_map(|(c, d)| meeting(a, b, c, d)).flatten()));
            cuts.sort_by(f64::total_cmp);
            for (from, to) in cuts.iter().zip(cuts.iter().skip(1)) {
                let along = b.minus(a);
                let Some(unit) = along.unit().filter(|_| to > from) else { continue };
                let middle = a.plus(0.5 * (from + to), along);
                let aside = Point { x: unit.y, y: -unit.x };
                let near = [1.0, -1.0].map(|side| middle.plus(side * OUTSIDE_M, aside));
                let outside = near.into_iter().find(|point| !inside(*point, corners));
                let continues = outside.is_none_or(|point| others().any(|other| inside(point, other)));
                if !continues {
                    found.push((a.plus(*from, along), a.plus(*to, along)));
                }
            }
        }
    }
    found
}

/// Returns the shares of `a`-`b` at which `c`-`d` crosses it; for collinear segments those at which `c`-`d` ends.
fn meeting(a: Point, b: Point, c: Point, d: Point) -> Option<Vec<f64>> {
    let (along, other) = (b.minus(a), d.minus(c));
    let squared = along.dot(along);
    if squared <= 0.0 {
        return None;
    }
    let within = |share: &f64| *share > 0.0 && *share < 1.0;
    let cross = along.cross(other);
    if cross.abs() <= 1e-12 * along.length() * other.length() {
        return Some([c, d].map(|end| end.minus(a).dot(along) / squared).into_iter().filter(within).collect());
    }
    let share = c.minus(a).cross(other) / cross;
    let back = c.minus(a).cross(along) / cross;
    ((-1e-9..=1.0 + 1e-9).contains(&back)).then(|| Some(share).filter(within).into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: ZoneBuffer = ZoneBuffer { horizontal_m: 0.0, vertical_m: 0.0, time_s: 0.0 };

    fn permitted(corners: &[(f64, f64)]) -> LocalZone {
        LocalZone {
            number: 0,
            kind: ZoneKind::Permitted,
            corners: corners.iter().map(|(x, y)| Point { x: *x, y: *y }).collect(),
            altitude_m: (0.0, 1_000.0),
            active_s: (f64::NEG_INFINITY, f64::INFINITY),
        }
    }

    #[test]
    fn neighbours_make_one_area() {
        let west = permitted(&[(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0)]);
        let east = permitted(&[(100.0, 20.0), (300.0, 20.0), (300.0, 80.0), (100.0, 80.0)]);
        let area = KeepIn::new(&[west, east], 500.0, 0.0).unwrap();
        let margin = |x: f64, y: f64| area.keep_in_m(Point { x, y }, 500.0, &NONE);
        assert!(
            (margin(99.0, 50.0) - 30.0).abs() < 0.2,
            "the nearest edge is the corner at (100, 80): {}",
            margin(99.0, 50.0)
        );
        assert_eq!(margin(200.0, 50.0), 30.0);
        assert_eq!(margin(99.0, 10.0), 1.0);
        assert_eq!(margin(200.0, 90.0), -10.0);
    }

    #[test]
    fn the_nearer_face_counts_inside() {
        let area = [permitted(&[(0.0, 0.0), (5_000.0, 0.0), (5_000.0, 5_000.0), (0.0, 5_000.0)])];
        let at = |altitude_m: f64| KeepIn::new(&area, altitude_m, 0.0).unwrap();
        let middle = Point { x: 2_500.0, y: 2_500.0 };
        assert_eq!(at(900.0).keep_in_m(middle, 900.0, &NONE), 100.0);
        assert_eq!(at(1_100.0).keep_in_m(middle, 1_100.0, &NONE), f64::NEG_INFINITY, "nothing is permitted there");
        assert_eq!(KeepIn::new(&[], 0.0, 0.0), None);
    }
}
