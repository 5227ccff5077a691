//! Elevation of the ground on grids of latitude and longitude: at a place, and the highest around it or along a leg.
//!
//! Between the posts of a grid the elevation is bilinear, so no place is higher than the highest of the four posts around it. Highest
//! elevations are read from blocks of posts: they are never below the true ones, but may be those of posts slightly outside of the radius.
//! Bound: O(1) for a place; O((radius / cell)^2) for the surroundings of a place, less for large radii by a factor of [`BLOCK`]^2.

use crate::geodesy::{self, Position, RAD_PER_DEG, wrap_180};
use apex_model::problem::Area;
use serde::{Deserialize, Serialize};

/// Number of posts along one side of a block whose highest elevation is stored.
pub const BLOCK: usize = 16;
/// Maximum number of posts of one grid.
pub const POSTS_MAX: usize = 64 << 20;
/// Elevations that occur on Earth, in metres above mean sea level.
pub const ELEVATION_M: (f64, f64) = (-500.0, 9_000.0);
/// Least length of a degree of latitude, rounded down.
const METRES_PER_DEGREE_MIN: f64 = 110_500.0;
/// Maximum number of samples of one leg.
const LEG_STEPS_MAX: usize = 20_000;

/// Posts of a grid, in rows from south to north and columns from west to east.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TerrainGrid {
    south_west: Position,
    /// Distance between rows, and between columns.
    step_deg: (f64, f64),
    rows: usize,
    columns: usize,
    /// Elevations above mean sea level; NaN where unknown.
    elevations_m: Vec<f32>,
    block_columns: usize,
    /// Highest elevation of each block; negative infinity if none is known.
    blocks_m: Vec<f32>,
    range_m: (f64, f64),
}

/// Rows and columns of a grid, each with its first and last.
#[derive(Clone, Copy, Debug)]
struct PostWindow {
    rows: (usize, usize),
    columns: (usize, usize),
}

