//! Where no way keeps every requirement: the least that has to be broken.
//!
//! The order is people on the ground, loss of the aircraft, airspace, mission. So the reach of landing places is abandoned
//! last. Of airspace, that is broken which takes the least time: an end that lies where it is forbidden to be is left, or
//! reached, by the shortest leg; zones that enclose everything are passed through one by one.

use super::limits::Limits;
use super::route::{MARGIN_SHARES, Strictness};
use super::{Broken, Request, Way};
use apex_geo::geodesy;
use apex_geo::plane::{self, Plane, Point};
use apex_geo::travel::{Network, TravelError};
use apex_model::problem::{AirspaceZone, Position, ZoneKind};

/// Distances at which a permitted place is searched: the first, the factor from one to the next, the last.
const LOOK_M_FIRST: f64 = 200.0;
const LOOK_GROWTH: f64 = 1.08;
const LOOK_M_MAX: f64 = 2_000_000.0;
const LOOK_DIRECTIONS: usize = 48;
/// Share of the margins that a way keeps which breaks a requirement already.
const MARGINS_LEFT: f64 = 0.2;

impl Limits {
    /// The way of a request: with every requirement where that can be, else with the least broken. None where it is straight.
    pub(super) fn best_way(&self, request: &Request) -> Option<Way> {
        if self.are_none() || self.is_straight_open(request) {
            return None;
        }
        let mut first = None;
        for margins in MARGIN_SHARES {
            match self.way(request, &Strictness::all(margins)) {
                Ok(way) => return Some(way),
                Err(reason) => first = first.or(Some(reason)),
            }
        }
        let why = first.unwrap_or(TravelError::Shut).to_string();
        let way = self.way_between_permitted_ends(request).or_else(|| self.through_zones(request, &why));
        Some(way.unwrap_or_else(|| self.straight_anyway(request, why)))
    }

    /// By the shortest legs out of where one must not be, and into where one must not go.
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
            .way(&eased, &Strictness::all(0.0))
            .ok()
            .or_else(|| self.way(&eased, &Strictness { turns: false, ..Strictness::all(0.0) }).ok())?;
        let mut via = Vec::new();
        via.extend(begin.iter().map(|(there, _)| *there));
        via.extend(found.via);
        via.extend(end.iter().map(|(there, _)| *there));
        let (name, why) = match (&begin, &end) {
            (Some((_, reason)), _) => (self.name_of(reason), format!("the vehicle is {reason}")),
            (None, Some((_, reason))) => (self.name_of(reason), format!("the place is {reason}")),
            (None, None) => return None,
        };
        Some(Way { via, broken: Some(Broken { name, why }), ..found })
    }

    /// The nearest place to `position` at which it is allowed to be, and why it is not there; within: none where it is.
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
                    // A little farther, so that the way from there has room.
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

    /// Through the zone that takes the least time, or through all of them; last out of the reach of landing places.
    fn through_zones(&self, request: &Request, why: &str) -> Option<Way> {
        let mut names: Vec<String> = Vec::new();
        for zone in &self.zones {
            if !names.contains(&zone.name) {
                names.push(zone.name.clone());
            }
        }
        let mut found: Option<(f64, Way)> = None;
        let mut consider = |without: Vec<String>, name: &str| {
            for turns in [true, false] {
                let strict = Strictness { turns, without: without.clone(), ..Strictness::all(0.0) };
                let Ok(way) = self.way(request, &strict) else { continue };
                let violated_s = self.time_in_s(request, &way, &without);
                let broken = Broken { name: name.to_string(), why: why.to_string() };
                if found.as_ref().is_none_or(|(least_s, _)| violated_s < *least_s) {
                    found = Some((violated_s, Way { broken: Some(broken), ..way }));
                }
                break;
            }
        };
        for name in &names {
            consider(vec![name.clone()], name);
        }
        if found.is_none() {
            let restricted = self.zones.iter().filter(|zone| zone.kind == ZoneKind::Restricted);
            let restricted: Vec<String> = restricted.map(|zone| zone.name.clone()).collect();
            let name = restricted.join(", ");
            let consider = |without: Vec<String>, name: &str| {
                let strict = Strictness { turns: false, without, ..Strictness::all(0.0) };
                let broken = Broken { name: name.to_string(), why: why.to_string() };
                self.way(request, &strict).ok().map(|way| Way { broken: Some(broken), ..way })
            };
            return consider(restricted, &name).or_else(|| consider(names.clone(), &names.join(", "))).or_else(|| {
                let strict = Strictness { turns: false, reach: false, ..Strictness::all(0.0) };
                let broken = Broken { name: "landing distance".to_string(), why: why.to_string() };
                self.way(request, &strict).ok().map(|way| Way { broken: Some(broken), ..way })
            });
        }
        found.map(|(_, way)| way)
    }

    fn straight_anyway(&self, request: &Request, why: String) -> Way {
        let time_s = geodesy::distance_m(request.from, request.to) / self.true_airspeed_mps;
        let broken = Some(Broken { name: "airspace and landing distance".to_string(), why });
        Way { via: Vec::new(), altitude_m: request.to_altitude_m, hold_s: 0.0, hold_around: None, time_s, broken }
    }

    /// How long a way is inside restricted zones of these names, or outside of permitted ones.
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
                "permitted area".to_string()
            }
            TravelError::NoLandingPlace(_) | TravelError::LeavesReach(_) => "landing distance".to_string(),
            TravelError::TooFar | TravelError::NoRoomToTurn | TravelError::Shut => "airspace".to_string(),
        }
    }
}

/// Length of a way on the wrong side of a zone's edges, in pieces of about a kilometre.
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
