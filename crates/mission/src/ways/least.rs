//! Least violation of requirements, if no path keeps all of them.
//!
//! The order of protection is third parties on the ground, loss of the aircraft, airspace, mission; so the reach of landing places is
//! given precedence over airspace. Of airspace, the violation with the least time is chosen: a forbidden start or destination is left or
//! reached by the shortest leg; zones that enclose everything are crossed one by one.

use super::limits::{GROUND, Limits, PERMITTED, TURN_WIDTH};
use super::route::{CIRCLE_ROOM, MARGIN_SHARES, Strictness};
use super::{Broken, Request, Way};
use apex_geo::geodesy;
use apex_geo::plane::{self, Plane, Point};
use apex_geo::travel::{Network, TravelError};
use apex_model::problem::{AirspaceZone, Position, ZoneKind};

/// Greatest detour around weak links: as a multiple of the straight path's time, and in additional seconds.
const WEAK_DETOUR: f64 = 3.0;
const WEAK_DETOUR_S: f64 = 120.0;
/// A way is long if it takes more than this multiple of the straight path's time and these seconds.
const LONG_DETOUR: f64 = 3.0;
const LONG_DETOUR_S: f64 = 30.0;
/// Share of the margins that is nearly the whole: the rest is for errors of the position.
const NEARLY: f64 = 0.9;
/// Distances at which a permitted place is searched: the first, the factor between successive ones, the last.
const LOOK_M_FIRST: f64 = 200.0;
const LOOK_GROWTH: f64 = 1.08;
const LOOK_M_MAX: f64 = 2_000_000.0;
const LOOK_DIRECTIONS: usize = 48;
/// Distance in metres by which wind and turns may move the vehicle off its path at its ends, where no margin is kept.
const EDGE_M: f64 = 500.0;
/// Name of the requirement on the reach of landing places.
const LANDING_DISTANCE: &str = "landing distance";
/// Share of the margins that a path keeps if it violates a requirement anyway.
const MARGINS_LEFT: f64 = 0.2;

impl Limits {
    /// Returns the path of a request, around weak links if that is not much longer: with every requirement if possible, otherwise with
    /// the least violation. `None` if it is straight.
    pub(super) fn best_way(&self, request: &Request) -> Option<Way> {
        match self.way_around_weak_links(request, true) {
            Some(way) => way,
            None if self.are_none() || self.is_straight_open(request) => None,
            None => Some(self.required_way(request)),
        }
    }

    /// Like [`Limits::best_way`], but computes the turns also if the straight path is open: an autopilot's turns onto a line may be wider
    /// than the space that was checked around the straight path. `None` for a mission without requirements.
    pub(super) fn turning_way(&self, request: &Request) -> Option<Way> {
        if self.are_none() {
            return None;
        }
        let around = self.way_around_weak_links(request, false).flatten();
        Some(around.unwrap_or_else(|| self.required_way(request)))
    }

    /// Returns a path that keeps every requirement and avoids weak links; the inner `None` if it is straight and that is permitted.
    fn way_around_weak_links(&self, request: &Request, may_be_straight: bool) -> Option<Option<Way>> {
        let limits = self.around_weak([request.from, request.to])?;
        if may_be_straight && limits.is_straight_open(request) {
            return Some(None);
        }
        let straight_s = geodesy::distance_m(request.from, request.to) / self.true_airspeed_mps;
        let of_use = |way: &Way| way.hold_s + way.time_s <= WEAK_DETOUR * straight_s + WEAK_DETOUR_S;
        let shares = MARGIN_SHARES.iter().filter(|share| **share > 0.0);
        let mut ways = shares.filter_map(|share| limits.way(request, &Strictness::all(*share)).ok());
        ways.next().filter(of_use).map(Some)
    }

