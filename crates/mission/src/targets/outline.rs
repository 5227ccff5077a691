//! Outlines of fires, and fires that have grown.

use super::{Target, TargetKind, circle};
use crate::features;
use crate::ground::MissionGround;
use apex_geo::terrain::Terrain;
use apex_model::problem::Position;
use apex_observation::grid::{GridSettings, PLANNING_CELLS, TargetGrid};
use apex_observation::target::{ObservedTarget, Polygon, TargetArea};
use std::sync::Arc;

impl Target {
    /// Returns the outline of a fire: that of its largest part, or the circle of its size; `None` for other targets.
    pub fn outline(&self) -> Option<Vec<Position>> {
        let TargetKind::Fire(fire) = &self.kind else { return None };
        match &fire.wanted.area {
            TargetArea::Circle { centre, radius_m } => Some(circle(*centre, *radius_m)),
            TargetArea::Polygons(polygons) | TargetArea::Perimeter { polygons, .. } => {
                polygons.first().map(|polygon| polygon.outer.clone())
            }
            TargetArea::Point(_) | TargetArea::Line(_) => None,
        }
    }

    /// Returns the ground of a fire with another outline; `None` for a target without outline.
    pub(crate) fn area_within(&self, outline: &[Position]) -> Option<TargetArea> {
        let TargetKind::Fire(fire) = &self.kind else { return None };
        let polygons = vec![Polygon { outer: outline.to_vec(), holes: Vec::new() }];
        match &fire.wanted.area {
            TargetArea::Circle { .. } | TargetArea::Polygons(_) => Some(TargetArea::Polygons(polygons)),
            TargetArea::Perimeter { half_width_m, interior_weight, .. } => {
                Some(TargetArea::Perimeter { polygons, half_width_m: *half_width_m, interior_weight: *interior_weight })
            }
            TargetArea::Point(_) | TargetArea::Line(_) => None,
        }
    }

    /// Updates the outline of a grown fire. An outline that cannot be divided into cells changes nothing.
    pub(crate) fn grow(&mut self, outline: &[Position], terrain: Option<&Arc<Terrain>>) {
        let Some(area) = self.area_within(outline) else { return };
        let TargetKind::Fire(fire) = &mut self.kind else { return };
        let wanted = ObservedTarget { area, ..fire.wanted.clone() };
        let settings = GridSettings { cells: PLANNING_CELLS, ..GridSettings::default() };
        let Ok(grid) = TargetGrid::new(&wanted, settings) else { return };
        let grid = match terrain {
            None => grid,
            Some(terrain) => grid.with_elevations(&MissionGround::new(Some(Arc::clone(terrain)), wanted.elevation_m)),
        };
        fire.radius_m = libm::sqrt(features::area_m2(outline) / std::f64::consts::PI);
        (fire.grid, fire.wanted) = (Arc::new(grid), wanted);
        self.polygons = vec![outline.to_vec()];
    }
}
