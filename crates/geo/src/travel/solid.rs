//! A polygon on the plane: computes the parts of a leg inside it, or closer than a margin.
//!
//! Touching does not count as entering: a leg along an edge or through a corner is outside. A point within [`Solid::tolerance`] of an
//! edge counts as on it. Any list of corners is a solid; the even-odd rule applies to edges that cross each other.
//! Bound: O(corners) for each query.

use super::spans::{Span, merged};
use crate::plane::{self, Point};

/// Share of the largest coordinate that rounding may blur.
const BLUR: f64 = 1e-12;

/// A polygon.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Solid {
    corners: Vec<Point>,
    /// South-western corner of the box around it.
    pub(crate) low: Point,
    /// North-eastern corner of the box around it.
    pub(crate) high: Point,
    /// A point closer to an edge than this counts as on the edge.
    pub(crate) tolerance: f64,
}

impl Solid {
    /// Returns the polygon with these corners without repeated ones; `None` if fewer than three remain or one is not finite.
    pub(crate) fn new(corners: &[Point]) -> Option<Solid> {
        let mut low = Point { x: f64::INFINITY, y: f64::INFINITY };
        let mut high = Point { x: f64::NEG_INFINITY, y: f64::NEG_INFINITY };
        for corner in corners {
            if !(corner.x.is_finite() && corner.y.is_finite()) {
                return None;
            }
            low = Point { x: low.x.min(corner.x), y: low.y.min(corner.y) };
            high = Point { x: high.x.max(corner.x), y: high.y.max(corner.y) };
        }
        let reach = low.x.abs().max(low.y.abs()).max(high.x.abs()).max(high.y.abs());
        let tolerance = BLUR * reach;
        let mut kept: Vec<Point> = Vec::with_capacity(corners.len());
        for corner in corners {
            if kept.last().is_none_or(|last| last.minus(*corner).length() > tolerance) {
                kept.push(*corner);
            }
        }
        while kept.len() > 1 && kept.first().zip(kept.last()).is_some_and(|(a, b)| a.minus(*b).length() <= tolerance) {
            kept.pop();
        }
        (kept.len() >= 3).then_some(Solid { corners: kept, low, high, tolerance })
    }

    /// Returns its corners in order, not closed.
    pub(crate) fn corners(&self) -> &[Point] {
        &self.corners
    }

    /// Returns the distance of `point` from the nearest edge.
    pub(crate) fn distance(&self, point: Point) -> f64 {
        plane::edges(&self.corners).fold(f64::INFINITY, |least, (c, d)| least.min(plane::point_to_segment(point, c, d)))
    }

    /// Returns true if `point` is inside and not on the edge.
    pub(crate) fn holds(&self, point: Point) -> bool {
        self.low.x < point.x
            && point.x < self.high.x
            && self.low.y < point.y
            && point.y < self.high.y
            && plane::inside(point, &self.corners)
            && self.distance(point) > self.tolerance
    }

    /// Returns true if the box around the leg is farther than `margin` from the box around the polygon.
    pub(crate) fn is_far_from(&self, a: Point, b: Point, margin: f64) -> bool {
        a.x.max(b.x) + margin < self.low.x
            || a.x.min(b.x) - margin > self.high.x
            || a.y.max(b.y) + margin < self.low.y
            || a.y.min(b.y) - margin > self.high.y
    }

    /// Returns the spans of the leg `a`-`b` that lie inside, as shares of its length.
    pub(crate) fn inside(&self, a: Point, b: Point) -> Vec<Span> {
        let pieces = self.pieces(a, b);
        let along = b.minus(a);
        merged(pieces.into_iter().filter(|(s, t)| self.holds(a.plus(0.5 * (s + t), along))).collect(), 1e-12)
    }

    /// Returns the spans of the leg that lie inside or closer to an edge than `margin`.
    pub(crate) fn near(&self, a: Point, b: Point, margin: f64) -> Vec<Span> {
        if self.is_far_from(a, b, margin) {
            return Vec::new();
        }
        let mut spans = self.inside(a, b);
        if margin > self.tolerance {
            spans.extend(plane::edges(&self.corners).filter_map(|(c, d)| beside(a, b, c, d, margin)));
        }
        merged(spans, 1e-12)
    }

