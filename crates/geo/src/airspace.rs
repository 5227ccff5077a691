//! Questions about one zone of airspace, whatever altitude and time: is a position inside, when is it entered?
//!
//! Ways around many zones are in [`crate::travel`]. Bound: O(corners).

use crate::geodesy::{self, Position};
use crate::plane::{self, Plane, Point};
pub use apex_model::problem::{AirspaceZone, ZoneKind};

/// Is `position` inside the polygon of `zone`, whatever altitude and time?
pub fn inside(zone: &AirspaceZone, position: Position) -> bool {
    let plane = Plane::around(&zone.corners);
    let corners: Option<Vec<Point>> = zone.corners.iter().map(|corner| plane.project(*corner)).collect();
    match (corners, plane.project(position)) {
        (Some(corners), Some(point)) => plane::inside(point, &corners),
        _ => false,
    }
}

/// Distance along the geodesic that leaves `from` at `track_deg` after which `zone`'s polygon is entered, within
/// `range_m`; 0 where `from` is inside. Whatever altitude and time.
pub fn entry_distance_m(zone: &AirspaceZone, from: Position, track_deg: f64, range_m: f64) -> Option<f64> {
    if inside(zone, from) {
        return Some(0.0);
    }
    let plane = Plane::around(&zone.corners);
    let corners: Vec<Point> = zone.corners.iter().map(|corner| plane.project(*corner)).collect::<Option<_>>()?;
    let (a, b) = (plane.project(from)?, plane.project(geodesy::destination(from, track_deg, range_m))?);
    let along = b.minus(a);
    let shares = plane::edges(&corners).filter_map(|(c, d)| {
        let edge = d.minus(c);
        let scale = along.cross(edge);
        let (share, edge_share) = (c.minus(a).cross(edge) / scale, c.minus(a).cross(along) / scale);
        (scale != 0.0 && (0.0..=1.0).contains(&share) && (0.0..=1.0).contains(&edge_share)).then_some(share)
    });
    let first = shares.min_by(f64::total_cmp)?;
    Some(geodesy::distance_m(from, plane.position(a.plus(first, along))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::TimeWindow;

    #[test]
    fn entry_is_predicted() {
        let corners = [(37.0, -119.0), (37.0, -117.0), (38.0, -117.0), (38.0, -119.0)];
        let zone = AirspaceZone {
            name: "R-1".to_string(),
            kind: ZoneKind::Restricted,
            corners: corners.map(|(latitude, longitude)| Position::new(latitude, longitude)).to_vec(),
            altitude_m_min: 0.0,
            altitude_m_max: 10_000.0,
            active: TimeWindow::ALWAYS,
        };
        assert!(inside(&zone, Position::new(37.5, -118.0)) && !inside(&zone, Position::new(36.5, -118.0)));
        let from = Position::new(36.0, -118.0);
        let distance = entry_distance_m(&zone, from, 0.0, 500_000.0).unwrap();
        assert!((distance - 111_000.0).abs() < 500.0, "{distance}");
        assert_eq!(entry_distance_m(&zone, from, 180.0, 500_000.0), None);
        assert_eq!(entry_distance_m(&zone, from, 0.0, 50_000.0), None);
    }
}
