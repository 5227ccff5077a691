//! One reading for each requirement: its present margin, and the time until the commanded route violates it.

use super::commanded::{Commanded, FlightOrder, Flown};
use super::commanded_route::{Circling, along, chart_distance_m, is_joining};
use super::response::Response;
use super::statement::Requirements;
use crate::link::LinkMemory;
use crate::storm::StormMemory;
use crate::vehicle::{Airframe, turn_radius_m};
use crate::ways::STRAIGHT_CLIMB_M;
use crate::{Mission, TargetKind};
use apex_geo::geodesy::{self, Position};
use apex_geo::plane::{Plane, Point};
use apex_geo::wind::{self, triangle};
use apex_model::problem::WindField;
use apex_model::quantity::Dimension;
use apex_requirements::margin::weather;
use apex_requirements::margin::zone::{KeepIn, LocalZone, ZoneBuffer};
use apex_requirements::prediction::active_span;
use apex_requirements::response::turn_away_s;
use apex_requirements::{Concern, Motion, Route, first_violation};
use std::cell::OnceCell;

/// A requirement compared with the flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Concern of the requirement: its rank among others.
    pub concern: Concern,
    /// Name of the requirement in PDL.
    pub name: &'static str,
    /// Margin in SI units; negative: violated now.
    pub margin: f64,
    /// Unit of the margin.
    pub unit: Dimension,
    /// Seconds until the commanded route violates it; `None` if not within the look-ahead.
    pub after_s: Option<f64>,
    /// Duration of the response, s.
    pub response_s: f64,
    /// Subject of the violation: a zone, a landing place, or the requirement itself.
    pub what: String,
    /// Response if the requirement is at risk.
    pub response: Response,
}

/// Greatest reported margin: obstacles farther away are not searched.
pub(super) const DISTANCE_M_MAX: f64 = 50_000.0;
/// Time for which a vehicle that turns onto a line is predicted straight ahead, s.
const AHEAD_S: f64 = 120.0;
/// Error of the speed along the route, as a share.
const SPEED_ERROR: f64 = 0.05;
/// Time from the command to the full bank.
const ROLL_IN_S: f64 = 3.0;
/// Interval between samples of the route for quantities that change slowly.
const COARSE_S: f64 = 30.0;
/// A site that is this factor farther on the chart than the nearest one is also farther in truth ..
const CHART_FACTOR: f64 = 1.3;
/// .. for a nearest site within this angle, and up to this latitude: the error of the chart is at most 10 % there.
const CHART_DEG_MAX: f64 = 5.0;
const CHART_LATITUDE_DEG_MAX: f64 = 60.0;

/// A place to land.
#[derive(Clone, Copy, Debug)]
pub(super) struct LandingSite<'a> {
    pub(super) name: &'a str,
    pub(super) position: Position,
    pub(super) elevation_m: f64,
}

/// The mission, the assumed wind, and the knowledge about links and storms.
pub(super) type Known<'a> = (&'a Mission, &'a WindField, &'a LinkMemory, &'a StormMemory);

/// Everything that readings are computed from.
pub(super) struct Scene<'a> {
    pub(super) mission: &'a Mission,
    pub(super) forecast: &'a WindField,
    pub(super) flown: &'a Flown,
    pub(super) links: &'a LinkMemory,
    pub(super) storms: &'a StormMemory,
    pub(super) here: Position,
    pub(super) now_s: f64,
    pub(super) plane: Plane,
    pub(super) motion: Motion,
    pub(super) route: Route,
    /// Straight ahead, for a vehicle that turns onto a line as its autopilot chooses, which may lead it away from the line first.
    ahead: Option<Route>,
    /// The flight command that is open.
    pub(super) order: Option<&'a FlightOrder>,
    /// Place at which a contingency lands, with its elevation.
    pub(super) landing_at: Option<(Position, f64)>,
    /// The way from here to the nearest landing site, once a reading has asked for it.
    way_from_here: OnceCell<WayToSite<'a>>,
}

/// A landing site with the length (m) and the azimuth (degrees) of the geodesic to it.
type WayToSite<'a> = (LandingSite<'a>, (f64, f64));

