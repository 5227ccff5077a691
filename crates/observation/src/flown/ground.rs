//! The ground of observed targets: divided into cells at first, and again if a target has grown before it is seen.

use super::{FlownObservation, ObservationError, TargetObservations};
use crate::footprint::Ground;
use crate::grid::{AreaError, GridSettings, TargetGrid};
use crate::looks::TargetLooks;
use crate::plane::Point;
use crate::target::{ObservedTarget, TargetArea};

impl TargetObservations {
    /// Returns a target of which nothing has been seen.
    pub(super) fn new(target: ObservedTarget, grid: TargetGrid) -> TargetObservations {
        let (low, high) = grid.bounds();
        let reach_m = [low, high, Point { x: low.x, y: high.y }, Point { x: high.x, y: low.y }]
            .iter()
            .fold(0.0, |most: f64, corner| most.max(corner.length()));
        let last_seen_s = f64::NEG_INFINITY;
        TargetObservations { target, grid, looks: TargetLooks::default(), last_seen_s, reach_m }
    }

    fn is_seen(&self) -> bool {
        self.looks.passes.iter().any(|pass| !pass.looks.is_empty())
    }
}

impl FlownObservation {
    /// Returns true if ground of a target has been seen.
    pub fn is_seen(&self, name: &str) -> bool {
        let is_of = |watched: &&TargetObservations| watched.target.name == name;
        self.watched.iter().find(is_of).is_some_and(TargetObservations::is_seen)
    }

    /// Adds a target. It replaces the target of the same name, unless ground of that target has been seen: then the call has no effect.
    pub fn put(&mut self, target: ObservedTarget, grid: TargetGrid) {
        match self.watched.iter_mut().find(|watched| watched.target.name == target.name) {
            Some(watched) if watched.is_seen() => {}
            Some(watched) => *watched = TargetObservations::new(target, grid),
            None => self.watched.push(TargetObservations::new(target, grid)),
        }
    }

    /// Returns the name of each target, and the number of looks that its cells have received.
    pub fn look_counts(&self) -> impl Iterator<Item = (&str, usize)> {
        self.watched.iter().map(|watched| (watched.target.name.as_str(), watched.looks.count()))
    }

    /// Returns the grid on which a flown target is accumulated, with the elevations of `ground`.
    ///
    /// # Errors
    /// The area cannot be divided into cells.
    pub fn grid_of(
        target: &ObservedTarget,
        settings: GridSettings,
        ground: &dyn Ground,
    ) -> Result<TargetGrid, AreaError> {
        Ok(TargetGrid::new(target, settings)?.with_elevations(ground))
    }

    /// Replaces the ground of a target that has not been seen yet; a target that has been seen keeps its ground.
    ///
    /// # Errors
    /// The area cannot be divided into cells: the target keeps its ground.
    pub fn reshape(&mut self, name: &str, area: TargetArea, ground: &dyn Ground) -> Result<(), ObservationError> {
        let settings = self.settings;
        let unseen = |watched: &&mut TargetObservations| watched.target.name == name && !watched.is_seen();
        let Some(watched) = self.watched.iter_mut().find(unseen) else { return Ok(()) };
        let target = ObservedTarget { area, ..watched.target.clone() };
        let grid = FlownObservation::grid_of(&target, settings.grid, ground).map_err(ObservationError::Area)?;
        *watched = TargetObservations::new(target, grid);
        Ok(())
    }
}
