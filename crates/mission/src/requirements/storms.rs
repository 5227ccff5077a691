//! Storms along the commanded route, and over landing places.
//!
//! Bound: O(cells) for each of [`STEPS`] points of the route.

use super::commanded::FlightOrder;
use super::readings::{LandingSite, Scene};
use crate::storm::KEPT_M;
use apex_geo::geodesy::{self, Position};

/// A route that comes nearer to a cell than this is to be changed.
const CLEARANCE_M: f64 = 5_000.0;
/// A vehicle that is nearer already must not come nearer by more than this.
const NEARER_M: f64 = 300.0;
/// Points of the route: their interval and number.
const STEP_S: f64 = 10.0;
const STEPS: u32 = 36;
/// Value of `storm-time` for a route that comes near to no cell.
const NEVER_S: f64 = 3_600.0;
/// A command whose last point is this near to a landing place leads there.
const PLACE_M: f64 = 3_000.0;
/// Height below which a landing continues whatever comes near.
const LANDING_M: f64 = 500.0;

/// Time for which a storm stands over a place, in seconds from now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StormSpell {
    pub(super) from_s: f64,
    /// `None` if the storm does not leave as far as it can be predicted.
    pub(super) until_s: Option<f64>,
}

impl<'a> Scene<'a> {
    /// Returns the seconds until the route comes near to a cell; [`NEVER_S`] if it does not.
    pub(super) fn storm_time_s(&self) -> f64 {
        let is_landing = matches!(self.order, Some(FlightOrder::Land(_)));
        let is_low = self.flown.height_above_ground_m.is_some_and(|height_m| height_m < LANDING_M);
        let is_taking_off = matches!(self.order, Some(FlightOrder::TakeOff(_)));
        if is_taking_off || (self.is_near_ground() && (is_low || !is_landing)) {
            return NEVER_S;
        }
        let nearest = |cell: &crate::storm::StormTrack| {
            let here_m = cell.distance_m(self.here, self.now_s);
            let limit_m = CLEARANCE_M.min(here_m - NEARER_M);
            // Cells out of reach within the time of the route need no comparison.
            let reach_m = 2.0 * self.route.speed_mps_max() * STEP_S * f64::from(STEPS);
            let is_far = here_m - CLEARANCE_M > reach_m;
            (1..=STEPS).filter(|_| !is_far).map(|step| STEP_S * f64::from(step)).find(|after_s| {
                let state = self.route.at(after_s.min(self.route.end_s()));
                state.is_some_and(|state| {
                    let place = self.plane.position(state.point);
                    *after_s <= self.route.end_s() && cell.distance_m(place, self.now_s + after_s) < limit_m
                })
            })
        };
        self.storms.cells().iter().filter_map(nearest).fold(NEVER_S, f64::min)
    }

    /// Returns the place to which the open command leads.
    fn goal(&self) -> Option<Position> {
        match self.order? {
            FlightOrder::TakeOff(_) => None,
            FlightOrder::FlyBy(points)
            | FlightOrder::Line(points)
            | FlightOrder::Circle(points)
            | FlightOrder::Stay(points)
            | FlightOrder::Land(points) => points.last().copied(),
        }
    }

    /// Returns true if a cell lies now between the vehicle and the place to which its command leads, or over that.
    pub(super) fn is_storm_between(&self) -> bool {
        let Some(goal) = self.goal() else { return false };
        self.storms.cells().iter().any(|cell| {
            let middle = cell.middle_at(self.now_s);
            let kept_m = cell.radius_m + CLEARANCE_M;
            let length_m = geodesy::distance_m(self.here, goal);
            let (along_m, across_m) = geodesy::along_cross_track_m(self.here, goal, middle);
            let passes = (0.0..=length_m).contains(&along_m) && across_m.abs() < kept_m;
            // A vehicle at the edge that flies away from it has the cell behind it.
            passes || geodesy::distance_m(goal, middle) < kept_m
        })
    }

    /// Returns the landing place to which the command leads, if a storm stands over it.
    pub(super) fn awaited_site(&self) -> Option<&'a str> {
        let goal = self.goal()?;
        let site = self.landing_sites().find(|site| geodesy::distance_m(site.position, goal) <= PLACE_M)?;
        self.storms.is_near(site.position, KEPT_M, (self.now_s, self.now_s)).then_some(site.name)
    }

    /// Returns the next time of a storm over a landing site, as far as cells can be predicted.
    pub(super) fn storm_spell(&self, site: &LandingSite<'_>) -> Option<StormSpell> {
        let (from_s, until_s) = self.storms.spell(site.position, KEPT_M, self.now_s)?;
        Some(StormSpell { from_s: from_s - self.now_s, until_s: until_s.map(|until_s| until_s - self.now_s) })
    }

    /// Returns true if a storm is over a site when the vehicle can be there.
    pub(super) fn is_stormy(&self, site: &LandingSite<'_>) -> bool {
        let cruise_mps = self.mission.model.true_airspeed_m_s_cruise;
        let arrives_s = self.now_s + geodesy::distance_m(self.here, site.position) / cruise_mps;
        self.storms.is_near(site.position, KEPT_M, (arrives_s, arrives_s))
    }

    /// Returns true if a storm closes this site and another one is open.
    pub(super) fn is_closed_by_storm(&self, site: &LandingSite<'_>) -> bool {
        self.is_stormy(site) && self.landing_sites().any(|other| !self.is_stormy(&other))
    }

    /// Returns the nearest landing site that no storm closes; `is_escalated`: and that is in no active zone. Without such a site, the
    /// nearest one that no storm closes, otherwise the nearest one.
    pub(super) fn nearest_open_site(&self, is_escalated: bool) -> LandingSite<'a> {
        let nearest = self.nearest_site(self.here).0;
        let is_shut = |site: &LandingSite<'_>| is_escalated && self.is_shut(site);
        if !self.is_closed_by_storm(&nearest) && !is_shut(&nearest) {
            return nearest;
        }
        let rank = |site: &LandingSite<'_>| (self.is_stormy(site), is_shut(site));
        let away_m = |site: &LandingSite<'_>| geodesy::distance_m(self.here, site.position);
        let best = self.landing_sites().min_by(|a, b| rank(a).cmp(&rank(b)).then(away_m(a).total_cmp(&away_m(b))));
        best.unwrap_or(nearest)
    }
}