    /// Returns a path with turns, ignoring links.
    pub(super) fn required_way(&self, request: &Request) -> Way {
        let mut first = None;
        for margins in MARGIN_SHARES {
            match self.way(request, &Strictness::all(margins)) {
                // Without any margin the wind alone may carry the vehicle across an edge.
                Ok(way) if margins == 0.0 => {
                    let names = self.crossed(request, &way, (EDGE_M, true));
                    let why = "no way keeps a distance from its edge".to_string();
                    let broken = (!names.is_empty()).then_some(Broken { names, why });
                    return Way { broken, ..way };
                }
                Ok(way) if margins == 1.0 => return self.or_nearer(request, way),
                Ok(way) => return way,
                Err(reason) => first = first.or(Some(reason)),
            }
        }
        // An altitude that is changed on the way may meet zones that neither altitude meets.
        let altitude_m = request.to_altitude_m;
        let shares = MARGIN_SHARES.iter().filter(|share| **share > 0.0);
        let mut changed =
            shares.filter_map(|share| self.way_after_change(request, altitude_m, &Strictness::all(*share)).ok());
        if let Some(way) = changed.next() {
            return way;
        }
        if let Some(way) = self.way_to_a_line_at_the_present_altitude(request) {
            return way;
        }
        let why = first.unwrap_or(TravelError::Shut).to_string();
        let way = self.way_without_space_for_circles(request);
        let way = way.or_else(|| self.way_between_permitted_ends(request));
        let way = way.or_else(|| self.through_zones(request, &why));
        way.unwrap_or_else(|| self.straight_anyway(request, why))
    }

    /// Returns the way with nearly the whole margins if `way`, which keeps them, is long and takes more than twice as long: a vehicle
    /// that is a few metres nearer to a corner than planned would fly around another one.
    fn or_nearer(&self, request: &Request, way: Way) -> Way {
        let straight_s = geodesy::distance_m(request.from, request.to) / self.true_airspeed_mps;
        let takes_s = |way: &Way| way.hold_s + way.time_s;
        if takes_s(&way) <= LONG_DETOUR * straight_s + LONG_DETOUR_S {
            return way;
        }
        let nearer = self.way(request, &Strictness::all(NEARLY)).ok();
        nearer.filter(|nearer| 2.0 * takes_s(nearer) < takes_s(&way)).unwrap_or(way)
    }

    /// Returns the path of a vehicle that changes its altitude on circles at its end for which there is no space, with the obstacle.
    fn way_without_space_for_circles(&self, request: &Request) -> Option<Way> {
        let shares = MARGIN_SHARES.iter().filter(|share| **share > 0.0);
        let mut ways = shares.filter_map(|share| self.way(request, &Strictness::without_circles(*share)).ok());
        let way = ways.next()?;
        let around = Request { from: request.to, ..*request };
        let name = self.shut_by(&around, (CIRCLE_ROOM * self.circle_radius_m(), 0.0));
        let why = "no place within reach has room for the circles on which the altitude changes";
        Some(Way { broken: name.map(|name| Broken::one(name, why)), ..way })
    }

    /// Returns the path of a vehicle over or under a zone to a line at another altitude, which it reaches in circles before the line.
    fn way_to_a_line_at_the_present_altitude(&self, request: &Request) -> Option<Way> {
        request.to_track_rad?;
        let shares = MARGIN_SHARES.iter().filter(|share| **share > 0.0);
        let mut ways =
            shares.filter_map(|share| self.way_at(request, request.from_altitude_m, &Strictness::all(*share)).ok());
        ways.next()
    }

    /// Returns the path with its violations: the requirements that the search ignored, and every zone that the path crosses. Where the
    /// vehicle chooses its turns itself, every zone near them counts.
    fn breaking(&self, request: &Request, way: Way, (ignored, why): (&[String], &str), has_turns: bool) -> Way {
        let clearance_m = TURN_WIDTH * self.turn_radius_m_over_ground();
        let mut names: Vec<String> = Vec::new();
        for name in ignored.iter().cloned().chain(self.crossed(request, &way, (clearance_m, has_turns))) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        if names.is_empty() {
            names.push(self.unnamed_limit().to_string());
        }
        Way { broken: Some(Broken { names, why: why.to_string() }), ..way }
    }

