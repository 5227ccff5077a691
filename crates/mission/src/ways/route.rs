//! Paths around, over and under zones, through the travel network.

use super::limits::{GROUND, Limits};
use super::straight::{LATE_S, LATE_SHARE};
use super::{Request, Way};
use apex_geo::geodesy;
use apex_geo::plane::{self, Plane, Point};
use apex_geo::travel::{Air, Network, Setting, TravelError, crossing};
use apex_model::problem::{AirspaceZone, Position, TimeWindow, ZoneKind};

/// Requirements that a search keeps.
#[derive(Clone, Debug)]
pub(super) struct Strictness {
    /// Share of the margins.
    pub(super) margins: f64,
    /// True if turns are computed with their radius.
    pub(super) turns: bool,
    /// True if changes of altitude for which a way is too short need space for their circles.
    pub(super) circles: bool,
    /// True if landing places must be in reach.
    pub(super) reach: bool,
    /// True if zones do not count that the vehicle cannot reach before it has climbed above them or descended below them, because it changes
    /// its altitude as soon as it leaves. Plans count on it.
    pub(super) early_change: bool,
    /// Zones that do not count.
    pub(super) without: Vec<String>,
}

impl Strictness {
    /// Returns every requirement, with this share of the margins.
    pub(super) fn all(margins: f64) -> Strictness {
        Strictness { margins, turns: true, circles: true, reach: true, early_change: false, without: Vec::new() }
    }

    /// Returns every requirement except for space for changes of altitude, with this share of the margins.
    pub(super) fn without_circles(margins: f64) -> Strictness {
        Strictness { circles: false, ..Strictness::all(margins) }
    }
}

/// Place of the circles on which a vehicle changes its altitude.
#[derive(Clone, Copy, Debug, PartialEq)]
enum PlaceOfChange {
    /// The vehicle's position, for so many seconds; the rest on the way and at its end.
    Here(f64),
    /// This centre, until the altitude is reached.
    Around(Position),
}

/// Shares of the margins that are tried in sequence.
pub(super) const MARGIN_SHARES: [f64; 4] = [1.0, 0.5, 0.2, 0.0];
/// Points of a turn are left out while the course changes by less than this angle.
const CHORD_DEG: f64 = 15.0;
/// Room for a circle that begins in its middle, as a multiple of its radius.
pub(super) const CIRCLE_ROOM: f64 = 2.2;
/// Duration in seconds below which a wait is ignored: a circle would take longer.
pub(super) const HOLD_S_MIN: f64 = 5.0;
/// Zones count from this many seconds before their active time until as many seconds after it.
const EARLY_S: f64 = 120.0;

impl Limits {
    /// Returns the fastest path at any of the candidate altitudes.
    ///
    /// # Errors
    /// The reason for which no path exists at the altitude of the place.
    pub(super) fn way(&self, request: &Request, strict: &Strictness) -> Result<Way, TravelError> {
        let mut found: Option<Way> = None;
        let mut trouble = None;
        // The ground under a detour around zones may be higher than that under the straight leg.
        let mut over_ground_m: Option<f64> = None;
        for altitude_m in self.altitudes_m(request) {
            let way = self.way_by_change(request, altitude_m, strict);
            match way {
                Ok(way) if found.as_ref().is_none_or(|best| cost_s(&way) < cost_s(best)) => found = Some(way),
                Ok(_) => {}
                Err(reason) => {
                    if let TravelError::Ground(needs_m) = reason {
                        over_ground_m = Some(over_ground_m.map_or(needs_m, |known_m| known_m.max(needs_m)));
                    }
                    trouble = trouble.or(Some(reason));
                }
            }
            // Other altitudes are only examined if the path at the altitude of the place is long.
            if let Some(way) = &found
                && way.altitude_m == request.to_altitude_m
                && self.is_nearly_straight(request, way)
            {
                break;
            }
        }
        let higher_m = over_ground_m.filter(|needs_m| found.is_none() && *needs_m <= self.altitude_m_max);
        let found = found.or_else(|| self.way_at(request, higher_m?, strict).ok());
        found.ok_or(trouble.unwrap_or(TravelError::Shut))
    }

