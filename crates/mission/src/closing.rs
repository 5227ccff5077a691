//! The closing of a landing place: a restricted zone over it becomes active, and the place stays closed until the mission ends.

use crate::Mission;
use apex_geo::plane::{Plane, inside};
use apex_model::problem::{AirspaceZone, Position, ZoneKind};

/// A zone whose lower face is at most this far above a landing place closes the place, m.
const LOW_M: f64 = 300.0;

/// The zone that closes a place until the end of the mission, and the instant at which it does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Closing<'a> {
    /// The zone.
    pub(crate) zone: &'a AirspaceZone,
    /// The instant from which on the place is closed until the mission ends, s.
    pub(crate) at_s: f64,
}

/// Returns the closing of a landing place; `None` if it is open when the mission ends.
pub(crate) fn closing(mission: &Mission, (place, elevation_m): (Position, f64)) -> Option<Closing<'_>> {
    let over = |zone: &&AirspaceZone| {
        zone.kind == ZoneKind::Restricted
            && zone.altitude_m_min <= elevation_m + LOW_M
            && elevation_m <= zone.altitude_m_max
            && is_inside(place, &zone.corners)
    };
    let zones: Vec<&AirspaceZone> = mission.zones.iter().filter(over).collect();
    let mut found: Option<Closing<'_>> = None;
    let mut open_until_s = mission.settings.duration.seconds();
    loop {
        let covers = |zone: &&&AirspaceZone| zone.active.from_s < open_until_s && open_until_s <= zone.active.until_s;
        let first = zones.iter().filter(covers).min_by(|a, b| a.active.from_s.total_cmp(&b.active.from_s));
        let Some(zone) = first else { return found };
        open_until_s = zone.active.from_s;
        found = Some(Closing { zone, at_s: open_until_s });
    }
}

fn is_inside(place: Position, corners: &[Position]) -> bool {
    let plane = Plane::new(place);
    let corners: Option<Vec<_>> = corners.iter().map(|corner| plane.project(*corner)).collect();
    corners.is_some_and(|corners| inside(Default::default(), &corners))
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::TimeWindow;
    use std::path::Path;

    #[test]
    fn consecutive_zones_close_a_place_from_the_first_on() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/first-picture");
        let mut mission = Mission::load(&path).unwrap();
        let end_s = mission.settings.duration.seconds();
        let (place, elevation_m) = (mission.start, mission.start_altitude_m);
        let around = [(-0.1, -0.1), (-0.1, 0.1), (0.1, 0.1), (0.1, -0.1)];
        let corners: Vec<Position> = around
            .iter()
            .map(|(north, east)| Position::new(place.latitude_deg + north, place.longitude_deg + east))
            .collect();
        let mut close = |zones: &[(f64, f64, f64)]| {
            mission.zones = zones
                .iter()
                .map(|(low_m, from_s, until_s)| AirspaceZone {
                    name: "z".to_string(),
                    kind: ZoneKind::Restricted,
                    corners: corners.clone(),
                    altitude_m_min: *low_m,
                    altitude_m_max: 5_000.0,
                    active: TimeWindow { from_s: *from_s, until_s: *until_s },
                })
                .collect();
            closing(&mission, (place, elevation_m)).map(|closing| closing.at_s)
        };
        assert_eq!(close(&[]), None);
        assert_eq!(close(&[(0.0, 100.0, end_s - 1.0)]), None, "open again");
        assert_eq!(close(&[(4_000.0, 100.0, end_s)]), None, "far above the place");
        assert_eq!(close(&[(0.0, 100.0, end_s)]), Some(100.0));
        assert_eq!(close(&[(0.0, 300.0, end_s + 9.0), (0.0, 100.0, 300.0), (0.0, 0.0, 50.0)]), Some(100.0));
    }
}
