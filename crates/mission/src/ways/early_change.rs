//! Paths over and under zones that the vehicle reaches only after it has changed its altitude.

use super::limits::Limits;
use super::route::{Strictness, cost_s};
use super::{Request, Way};
use apex_geo::plane::{self, Plane, Point};
use apex_geo::travel::TravelError;
use apex_model::problem::{AirspaceZone, ZoneKind};

/// Time by which a path must be shorter if it counts on a change of altitude before a zone, s.
const EARLY_GAIN_S: f64 = 60.0;

impl Limits {
    /// Returns the path that keeps clear of every zone between both altitudes; if there is none, or it is much longer, the path of a vehicle
    /// that is above or below a zone before it reaches it.
    ///
    /// # Errors
    /// The reason for which no path exists.
    pub(super) fn way_by_change(
        &self,
        request: &Request,
        altitude_m: f64,
        strict: &Strictness,
    ) -> Result<Way, TravelError> {
        let way = self.way_at(request, altitude_m, strict);
        let is_left = |zone: &AirspaceZone| self.is_left_by_change(request, altitude_m, (zone, strict.margins));
        // Without any margin the prediction of the climb decides nothing.
        if strict.margins <= 0.0 || !self.zones.iter().any(is_left) {
            return way;
        }
        let early = self.way_at(request, altitude_m, &Strictness { early_change: true, ..strict.clone() });
        match (&way, &early) {
            (Err(_), Ok(_)) => early,
            (Ok(way), Ok(shorter)) if cost_s(shorter) + EARLY_GAIN_S < cost_s(way) => early,
            _ => way,
        }
    }

    /// Returns true for a restricted zone between both altitudes that the vehicle, which changes its altitude as soon as it leaves, is above
    /// or below before it can be there.
    pub(super) fn is_left_by_change(
        &self,
        request: &Request,
        altitude_m: f64,
        (zone, margins): (&AirspaceZone, f64),
    ) -> bool {
        let (above_m, from_m) = (margins * self.above_zone_m, request.from_altitude_m);
        let (over_m, under_m) = (zone.altitude_m_max + above_m, zone.altitude_m_min - above_m);
        let clear_m = match altitude_m > from_m {
            true if from_m < over_m && altitude_m >= over_m => over_m,
            false if from_m >= under_m && altitude_m < under_m => under_m,
            _ => return false,
        };
        let fastest_mps = self.true_airspeed_mps + self.wind_mps_max();
        let reach_m = margins * self.margin_m + self.change_s(from_m, clear_m) * fastest_mps;
        let plane = Plane::new(request.from);
        let corners: Option<Vec<Point>> = zone.corners.iter().map(|corner| plane.project(*corner)).collect();
        let here = Point::default();
        zone.kind == ZoneKind::Restricted
            && corners.is_some_and(|corners| {
                !plane::inside(here, &corners) && plane::segment_to_edges(here, here, &corners) > reach_m
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mission;
    use apex_geo::geodesy;
    use apex_model::problem::{Position, TimeWindow};

    const HERE: Position = Position { latitude_deg: 40.0, longitude_deg: -120.0 };
    const FAR_M: f64 = 200_000.0;

    /// Returns waiting and flying time of a Predator B to a place 200 km to the north, past a zone 10 km long and 600 km wide.
    fn times_s(ahead_m: f64, (zone_low_m, zone_high_m): (f64, f64), (from_m, to_m): (f64, f64)) -> (f64, f64) {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/western-states");
        let mut limits = Limits::of(&Mission::load(&folder).unwrap());
        let corner =
            |east_m: f64, north_m: f64| geodesy::destination(geodesy::destination(HERE, 0.0, north_m), 90.0, east_m);
        let behind_m = ahead_m + 10_000.0;
        limits.zones = vec![AirspaceZone {
            name: "barrier".to_string(),
            kind: ZoneKind::Restricted,
            corners: vec![
                corner(-300_000.0, ahead_m),
                corner(300_000.0, ahead_m),
                corner(300_000.0, behind_m),
                corner(-300_000.0, behind_m),
            ],
            altitude_m_min: zone_low_m,
            altitude_m_max: zone_high_m,
            active: TimeWindow::ALWAYS,
        }];
        limits.wind.layers.clear();
        limits.patches.clear();
        (limits.terrain, limits.landing_distance_m_max) = (None, None);
        let request = Request {
            from: HERE,
            from_altitude_m: from_m,
            from_track_rad: Some(0.0),
            at_s: 0.0,
            to: geodesy::destination(HERE, 0.0, FAR_M),
            to_altitude_m: to_m,
            to_track_rad: Some(0.0),
            circle_radius_m: 0.0,
            stay_s: 0.0,
        };
        let way = limits.required_way(&request);
        assert_eq!(way.broken, None);
        (way.hold_s, way.time_s)
    }

    /// Plans count a climb at 4 m/s: after 900 s, in which the aircraft flies 86 km, it is 3,600 m higher.
    #[test]
    fn a_zone_is_flown_over_or_under_if_it_is_reached_after_the_change_of_altitude() {
        let straight_s = FAR_M / 95.2;
        let (over, under) = ((0.0, 9_000.0), (7_000.0, 20_000.0));
        for (ahead_m, zone, change) in [(90_000.0, over, (6_000.0, 10_000.0)), (70_000.0, under, (10_000.0, 6_000.0))] {
            let (hold_s, time_s) = times_s(ahead_m, zone, change);
            assert!(hold_s == 0.0 && time_s < straight_s + 60.0, "{zone:?}: {hold_s} s, {time_s} s for {straight_s} s");
        }
        // 60 km ahead the aircraft would be at 8,500 m: it flies around, or climbs before it leaves.
        for (ahead_m, zone, change) in [(60_000.0, over, (6_000.0, 10_000.0)), (40_000.0, under, (10_000.0, 6_000.0))] {
            let (hold_s, time_s) = times_s(ahead_m, zone, change);
            assert!(hold_s + time_s > straight_s + 300.0, "{zone:?}: {hold_s} s, {time_s} s for {straight_s} s");
        }
    }
}