    /// Returns the fastest way through open airspace: turns in the wind, and a straight leg between them.
    pub(super) fn open_way(&self, request: &Request) -> Option<Way> {
        let without = self.zones.iter().map(|zone| zone.name.clone()).collect();
        let strict = Strictness { reach: false, without, ..Strictness::without_circles(1.0) };
        self.way_at(request, request.to_altitude_m, &strict).ok()
    }

    fn is_nearly_straight(&self, request: &Request, way: &Way) -> bool {
        let straight_s = geodesy::distance_m(request.from, request.to) / self.true_airspeed_mps;
        way.hold_s <= 0.0 && way.time_s < 1.1 * straight_s + 120.0
    }

    /// Returns the candidate altitudes: that of the place, the present one, and those just above and below zones in between.
    fn altitudes_m(&self, request: &Request) -> Vec<f64> {
        let lowest_m = self.lowest_altitude_m(&[request.from, request.to], (request.from, request.to), 1.0);
        let floor_m = self.elevation_m_at(request.from).max(self.elevation_m_at(request.to)) + self.ground_margin_m;
        let above_m = self.above_zone_m;
        let edges = self
            .zones
            .iter()
            .flat_map(|zone| [zone.altitude_m_min - 2.0 * above_m, zone.altitude_m_max + 2.0 * above_m]);
        let of_use = |altitude_m: &f64| {
            let low_m = floor_m.max(lowest_m);
            (low_m..=self.altitude_m_max).contains(altitude_m)
        };
        let mut altitudes_m = vec![request.to_altitude_m];
        if request.to_track_rad.is_some() {
            // A line is joined at its own altitude; if the ground in between is higher, the path to it is flown higher.
            altitudes_m.extend((self.terrain.is_some() && lowest_m > request.to_altitude_m).then_some(lowest_m));
            return altitudes_m;
        }
        let others = std::iter::once(request.from_altitude_m).chain(edges).chain([lowest_m]);
        altitudes_m.extend(others.filter(of_use));
        let mut unique_m: Vec<f64> = Vec::new();
        for altitude_m in altitudes_m {
            if !unique_m.iter().any(|known_m| (known_m - altitude_m).abs() < 1.0) {
                unique_m.push(altitude_m);
            }
        }
        unique_m
    }

    /// Returns the place of the circles on which the vehicle changes its altitude if its way, which takes `way_s`, is too short for that.
    /// It circles before it leaves for as long as plans count, if there is space, and for the rest at the end.
    ///
    /// # Errors
    /// No place within reach has space for them.
    fn place_of_change(
        &self,
        request: &Request,
        (altitude_m, way_s): (f64, f64),
        strict: &Strictness,
    ) -> Result<PlaceOfChange, TravelError> {
        let change = (request.from_altitude_m, altitude_m);
        // A line is met at its altitude, and a place, too; on a circle the vehicle continues to climb or descend.
        let must_be_level =
            request.to_track_rad.is_some() || (self.turn_radius_m > 0.0 && request.circle_radius_m == 0.0);
        let short_s = self.change_s(change.0, change.1) - way_s;
        if !must_be_level || short_s <= 0.0 {
            return Ok(PlaceOfChange::Here(0.0));
        }
        let room_m = CIRCLE_ROOM * self.circle_radius_m();
        let here = Request { to: request.from, to_altitude_m: altitude_m, ..*request };
        let is_open_here = self.is_open(&here, room_m);
        let stay_s = self.change_s(change.0, change.1);
        // A vehicle climbs faster at the beginning: it is at least so far on its way up when it arrives.
        let arrives_m = change.0 + (change.1 - change.0) * (way_s / stay_s).min(1.0);
        let there = Request { from: request.to, to: request.to, from_altitude_m: arrives_m, stay_s, ..here };
        // Plans count on less than the fastest descent.
        let needs_circles = self.turn_radius_m > 0.0 && self.fastest_change_s(change.0, change.1) > way_s;
        let shut_by =
            if strict.circles && needs_circles { self.shut_by(&there, (room_m, strict.margins)) } else { None };
        let planned_s = (self.planned_change_s(change.0, change.1) - way_s).max(0.0);
        match shut_by {
            None => Ok(PlaceOfChange::Here(if is_open_here { planned_s } else { 0.0 })),
            Some(_) if is_open_here => Ok(PlaceOfChange::Here(short_s)),
            Some(name) => {
                let centre = self.circle_from_here(&Request { stay_s, ..here });
                centre.map(PlaceOfChange::Around).ok_or_else(|| self.no_room(&there, &name))
            }
        }
    }

