//! Bends of paths: at corners of zones, on outlines at the distance of the margin.
//!
//! A shortest path among polygons bends only at convex corners, and only so that the zone is inside the bend ([`PathVertex::takes`]).
//! With a margin the outline around a corner is an arc; the bends are the corners of the polygon around that arc, so that no leg between
//! them cuts into the margin (decision 0036).

use super::solid::Solid;
use crate::plane::{self, Point};

/// Greatest turn of a bend: a polygon around the arc is then at most 5.5 % longer than the arc.
pub(crate) const TURN_RAD_MAX: f64 = std::f64::consts::FRAC_PI_4;
/// Relative amount by which bends keep more than the margin, so that rounding does not put a leg between two of them inside it.
const BLUR: f64 = 1e-9;
/// Angle below which a neighbour counts as lying on the leg's line.
const ALONG_RAD: f64 = 1e-9;

/// A corner of an outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PathVertex {
    /// Position.
    pub(crate) point: Point,
    /// Direction to the preceding corner of the outline.
    before: Point,
    /// Direction to the following corner.
    after: Point,
}

impl PathVertex {
    /// Returns true if a shortest path may continue along a leg in direction `along` that begins or ends at this corner: only if both
    /// neighbours are on the same side of the leg's line.
    pub(crate) fn takes(&self, along: Point) -> bool {
        let Some(unit) = along.unit() else { return false };
        let (before, after) = (unit.cross(self.before), unit.cross(self.after));
        !((before > ALONG_RAD && after < -ALONG_RAD) || (before < -ALONG_RAD && after > ALONG_RAD))
    }
}

/// Returns the bends around `solid`, or along its inside if it is a permitted zone, at `margin` from its edges.
pub(crate) fn path_vertices(solid: &Solid, keep_in: bool, margin: f64) -> Vec<PathVertex> {
    let corners = solid.corners();
    let reversed: Vec<Point> = corners.iter().rev().copied().collect();
    // Walk with the space to be flown on the right: counter-clockwise around zones, clockwise inside corridors.
    let counter_clockwise = plane::doubled_area(corners) > 0.0;
    let (walk, other) = if counter_clockwise == keep_in { (&reversed[..], corners) } else { (corners, &reversed[..]) };
    let mut found = along(walk, margin);
    if crosses_itself(corners) {
        found.extend(along(other, margin));
    }
    found
}

fn along(walk: &[Point], margin: f64) -> Vec<PathVertex> {
    let last = walk.last().copied().into_iter();
    let before = last.chain(walk.iter().copied());
    let after = walk.iter().copied().skip(1).chain(walk.first().copied());
    let mut found = Vec::new();
    for ((corner, before), after) in walk.iter().zip(before).zip(after) {
        if let (Some(into), Some(out)) = (corner.minus(before).unit(), after.minus(*corner).unit()) {
            around(*corner, into, out, margin, &mut found);
        }
    }
    found
}

fn around(corner: Point, into: Point, out: Point, margin: f64, found: &mut Vec<PathVertex>) {
    let turn_rad = libm::atan2(into.cross(out), into.dot(out));
    // An edge that reverses exactly turns by half a circle, whichever sign rounding gives.
    let back = turn_rad.abs() > std::f64::consts::PI - 1e-9;
    if turn_rad <= 1e-12 && !back {
        return;
    }
    let turn_rad = turn_rad.abs();
    if margin <= 0.0 {
        found.push(PathVertex { point: corner, before: Point::default().minus(into), after: out });
        return;
    }
    let count = libm::ceil(turn_rad / TURN_RAD_MAX - 1e-9).max(1.0) as usize;
    let part_rad = turn_rad / count as f64;
    let reach = margin * (1.0 + BLUR) / libm::cos(0.5 * part_rad);
    let right = Point { x: into.y, y: -into.x };
    found.extend((0..count).map(|index| {
        let begin_rad = index as f64 * part_rad;
        PathVertex {
            point: corner.plus(reach, rotated(right, begin_rad + 0.5 * part_rad)),
            before: Point::default().minus(rotated(into, begin_rad)),
            after: rotated(into, begin_rad + part_rad),
        }
    }));
}