impl TerrainGrid {
    /// Returns a grid whose first post is at `south_west`, with `step_deg` between rows and between columns. `elevations_m` has `rows`
    /// times `columns` numbers from the southern row on, NaN where unknown.
    ///
    /// # Errors
    /// An error message that names the figure that is wrong.
    pub fn new(
        south_west: Position,
        step_deg: (f64, f64),
        (rows, columns): (usize, usize),
        elevations_m: Vec<f32>,
    ) -> Result<TerrainGrid, String> {
        if rows < 2 || columns < 2 {
            return Err(format!("it has {rows} rows and {columns} columns; each must be 2 or more"));
        }
        let posts = rows.checked_mul(columns).filter(|posts| *posts <= POSTS_MAX);
        if posts != Some(elevations_m.len()) {
            let found = elevations_m.len();
            return Err(format!(
                "{rows} rows of {columns} posts do not give {found} elevations, or are more than {POSTS_MAX}"
            ));
        }
        let (north, east) = ((rows - 1) as f64 * step_deg.0, (columns - 1) as f64 * step_deg.1);
        let steps_are_right = step_deg.0 > 0.0 && step_deg.1 > 0.0 && north.is_finite() && east <= 360.0;
        let Position { latitude_deg, longitude_deg } = south_west;
        let fits = latitude_deg >= -90.0 && latitude_deg + north <= 90.0 + 1e-9 && longitude_deg.abs() <= 360.0;
        if !(steps_are_right && fits) {
            return Err(format!(
                "it reaches from latitude {latitude_deg} to {}, longitude {longitude_deg} to {} in steps of {} and {} degrees; it must lie \
                 on Earth",
                latitude_deg + north,
                longitude_deg + east,
                step_deg.0,
                step_deg.1
            ));
        }
        let known = elevations_m.iter().copied().filter(|elevation_m| !elevation_m.is_nan()).map(f64::from);
        let range_m = known.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), m| (low.min(m), high.max(m)));
        if range_m.0 > range_m.1 {
            return Err("no elevation in it is known".to_string());
        }
        if range_m.0 < ELEVATION_M.0 || range_m.1 > ELEVATION_M.1 {
            let ((low, high), (least, most)) = (range_m, ELEVATION_M);
            return Err(format!(
                "its elevations reach from {low} to {high} m; on Earth they are between {least} and {most} m"
            ));
        }
        let block_columns = columns.div_ceil(BLOCK);
        let mut blocks_m = vec![f32::NEG_INFINITY; rows.div_ceil(BLOCK) * block_columns];
        for (index, elevation_m) in elevations_m.iter().enumerate() {
            let block = (index / columns / BLOCK) * block_columns + index % columns / BLOCK;
            if let Some(highest_m) = blocks_m.get_mut(block) {
                *highest_m = highest_m.max(*elevation_m);
            }
        }
        Ok(TerrainGrid { south_west, step_deg, rows, columns, elevations_m, block_columns, blocks_m, range_m })
    }

    /// Returns the row and column of a place as fractions; `None` outside of the grid.
    fn place(&self, position: Position) -> Option<(f64, f64)> {
        let row = (position.latitude_deg - self.south_west.latitude_deg) / self.step_deg.0;
        let east_deg = self.east_deg(position.longitude_deg);
        let column = east_deg / self.step_deg.1;
        let last = ((self.rows - 1) as f64, (self.columns - 1) as f64);
        let near = 1e-6;
        let is_inside = row >= -near && row <= last.0 + near && column >= -near && column <= last.1 + near;
        is_inside.then(|| (row.clamp(0.0, last.0), column.clamp(0.0, last.1)))
    }

    /// Returns the degrees east of the first column, counted around the middle of the grid.
    fn east_deg(&self, longitude_deg: f64) -> f64 {
        let half_deg = 0.5 * (self.columns - 1) as f64 * self.step_deg.1;
        half_deg + wrap_180(longitude_deg - self.south_west.longitude_deg - half_deg)
    }

    fn post_m(&self, row: usize, column: usize) -> Option<f64> {
        let elevation_m = self.elevations_m.get(row * self.columns + column)?;
        (!elevation_m.is_nan()).then(|| f64::from(*elevation_m))
    }

    /// Returns the bilinear elevation; `None` outside, and next to an unknown post.
    pub fn elevation_m_at(&self, position: Position) -> Option<f64> {
        let (row, column) = self.place(position)?;
        let (south, west) = ((row as usize).min(self.rows - 2), (column as usize).min(self.columns - 2));
        let (up, right) = (row - south as f64, column - west as f64);
        let low = (1.0 - right) * self.post_m(south, west)? + right * self.post_m(south, west + 1)?;
        let high = (1.0 - right) * self.post_m(south + 1, west)? + right * self.post_m(south + 1, west + 1)?;
        Some((1.0 - up) * low + up * high)
    }

    /// Returns the posts of all cells that a box of this half width touches; `None` if the box is outside.
    fn window(&self, position: Position, radius_m: f64) -> Option<PostWindow> {
        let north_deg = radius_m / METRES_PER_DEGREE_MIN;
        let poleward_deg = (position.latitude_deg.abs() + north_deg).min(89.9);
        let east_deg = north_deg / libm::cos(poleward_deg * RAD_PER_DEG);
        self.window_deg(position, north_deg, east_deg)
    }

    /// Returns the posts of all cells from `north_deg` and `east_deg` on either side of a place.
    fn window_deg(&self, position: Position, north_deg: f64, east_deg: f64) -> Option<PostWindow> {
        let row = (position.latitude_deg - self.south_west.latitude_deg) / self.step_deg.0;
        let column = self.east_deg(position.longitude_deg) / self.step_deg.1;
        let rows = span(row, north_deg / self.step_deg.0, self.rows)?;
        let columns = span(column, east_deg / self.step_deg.1, self.columns)?;
        Some(PostWindow { rows, columns })
    }

    /// Returns the highest elevation of a window: of whole blocks by their stored maximum, of the rest post by post.
    fn highest_m_in(&self, window: PostWindow) -> f64 {
        let mut highest_m = f32::NEG_INFINITY;
        for block_row in window.rows.0 / BLOCK..=window.rows.1 / BLOCK {
            let rows = (block_row * BLOCK, ((block_row + 1) * BLOCK - 1).min(self.rows - 1));
            for block_column in window.columns.0 / BLOCK..=window.columns.1 / BLOCK {
                let columns = (block_column * BLOCK, ((block_column + 1) * BLOCK - 1).min(self.columns - 1));
                let block_m = self.blocks_m.get(block_row * self.block_columns + block_column).copied();
                let block_m = block_m.unwrap_or(f32::NEG_INFINITY);
                if block_m <= highest_m {
                    continue;
                }
                let is_whole = |outer: (usize, usize), inner: (usize, usize)| outer.0 <= inner.0 && inner.1 <= outer.1;
                if is_whole(window.rows, rows) && is_whole(window.columns, columns) {
                    highest_m = block_m;
                    continue;
                }
                for row in rows.0.max(window.rows.0)..=rows.1.min(window.rows.1) {
                    let (west, east) = (columns.0.max(window.columns.0), columns.1.min(window.columns.1));
                    let posts = self.elevations_m.get(row * self.columns + west..=row * self.columns + east);
                    highest_m = posts.unwrap_or_default().iter().copied().fold(highest_m, f32::max);
                }
            }
        }
        f64::from(highest_m)
    }
}

