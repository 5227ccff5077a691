//! Turns between the lines of a manoeuvre.

use super::zones::{distance_m, holds};
use apex_geo::geodesy::{self, Position};
use apex_geo::landing;
use apex_geo::travel::{Network, TravelError};
use apex_model::problem::{AirspaceZone, SingleVisitProblem, ZoneKind};

/// Space for circles up or down around a place, and for a turn between two lines, in turn radii.
pub(super) const CIRCLES_RADII: f64 = 4.0;

/// The turn from the end of a line to the next one, which it meets in its direction.
pub(super) struct TurnBetween {
    pub(super) from: Position,
    from_track_rad: f64,
    /// Beginning of the straight flight before the next line.
    pub(super) to: Position,
    to_track_rad: f64,
    /// Beginning of the next line.
    pub(super) begin: Position,
}

impl TurnBetween {
    pub(super) fn of(line: (Position, Position), next: (Position, Position), lead_m: f64) -> TurnBetween {
        let track_deg = geodesy::azimuth_deg(next.0, next.1);
        TurnBetween {
            from: line.1,
            from_track_rad: (geodesy::azimuth_deg(line.1, line.0) + 180.0).to_radians(),
            to: geodesy::destination(next.0, geodesy::wrap_360(track_deg + 180.0), lead_m),
            to_track_rad: track_deg.to_radians(),
            begin: next.0,
        }
    }

    /// Returns true if a zone at the altitude, or the end of the reach of landing places, is so near that the turn may not have space.
    pub(super) fn is_near_limits(&self, problem: &SingleVisitProblem, altitude_m: f64) -> bool {
        let room_m = CIRCLES_RADII * problem.vehicle.turn_radius_m;
        let is_near = |zone: &AirspaceZone| {
            let apart_m = |end| distance_m(end, &zone.corners);
            let is_near = apart_m(self.from).min(apart_m(self.to)) < room_m + problem.zone_margin_m;
            zone.kind == ZoneKind::Restricted && holds(zone, altitude_m) && is_near
        };
        let is_within = |limit_m| landing::leg_is_within(&problem.landing_places, self.from, self.to, limit_m - room_m);
        !problem.landing_distance_m_max.is_none_or(is_within) || problem.zones.iter().any(is_near)
    }

    /// Returns the reason for which no path leads from line to line.
    pub(super) fn trouble(&self, network: &mut Network, begin_s: f64) -> Option<TravelError> {
        let (from, to) = match network.add(self.from).and_then(|from| Ok((from, network.add(self.to)?))) {
            Ok(ends) => ends,
            Err(trouble) => return Some(trouble),
        };
        network.head(from, Some(self.from_track_rad));
        network.head(to, Some(self.to_track_rad));
        network.trip(from, to, begin_s).err()
    }
}
