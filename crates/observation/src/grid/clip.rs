//! Exact areas of polygons inside cells, by clipping at the lines between rows and columns.

use crate::plane::Point;
use apex_geo::plane::doubled_area;

/// The side of a line that is kept.
#[derive(Clone, Copy)]
enum Keep {
    XFrom(f64),
    XTo(f64),
    YFrom(f64),
    YTo(f64),
}

impl Keep {
    fn side(self, point: Point) -> f64 {
        match self {
            Keep::XFrom(x) => point.x - x,
            Keep::XTo(x) => x - point.x,
            Keep::YFrom(y) => point.y - y,
            Keep::YTo(y) => y - point.y,
        }
    }
}

/// Replaces `kept` by the part of a polygon on one side of a line; edges along the line may be counted twice in opposite directions,
/// which leaves the area exact.
fn clip(polygon: &[Point], keep: Keep, kept: &mut Vec<Point>) {
    kept.clear();
    let Some(last) = polygon.last() else { return };
    let (mut from, mut from_side) = (*last, keep.side(*last));
    for to in polygon {
        let to_side = keep.side(*to);
        if (from_side >= 0.0) != (to_side >= 0.0) {
            let share = from_side / (from_side - to_side);
            kept.push(from.plus(share, to.minus(from)));
        }
        if to_side >= 0.0 {
            kept.push(*to);
        }
        (from, from_side) = (*to, to_side);
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
    let (mut right, mut part) = (Vec::new(), Vec::new());
    for (row, cells) in (0..rows).zip(areas.chunks_mut(columns.max(1))) {
        let top = origin.y + (row + 1) as f64 * cell_m;
        clip(&above, Keep::YTo(top), &mut right);
        clip(&above, Keep::YFrom(top), &mut part);
        std::mem::swap(&mut above, &mut part);
        if area(&right) == 0.0 {
            continue;
        }
        let least_x = right.iter().fold(f64::INFINITY, |least, corner| least.min(corner.x));
        let most_x = right.iter().fold(f64::NEG_INFINITY, |most, corner| most.max(corner.x));
        let first = libm::floor((least_x - origin.x) / cell_m).max(0.0) as usize;
        let last = (libm::floor((most_x - origin.x) / cell_m).max(0.0) as usize).min(columns.saturating_sub(1));
        for (column, cell) in cells.iter_mut().enumerate().take(last + 1).skip(first) {
            let edge = origin.x + (column + 1) as f64 * cell_m;
            clip(&right, Keep::XTo(edge), &mut part);
            *cell += sign * area(&part);
            clip(&right, Keep::XFrom(edge), &mut part);
            std::mem::swap(&mut right, &mut part);
        }
    }
}
