//! Ground that remains to be seen of a fire that has grown: lines over it, and lines along the outline.
//!
//! The grid of such a fire gives weight to the remaining ground alone. Lines are drawn over all of it, and over the part that lies away
//! from ground that has been seen, mostly the head of the fire. Lines with little of it below them are left out.
//! Bound: O(cells^2) for the distances, O(cells x lines) for the selection of lines.

use crate::Fire;
use apex_geo::coverage::CoverageArea;
use apex_geo::plane::{Point, point_to_segment};
use apex_model::problem::Position;
use apex_observation::grid::TargetGrid;
use apex_observation::target::{ObservedTarget, TargetArea};

/// A line with a smaller share of the remaining ground below it than this is not flown.
const SHARE_MIN: f64 = 0.02;
/// Share of the greatest distance from seen ground from which on ground belongs to the far part.
const FAR_SHARE: f64 = 0.35;

/// Ground over which lines are drawn.
pub(super) struct LineGround {
    /// First part of the names of its manoeuvres.
    pub(super) name: &'static str,
    /// The areas.
    pub(super) areas: Vec<CoverageArea>,
    /// Lines follow the outline only, instead of sweeping the inside.
    pub(super) is_outline: bool,
}

/// Returns the grounds over which lines are alternatives of each other.
pub(super) fn line_grounds(fire: &Fire) -> Vec<LineGround> {
    let whole = grounds(&fire.wanted);
    if !fire.grid.is_partial() {
        return vec![LineGround { name: "sweep", areas: whole, is_outline: false }];
    }
    let rest =
        |name, areas: Option<CoverageArea>| areas.map(|area| LineGround { name, areas: vec![area], is_outline: false });
    let outlines: Vec<CoverageArea> =
        whole.into_iter().filter(|area| matches!(area, CoverageArea::Polygon(_))).collect();
    let outline = LineGround { name: "outline", areas: outlines, is_outline: true };
    let all = rest("growth", hull(&fire.grid, |_| true));
    let far = far_cells(&fire.grid);
    let head = rest("head", hull(&fire.grid, |cell| far.get(cell).copied().unwrap_or(false)));
    all.into_iter().chain(head).chain((!outline.areas.is_empty()).then_some(outline)).collect()
}

/// Returns the areas of a target's ground in their order; empty for a point or a line.
fn grounds(wanted: &ObservedTarget) -> Vec<CoverageArea> {
    match &wanted.area {
        TargetArea::Circle { centre, radius_m } => vec![CoverageArea::Circle { centre: *centre, radius_m: *radius_m }],
        TargetArea::Polygons(polygons) | TargetArea::Perimeter { polygons, .. } => {
            polygons.iter().map(|polygon| CoverageArea::Polygon(polygon.outer.clone())).collect()
        }
        TargetArea::Point(_) | TargetArea::Line(_) => Vec::new(),
    }
}

/// Returns the areas that cover the ground that remains to be seen: all of it, or the hull of the rest of a fire that has grown.
pub(super) fn remaining(fire: &Fire) -> Vec<CoverageArea> {
    match fire.grid.is_partial() {
        true => hull(&fire.grid, |_| true).into_iter().collect(),
        false => grounds(&fire.wanted),
    }
}

/// Returns the lines that have enough of the remaining ground below them, and the share of it that lies within half a swath of them. All
/// lines of a fire that has not grown are kept.
pub(super) fn useful(fire: &Fire, lines: Vec<(Position, Position)>, swath_m: f64) -> (Vec<(Position, Position)>, f64) {
    if !fire.grid.is_partial() {
        return (lines, 1.0);
    }
    let plane = fire.grid.plane();
    let flat: Vec<(Point, Point)> = lines.iter().map(|(from, to)| (plane.project(*from), plane.project(*to))).collect();
    let mut below = vec![0.0; lines.len()];
    let total = fire.grid.total();
    for (middle, weight) in cells(&fire.grid) {
        let distances = flat.iter().map(|(from, to)| point_to_segment(middle, *from, *to)).enumerate();
        let Some((line, distance_m)) = distances.min_by(|(_, a), (_, b)| a.total_cmp(b)) else { continue };
        if distance_m <= 0.5 * swath_m
            && let Some(sum) = below.get_mut(line)
        {
            *sum += weight;
        }
    }
    let kept = |share: &f64| *share >= SHARE_MIN * total;
    let covered: f64 = below.iter().filter(|share| kept(share)).sum();
    let lines = lines.into_iter().zip(&below).filter(|(_, share)| kept(share)).map(|(line, _)| line).collect();
    (lines, if total > 0.0 { covered / total } else { 0.0 })
}

/// Returns the middles of the cells that are still wanted, with their weights.
fn cells(grid: &TargetGrid) -> impl Iterator<Item = (Point, f64)> + '_ {
    let all = grid.centres().zip(grid.weights()).filter(|(_, weight)| **weight > 0.0);
    all.map(|((x, y), weight)| (Point { x, y }, *weight))
}

/// Returns for each cell whether it is wanted and far from ground that is not wanted any longer.
fn far_cells(grid: &TargetGrid) -> Vec<bool> {
    let middles: Vec<Point> = grid.centres().map(|(x, y)| Point { x, y }).collect();
    let is_wanted = |cell: usize| grid.weights().get(cell).is_some_and(|weight| *weight > 0.0);
    let seen: Vec<Point> =
        middles.iter().enumerate().filter(|(cell, _)| !is_wanted(*cell)).map(|(_, middle)| *middle).collect();
    let distance_m = |(cell, middle): (usize, &Point)| {
        let nearest_m = seen.iter().map(|other| middle.minus(*other).length()).fold(f64::INFINITY, f64::min);
        if is_wanted(cell) { nearest_m } else { 0.0 }
    };
    let distances_m: Vec<f64> = middles.iter().enumerate().map(distance_m).collect();
    let farthest_m = distances_m.iter().copied().fold(0.0, f64::max);
    distances_m.into_iter().map(|distance_m| distance_m >= FAR_SHARE * farthest_m && distance_m > 0.0).collect()
}

/// Returns the convex hull of the wanted cells for which `is_part` is true, with their whole squares; `None` without such cells.
fn hull(grid: &TargetGrid, is_part: impl Fn(usize) -> bool) -> Option<CoverageArea> {
    let half_m = 0.5 * grid.cell_m();
    let parts =
        grid.centres().zip(grid.weights()).enumerate().filter(|(cell, (_, weight))| **weight > 0.0 && is_part(*cell));
    let corners = parts.flat_map(|(_, ((x, y), _))| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(right, up)| Point { x: x + right * half_m, y: y + up * half_m })
    });
    let mut points: Vec<Point> = corners.collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    // Andrew's monotone chain (1979): the lower side from west to east, the upper side back.
    let mut hull = chain(points.iter().copied());
    hull.extend(chain(points.iter().rev().copied()));
    (hull.len() >= 3)
        .then(|| CoverageArea::Polygon(hull.into_iter().map(|point| grid.plane().position(point)).collect()))
}

/// Returns one side of the hull of sorted points, without its last point.
fn chain(points: impl Iterator<Item = Point>) -> Vec<Point> {
    let mut side: Vec<Point> = Vec::new();
    for point in points {
        while let [.., before, last] = side.as_slice() {
            if last.minus(*before).cross(point.minus(*before)) > 0.0 {
                break;
            }
            side.pop();
        }
        side.push(point);
    }
    side.pop();
    side
}
