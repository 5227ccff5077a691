//! The ground of observed targets: divided into cells at first, and again if a target has grown before it is seen.

use super::{FlownObservation, ObservationError, TargetObservations};
use crate::footprint::Ground;
use crate::grid::{GridSettings, TargetGrid};
use crate::looks::TargetLooks;
use crate::plane::Point;
use crate::target::{ObservedTarget, TargetArea};

impl TargetObservations {
    /// Nothing of the target seen yet.
    pub(super) fn new(
        target: ObservedTarget,
        settings: GridSettings,
        ground: &dyn Ground,
    ) -> Result<TargetObservations, ObservationError> {
        let grid = TargetGrid::new(&target, settings).map_err(ObservationError::Area)?.with_elevations(ground);
        let (low, high) = grid.bounds();
        let reach_m = [low, high, Point { x: low.x, y: high.y }, Point { x: high.x, y: low.y }]
            .iter()
            .fold(0.0, |most: f64, corner| most.max(corner.length()));
        let last_seen_s = f64::NEG_INFINITY;
        Ok(TargetObservations { target, grid, looks: TargetLooks::default(), last_seen_s, reach_m })
    }
}

impl FlownObservation {
    /// Replaces the ground of a target that has not been seen yet; a target that has been seen keeps its ground.
    ///
    /// # Errors
    /// The area cannot be divided into cells: the target keeps its ground.
    pub fn reshape(&mut self, name: &str, area: TargetArea, ground: &dyn Ground) -> Result<(), ObservationError> {
        let settings = self.settings;
        let unseen = |watched: &&mut TargetObservations| {
            watched.target.name == name && watched.looks.passes.iter().all(|pass| pass.looks.is_empty())
        };
        let Some(watched) = self.watched.iter_mut().find(unseen) else { return Ok(()) };
        let target = ObservedTarget { area, ..watched.target.clone() };
        *watched = TargetObservations::new(target, settings.grid, ground)?;
        Ok(())
    }
}
