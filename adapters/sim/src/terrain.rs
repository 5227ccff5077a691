//! The ground under the vehicle: only the patches near it are read; they are selected again when it has moved away.

use crate::config::{Ground, GroundPatch};
use crate::geodesic::bearing;
use apex_geo::geodesy::wrap_180;
use apex_model::problem::Position;

/// The selection is valid within this many degrees of latitude and longitude from the place at which it was made.
const NEAR_DEG: f64 = 0.1;
/// Upper bound on the distance from that place, anywhere on Earth.
const NEAR_M: f64 = 16_000.0;

/// Lower bound on the length of a degree of latitude.
const METRES_PER_DEGREE_MIN: f64 = 110_000.0;

/// The ground, with the nearby patches cached.
#[derive(Clone, Debug)]
pub(crate) struct Terrain {
    all: Ground,
    /// The patches near the vehicle.
    near: Vec<GroundPatch>,
    /// Position for which `near` was chosen.
    middle: Option<Position>,
}

impl Terrain {
    pub(crate) fn new(all: Ground) -> Terrain {
        Terrain { all, near: Vec::new(), middle: None }
    }

    /// Returns the elevation anywhere.
    pub(crate) fn elevation_m_at(&self, position: Position) -> f64 {
        self.all.elevation_m_at(position)
    }

    /// Returns the elevation under the vehicle: the same value as without the cache, found faster from step to step.
    pub(crate) fn elevation_m_below(&mut self, vehicle: Position) -> f64 {
        if self.all.patches.is_empty() {
            return self.all.elevation_m_at(vehicle);
        }
        let holds = |middle: Position| {
            (vehicle.latitude_deg - middle.latitude_deg).abs() < NEAR_DEG
                && wrap_180(vehicle.longitude_deg - middle.longitude_deg).abs() < NEAR_DEG
        };
        if !self.middle.is_some_and(holds) {
            let patches = self.all.patches.iter();
            let within = patches.filter(|patch| {
                let north_deg = (vehicle.latitude_deg - patch.position.latitude_deg).abs();
                let reach_m = patch.radius_m + NEAR_M;
                // Most patches are too far to the north or south, which needs no geodesic.
                north_deg * METRES_PER_DEGREE_MIN <= reach_m && bearing(vehicle, patch.position).1 <= reach_m
            });
            self.near = within.cloned().collect();
            self.middle = Some(vehicle);
        }
        self.all.elevation_m_among(&self.near, vehicle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::GroundPatch;
    use apex_geo::geodesy::destination;

    #[test]
    fn a_long_way_over_many_patches_finds_what_looking_at_all_of_them_finds() {
        let patches = (0..80).map(|index| {
            let index = f64::from(index);
            GroundPatch {
                position: Position::new(60.0 + 0.05 * index, 178.0 + 0.07 * index),
                radius_m: 1_500.0 + 400.0 * index,
                elevation_m: index,
            }
        });
        let mut terrain = Terrain::new(Ground { elevation_m: -1.0, patches: patches.collect(), terrain: None });
        let mut seen = Vec::new();
        for step in 0..4_000 {
            let position = destination(Position::new(59.8, 177.5), 33.0, 150.0 * f64::from(step));
            let elevation_m = terrain.elevation_m_below(position);
            assert_eq!(elevation_m, terrain.elevation_m_at(position), "{position:?}");
            seen.push(elevation_m);
        }
        seen.dedup();
        assert!(seen.len() > 10, "{seen:?}");
    }
}