    /// Returns the path with the shortest legs out of and into forbidden space at its ends.
    fn way_between_permitted_ends(&self, request: &Request) -> Option<Way> {
        let strict = Strictness::all(MARGINS_LEFT);
        let low_m = request.from_altitude_m.min(request.to_altitude_m);
        let high_m = request.from_altitude_m.max(request.to_altitude_m);
        let mut network = self.network(request, (low_m, high_m, request.to_altitude_m), &strict).ok()?;
        let begin = self.nearest_permitted(&mut network, request.from, request.at_s)?;
        let lasts_s = geodesy::distance_m(request.from, request.to) / self.true_airspeed_mps;
        let end = self.nearest_permitted(&mut network, request.to, request.at_s + lasts_s)?;
        if begin.is_none() && end.is_none() {
            return None;
        }
        let track_rad = |from: Position, to: Position| geodesy::azimuth_deg(from, to).to_radians();
        let mut eased = *request;
        if let Some((there, _)) = &begin {
            eased.from = *there;
            eased.from_track_rad = request.from_track_rad.map(|_| track_rad(request.from, *there));
        }
        if let Some((there, _)) = &end {
            eased.to = *there;
            eased.to_track_rad = None;
        }
        let found = self
            .way(&eased, &Strictness::without_circles(0.0))
            .ok()
            .or_else(|| self.way(&eased, &Strictness { turns: false, ..Strictness::without_circles(0.0) }).ok())?;
        let mut via = Vec::new();
        via.extend(begin.iter().map(|(there, _)| *there));
        via.extend(found.via);
        via.extend(end.iter().map(|(there, _)| *there));
        let (name, why) = match (&begin, &end) {
            (Some((_, reason)), _) => (self.name_of(reason), format!("the vehicle is {reason}")),
            (None, Some((_, reason))) => (self.name_of(reason), format!("the place is {reason}")),
            (None, None) => return None,
        };
        Some(self.breaking(request, Way { via, ..found }, (&[name], &why), false))
    }

    /// Returns the nearest permitted place to `position`, and the reason for which `position` is not permitted; the inner `None` if it
    /// is.
    fn nearest_permitted(
        &self,
        network: &mut Network,
        position: Position,
        at_s: f64,
    ) -> Option<Option<(Position, TravelError)>> {
        let mut trouble_at = |position: Position| match network.add(position) {
            Ok(place) => network.place_trouble(place, (at_s, at_s)),
            Err(reason) => Some(reason),
        };
        let Some(reason) = trouble_at(position) else { return Some(None) };
        let mut distance_m = LOOK_M_FIRST;
        while distance_m < LOOK_M_MAX {
            for index in 0..LOOK_DIRECTIONS {
                let azimuth_deg = 360.0 * index as f64 / LOOK_DIRECTIONS as f64;
                let there = geodesy::destination(position, azimuth_deg, distance_m);
                if trouble_at(there).is_none() {
                    // A little farther, so that the path from there has clearance.
                    let on_m = distance_m + 100.0;
                    let on = geodesy::destination(position, azimuth_deg, on_m);
                    let there = if trouble_at(on).is_none() { on } else { there };
                    return Some(Some((there, reason)));
                }
            }
            distance_m *= LOOK_GROWTH;
        }
        None
    }

    /// Returns the fastest path through the zone, or through all of them; as a last resort beyond the reach of landing places.
    fn through_zones(&self, request: &Request, why: &str) -> Option<Way> {
        let mut names: Vec<String> = Vec::new();
        for zone in &self.zones {
            if !names.contains(&zone.name) {
                names.push(zone.name.clone());
            }
        }
        let without = |without: Vec<String>, turns: bool| {
            self.way(request, &Strictness { turns, without, ..Strictness::without_circles(0.0) }).ok()
        };
        let through_one = |turns: bool| {
            let ways = names.iter().filter_map(|name| {
                let way = without(vec![name.clone()], turns)?;
                Some((self.time_in_s(request, &way, std::slice::from_ref(name)), name, way))
            });
            let least = ways.min_by(|(a_s, ..), (b_s, ..)| a_s.total_cmp(b_s));
            least.map(|(_, name, way)| self.breaking(request, way, (std::slice::from_ref(name), why), turns))
        };
        let restricted = self.zones.iter().filter(|zone| zone.kind == ZoneKind::Restricted);
        let restricted: Vec<String> = restricted.map(|zone| zone.name.clone()).collect();
        let through_all =
            |of: &[String]| without(of.to_vec(), false).map(|way| self.breaking(request, way, (of, why), false));
        through_one(true)
            // Only the turns lack clearance: the vehicle turns where it can.
            .or_else(|| through_all(&[]))
            .or_else(|| through_one(false))
            .or_else(|| through_all(&restricted))
            .or_else(|| through_all(&names))
            .or_else(|| {
                let strict = Strictness { turns: false, reach: false, ..Strictness::without_circles(0.0) };
                let way = self.way(request, &strict).ok()?;
                Some(self.breaking(request, way, (&[LANDING_DISTANCE.to_string()], why), false))
            })
    }