    /// Returns the path of a vehicle that first climbs or descends to its altitude on the circle around `centre`.
    fn way_by_circle(
        &self,
        request: &Request,
        (centre, altitude_m): (Position, f64),
        strict: &Strictness,
    ) -> Result<Way, TravelError> {
        let slowest_mps = (self.true_airspeed_mps - self.wind_mps_max()).max(1.0);
        let reach_s = (geodesy::distance_m(request.from, centre) + self.circle_radius_m()) / slowest_mps;
        let hold_s = reach_s.max(self.change_s(request.from_altitude_m, altitude_m));
        let at_s = request.at_s + hold_s;
        let level = Request { from: centre, from_altitude_m: altitude_m, from_track_rad: None, at_s, ..*request };
        let way = self.way_at(&level, altitude_m, strict)?;
        Ok(Way { hold_s: hold_s + way.hold_s, hold_around: Some(centre), ..way })
    }

    /// Returns the place to wait near the vehicle, with space for a circle between its altitude and that of the path, on which it climbs
    /// or descends; `None` if there is no such place.
    ///
    /// # Errors
    /// No place within reach has space for a circle.
    fn hold_around(&self, request: &Request, altitude_m: f64, hold_s: f64) -> Result<Option<Position>, TravelError> {
        if hold_s < HOLD_S_MIN || self.turn_radius_m <= 0.0 {
            return Ok(None);
        }
        let here = Request { to: request.from, to_altitude_m: altitude_m, stay_s: hold_s, ..*request };
        // A circle onto which the way is open comes first.
        let found = self.circle_from_here(&here).map_or_else(|| self.circle_centre(&here), |centre| (centre, None));
        match found {
            (_, Some(name)) => Err(self.no_room(&here, &name)),
            (centre, None) => Ok((centre != request.from).then_some(centre)),
        }
    }

    /// Returns true if the vehicle may descend on the spot where only the ground forbids circles: a place to hover at may be near the
    /// ground.
    fn may_descend_upright(&self, shut_by: &str) -> bool {
        self.turn_radius_m <= 0.0 && shut_by == GROUND
    }

    /// Returns the reason for which the vehicle cannot circle at the end of a request, given the obstacle.
    fn no_room(&self, there: &Request, shut_by: &str) -> TravelError {
        let places = [there.to, there.to];
        match shut_by == GROUND {
            true => TravelError::Ground(self.lowest_altitude_m(&places, (there.to, there.to), 1.0)),
            false => TravelError::NoRoomToTurn,
        }
    }

    pub(super) fn way_at(&self, request: &Request, altitude_m: f64, strict: &Strictness) -> Result<Way, TravelError> {
        let low_m = request.from_altitude_m.min(altitude_m);
        let high_m = request.from_altitude_m.max(altitude_m);
        let mut network = self.network(request, (low_m, high_m, altitude_m), strict)?;
        let (from, to) = (network.add(request.from)?, network.add(request.to)?);
        network.head(from, request.from_track_rad);
        network.head(to, request.to_track_rad);
        let trip = network.trip(from, to, request.at_s)?;
        let path = network.path(trip.way, trip.depart_s);
        let needs_m = self.lowest_altitude_m(&path, (request.from, request.to), strict.margins);
        let needs_m = needs_m.max(self.lowest_descent_m(&path, request.from_altitude_m, strict.margins));
        if altitude_m < needs_m {
            return Err(TravelError::Ground(needs_m));
        }
        // If the present altitude and that of the place differ from that of the path, circles at its end make up the difference.
        let climb_m = request.to_altitude_m - altitude_m;
        let there = Request { from: request.to, from_altitude_m: altitude_m, ..*request };
        if climb_m != 0.0
            && let Some(name) = self.shut_by(&there, (CIRCLE_ROOM * self.circle_radius_m(), strict.margins))
            && !self.may_descend_upright(&name)
        {
            return Err(self.no_room(&there, &name));
        }
        let way_s = trip.arrive_s - trip.depart_s;
        let change_s = match self.place_of_change(request, (altitude_m, way_s), strict)? {
            PlaceOfChange::Here(hold_s) => hold_s,
            PlaceOfChange::Around(centre) => return self.way_by_circle(request, (centre, altitude_m), strict),
        };
        let hold_s = (trip.depart_s - request.at_s).max(change_s);
        // An aircraft below the ground ahead climbs before it leaves.
        let is_below = self.terrain.is_some() && needs_m.min(altitude_m) > request.from_altitude_m;
        let below_s = if is_below { self.change_s(request.from_altitude_m, needs_m.min(altitude_m)) } else { 0.0 };
        let hold_s = hold_s.max(below_s);
        let mut via = thinned(&path);
        if climb_m != 0.0 {
            // The whole way is flown at its altitude.
            via.push(request.to);
        }
        Ok(Way {
            via,
            altitude_m,
            hold_s: if hold_s < HOLD_S_MIN { 0.0 } else { hold_s },
            hold_around: self.hold_around(request, altitude_m, hold_s)?,
            time_s: way_s + self.change_s(altitude_m, request.to_altitude_m),
            broken: None,
        })
    }

