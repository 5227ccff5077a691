//! Exact areas of polygons inside cells, by clipping at the lines between rows and columns.

use crate::plane::Point;
use apex_geo::plane::doubled_area;

/// Splits a polygon at a line into the parts before and beyond it; `ahead` is the signed distance of a point beyond the line. A corner on
/// the line belongs to both parts. Edges along the line may be counted twice in opposite directions, which leaves the areas exact.
fn split(polygon: &[Point], ahead: impl Fn(Point) -> f64, before: &mut Vec<Point>, beyond: &mut Vec<Point>) {
    before.clear();
    beyond.clear();
    let Some(last) = polygon.last() else { return };
    let (mut from, mut from_m) = (*last, ahead(*last));
    for to in polygon {
        let to_m = ahead(*to);
        let (leaves, enters) = ((from_m <= 0.0) != (to_m <= 0.0), (from_m >= 0.0) != (to_m >= 0.0));
        if leaves || enters {
            let crossing = from.plus(from_m / (from_m - to_m), to.minus(from));
            if leaves {
                before.push(crossing);
            }
            if enters {
                beyond.push(crossing);
            }
        }
        if to_m <= 0.0 {
            before.push(*to);
        }
        if to_m >= 0.0 {
            beyond.push(*to);
        }
        (from, from_m) = (*to, to_m);
    }
}

fn area(polygon: &[Point]) -> f64 {
    0.5 * doubled_area(polygon).abs()
}

/// Adds `sign` times the area of the polygon inside each cell to `areas`, row by row from `origin` (the south-west corner),
/// `columns` cells a row.
pub(super) fn add_areas(polygon: &[Point], origin: Point, cell_m: f64, columns: usize, areas: &mut [f64], sign: f64) {
    let rows = areas.len().checked_div(columns).unwrap_or(0);
    let mut above = polygon.to_vec();
    let (mut right, mut part, mut rest) = (Vec::new(), Vec::new(), Vec::new());
    for (row, cells) in (0..rows).zip(areas.chunks_mut(columns.max(1))) {
        let top = origin.y + (row + 1) as f64 * cell_m;
        split(&above, |corner| corner.y - top, &mut right, &mut rest);
        std::mem::swap(&mut above, &mut rest);
        if area(&right) == 0.0 {
            continue;
        }
        let least_x = right.iter().fold(f64::INFINITY, |least, corner| least.min(corner.x));
        let most_x = right.iter().fold(f64::NEG_INFINITY, |most, corner| most.max(corner.x));
        let first = libm::floor((least_x - origin.x) / cell_m).max(0.0) as usize;
        let last = (libm::floor((most_x - origin.x) / cell_m).max(0.0) as usize).min(columns.saturating_sub(1));
        for (column, cell) in cells.iter_mut().enumerate().take(last + 1).skip(first) {
            let edge = origin.x + (column + 1) as f64 * cell_m;
            split(&right, |corner| corner.x - edge, &mut part, &mut rest);
            *cell += sign * area(&part);
            std::mem::swap(&mut right, &mut rest);
        }
    }
}