    fn straight_anyway(&self, request: &Request, why: String) -> Way {
        let time_s = geodesy::distance_m(request.from, request.to) / self.true_airspeed_mps;
        let altitude_m = request.to_altitude_m;
        let way = Way { via: Vec::new(), altitude_m, hold_s: 0.0, hold_around: None, time_s, broken: None };
        let lowest_m = request.from_altitude_m.min(request.to_altitude_m);
        let is_low = lowest_m < self.lowest_altitude_m(&[request.from, request.to], (request.from, request.to), 1.0);
        let name = if is_low { GROUND } else { LANDING_DISTANCE };
        self.breaking(request, way, (&[name.to_string()], &why), false)
    }

    /// Returns the time that a path spends inside restricted zones of these names, or outside of permitted ones.
    fn time_in_s(&self, request: &Request, way: &Way, names: &[String]) -> f64 {
        let mut points = vec![request.from];
        points.extend_from_slice(&way.via);
        points.push(request.to);
        let zones = self.zones.iter().filter(|zone| names.contains(&zone.name));
        let metres: f64 = zones.map(|zone| metres_against(zone, &points)).sum();
        metres / self.true_airspeed_mps
    }

    pub(super) fn name_of(&self, reason: &TravelError) -> String {
        match reason {
            TravelError::Inside(name) | TravelError::Crosses(name) | TravelError::LegCrosses(name) => name.clone(),
            TravelError::Outside | TravelError::LeavesPermitted | TravelError::LegLeavesPermitted => {
                PERMITTED.to_string()
            }
            TravelError::NoLandingPlace(_) | TravelError::LeavesReach(_) => LANDING_DISTANCE.to_string(),
            TravelError::Ground(_) => GROUND.to_string(),
            TravelError::TooFar | TravelError::NoRoomToTurn | TravelError::Shut => self.unnamed_limit().to_string(),
        }
    }

    /// Returns the name of a violation whose reason names no obstacle, such as too little space for turns: of the limits that exist.
    fn unnamed_limit(&self) -> &'static str {
        match (self.zones.is_empty(), self.terrain.is_some()) {
            (true, true) => GROUND,
            (true, false) if self.landing_distance_m_max.is_some() => LANDING_DISTANCE,
            _ => "airspace",
        }
    }
}

/// Returns the length of a way on the wrong side of a zone's edges, in pieces of about a kilometre.
fn metres_against(zone: &AirspaceZone, points: &[Position]) -> f64 {
    let plane = Plane::around(&zone.corners);
    let corners: Vec<Point> = zone.corners.iter().filter_map(|corner| plane.project(*corner)).collect();
    let wrong_inside = zone.kind == ZoneKind::Restricted;
    let legs = points.iter().zip(points.iter().skip(1));
    legs.map(|(from, to)| {
        let length_m = geodesy::distance_m(*from, *to);
        let pieces = libm::ceil(length_m / 1_000.0).clamp(1.0, 5_000.0);
        let wrong = (0..pieces as usize).filter(|piece| {
            let middle = geodesy::interpolate(*from, *to, (*piece as f64 + 0.5) / pieces);
            plane.project(middle).is_some_and(|point| plane::inside(point, &corners)) == wrong_inside
        });
        wrong.count() as f64 * length_m / pieces
    })
    .sum()
}