    /// Returns the path of a vehicle that first climbs or descends to an altitude on a circle at its position, and leaves at that altitude:
    /// it passes above or below zones that it would meet if it changed its altitude on the way.
    ///
    /// # Errors
    /// The reason for which the change of altitude or the path is closed.
    pub(super) fn way_after_change(
        &self,
        request: &Request,
        altitude_m: f64,
        strict: &Strictness,
    ) -> Result<Way, TravelError> {
        let change_m = altitude_m - request.from_altitude_m;
        let here = Request { to: request.from, to_altitude_m: altitude_m, ..*request };
        let room_m = CIRCLE_ROOM * self.circle_radius_m();
        if change_m.abs() < 1.0 {
            return Err(TravelError::NoRoomToTurn);
        }
        if let Some(name) = self.shut_by(&here, (room_m, strict.margins)) {
            return Err(self.no_room(&here, &name));
        }
        let change_s = (1.0 + LATE_SHARE) * self.change_s(request.from_altitude_m, altitude_m) + HOLD_S_MIN;
        let level = Request { from_altitude_m: altitude_m, at_s: request.at_s + change_s, ..*request };
        let way = self.way_at(&level, altitude_m, strict)?;
        let hold_s = change_s + way.hold_s;
        Ok(Way { hold_s, hold_around: self.hold_around(request, altitude_m, hold_s)?, ..way })
    }

    /// Returns the network of a search between two altitudes, with the wind at a third.
    pub(super) fn network(
        &self,
        request: &Request,
        (low_m, high_m, altitude_m): (f64, f64, f64),
        strict: &Strictness,
    ) -> Result<Network, TravelError> {
        let above_m = strict.margins * self.above_zone_m;
        let zones = self.counted(request, altitude_m, strict);
        let around: Vec<Position> = [request.from, request.to].into();
        let rim_m = strict.margins * (self.rim_m + 0.005 * self.landing_distance_m_max.unwrap_or(0.0));
        let setting = Setting {
            zones: &zones,
            margin_m: strict.margins * self.margin_m,
            turn_radius_m: if strict.turns { self.turn_radius_m } else { 0.0 },
            circling: false,
            landing_places: &self.landing_places,
            landing_distance_m_max: self.landing_distance_m_max.filter(|_| strict.reach).map(|limit_m| limit_m - rim_m),
            around: &around,
            altitudes_m: (low_m - above_m, high_m + above_m),
            time_s: (request.at_s, self.end_s.max(request.at_s) + LATE_S),
        };
        let air = Air::new(&self.wind, altitude_m, self.true_airspeed_mps, request.at_s, setting.time_s.1);
        Network::new(&setting, air).map_err(|_| TravelError::TooFar)
    }

