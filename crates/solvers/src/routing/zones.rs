//! Extent of zones in height and distance.

use apex_geo::plane::{self, Plane, Point};
use apex_model::problem::{AirspaceZone, Position};

/// Returns true if the altitude is between the faces of the zone.
pub(super) fn holds(zone: &AirspaceZone, altitude_m: f64) -> bool {
    zone.altitude_m_min <= altitude_m && altitude_m < zone.altitude_m_max
}

/// Returns the distance from an outline, 0 inside; 0 too where the outline is too large for a map.
pub(super) fn distance_m(position: Position, corners: &[Position]) -> f64 {
    let plane = Plane::new(position);
    let flat: Option<Vec<Point>> = corners.iter().map(|corner| plane.project(*corner)).collect();
    let here = Point::default();
    match flat {
        Some(flat) if !plane::inside(here, &flat) => plane::segment_to_edges(here, here, &flat),
        _ => 0.0,
    }
}
