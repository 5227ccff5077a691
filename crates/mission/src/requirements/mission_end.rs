//! Requirement `mission-end`: the vehicle lands at its base before the mission ends.

use super::commanded::FlightOrder;
use super::commanded_route::chart_distance_m;
use super::readings::{LandingSite, Reading, Scene};
use super::response::Response;
use super::storms::StormSpell;
use crate::closing::closing;
use crate::descent::Descent;
use crate::storm::AHEAD_S;
use crate::vehicle::way_altitude_m_max;
use crate::ways::is_inside;
use apex_geo::geodesy::{self, Position};
use apex_geo::wind::{self, Wind, WindAt, leg_times_s};
use apex_model::problem::ZoneKind;
use apex_model::quantity::Dimension;
use apex_requirements::Concern;
use apex_requirements::margin::mission_end::mission_end;

/// Detour of the way home around zones, as a factor of the distance.
const DETOUR: f64 = 1.03;
/// A command whose last point is this near to the base leads home.
const BASE_M: f64 = 3_000.0;
/// Share of the application's `end-margin` below which the remaining visits are planned again: a stronger wind, for example, has used up
/// the rest.
const REPLAN_SHARE: f64 = 0.3;
/// Magnitude in seconds of the margin, which is negative, if the wind permits no way home.
const NO_WAY_S: f64 = 86_400.0;

impl<'a> Scene<'a> {
    pub(super) fn mission_end(&self) -> Option<Reading> {
        let before_s = self.requirements().landed_before_end_s?;
        // A landing cannot be made earlier.
        if matches!(self.order, Some(FlightOrder::Land(_))) {
            return None;
        }
        let base = self.base();
        // The commanded way home has its detours already.
        let home_m = self.way_home_m(base.position);
        let detour = home_m.map_or(DETOUR, |home_m| home_m / geodesy::distance_m(self.here, base.position).max(1.0));
        let mut margin = self.landed_s(before_s, self.present(), &base, detour.max(1.0));
        let (mut site, mut response) = (base, Response::LandAt);
        // Without enough time for the way home, the flight continues until another landing place is the last one in reach.
        if margin < -before_s
            && let Some((other, other_s)) = self.site_of_most_time(before_s).filter(|(_, other_s)| *other_s > margin)
        {
            (site, margin, response) = (other, other_s, Response::LandElsewhere);
        }
        let is_home = home_m.is_some() && response == Response::LandAt;
        let is_far = margin > 4.0 * self.requirements().look_ahead_s;
        let after_s = if is_far || is_home {
            None
        } else {
            self.first_below(|state| {
                let there = (self.plane.position(state.point), state.altitude_m, state.after_s);
                self.landed_s(before_s, there, &site, DETOUR)
            })
        };
        Some(Reading {
            concern: Concern::MissionEnd,
            name: "mission-end",
            margin,
            unit: Dimension::TIME,
            after_s,
            response_s: self.turn_away_s(),
            what: site.name.to_string(),
            response,
        })
    }

    /// Returns true if so little time is left in addition to the way home that the remaining visits are to be planned again, by the wind as
    /// measured. The response to the requirement itself begins when only the way home is left.
    pub(super) fn wants_replanning(&self, reading: &Reading) -> bool {
        let least_s = REPLAN_SHARE * self.mission.settings.end_margin.seconds();
        let is_short = reading.concern == Concern::MissionEnd && (0.0..least_s).contains(&reading.margin);
        is_short && reading.response == Response::LandAt && self.way_home_m(self.base().position).is_none()
    }

    /// Returns the present position and altitude, and 0 s from now.
    fn present(&self) -> (Position, f64, f64) {
        (self.here, self.flown.altitude_m, 0.0)
    }

    /// Returns the time in seconds that remains after a landing at a site, until `before_s` before the mission ends or the site closes. The
    /// flight to the site begins at a position, an altitude and an instant after now, and waits until the site is open.
    fn landed_s(
        &self,
        before_s: f64,
        (from, altitude_m, after_s): (Position, f64, f64),
        site: &LandingSite<'_>,
        detour: f64,
    ) -> f64 {
        let way_s = self.way_s(from, site.position, altitude_m, after_s).map(|way_s| detour * way_s);
        // A storm that leaves the site in time is waited for.
        let spell = self.storm_spell(site);
        let left_s = spell.filter(|spell| spell.from_s <= 0.0).and_then(|spell| spell.until_s).unwrap_or(0.0);
        let way_s = way_s.map(|way_s| way_s.max(left_s - after_s));
        let arrives_s = self.now_s + after_s + way_s.unwrap_or_default();
        let wind_mps = |altitude_m: f64| self.wind_over_mps(site.position, altitude_m, arrives_s);
        let descent_s = Descent::new(&self.mission.model, (altitude_m, site.elevation_m), &wind_mps).time_s;
        mission_end(self.open_s(site, spell) - before_s - after_s, way_s, descent_s).max(-NO_WAY_S)
    }