/// Returns the first and the last post of the cells from `middle - half` to `middle + half`; `None` outside of `count` posts.
fn span(middle: f64, half: f64, count: usize) -> Option<(usize, usize)> {
    let last = (count - 1) as f64;
    let (low, high) = (libm::floor(middle - half), libm::ceil(middle + half));
    (low <= last && high >= 0.0).then(|| (low.max(0.0) as usize, high.min(last) as usize))
}

/// The terrain of a mission: one grid or more. Where grids overlap, the first grid with a known elevation counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Terrain {
    grids: Vec<TerrainGrid>,
}

impl Terrain {
    /// Returns the terrain of these grids; `None` without any.
    pub fn new(grids: Vec<TerrainGrid>) -> Option<Terrain> {
        (!grids.is_empty()).then_some(Terrain { grids })
    }

    /// Returns the elevation above mean sea level; `None` if it is unknown.
    pub fn elevation_m_at(&self, position: Position) -> Option<f64> {
        self.grids.iter().find_map(|grid| grid.elevation_m_at(position))
    }

    /// Returns the lowest and highest known elevation.
    pub fn range_m(&self) -> (f64, f64) {
        let ranges = self.grids.iter().map(|grid| grid.range_m);
        ranges.fold((f64::INFINITY, f64::NEG_INFINITY), |all, range| (all.0.min(range.0), all.1.max(range.1)))
    }

    /// Returns the highest elevation in an area; `None` if none is known.
    pub fn highest_m_in(&self, area: &Area) -> Option<f64> {
        let middle_deg = 0.5 * (area.south_deg + area.north_deg);
        let height_deg = 0.5 * (area.north_deg - area.south_deg);
        let width_deg = if area.west_deg <= area.east_deg {
            area.east_deg - area.west_deg
        } else {
            360.0 + area.east_deg - area.west_deg
        };
        let middle = Position::new(middle_deg, wrap_180(area.west_deg + 0.5 * width_deg));
        let windows = self.grids.iter().filter_map(|grid| {
            let window = grid.window_deg(middle, height_deg, 0.5 * width_deg)?;
            Some(grid.highest_m_in(window))
        });
        windows.max_by(f64::total_cmp).filter(|highest_m| highest_m.is_finite())
    }

    /// Returns the shortest side of a cell, in metres.
    pub fn cell_m(&self) -> f64 {
        let side_m = |grid: &TerrainGrid| {
            let north_deg = grid.south_west.latitude_deg + (grid.rows - 1) as f64 * grid.step_deg.0;
            let poleward_deg = grid.south_west.latitude_deg.abs().max(north_deg.abs()).min(89.9);
            METRES_PER_DEGREE_MIN * grid.step_deg.0.min(grid.step_deg.1 * libm::cos(poleward_deg * RAD_PER_DEG))
        };
        self.grids.iter().map(side_m).fold(f64::INFINITY, f64::min).max(1.0)
    }

    /// Returns the highest elevation within `radius_m` of a place; `None` if none is known.
    pub fn highest_m_near(&self, position: Position, radius_m: f64) -> Option<f64> {
        let windows = self.grids.iter().filter_map(|grid| Some(grid.highest_m_in(grid.window(position, radius_m)?)));
        windows.max_by(f64::total_cmp).filter(|highest_m| highest_m.is_finite())
    }