impl<'a> Scene<'a> {
    /// Returns the scene at `now_s`; `None` before the first position.
    pub(super) fn new(
        (mission, forecast, links, storms): Known<'a>,
        flown: &'a Flown,
        commanded: &'a Commanded,
        now_s: f64,
    ) -> Option<Scene<'a>> {
        let here = flown.position?;
        let model = &mission.model;
        let plane = Plane::new(here);
        let blowing = wind::at(forecast, here, flown.altitude_m, now_s);
        let speed_mps = commanded.true_airspeed_mps.or(flown.true_airspeed_mps.filter(|speed| *speed > 1.0));
        // In thin air the slowest speed exceeds that of cruise, and turns are wider.
        let faster = flown.true_airspeed_mps.map_or(1.0, |speed| speed / model.true_airspeed_m_s_cruise).max(1.0);
        let motion = Motion {
            true_airspeed_mps: speed_mps.unwrap_or(model.true_airspeed_m_s_cruise),
            wind: blowing,
            turn_radius_m: turn_radius_m(model) * faster * faster,
            // The climb rate falls with the altitude.
            climb_mps: (model.climb_rate_m_s_max * model.planning.climb_share)
                .min(model.climb().rate_m_s(flown.altitude_m)),
            descent_mps: model.descent_rate_m_s_max,
        };
        let track_rad = flown.track_deg().to_radians();
        let track = Point { x: libm::sin(track_rad), y: libm::cos(track_rad) };
        let altitude_m = (flown.altitude_m, commanded.altitude_m().unwrap_or(flown.altitude_m));
        let begin = Route::begin(Point::default(), track, altitude_m, motion);
        let (widening, fastest_mps) = wider(&motion, flown.wind_mps);
        let turn_radius_m = motion.turn_radius_m * widening;
        let order = commanded.order_at(now_s);
        let is_joining = motion.turn_radius_m > 0.0 && order.is_some_and(|order| is_joining(&begin, order, &plane));
        let ahead = is_joining.then(|| {
            let there = Point::default().plus(AHEAD_S * motion.true_airspeed_mps, track);
            begin.clone().straight(there)
        });
        let circling = Circling {
            centre: commanded.circle(),
            radius_m: model.turns.circle_width * turn_radius_m,
            join_m: (JOIN_WIDTH * turn_radius_m, JOIN_LEAD_IN_S * fastest_mps),
            straight_m: straight_climb_m(&motion, flown),
        };
        let route = along(begin, order, &plane, &circling, mission.requirements.look_ahead_s);
        let way_from_here = OnceCell::new();
        let order = commanded.order.as_ref();
        let landing_at = commanded.landing_at;
        Some(Scene {
            mission,
            forecast,
            flown,
            links,
            storms,
            here,
            now_s,
            plane,
            motion,
            route,
            ahead,
            order,
            landing_at,
            way_from_here,
        })
    }

    pub(super) fn requirements(&self) -> &'a Requirements {
        &self.mission.requirements
    }

    /// Returns true for a fixed wing on the straight climb after a take-off.
    pub(super) fn climbs_from_the_ground(&self) -> bool {
        let takes_off = matches!(self.order, Some(FlightOrder::TakeOff(_)));
        let is_low = self.flown.height_above_ground_m.is_some_and(|height_m| height_m < STRAIGHT_CLIMB_M);
        takes_off && is_low && self.mission.model.airframe == Airframe::FixedWing
    }

    /// Returns the routes that the vehicle may fly.
    pub(super) fn routes(&self) -> impl Iterator<Item = &Route> {
        std::iter::once(&self.route).chain(&self.ahead)
    }

    /// Returns true if the autopilot of the vehicle turns onto a line by a way of its choice.
    pub(super) fn is_joining(&self) -> bool {
        self.ahead.is_some()
    }

    /// Returns the landing places: airfields and bases.
    pub(super) fn landing_sites(&self) -> impl Iterator<Item = LandingSite<'a>> + use<'a> {
        let mission = self.mission;
        let airfields = mission.airfields.iter().map(|airfield| LandingSite {
            name: &airfield.id,
            position: airfield.position,
            elevation_m: airfield.elevation_m,
        });
        let bases = mission.targets.iter().filter(|target| matches!(target.kind, TargetKind::Base));
        let bases =
            bases.map(|base| LandingSite { name: &base.id, position: base.position, elevation_m: base.elevation_m });
        airfields.chain(bases)
    }

    /// Returns the base: the landing site at the start, or the start itself.
    pub(super) fn base(&self) -> LandingSite<'a> {
        self.landing_sites().find(|site| site.position == self.mission.start).unwrap_or_else(|| self.start())
    }

    /// Returns the start as a place to land, for missions that name no other.
    fn start(&self) -> LandingSite<'a> {
        let mission = self.mission;
        LandingSite { name: "start", position: mission.start, elevation_m: mission.start_altitude_m }
    }

    /// Returns the nearest landing site to a position, with its distance; the start if the mission has none.
    pub(super) fn nearest_site(&self, position: Position) -> (LandingSite<'a>, f64) {
        let (site, (distance_m, _)) = self.way_to_site(position);
        (site, distance_m)
    }

    /// Returns the nearest landing site to a position, with the length and the azimuth of the geodesic to it.
    pub(super) fn way_to_site(&self, position: Position) -> WayToSite<'a> {
        if position == self.here {
            return *self.way_from_here.get_or_init(|| self.find_site(position));
        }
        self.find_site(position)
    }

    fn find_site(&self, position: Position) -> WayToSite<'a> {
        // Sites are sorted on a plane chart first, because geodesics are expensive; the nearest three are compared exactly.
        let east = libm::cos(position.latitude_deg.to_radians());
        let chart = |site: &LandingSite<'_>| {
            let north_deg = site.position.latitude_deg - position.latitude_deg;
            let east_deg = geodesy::wrap_180(site.position.longitude_deg - position.longitude_deg) * east;
            north_deg * north_deg + east_deg * east_deg
        };
        let mut best: [Option<(f64, LandingSite<'_>)>; 3] = [None; 3];
        for site in self.landing_sites() {
            let mut entry = (chart(&site), site);
            for slot in &mut best {
                match slot {
                    Some(other) if other.0 <= entry.0 => {}
                    Some(other) => std::mem::swap(other, &mut entry),
                    None => {
                        *slot = Some(entry);
                        break;
                    }
                }
            }
        }
        let way = |site: LandingSite<'a>| (site, geodesy::inverse(position, site.position));
        let nearest = best.first().copied().flatten().map_or(f64::INFINITY, |(squared, _)| squared);
        let is_exact =
            nearest <= CHART_DEG_MAX * CHART_DEG_MAX && position.latitude_deg.abs() <= CHART_LATITUDE_DEG_MAX;
        let limit = if is_exact { CHART_FACTOR * CHART_FACTOR * nearest } else { f64::INFINITY };
        let near = best.into_iter().flatten().filter(|(squared, _)| *squared <= limit);
        near.map(|(_, site)| way(site))
            .min_by(|(_, a), (_, b)| a.0.total_cmp(&b.0))
            .unwrap_or_else(|| way(self.start()))
    }

    /// Returns the ground speed on a track.
    pub(super) fn ground_speed_mps(&self, track_deg: f64, airspeed_mps: f64) -> f64 {
        triangle(track_deg, airspeed_mps, self.motion.wind).map_or(0.0, |found| found.ground_speed_mps)
    }

    /// Returns the speed of the wind that the scene assumes, for turns.
    fn wind_mps(&self) -> f64 {
        libm::hypot(self.motion.wind.east_mps, self.motion.wind.north_mps)
    }

    pub(super) fn turn_away_s(&self) -> f64 {
        let roll_in_s = if self.motion.turn_radius_m > 0.0 { ROLL_IN_S } else { 0.0 };
        let turn_s = turn_away_s(self.motion.true_airspeed_mps, self.motion.turn_radius_m, self.wind_mps(), roll_in_s);
        let model = &self.mission.model;
        match model.airframe {
            Airframe::FixedWing => turn_s,
            Airframe::Rotorcraft => {
                let braking_m_s2 = model.braking_share * model.acceleration_m_s2_max;
                apex_requirements::response::stop_s(self.flown.ground_speed_mps.unwrap_or(0.0), braking_m_s2)
            }
        }
    }

    /// Returns the first instant with a negative margin; samples the route every [`COARSE_S`] from now to its end or the look-ahead.
    pub(super) fn first_below(&self, margin: impl FnMut(&apex_requirements::RouteState) -> f64) -> Option<f64> {
        let mut margin = margin;
        let until_s = self.route.end_s().min(self.requirements().look_ahead_s);
        let count = (until_s / COARSE_S) as u32 + 1;
        let instants = (0..=count).map(|number| (f64::from(number) * COARSE_S).min(until_s));
        instants
            .filter_map(|after_s| self.route.at(after_s))
            .find(|state| margin(state) < 0.0)
            .map(|state| state.after_s)
    }

    /// Returns the readings of all requirements that the mission states and the vehicle's reports allow, most important first.
    pub(super) fn readings(&self) -> Vec<Reading> {
        let flight = [self.terrain(), self.energy(), self.landing(), self.airspace(), self.turbulence(), self.wind()];
        let all = flight.into_iter().chain([self.icing(), self.mission_end(), self.link(), self.heat(), self.sun()]);
        all.flatten().collect()
    }

    /// Returns the zones on the plane that the vehicle can reach within the look-ahead, and a lower bound of the distance to all others.
    pub(super) fn near_zones(&self) -> (Vec<LocalZone>, f64) {
        let reach_m = self.route.speed_mps_max().max(self.motion.true_airspeed_mps) * self.requirements().look_ahead_s;
        let reach_m = reach_m.max(DISTANCE_M_MAX);
        let (mut near, mut far_m) = (Vec::new(), f64::INFINITY);
        for (number, zone) in self.mission.zones.iter().enumerate() {
            let is_permitted = zone.kind == apex_model::problem::ZoneKind::Permitted;
            let least_m = chart_distance_m(self.here, &zone.corners);
            if is_permitted || least_m <= reach_m {
                near.extend(LocalZone::new(number, zone, &self.plane));
            } else {
                far_m = far_m.min(least_m);
            }
        }
        (near, far_m)
    }

    fn airspace(&self) -> Option<Reading> {
        let buffer = self.requirements().airspace?;
        let (zones, far_m) = self.near_zones();
        if self.mission.zones.is_empty() {
            return None;
        }
        let look_ahead_s = self.requirements().look_ahead_s;
        let mut margin = (far_m - buffer.horizontal_m).min(DISTANCE_M_MAX);
        let mut what = None;
        let mut first: Option<(f64, usize)> = None;
        for zone in zones.iter().filter(|zone| zone.is_restricted() && !self.is_broken_on_purpose(zone.number)) {
            if zone.is_active(self.now_s) {
                let here_m = zone.keep_out_m(Point::default(), self.flown.altitude_m, &buffer);
                if here_m < margin {
                    (margin, what) = (here_m, Some(zone.number));
                }
            }
            let entries = self
                .routes()
                .filter_map(|route| zone.first_entry(route, &buffer, self.now_s, SPEED_ERROR, look_ahead_s));
            for entry in entries {
                if first.is_none_or(|(first_s, _)| entry.after_s < first_s) {
                    first = Some((entry.after_s, zone.number));
                }
            }
        }
        let (inside_m, leaves_s) = self.keep_in(&zones, &buffer);
        let permitted = zones.iter().find(|zone| !zone.is_restricted()).map(|zone| zone.number);
        if inside_m < margin {
            (margin, what) = (inside_m, permitted);
        }
        if let Some(leaves_s) = leaves_s
            && first.is_none_or(|(first_s, _)| leaves_s < first_s)
        {
            first = permitted.map(|number| (leaves_s, number));
        }
        let number = first.map(|(_, number)| number).or(what);
        let zone = number.and_then(|number| self.mission.zones.get(number));
        Some(Reading {
            concern: Concern::Airspace,
            name: "airspace",
            margin,
            unit: Dimension::LENGTH,
            after_s: first.map(|(after_s, _)| after_s),
            response_s: self.turn_away_s(),
            what: zone.map_or_else(|| "airspace".to_string(), |zone| zone.name.clone()),
            response: Response::TurnAway,
        })
    }

    /// Returns the margin inside the permitted area, and the time at which the route leaves it.
    fn keep_in(&self, zones: &[LocalZone], buffer: &ZoneBuffer) -> (f64, Option<f64>) {
        let Some(area) = KeepIn::new(zones, self.flown.altitude_m, self.now_s) else { return (f64::INFINITY, None) };
        let inside_m = area.keep_in_m(Point::default(), self.flown.altitude_m, buffer);
        // The permitted area may change along the path.
        let look_ahead_s = self.requirements().look_ahead_s;
        let permitted = self.mission.zones.iter().filter(|zone| zone.kind == apex_model::problem::ZoneKind::Permitted);
        let mut changes_s: Vec<f64> = permitted.flat_map(|zone| [zone.active.from_s, zone.active.until_s]).collect();
        changes_s.retain(|at_s| *at_s > self.now_s && *at_s < self.now_s + look_ahead_s);
        changes_s.push(self.now_s + look_ahead_s);
        changes_s.sort_by(f64::total_cmp);
        let mut from_s = self.now_s;
        // Until the first change the area is the present one.
        let mut present = Some(area);
        for until_s in changes_s {
            let span = active_span((from_s, until_s), self.now_s, 0.0, 0.0, look_ahead_s);
            let later = || KeepIn::new(zones, self.flown.altitude_m, 0.5 * (from_s + until_s));
            let area = present.take().or_else(later);
            if let Some((span, area)) = span.zip(area) {
                let left = first_violation(&self.route, span, self.route.speed_mps_max(), |state| {
                    area.keep_in_m(state.point, state.altitude_m, buffer)
                });
                if let Some(left) = left {
                    return (inside_m, Some(left.after_s));
                }
            }
            from_s = until_s;
        }
        (inside_m, None)
    }

    fn turbulence(&self) -> Option<Reading> {
        let most = self.requirements().edr_max?;
        let margin = weather::turbulence_edr(self.flown.edr?, most);
        let ahead = self.first_below(|state| {
            let there =
                wind::at(self.forecast, self.plane.position(state.point), state.altitude_m, self.now_s + state.after_s);
            weather::turbulence_edr(there.edr, most)
        });
        Some(self.weather("turbulence", margin, Dimension::NONE, ahead))
    }

    fn wind(&self) -> Option<Reading> {
        let most_mps = self.requirements().wind_mps_max?;
        let margin = weather::wind_mps(self.flown.wind_mps?, 0.0, most_mps);
        let ahead = self.first_below(|state| {
            let there =
                wind::at(self.forecast, self.plane.position(state.point), state.altitude_m, self.now_s + state.after_s);
            weather::wind_mps(libm::hypot(there.east_mps, there.north_mps), 0.0, most_mps)
        });
        Some(self.weather("wind", margin, Dimension::SPEED, ahead))
    }

    fn weather(&self, name: &'static str, margin: f64, unit: Dimension, after_s: Option<f64>) -> Reading {
        // The present measurement counts; a forecast that contradicts it does not.
        let after_s = if margin >= 0.0 { after_s.filter(|after_s| *after_s > 0.0) } else { Some(0.0) };
        let (what, response) = (name.to_string(), Response::Descend);
        Reading {
            concern: Concern::Weather,
            name,
            margin,
            unit,
            after_s,
            response_s: self.turn_away_s(),
            what,
            response,
        }
    }
}

/// Radius of the turn onto a line as a multiple of that of the tightest planned turn, and the time from there to the line, of autopilots.
const JOIN_WIDTH: f64 = 1.1;
const JOIN_LEAD_IN_S: f64 = 16.0;

/// Returns the radius over ground of a circle in the wind, forecast or measured, as a multiple of that in still air, and the greatest speed
/// over ground.
fn wider(motion: &Motion, measured_mps: Option<f64>) -> (f64, f64) {
    let forecast_mps = libm::hypot(motion.wind.east_mps, motion.wind.north_mps);
    let fastest_mps = motion.true_airspeed_mps + forecast_mps.max(measured_mps.unwrap_or(0.0));
    let share = fastest_mps / motion.true_airspeed_mps;
    (share * share, fastest_mps)
}

/// Returns the length of the straight flight until a vehicle that takes off begins to turn.
fn straight_climb_m(motion: &Motion, flown: &Flown) -> f64 {
    let left_m = STRAIGHT_CLIMB_M - flown.height_above_ground_m.unwrap_or(STRAIGHT_CLIMB_M);
    left_m.max(0.0) / motion.climb_mps.max(1.0) * flown.ground_speed_mps.unwrap_or(motion.true_airspeed_mps)
}
