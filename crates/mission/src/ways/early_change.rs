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
