//! The cells of a target and their rasterising.

use crate::footprint::Ground;
use crate::plane::{EqualAreaPlane, Point};
use apex_geo::geodesy::Position;

/// An edge of a strip, from its lower end.
#[derive(Clone, Copy)]
struct GlanceEdge {
    low: Point,
    high_y: f64,
    /// Change of x per metre of y.
    slope: f64,
}

impl GlanceEdge {
    fn x_at(&self, y: f64) -> f64 {
        self.low.x + self.slope * (y - self.low.y)
    }
}

/// Approximate crossings of the rows with a narrow strip: most rows have no cell centre in it and need no exact crossings. Callers pass
/// rows in order of y.
struct Glance {
    /// Edges of the strip; all `None` if it has more than four.
    edges: [Option<GlanceEdge>; 4],
    /// The only two edges that cross the rows below `until_y`; `None` if another number of edges crosses them.
    pair: Option<(GlanceEdge, GlanceEdge)>,
    until_y: f64,
    cells_per_m: f64,
    /// Bound of the error of a coarse crossing, in cells.
    slack: f64,
}

impl Glance {
    fn new(edges: &[(Point, Point)], cell_m: f64) -> Glance {
        let mut found = [None; 4];
        let most_m = edges.iter().flat_map(|(a, b)| [a.x.abs(), b.x.abs(), a.y.abs(), b.y.abs()]).fold(0.0, f64::max);
        if edges.len() <= found.len() {
            for (slot, (a, b)) in found.iter_mut().zip(edges) {
                let (low, high) = if a.y < b.y { (*a, *b) } else { (*b, *a) };
                *slot = Some(GlanceEdge { low, high_y: high.y, slope: (high.x - low.x) / (high.y - low.y) });
            }
        }
        let slack = 1e-6 + 1e-9 * most_m / cell_m;
        Glance { edges: found, pair: None, until_y: f64::NEG_INFINITY, cells_per_m: 1.0 / cell_m, slack }
    }

    /// Selects the edges that cross the row at `y`, and the next y at which that changes.
    fn select(&mut self, y: f64) {
        let edges = || self.edges.iter().flatten();
        let mut crossing = edges().filter(|edge| edge.low.y <= y && y < edge.high_y);
        let pair = crossing.next().zip(crossing.next());
        let pair = pair.filter(|_| crossing.next().is_none()).map(|(first, second)| (*first, *second));
        let changes = edges().flat_map(|edge| [edge.low.y, edge.high_y]).filter(|change_y| *change_y > y);
        let until_y = changes.fold(f64::INFINITY, f64::min);
        (self.pair, self.until_y) = (pair, until_y);
    }

    /// Returns true if certainly no cell centre of the row is inside; centres are a whole number of cells from the first one. Always false
    /// unless exactly two edges cross the row.
    fn misses(&mut self, row: &CellRow) -> bool {
        if row.y >= self.until_y {
            self.select(row.y);
        }
        let Some((first, second)) = &self.pair else { return false };
        let (a, b) = (first.x_at(row.y), second.x_at(row.y));
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        let low_cells = (low - row.west) * self.cells_per_m - self.slack;
        let high_cells = (high - row.west) * self.cells_per_m + self.slack;
        let is_between = low_cells > 0.0 && high_cells < 1e9 && low_cells as i64 == high_cells as i64;
        is_between || high_cells < 0.0
    }
}

/// One row of cells with the same y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CellRow {
    pub(super) y: f64,
    pub(super) first: usize,
    pub(super) count: usize,
    /// The x of its first cell.
    pub(super) west: f64,
}

/// The cells of a target.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetGrid {
    pub(super) plane: EqualAreaPlane,
    pub(super) cell_m: f64,
    pub(super) rows: Vec<CellRow>,
    pub(super) x: Vec<f64>,
    pub(super) weights: Vec<f64>,
    pub(super) total: f64,
    /// Elevation of each cell; empty: the target's elevation everywhere.
    pub(super) elevations_m: Vec<f32>,
    pub(super) elevation_m: f64,
    /// True if some cell's elevation was not known.
    pub(super) is_terrain_missing: bool,
    pub(super) slope_max: f64,
    /// Unit normals of the ellipsoid at the cells, for the elevation of the sun.
    pub(super) normals: Vec<[f64; 3]>,
    pub(super) low: Point,
    pub(super) high: Point,
}