    /// Returns the time in seconds until the mission ends or the site closes until the end of the mission, whichever is earlier. For a site that has closed
    /// it is 0 if another site is open; otherwise the time until the mission ends, because no better site remains. A storm closes a site
    /// if it is not expected to leave before the mission ends.
    fn open_s(&self, site: &LandingSite<'_>, spell: Option<StormSpell>) -> f64 {
        let left_s = self.mission.settings.duration.seconds() - self.now_s;
        let left_s = match spell {
            Some(StormSpell { from_s, until_s }) if until_s.unwrap_or(f64::INFINITY) >= left_s => match from_s > 0.0 {
                // Farther ahead, the storm may leave before the mission ends.
                true if left_s > AHEAD_S => left_s,
                true => from_s.min(left_s),
                false if self.is_closed_by_storm(site) => 0.0,
                false => left_s,
            },
            _ => left_s,
        };
        let Some(closing) = closing(self.mission, (site.position, site.elevation_m)) else { return left_s };
        match closing.at_s - self.now_s {
            open_s if open_s > 0.0 => open_s.min(left_s),
            _ if self.landing_sites().any(|other| !self.is_shut(&other)) => 0.0,
            _ => left_s,
        }
    }

    /// Returns the landing site that leaves most time, of those outside of restricted zones.
    fn site_of_most_time(&self, before_s: f64) -> Option<(LandingSite<'a>, f64)> {
        let open = self.landing_sites().filter(|site| !self.is_shut(site));
        let sites = open.map(|site| (site, self.landed_s(before_s, self.present(), &site, DETOUR)));
        sites.max_by(|(_, a), (_, b)| a.total_cmp(b))
    }

    /// Returns true if a landing site lies in a restricted zone that is active now.
    pub(super) fn is_shut(&self, site: &LandingSite<'_>) -> bool {
        let restricted = self.mission.zones.iter().filter(|zone| zone.kind == ZoneKind::Restricted);
        restricted.filter(|zone| zone.active.contains(self.now_s)).any(|zone| {
            let is_at_height = (zone.altitude_m_min..=zone.altitude_m_max).contains(&site.elevation_m);
            is_at_height
                && chart_distance_m(site.position, &zone.corners) <= 0.0
                && is_inside(site.position, &zone.corners)
        })
    }

    /// Returns true for a zone around the place at which a contingency lands. A turn away from it would only delay the landing.
    pub(super) fn is_broken_on_purpose(&self, number: usize) -> bool {
        let Some(((place, elevation_m), zone)) = self.landing_at.zip(self.mission.zones.get(number)) else {
            return false;
        };
        (zone.altitude_m_min..=zone.altitude_m_max).contains(&elevation_m) && is_inside(place, &zone.corners)
    }

    /// Returns the time from a position to a place, leaving after `after_s`, in the forecast wind or in the wind as measured, whichever
    /// takes longer. The way is flown at the present altitude, but no higher than cruise, as by the response and in plans. `None` if the
    /// vehicle makes no progress at its fastest.
    fn way_s(&self, from: Position, to: Position, altitude_m: f64, after_s: f64) -> Option<f64> {
        let model = &self.mission.model;
        let altitude_m = altitude_m.min(way_altitude_m_max(model));
        let forecast = |at: Position, at_s: f64| wind::at(self.forecast, at, altitude_m, at_s);
        let correction = self.flown.wind_error.correction();
        let believed = |at: Position, at_s: f64| correction.of(forecast(at, at_s));
        let winds: [WindAt<'_>; 2] = [&forecast, &believed];
        [model.true_airspeed_m_s_cruise, model.true_airspeed_m_s_max].into_iter().find_map(|airspeed_mps| {
            let [forecast_s, believed_s] = leg_times_s(from, to, airspeed_mps, self.now_s + after_s, winds);
            Some(forecast_s?.max(believed_s?))
        })
    }

    /// Returns the speed of the wind over a place: as forecast or as measured, whichever is stronger.
    pub(super) fn wind_over_mps(&self, place: Position, altitude_m: f64, at_s: f64) -> f64 {
        let forecast = wind::at(self.forecast, place, altitude_m, at_s);
        let believed = self.flown.wind_error.correction().of(forecast);
        let speed_mps = |wind: Wind| libm::hypot(wind.east_mps, wind.north_mps);
        speed_mps(forecast).max(speed_mps(believed))
    }

    /// Returns the length of the commanded way if it leads to the base.
    fn way_home_m(&self, base: Position) -> Option<f64> {
        let Some(FlightOrder::FlyBy(points)) = self.order else { return None };
        let near = points.last().filter(|last| geodesy::distance_m(**last, base) <= BASE_M);
        near?;
        let legs = std::iter::once(&self.here).chain(points).zip(points);
        Some(legs.map(|(from, to)| geodesy::distance_m(*from, *to)).sum())
    }

    /// Returns the landing site of the response to a violation: the base, or the site that leaves most time if the base leaves none.
    pub(super) fn site_for_mission_end(&self, reading: &Reading) -> LandingSite<'a> {
        self.landing_sites().find(|site| site.name == reading.what).unwrap_or_else(|| self.base())
    }
}