    /// Returns true if a part of the leg lies inside or closer to an edge than `margin`. As [`Solid::near`], but
    /// faster.
    pub(crate) fn meets(&self, a: Point, b: Point, margin: f64) -> bool {
        if self.is_far_from(a, b, margin) {
            return false;
        }
        if margin > self.tolerance
            && plane::edges(&self.corners).any(|(c, d)| plane::segment_to_segment(a, b, c, d) < margin)
        {
            return true;
        }
        // Without a margin the leg may touch: only its inside parts count.
        !self.inside(a, b).is_empty()
    }

    /// Returns the leg divided at every edge and corner that it meets: shares of its length, in order, without very short pieces.
    pub(crate) fn pieces(&self, a: Point, b: Point) -> Vec<Span> {
        let along = b.minus(a);
        let length = along.length();
        if length <= self.tolerance {
            return vec![(0.0, 1.0)];
        }
        let mut cuts = vec![0.0, 1.0];
        for (c, d) in plane::edges(&self.corners) {
            let edge = d.minus(c);
            let scale = along.cross(edge);
            let (share, on) = (c.minus(a).cross(edge) / scale, c.minus(a).cross(along) / scale);
            let blur = self.tolerance / edge.length();
            if share > 0.0 && share < 1.0 && on > -blur && on < 1.0 + blur {
                cuts.push(share);
            }
            let share = c.minus(a).dot(along) / (length * length);
            if share > 0.0 && share < 1.0 && (c.minus(a).cross(along) / length).abs() <= self.tolerance {
                cuts.push(share);
            }
        }
        cuts.sort_by(f64::total_cmp);
        let pairs = cuts.iter().copied().zip(cuts.iter().copied().skip(1));
        pairs.filter(|(s, t)| (t - s) * length > 2.0 * self.tolerance).collect()
    }
}

/// Returns the span of the leg `a`-`b` that is closer than `margin` to the segment `c`-`d`: the space around a segment is convex.
fn beside(a: Point, b: Point, c: Point, d: Point, margin: f64) -> Option<Span> {
    let along = b.minus(a);
    let edge = d.minus(c);
    let mut span: Option<Span> = None;
    let mut take = |found: Option<Span>| {
        if let Some((from, until)) = found.map(|(s, t)| (s.max(0.0), t.min(1.0))).filter(|(s, t)| t > s) {
            span = Some(span.map_or((from, until), |(s, t)| (s.min(from), t.max(until))));
        }
    };
    take(within_disc(a, along, c, margin));
    take(within_disc(a, along, d, margin));
    if let Some(unit) = edge.unit() {
        let (ahead, left) = (a.minus(c).dot(unit), unit.cross(a.minus(c)));
        let (ahead_rate, left_rate) = (along.dot(unit), unit.cross(along));
        let lengthwise = within_band(ahead, ahead_rate, 0.0, edge.length());
        let across = within_band(left, left_rate, -margin, margin);
        take(lengthwise.zip(across).map(|(p, q)| (p.0.max(q.0), p.1.min(q.1))));
    }
    span
}

/// Returns the span of the line `a + s along` at less than `radius` from `centre`.
fn within_disc(a: Point, along: Point, centre: Point, radius: f64) -> Option<Span> {
    let from = a.minus(centre);
    let (squared, half, rest) = (along.dot(along), from.dot(along), from.dot(from) - radius * radius);
    if squared <= 0.0 {
        return (rest < 0.0).then_some((0.0, 1.0));
    }
    // The distance of the line from the centre is kinder to rounding than the usual discriminant.
    let beside = from.cross(along);
    let room = radius * radius * squared - beside * beside;
    if room <= 0.0 {
        return None;
    }
    let root = libm::sqrt(room);
    Some(((-half - root) / squared, (-half + root) / squared))
}