impl TargetGrid {
    /// Returns the grid with the elevation of each cell from `ground`. Where that is unknown, the target's elevation is used and
    /// [`TargetGrid::is_terrain_missing`] is true.
    pub fn with_elevations(mut self, ground: &dyn Ground) -> TargetGrid {
        let mut elevations_m = Vec::with_capacity(self.x.len());
        let mut is_missing = false;
        for position in self.positions() {
            let known = ground.elevation_m_at(position);
            is_missing |= known.is_none();
            elevations_m.push(known.unwrap_or(self.elevation_m) as f32);
        }
        self.is_terrain_missing = is_missing;
        self.slope_max = self.steepest(&elevations_m);
        let is_flat = elevations_m.windows(2).all(|pair| pair.first() == pair.last());
        match elevations_m.first() {
            Some(first) if is_flat => {
                self.elevation_m = f64::from(*first);
                self.elevations_m = Vec::new();
            }
            _ => self.elevations_m = elevations_m,
        }
        self
    }

    /// Returns the plane of the cells.
    pub fn plane(&self) -> &EqualAreaPlane {
        &self.plane
    }

    /// Returns the edge of a cell.
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// Returns the number of cells.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Returns true if no ground is wanted.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Returns the weight of each cell: square metres of areas, metres of lines, 1 for a point.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Returns the sum of the weights.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// Returns the corners of the box around the cells: least x and y, greatest x and y.
    pub fn bounds(&self) -> (Point, Point) {
        (self.low, self.high)
    }

    /// Returns the elevation of the ground at a cell.
    pub fn elevation_m(&self, cell: usize) -> f64 {
        self.elevations_m.get(cell).map_or(self.elevation_m, |elevation_m| f64::from(*elevation_m))
    }

    /// Returns true if the elevation of some cell was not known.
    pub fn is_terrain_missing(&self) -> bool {
        self.is_terrain_missing
    }

    /// Returns the steepest slope between neighbours in a row, as rise over distance; 0 on flat ground.
    pub fn slope_max(&self) -> f64 {
        self.slope_max
    }

    /// Returns the unit normal of the ellipsoid at a cell.
    pub(crate) fn normal(&self, cell: usize) -> [f64; 3] {
        self.normals.get(cell).copied().unwrap_or_default()
    }

    /// Returns the middle of each cell, in the order of the cells.
    pub fn centres(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.rows.iter().flat_map(|row| self.row_cells(row).iter().map(|x| (*x, row.y)))
    }