    /// Returns the zones with their tolerances: restricted zones with times last longer, permitted ones shorter and are smaller.
    fn counted(&self, request: &Request, altitude_m: f64, strict: &Strictness) -> Vec<AirspaceZone> {
        let is_left = |zone: &AirspaceZone| {
            strict.early_change && self.is_left_by_change(request, altitude_m, (zone, strict.margins))
        };
        let counts = |zone: &&AirspaceZone| !strict.without.contains(&zone.name) && !is_left(zone);
        let mut zones: Vec<AirspaceZone> = self.zones.iter().filter(counts).cloned().collect();
        for zone in &mut zones {
            // The time of passage is less certain the later it is.
            let spread_s = |time_s: f64| strict.margins * time_error_s(time_s - request.at_s);
            let TimeWindow { from_s, until_s } = zone.active;
            let (early_s, late_s) = (spread_s(from_s), spread_s(until_s));
            let permitted = zone.kind == ZoneKind::Permitted;
            let sign = if permitted { -1.0 } else { 1.0 };
            zone.active = TimeWindow { from_s: from_s - sign * early_s, until_s: until_s + sign * late_s };
            if permitted {
                // The lower face of a permitted zone is mostly the ground.
                zone.altitude_m_min -= strict.margins * self.above_zone_m;
                zone.corners = inset(&zone.corners, strict.margins * self.rim_m);
            }
        }
        zones
    }
}

/// Returns the error of the time at which a zone is passed that opens or closes `ahead_s` from now.
pub(crate) fn time_error_s(ahead_s: f64) -> f64 {
    (EARLY_S + LATE_SHARE * ahead_s.max(0.0)).min(LATE_S)
}

pub(super) fn cost_s(way: &Way) -> f64 {
    way.hold_s + way.time_s
}

/// Returns the points that suffice to fly a path, without its first and last.
fn thinned(path: &[Position]) -> Vec<Position> {
    let mut kept = Vec::new();
    let mut turned_deg = 0.0;
    let mut before_deg: Option<f64> = None;
    let mut chord_m = f64::INFINITY;
    for (from, to) in path.iter().zip(path.iter().skip(1)) {
        let (length_m, azimuth_deg) = geodesy::inverse(*from, *to);
        if length_m < 1.0 {
            continue;
        }
        if let Some(before_deg) = before_deg {
            let change_deg = geodesy::wrap_180(azimuth_deg - before_deg).abs();
            turned_deg += change_deg;
            // A turn begins and ends where a leg is much longer than the neighbouring one.
            let edge = change_deg > 0.1 && (length_m > 3.0 * chord_m || chord_m > 3.0 * length_m);
            if turned_deg >= CHORD_DEG || edge {
                kept.push(*from);
                turned_deg = 0.0;
            }
        }
        chord_m = length_m;
        before_deg = Some(azimuth_deg);
    }
    kept
}

/// Returns the polygon shrunk by `rim_m` on all sides; unchanged if the result would not be a polygon.
fn inset(corners: &[Position], rim_m: f64) -> Vec<Position> {
    let smaller = || {
        let plane = Plane::around(corners);
        let flat: Vec<Point> = corners.iter().map(|corner| plane.project(*corner)).collect::<Option<_>>()?;
        let sense = if plane::doubled_area(&flat) > 0.0 { 1.0 } else { -1.0 };
        let count = flat.len();
        let at = |index: usize| flat.get(index % count).copied().unwrap_or_default();
        let inward = |from: Point, to: Point| {
            let along = to.minus(from).unit()?;
            Some(Point { x: -sense * along.y, y: sense * along.x })
        };
        let moved = |index: usize| {
            let here = at(index);
            let (before, after) = (inward(at(index + count - 1), here)?, inward(here, at(index + 1))?);
            let open = 1.0 + before.dot(after);
            let by = rim_m * plane.stretch(here) / open.max(0.1);
            Some(here.plus(by, before).plus(by, after))
        };
        let made: Vec<Point> = (0..count).map(moved).collect::<Option<_>>()?;
        let sound = crossing(&made).is_none()
            && plane::doubled_area(&made) * sense > 0.0
            && made.iter().all(|point| plane::inside(*point, &flat));
        sound.then(|| made.iter().map(|point| plane.position(*point)).collect::<Vec<Position>>())
    };
    if rim_m > 0.0 { smaller().unwrap_or_else(|| corners.to_vec()) } else { corners.to_vec() }
}
