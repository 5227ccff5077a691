//! Parts of a line that keep a distance from polygons, computed from the edges instead of from points of the line.
//!
//! Bound: O(edges x log edges) for a line, and O(edges) for each of its open parts.

use apex_geo::plane::{Point, edges, inside};

/// Part of a line, by the distances of its ends from the beginning of the line, m.
pub(super) type OpenSpan = (f64, f64);

/// Returns the parts of the segment `from`-`to` that are outside of all polygons and at least `keep_m`, which is above 0, from their edges,
/// in order. A segment of length zero has no parts.
pub(super) fn open_spans((from, to): (Point, Point), polygons: &[Vec<Point>], keep_m: f64) -> Vec<OpenSpan> {
    let length_m = to.minus(from).length();
    let Some(along) = to.minus(from).unit() else { return Vec::new() };
    let near = |(a, b): (Point, Point)| near_edge((from, along), (a, b), keep_m);
    let all = polygons.iter().flat_map(|corners| edges(corners)).filter_map(near);
    let mut closed: Vec<OpenSpan> = all.filter(|(begin, end)| *begin < length_m && *end > 0.0).collect();
    closed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut open, mut since_m) = (Vec::new(), 0.0);
    for (begin_m, end_m) in closed {
        if begin_m > since_m {
            open.push((since_m, begin_m));
        }
        since_m = end_m.max(since_m);
    }
    if since_m < length_m {
        open.push((since_m, length_m));
    }
    // Between edges, a part is inside or outside as a whole.
    open.retain(|(begin_m, end_m)| {
        let middle = from.plus(0.5 * (begin_m + end_m), along);
        !polygons.iter().any(|corners| inside(middle, corners))
    });
    open
}

/// Returns the part of the straight line through `from` that is nearer than `keep_m` to the edge `a`-`b`; `None` without such a part. The
/// points near an edge are a convex set, so the part is one: the span over both discs around the ends and the rectangle between them.
fn near_edge((from, along): (Point, Point), (a, b): (Point, Point), keep_m: f64) -> Option<OpenSpan> {
    // Most edges are far away on one side.
    let asides = [a, b].map(|end| along.cross(end.minus(from)));
    if asides.iter().all(|aside| *aside >= keep_m) || asides.iter().all(|aside| *aside <= -keep_m) {
        return None;
    }
    let discs = [a, b].into_iter().filter_map(|centre| {
        let middle = along.dot(centre.minus(from));
        let aside = along.cross(centre.minus(from));
        let half = keep_m * keep_m - aside * aside;
        (half > 0.0).then(|| (middle - half.sqrt(), middle + half.sqrt()))
    });
    let found = discs.chain(near_rectangle((from, along), (a, b), keep_m));
    found.reduce(|all, each| (all.0.min(each.0), all.1.max(each.1)))
}

/// Returns the part of the line through `from` alongside the edge `a`-`b`, nearer than `keep_m`.
fn near_rectangle((from, along): (Point, Point), (a, b): (Point, Point), keep_m: f64) -> Option<OpenSpan> {
    let edge = b.minus(a).unit()?;
    let here = from.minus(a);
    let beside = within((edge.dot(here), edge.dot(along)), (0.0, b.minus(a).length()))?;
    let near = within((edge.cross(here), edge.cross(along)), (-keep_m, keep_m))?;
    let both = (beside.0.max(near.0), beside.1.min(near.1));
    (both.0 < both.1).then_some(both)
}

/// Returns where `start + s * slope` lies within bounds; `None` if it does so nowhere.
fn within((start, slope): (f64, f64), (least, greatest): (f64, f64)) -> Option<OpenSpan> {
    if slope == 0.0 {
        return (least < start && start < greatest).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let (one, other) = ((least - start) / slope, (greatest - start) / slope);
    Some((one.min(other), one.max(other)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_geo::plane::segment_to_edges;
    use proptest::prelude::*;

    fn point(range: f64) -> impl Strategy<Value = Point> {
        (-range..range, -range..range).prop_map(|(x, y)| Point { x, y })
    }

    /// A star-shaped polygon: corners around a centre at random distances.
    fn polygon() -> impl Strategy<Value = Vec<Point>> {
        (point(8_000.0), proptest::collection::vec(500.0..6_000.0, 3..40)).prop_map(|(centre, radii)| {
            let turn = std::f64::consts::TAU / radii.len() as f64;
            let corner = |(number, radius): (usize, &f64)| {
                let (y, x) = libm::sincos(turn * number as f64);
                centre.plus(*radius, Point { x, y })
            };
            radii.iter().enumerate().map(corner).collect()
        })
    }

    proptest! {
        /// Points of the line, compared one by one with the polygons.
        #[test]
        fn spans_are_those_of_single_points(
            from in point(12_000.0),
            to in point(12_000.0),
            polygons in proptest::collection::vec(polygon(), 1..4),
            keep_m in 1.0..2_000.0,
        ) {
            let spans = open_spans((from, to), &polygons, keep_m);
            let length_m = to.minus(from).length();
            let along = to.minus(from).unit().unwrap();
            for step in 0..400 {
                let at_m = length_m * (f64::from(step) + 0.5) / 400.0;
                let here = from.plus(at_m, along);
                let edge_m = polygons.iter().map(|corners| segment_to_edges(here, here, corners)).fold(f64::INFINITY, f64::min);
                let is_inside = polygons.iter().any(|corners| inside(here, corners));
                // Rounding decides about points whose distance is the kept one, and about points on an edge.
                if (edge_m - keep_m).abs() < 1e-6 || edge_m < 1e-6 {
                    continue;
                }
                let is_open = spans.iter().any(|(begin_m, end_m)| (*begin_m..=*end_m).contains(&at_m));
                prop_assert_eq!(is_open, !is_inside && edge_m > keep_m, "{} m: {:?}", at_m, &spans);
            }
        }
    }
}