/// Returns the span in which `value + s rate` lies between `low` and `high`.
fn within_band(value: f64, rate: f64, low: f64, high: f64) -> Option<Span> {
    if rate == 0.0 {
        return (low < value && value < high).then_some((0.0, 1.0));
    }
    let (p, q) = ((low - value) / rate, (high - value) / rate);
    Some((p.min(q), p.max(q)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn solid(corners: &[(f64, f64)]) -> Solid {
        let corners: Vec<Point> = corners.iter().map(|(x, y)| Point { x: *x, y: *y }).collect();
        Solid::new(&corners).unwrap()
    }

    fn p(x: f64, y: f64) -> Point {
        Point { x, y }
    }

    #[test]
    fn touching_is_not_entering() {
        let square = solid(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]);
        assert_eq!(square.inside(p(-5.0, 0.0), p(15.0, 0.0)), [], "along an edge");
        assert_eq!(square.inside(p(-5.0, 5.0), p(5.0, -5.0)), [], "through a corner from outside");
        assert_eq!(square.inside(p(-10.0, -10.0), p(20.0, 20.0)), [(1.0 / 3.0, 2.0 / 3.0)], "corner to corner");
        assert_eq!(square.near(p(-5.0, -2.0), p(15.0, -2.0), 2.0), [], "exactly at the margin");
        assert!(square.meets(p(-5.0, -1.9), p(15.0, -1.9), 2.0));
        assert_eq!(square.inside(p(5.0, 5.0), p(5.0, 5.0)), [(0.0, 1.0)], "no leg at all, inside");
    }

    #[test]
    fn a_notch_is_outside() {
        let notched = solid(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (5.0, 2.0), (0.0, 10.0)]);
        let spans = notched.inside(p(-5.0, 6.0), p(15.0, 6.0));
        assert_eq!(spans.len(), 2);
        assert_eq!(notched.inside(p(0.0, 10.0), p(10.0, 10.0)), [], "over the mouth");
        assert_eq!(notched.inside(p(0.0, 10.0), p(5.0, 2.0)), [], "along its side");
    }

    #[test]
    fn what_is_not_a_polygon_is_none() {
        assert_eq!(Solid::new(&[p(0.0, 0.0), p(1.0, 0.0), p(1.0, 0.0), p(0.0, 0.0)]), None);
        assert_eq!(Solid::new(&[p(0.0, 0.0), p(1.0, 0.0), p(f64::NAN, 0.0)]), None);
        let flat = solid(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]);
        assert_eq!(flat.inside(p(-1.0, 0.0), p(3.0, 0.0)), []);
        assert!(flat.meets(p(-1.0, 0.5), p(3.0, 0.5), 1.0));
    }

    proptest! {
        // The naive twin: samples the leg point by point.
        #[test]
        fn spans_are_where_points_are_near(
            corners in prop::collection::vec((-5i32..6, -5i32..6), 3..9), ends in (-8i32..9, -8i32..9, -8i32..9, -8i32..9),
            margin in 0.0..2.0f64,
        ) {
            let corners: Vec<Point> = corners.iter().map(|(x, y)| p(f64::from(*x), f64::from(*y))).collect();
            let Some(solid) = Solid::new(&corners) else { return Ok(()) };
            let (a, b) = (p(f64::from(ends.0), f64::from(ends.1)), p(f64::from(ends.2), f64::from(ends.3)));
            let margin = if margin < 0.5 { 0.0 } else { margin };
            let spans = solid.near(a, b, margin);
            prop_assert_eq!(solid.meets(a, b, margin), !spans.is_empty(), "{:?}", spans);
            for step in 0..200 {
                let share = (f64::from(step) + 0.37) / 200.0;
                let here = a.plus(share, b.minus(a));
                let clear = solid.distance(here) - margin;
                let near = solid.holds(here) || clear < 0.0;
                let told = spans.iter().any(|(from, until)| *from < share && share < *until);
                prop_assert!(near == told || clear.abs() < 1e-6, "at {share}: near {near}, reported {told}, {spans:?}");
            }
        }
    }
}
