//! The cells of a target and their rasterising.

use crate::footprint::Ground;
use crate::plane::{EqualAreaPlane, Point};
use apex_geo::geodesy::Position;

/// One row of cells with the same y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CellRow {
    pub(super) y: f64,
    pub(super) first: usize,
    pub(super) count: usize,
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
    /// Returns the grid with the elevation of each cell from `ground`. Where it is not known, the target's elevation is used and
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

    /// Corners south-west and north-east of the box around the cells.
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

    /// Returns unit normal of the ellipsoid at a cell.
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

    /// Returns the cell whose middle is nearest to a point among those of the nearest row; `None` without cells.
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

    /// Calls `hit` for every cell whose middle lies in the polygon (even-odd rule), with its index and its middle.
    pub fn rasterise(&self, polygon: &[Point], mut hit: impl FnMut(usize, Point)) {
        let (mut low_y, mut high_y) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut low_x, mut high_x) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in polygon {
            (low_y, high_y) = (low_y.min(corner.y), high_y.max(corner.y));
            (low_x, high_x) = (low_x.min(corner.x), high_x.max(corner.x));
        }
        // Most strips of a join lie outside the target.
        if high_x < self.low.x || low_x > self.high.x {
            return;
        }
        let first = self.rows.partition_point(|row| row.y < low_y);
        let edges: Vec<(Point, Point)> = apex_geo::plane::edges(polygon).filter(|(a, b)| a.y != b.y).collect();
        let mut crossings: Vec<f64> = Vec::with_capacity(edges.len());
        for row in self.rows.iter().skip(first).take_while(|row| row.y <= high_y) {
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

    /// Returns the first of the cells of a row whose middle is not west of `x`. Middles are a cell or more apart, and mostly one.
    fn first_from(&self, cells: &[f64], x: f64) -> usize {
        let Some(west) = cells.first() else { return 0 };
        let guess = libm::ceil((x - west) / self.cell_m).clamp(0.0, cells.len() as f64) as usize;
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
