//! Grids of which only a part of the ground is wanted.

use super::cells::TargetGrid;

impl TargetGrid {
    /// Returns the grid with weight 0 for the cells for which `is_wanted` is false: they are no longer wanted.
    #[must_use]
    pub fn only(mut self, is_wanted: impl Fn(usize) -> bool) -> TargetGrid {
        let left_out = self.weights.iter_mut().enumerate().filter(|(cell, _)| !is_wanted(*cell));
        left_out.for_each(|(_, weight)| *weight = 0.0);
        self.total = self.weights.iter().sum();
        self
    }

    /// Returns true if some cells are not wanted.
    pub fn is_partial(&self) -> bool {
        self.weights.contains(&0.0)
    }
}