fn rotated(vector: Point, angle_rad: f64) -> Point {
    let (sine, cosine) = (libm::sin(angle_rad), libm::cos(angle_rad));
    Point { x: cosine * vector.x - sine * vector.y, y: sine * vector.x + cosine * vector.y }
}

/// Returns true if two edges that are not neighbours meet.
pub(crate) fn crosses_itself(corners: &[Point]) -> bool {
    crossing(corners).is_some()
}

/// Returns the numbers of the first two edges that meet without being neighbours; edge 0 begins at corner 0.
pub fn crossing(corners: &[Point]) -> Option<(usize, usize)> {
    let edges: Vec<(Point, Point)> = plane::edges(corners).collect();
    for (first, (a, b)) in edges.iter().enumerate() {
        for (second, (c, d)) in edges.iter().enumerate().skip(first + 2) {
            let neighbours = first == 0 && second + 1 == edges.len();
            if !neighbours && plane::segments_meet(*a, *b, *c, *d) {
                return Some((first, second));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn p(x: f64, y: f64) -> Point {
        Point { x, y }
    }

    fn notched() -> Solid {
        Solid::new(&[p(0.0, 0.0), p(10.0, 0.0), p(10.0, 10.0), p(5.0, 2.0), p(0.0, 10.0)]).unwrap()
    }

    #[test]
    fn ways_bend_at_corners_that_stick_out() {
        let points: Vec<Point> = path_vertices(&notched(), false, 0.0).iter().map(|bend| bend.point).collect();
        assert_eq!(points, [p(0.0, 0.0), p(10.0, 0.0), p(10.0, 10.0), p(0.0, 10.0)]);
        let inside: Vec<Point> = path_vertices(&notched(), true, 0.0).iter().map(|bend| bend.point).collect();
        assert_eq!(inside, [p(5.0, 2.0)]);
    }

    #[test]
    fn bends_keep_the_margin_and_so_do_the_legs_between_them() {
        let square = Solid::new(&[p(0.0, 0.0), p(0.0, 10.0), p(10.0, 10.0), p(10.0, 0.0)]).unwrap();
        let path_vertices = path_vertices(&square, false, 2.0);
        assert_eq!(path_vertices.len(), 8, "two of 45 degrees a corner");
        for (from, to) in path_vertices.iter().zip(path_vertices.iter().cycle().skip(1)) {
            assert!(!square.meets(from.point, to.point, 2.0));
            assert!(plane::segment_to_edges(from.point, to.point, square.corners()) < 2.0 + 1e-6);
            assert!(from.takes(to.point.minus(from.point)) && to.takes(to.point.minus(from.point)));
        }
    }

    #[test]
    fn a_leg_that_ends_at_a_zone_is_of_no_use() {
        let square = Solid::new(&[p(0.0, 0.0), p(10.0, 0.0), p(10.0, 10.0), p(0.0, 10.0)]).unwrap();
        let corner = path_vertices(&square, false, 0.0)[0];
        assert!(corner.takes(p(1.0, 0.0)) && corner.takes(p(1.0, -1.0)));
        assert!(!corner.takes(p(1.0, 1.0)), "into the zone or straight away from it");
    }

    #[test]
    fn an_eight_crosses_itself_and_is_bent_around_on_both_sides() {
        let eight = [p(0.0, 0.0), p(4.0, 4.0), p(4.0, 0.0), p(0.0, 4.0)];
        assert_eq!(crossing(&eight), Some((0, 2)));
        assert_eq!(path_vertices(&Solid::new(&eight).unwrap(), false, 0.0).len(), 4);
        assert_eq!(crossing(notched().corners()), None);
    }
}
