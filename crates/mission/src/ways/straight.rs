//! Check of the straight path, with space for the turns at its ends.

use super::Request;
use super::limits::{GROUND, Limits, PERMITTED, TURN_WIDTH};
use apex_geo::plane::{self, Plane, Point};
use apex_model::problem::{AirspaceZone, Position, ZoneKind};

/// Share by which a flight may take longer than planned, and by which a zone's active time may begin earlier or end later.
pub(super) const LATE_SHARE: f64 = 0.1;
pub(super) const LATE_S: f64 = 900.0;

impl Limits {
    /// Returns true if the straight path with the turns at both ends keeps every requirement with its margin, whenever it is flown.
    pub(super) fn is_straight_open(&self, request: &Request) -> bool {
        let room_m = TURN_WIDTH * self.turn_radius_m_over_ground() + request.circle_radius_m;
        self.is_open(request, room_m)
    }

    /// Returns true if everything within `room_m` of the straight leg keeps every requirement.
    pub(super) fn is_open(&self, request: &Request, room_m: f64) -> bool {
        self.shut_by(request, (room_m, 1.0)).is_none()
    }

    /// Returns the obstacle within `room_m` of the straight leg, with this share of the margins.
    pub(super) fn shut_by(&self, request: &Request, (room_m, margins): (f64, f64)) -> Option<String> {
        let Request { from, to, at_s, .. } = *request;
        let slowest_mps = (self.true_airspeed_mps - self.wind_mps_max()).max(1.0);
        let lasts_s = apex_geo::geodesy::distance_m(from, to) / slowest_mps;
        let span_s = (at_s, at_s + (1.0 + LATE_SHARE) * lasts_s + LATE_S + request.stay_s);
        let lowest_m = request.from_altitude_m.min(request.to_altitude_m);
        let low_m = lowest_m - margins * self.above_zone_m;
        let high_m = request.from_altitude_m.max(request.to_altitude_m) + margins * self.above_zone_m;
        let leg = Leg { from, to, span_s, low_m, high_m };
        let mut restricted = self.zones.iter().filter(|zone| zone.kind == ZoneKind::Restricted);
        let inside = restricted.find(|zone| !leg.keeps_out(zone, margins * self.margin_m + room_m));
        if let Some(zone) = inside {
            return Some(zone.name.clone());
        }
        let rim_m = margins * self.rim_m + room_m;
        if self.must_stay() && !self.zones.iter().any(|zone| leg.keeps_in(zone, rim_m)) {
            return Some(PERMITTED.to_string());
        }
        if !self.leg_is_within_reach(from, to, rim_m) {
            return Some("landing distance".to_string());
        }
        let needs_m = self.lowest_altitude_m(&[from, to], (from, to), margins);
        let needs_m = needs_m.max(self.lowest_descent_m(&[from, to], request.from_altitude_m, margins));
        (lowest_m < needs_m).then(|| GROUND.to_string())
    }
}

struct Leg {
    from: Position,
    to: Position,
    span_s: (f64, f64),
    low_m: f64,
    high_m: f64,
}

/// Returns true if a leg keeps its distance from edges. A leg that crosses one has the distance zero, which also a margin of zero excludes.
fn is_apart(edges_m: f64, distance_m: f64) -> bool {
    edges_m > 0.0 && edges_m >= distance_m
}

impl Leg {
    fn flat(&self, zone: &AirspaceZone) -> Option<(Point, Point, Vec<Point>)> {
        let plane = Plane::around(&[self.from, self.to]);
        let corners: Option<Vec<Point>> = zone.corners.iter().map(|corner| plane.project(*corner)).collect();
        Some((plane.project(self.from)?, plane.project(self.to)?, corners?))
    }

    fn keeps_out(&self, zone: &AirspaceZone, distance_m: f64) -> bool {
        let meets = zone.altitude_m_min <= self.high_m
            && self.low_m < zone.altitude_m_max
            && zone.active.overlaps(self.span_s.0, self.span_s.1);
        // A zone on the other side of the Earth is far from any leg; one that is partly within reach of the plane is left to the network.
        let clear = |(a, b, corners): (Point, Point, Vec<Point>)| {
            !plane::inside(a, &corners) && is_apart(plane::segment_to_edges(a, b, &corners), distance_m)
        };
        !meets || self.flat(zone).map_or_else(|| self.is_beyond_reach(zone), clear)
    }

    /// Returns true if the plane around the leg contains the leg, and no corner of the zone.
    fn is_beyond_reach(&self, zone: &AirspaceZone) -> bool {
        let plane = Plane::around(&[self.from, self.to]);
        [self.from, self.to].into_iter().all(|end| plane.project(end).is_some())
            && zone.corners.iter().all(|corner| plane.project(*corner).is_none())
    }

    fn keeps_in(&self, zone: &AirspaceZone, distance_m: f64) -> bool {
        let counts = zone.kind == ZoneKind::Permitted
            && zone.altitude_m_min <= self.low_m.max(0.0)
            && self.high_m < zone.altitude_m_max
            && zone.active.from_s <= self.span_s.0
            && self.span_s.1 < zone.active.until_s;
        let clear = |(a, b, corners): (Point, Point, Vec<Point>)| {
            plane::inside(a, &corners) && is_apart(plane::segment_to_edges(a, b, &corners), distance_m)
        };
        counts && self.flat(zone).is_some_and(clear)
    }
}