    /// Returns the highest elevation within `half_width_m` of the geodesic between two places, without `skip_m` at its beginning and at
    /// its end; `None` if no elevation is known or no part remains.
    pub fn highest_m_along(&self, from: Position, to: Position, half_width_m: f64, skip_m: (f64, f64)) -> Option<f64> {
        let (length_m, azimuth_deg) = geodesy::inverse(from, to);
        let (begin_m, end_m) = (skip_m.0, length_m - skip_m.1);
        if begin_m > end_m {
            return None;
        }
        // Discs of a radius that holds every point of the strip between two middles.
        let step_m = half_width_m.max(self.cell_m()).max((end_m - begin_m) / LEG_STEPS_MAX as f64);
        let radius_m = libm::hypot(half_width_m, 0.5 * step_m);
        let count = libm::ceil((end_m - begin_m) / step_m) as usize;
        let at = |index: usize| (begin_m + index as f64 * step_m).min(end_m);
        let discs = (0..=count)
            .filter_map(|index| self.highest_m_near(geodesy::destination(from, azimuth_deg, at(index)), radius_m));
        discs.max_by(f64::total_cmp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Rises by 10 m per column and 100 m per row from 0 m at 40 N 120 W.
    fn ramp() -> TerrainGrid {
        let elevations = (0..50).flat_map(|row| (0..60).map(move |column| (100 * row + 10 * column) as f32)).collect();
        TerrainGrid::new(Position::new(40.0, -120.0), (0.01, 0.01), (50, 60), elevations).unwrap()
    }

    #[test]
    fn between_posts_the_elevation_is_bilinear() {
        let grid = ramp();
        let corner_m = grid.elevation_m_at(Position::new(40.0, -120.0)).unwrap();
        assert!(corner_m.abs() < 1e-6, "{corner_m}");
        let middle_m = grid.elevation_m_at(Position::new(40.015, -119.985)).unwrap();
        assert!((middle_m - 165.0).abs() < 1e-3, "{middle_m}");
        assert_eq!(grid.elevation_m_at(Position::new(39.9, -120.0)), None);
        assert_eq!(grid.elevation_m_at(Position::new(40.2, -121.0)), None);
    }

    #[test]
    fn next_to_a_post_that_is_not_known_nothing_is_known() {
        let mut elevations = vec![100.0; 16];
        elevations[5] = f32::NAN;
        let grid = TerrainGrid::new(Position::new(0.0, 179.98), (0.01, 0.01), (4, 4), elevations).unwrap();
        assert_eq!(grid.elevation_m_at(Position::new(0.015, 179.995)), None);
        assert_eq!(grid.elevation_m_at(Position::new(0.025, -179.995)), Some(100.0), "across the 180th meridian");
        let terrain = Terrain::new(vec![grid]).unwrap();
        assert_eq!(terrain.highest_m_near(Position::new(0.015, 179.995), 100.0), Some(100.0));
    }

    #[test]
    fn a_peak_is_found_from_a_leg_that_passes_it() {
        let mut elevations = vec![500.0; 200 * 200];
        elevations[100 * 200 + 100] = 3_000.0;
        let grid = TerrainGrid::new(Position::new(40.0, -120.0), (0.005, 0.005), (200, 200), elevations).unwrap();
        let terrain = Terrain::new(vec![grid]).unwrap();
        let (from, to) = (Position::new(40.47, -119.9), Position::new(40.47, -119.1));
        // The peak lies 3.3 km north of the leg, 33.9 km from its beginning.
        assert_eq!(terrain.highest_m_along(from, to, 1_000.0, (0.0, 0.0)), Some(500.0));
        assert_eq!(terrain.highest_m_along(from, to, 4_000.0, (0.0, 0.0)), Some(3_000.0));
        assert_eq!(terrain.highest_m_along(from, to, 4_000.0, (45_000.0, 0.0)), Some(500.0), "behind it");
        assert_eq!(terrain.highest_m_along(from, to, 4_000.0, (45_000.0, 45_000.0)), None);
    }

    #[test]
    fn impossible_grids_are_refused_with_a_sentence() {
        let here = Position::new(40.0, -120.0);
        let refused = |step_deg: (f64, f64), size: (usize, usize), elevations: Vec<f32>| {
            TerrainGrid::new(here, step_deg, size, elevations).unwrap_err()
        };
        assert!(refused((0.1, 0.1), (1, 4), vec![0.0; 4]).contains("1 rows"));
        assert!(refused((0.1, 0.1), (2, 2), vec![0.0; 5]).contains("do not give 5"));
        assert!(refused((0.0, 0.1), (2, 2), vec![0.0; 4]).contains("on Earth"));
        assert!(refused((100.0, 0.1), (2, 2), vec![0.0; 4]).contains("on Earth"));
        assert!(refused((0.1, 0.1), (2, 2), vec![f32::NAN; 4]).contains("is known"));
        assert!(refused((0.1, 0.1), (2, 2), vec![0.0, 0.0, 0.0, 9_500.0]).contains("9500"));
    }

    proptest! {
        /// The highest elevation around a place is at least that of every place within the radius, by sampling.
        #[test]
        fn no_place_within_the_radius_is_higher(
            seeds in prop::collection::vec(0.0f32..4_000.0, 40 * 40),
            north in 0.05..0.35f64, east in 0.05..0.35f64, radius_m in 0.0..9_000.0f64,
            samples in prop::collection::vec((0.0..360.0f64, 0.0..1.0f64), 30),
        ) {
            let grid = TerrainGrid::new(Position::new(35.0, -118.0), (0.01, 0.01), (40, 40), seeds).unwrap();
            let terrain = Terrain::new(vec![grid]).unwrap();
            let here = Position::new(35.0 + north, -118.0 + east);
            let highest_m = terrain.highest_m_near(here, radius_m).unwrap();
            for (azimuth_deg, share) in samples {
                let there = geodesy::destination(here, azimuth_deg, share * radius_m);
                if let Some(elevation_m) = terrain.elevation_m_at(there) {
                    prop_assert!(elevation_m <= highest_m + 1e-6, "{elevation_m} at {there:?}, {highest_m}");
                }
            }
            let all_m = terrain.highest_m_near(here, 60_000.0).unwrap();
            prop_assert_eq!(all_m, terrain.range_m().1);
        }
    }
}
