//! The ground of a mission in the terms of the observation model.

use apex_geo::terrain::Terrain;
use apex_model::problem::Position;
use apex_observation::footprint::Ground;
use std::sync::Arc;

/// The ground of a mission: its terrain; where that is not known the ground lies at the elevation of each target.
#[derive(Clone, Debug)]
pub(crate) struct MissionGround {
    terrain: Option<Arc<Terrain>>,
    range_m: (f64, f64),
    cell_m: f64,
}

impl MissionGround {
    /// Returns the ground of a mission with this terrain, in which no target lies lower than `lowest_m`.
    pub(crate) fn new(terrain: Option<Arc<Terrain>>, lowest_m: f64) -> MissionGround {
        // Without terrain the ground is not higher than any target, so that each target's own elevation counts.
        let range_m = terrain.as_ref().map_or((lowest_m - 1.0, lowest_m), |terrain| {
            let (low_m, high_m) = terrain.range_m();
            (low_m.min(lowest_m) - 1.0, high_m)
        });
        let cell_m = terrain.as_ref().map_or(f64::INFINITY, |terrain| terrain.cell_m());
        MissionGround { terrain, range_m, cell_m }
    }
}

impl Ground for MissionGround {
    fn elevation_m_at(&self, position: Position) -> Option<f64> {
        self.terrain.as_ref()?.elevation_m_at(position)
    }

    fn elevation_range_m(&self) -> (f64, f64) {
        self.range_m
    }

    fn cell_m(&self) -> f64 {
        self.cell_m
    }
}