    /// Returns the position of each cell's middle.
    pub fn positions(&self) -> impl Iterator<Item = Position> + '_ {
        self.rows.iter().flat_map(|row| self.plane.row_positions(row.y, self.row_cells(row)))
    }

    /// Returns the cell of the nearest row whose centre is nearest to a point; `None` without cells.
    pub fn nearest_cell(&self, point: Point) -> Option<usize> {
        let above = self.rows.partition_point(|row| row.y < point.y);
        let near_rows = self.rows.iter().take(above + 1).skip(above.saturating_sub(1));
        let row = near_rows.min_by(|a, b| (a.y - point.y).abs().total_cmp(&(b.y - point.y).abs()))?;
        let cells = self.row_cells(row);
        let right = cells.partition_point(|x| *x < point.x);
        let near_cells = cells.iter().enumerate().take(right + 1).skip(right.saturating_sub(1));
        let nearest = near_cells.min_by(|(_, a), (_, b)| (*a - point.x).abs().total_cmp(&(*b - point.x).abs()))?;
        Some(row.first + nearest.0)
    }

    /// Calls `hit` for every cell whose centre is in the polygon (even-odd rule), with its index and its centre.
    pub fn rasterise(&self, polygon: &[Point], mut hit: impl FnMut(usize, Point)) {
        let (mut low_y, mut high_y) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut low_x, mut high_x) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in polygon {
            (low_y, high_y) = (low_y.min(corner.y), high_y.max(corner.y));
            (low_x, high_x) = (low_x.min(corner.x), high_x.max(corner.x));
        }
        // Most strips lie outside the target.
        if high_x < self.low.x || low_x > self.high.x {
            return;
        }
        let first = self.rows.partition_point(|row| row.y < low_y);
        let edges: Vec<(Point, Point)> = apex_geo::plane::edges(polygon).filter(|(a, b)| a.y != b.y).collect();
        let mut crossings: Vec<f64> = Vec::with_capacity(edges.len());
        let mut glance = Glance::new(&edges, self.cell_m);
        for row in self.rows.get(first..).unwrap_or_default().iter().take_while(|row| row.y <= high_y) {
            if glance.misses(row) {
                continue;
            }
            crossings.clear();
            for (a, b) in &edges {
                if (a.y > row.y) != (b.y > row.y) {
                    crossings.push(a.x + (b.x - a.x) * (row.y - a.y) / (b.y - a.y));
                }
            }
            // Most strips cross a row twice.
            match crossings.as_mut_slice() {
                [from, to] if *from > *to => std::mem::swap(from, to),
                [_, _] => {}
                many => many.sort_by(f64::total_cmp),
            }
            let cells = self.row_cells(row);
            for pair in crossings.chunks_exact(2) {
                let [from, to] = pair else { continue };
                let start = self.first_from(cells, *from);
                for (index, x) in cells.iter().enumerate().skip(start) {
                    if *x >= *to {
                        break;
                    }
                    hit(row.first + index, Point { x: *x, y: row.y });
                }
            }
        }
    }

    /// Returns the first cell of a row whose centre is not west of `x`. Centres are a cell or more apart, mostly exactly one.
    fn first_from(&self, cells: &[f64], x: f64) -> usize {
        let Some(west) = cells.first() else { return 0 };
        let share = (x - west) / self.cell_m;
        let whole = if share >= cells.len() as f64 { cells.len() } else { share as usize };
        let guess = (whole + usize::from((whole as f64) < share)).min(cells.len());
        let is_before = |index: usize| cells.get(index).is_some_and(|middle| *middle < x);
        if (guess == 0 || is_before(guess - 1)) && !is_before(guess) {
            return guess;
        }
        cells.partition_point(|middle| *middle < x)
    }

    fn row_cells(&self, row: &CellRow) -> &[f64] {
        self.x.get(row.first..row.first + row.count).unwrap_or(&[])
    }

    fn steepest(&self, elevations_m: &[f32]) -> f64 {
        let rise = |pair: &[f32]| pair.iter().copied().reduce(|a, b| (b - a).abs()).map_or(0.0, f64::from);
        let in_row = self.rows.iter().filter_map(|row| elevations_m.get(row.first..row.first + row.count));
        in_row.flat_map(|row| row.windows(2)).fold(0.0, |most: f64, pair| most.max(rise(pair) / self.cell_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::GridSettings;
    use crate::target::{ObservedTarget, Polygon, TargetArea, WantedLook};

    /// Returns the cells by the even-odd rule: those whose centre has an odd number of crossings to its west.
    fn by_definition(grid: &TargetGrid, polygon: &[Point]) -> Vec<usize> {
        let middles = grid.centres().enumerate();
        let inside = middles.filter(|(_, (x, y))| {
            let edges = apex_geo::plane::edges(polygon).filter(|(a, b)| (a.y > *y) != (b.y > *y));
            let mut crossings: Vec<f64> = edges.map(|(a, b)| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y)).collect();
            crossings.sort_by(f64::total_cmp);
            crossings.chunks_exact(2).any(|pair| pair[0] <= *x && *x < pair[1])
        });
        inside.map(|(cell, _)| cell).collect()
    }

    /// Strips of a scanner in all directions, some as thin as a picture line, some twisted, some with an edge on a row of centres.
    #[test]
    fn strips_hit_the_cells_of_the_definition() {
        let corners = [(40.0, -120.0), (40.1, -120.02), (40.12, -119.9), (40.05, -119.95), (40.01, -119.88)];
        let outer = corners.map(|(latitude, longitude)| Position::new(latitude, longitude)).to_vec();
        let target = ObservedTarget {
            name: "fire".into(),
            area: TargetArea::Polygons(vec![Polygon { outer, holes: Vec::new() }]),
            elevation_m: 0.0,
            is_water: false,
            looks: vec![WantedLook::new("any", 1.0, 10.0)],
            after: Vec::new(),
        };
        let grid = TargetGrid::new(&target, GridSettings { cells: 3_000, ..GridSettings::default() }).unwrap();
        let mut state = 1_u64;
        let mut draw = |most: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            most * ((state >> 11) as f64 / 9_007_199_254_740_992.0 * 2.0 - 1.0)
        };
        let mut hits = 0;
        for round in 0..3_000 {
            let middle = Point { x: draw(7_000.0), y: draw(7_000.0) };
            let along = Point { x: draw(60.0), y: draw(60.0) };
            let across = match round % 5 {
                0 => Point { x: 0.0, y: draw(6_000.0) },
                1 => Point { x: draw(6_000.0), y: 0.0 },
                _ => Point { x: draw(6_000.0), y: draw(6_000.0) },
            };
            let row_y = grid.rows[round % grid.rows.len()].y;
            let from = if round % 7 == 0 { Point { y: row_y, ..middle } } else { middle };
            let twist = if round % 11 == 0 { -1.0 } else { 1.0 };
            let polygon =
                [from, from.plus(1.0, across), from.plus(1.0, across).plus(twist, along), from.plus(1.0, along)];
            let mut found = Vec::new();
            grid.rasterise(&polygon, |cell, _| found.push(cell));
            found.sort_unstable();
            hits += found.len();
            assert_eq!(found, by_definition(&grid, &polygon), "{polygon:?}");
        }
        assert!(hits > 1_000, "{hits} hits, expected more than 1,000");
    }
}
