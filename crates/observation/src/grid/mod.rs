//! The grid of a target: wanted ground as weighted cells.
//!
//! Cells are squares on an equal-area plane at the target's middle. The weight of a cell is its exact area inside the polygon; a border
//! cell whose middle is outside gives its area to a neighbour. A point is one cell of weight 1; the cells of a line are weighted by its
//! length. Cells lie in rows of increasing y and, in a row, of increasing x, so that a swath is rasterised row by row.
//!
//! Cell size: `min(W_use / 30, max(g_want, sqrt(area / cells)))` for the useful width of the swath, the finest wanted resolution and the
//! number of cells aimed at ([`GridSettings`]), enlarged where that makes more than [`CELLS_MAX`] cells.
//! Bound: building is O(cells x corners of a row), rasterising O(rows + cells hit).

mod build;
mod cells;
mod clip;
mod parts;

pub use build::{AreaError, CELLS_MAX, GridSettings, PLANNING_CELLS, SCORING_CELLS};
pub use cells::TargetGrid;
