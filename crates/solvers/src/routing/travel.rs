//! Paths and travel times between the places of a single-visit problem: computed through wind and around airspace, or given as numbers.
//!
//! A vehicle changes its altitude as soon as it leaves a place: near the place all altitudes between both ends count, farther away only
//! that of the other end. So pairs of places differ in the zones that apply to them; each set of zones has one network
//! (`apex_geo::travel`), made when it is first needed. Times are exact for every departure, and a later departure never arrives earlier.
//! The examined parts of a network are charged as work.

pub(crate) use super::places::PointKey;
use super::places::{given_s, given_s_min, place, track_rad};
use super::turns_between::{CIRCLES_RADII, TurnBetween};
use super::zones::{distance_m, holds};
use apex_geo::direction::Direction;
use apex_geo::geodesy::{self, Position};
use apex_geo::landing;
use apex_geo::travel::{Air, EndpointId, Network, Setting, TravelError, Trip};
use apex_model::problem::{AirspaceZone, FOREVER_S, SingleVisitProblem, ZoneKind};
use std::collections::BTreeMap;

/// Work units of examining one leg, or one continuation from a bend.
const UNITS_PER_LOOK: u64 = 5;
/// Maximum number of networks of one problem; further sets of zones share one in which every zone applies at every altitude.
const NETWORKS_MAX: usize = 16;

/// A way with its times.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TimedPath {
    /// Positions of the way: both ends and the bends between them.
    pub(crate) route: Vec<Position>,
    /// Flown path, turns included; empty if turns are not limited.
    pub(crate) path: Vec<Position>,
    /// Departure, after a hold if one is needed.
    pub(crate) depart_s: f64,
    /// Arrival.
    pub(crate) arrive_s: f64,
}

/// Departure and arrival of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Times {
    /// Departure, after a hold if one is needed.
    pub(crate) depart_s: f64,
    /// Arrival.
    pub(crate) arrive_s: f64,
}

/// Number of zones that are distinguished by altitude; further ones apply to every leg.
const ZONES_TOLD_APART: usize = 128;

/// A set of zones, by their numbers.
type ZoneSet = u128;

/// A network, with the numbers of the nodes in it.
struct Layer {
    zones: ZoneSet,
    network: Network,
    places: Vec<Option<Result<EndpointId, TravelError>>>,
}

/// Position of a node.
#[derive(Clone, Copy)]
struct Spot {
    position: Position,
    altitude_m: f64,
    direction: Direction,
    /// Direction in which the place is left and reached, clockwise from north; `None` for any direction.
    track_rad: Option<f64>,
}

/// The travel model with the paths computed so far.
pub(crate) struct Travel<'a> {
    problem: &'a SingleVisitProblem,
    /// The first manoeuvre of each target among all manoeuvres.
    offsets: Vec<usize>,
    spots: Vec<Spot>,
    /// Positions around whose centre the projection is placed.
    around: Vec<Position>,
    air: Air,
    /// For each spot its distance from each zone that is distinguished, m.
    zones_m: Vec<Vec<f64>>,
    layers: Vec<Layer>,
    lines: BTreeMap<(usize, usize, (usize, usize)), Option<String>>,
}

impl<'a> Travel<'a> {
    /// Prepares airspace and wind of `problem`.
    ///
    /// # Errors
    /// An error message that names an invalid zone.
    pub(crate) fn new(problem: &'a SingleVisitProblem) -> Result<Travel<'a>, String> {
        let mut around = vec![problem.start];
        around.extend(problem.base);
        around.extend(problem.targets.iter().map(|target| target.position));
        let vehicle = &problem.vehicle;
        let (begin_s, end_s) = time_s(problem);
        let air = Air::new(&problem.wind, vehicle.cruise_altitude_m, vehicle.true_airspeed_mps, begin_s, end_s);
        let mut offsets = Vec::with_capacity(problem.targets.len());
        let mut nodes = vec![PointKey::Start, PointKey::Base];
        for (target, data) in problem.targets.iter().enumerate() {
            offsets.push((nodes.len() - 2) / 2);
            for manoeuvre in 0..data.manoeuvres.len() {
                nodes.extend([PointKey::Entry(target, manoeuvre), PointKey::Exit(target, manoeuvre)]);
            }
        }
        let spots = nodes.iter().map(|node| {
            let (position, altitude_m) = place(problem, *node);
            let (direction, track_rad) = (Direction::of(position), track_rad(problem, *node));
            Spot { position, altitude_m, direction, track_rad }
        });
        let spots: Vec<Spot> = spots.collect();
        let from_zones = |spot: &Spot| {
            let told_apart = problem.zones.iter().take(ZONES_TOLD_APART);
            told_apart.map(|zone| distance_m(spot.position, &zone.corners)).collect()
        };
        let zones_m = if problem.travel.is_none() { spots.iter().map(from_zones).collect() } else { Vec::new() };
        let mut travel =
            Travel { problem, offsets, spots, around, air, zones_m, layers: Vec::new(), lines: BTreeMap::new() };
        if problem.travel.is_none() {
            // Invalid zones are reported before any planning.
            travel.layer(travel.zones_at(vehicle.cruise_altitude_m))?;
        }
        Ok(travel)
    }

    /// Returns true if paths take the same time at every departure until `limit_s`.
    pub(crate) fn is_steady(&self, limit_s: f64) -> bool {
        match &self.problem.travel {
            Some(travel) => travel.is_constant(),
            None => self.changes_s().iter().all(|change_s| *change_s > limit_s),
        }
    }

    /// Returns the instants after the plan's beginning at which the wind changes and zones open or close, in order.
    pub(crate) fn changes_s(&self) -> Vec<f64> {
        let ends = self.problem.zones.iter().flat_map(|zone| [zone.active.from_s, zone.active.until_s]);
        let mut changes_s: Vec<f64> = ends.chain(self.air.changes_s().iter().copied()).collect();
        changes_s.retain(|change_s| *change_s > self.problem.start_s && *change_s < FOREVER_S);
        changes_s.sort_by(f64::total_cmp);
        changes_s.dedup();
        changes_s
    }

    /// Returns the work units since the last call, for the budget.
    pub(crate) fn take_work(&mut self) -> u64 {
        let looks: u64 = self.layers.iter_mut().map(|layer| layer.network.take_work()).sum();
        UNITS_PER_LOOK * looks
    }

    fn number(&self, node: PointKey) -> usize {
        let of = |target: usize, manoeuvre: usize| self.offsets.get(target).map_or(0, |first| first + manoeuvre);
        match node {
            PointKey::Start => 0,
            PointKey::Base => 1,
            PointKey::Entry(target, manoeuvre) => 2 + 2 * of(target, manoeuvre),
            PointKey::Exit(target, manoeuvre) => 3 + 2 * of(target, manoeuvre),
        }
    }

    /// Returns departure and arrival at `to` of a vehicle that can leave `from` at `ready_s`. Errors: the obstacle.
    pub(crate) fn times(&mut self, from: PointKey, to: PointKey, ready_s: f64) -> Result<Times, String> {
        if let Some(travel) = &self.problem.travel {
            let travel_s = given_s(travel, from, to, ready_s).ok_or("no way leads there")?;
            return Ok(Times { depart_s: ready_s, arrive_s: ready_s + travel_s });
        }
        self.find(from, to, ready_s).map(|(_, times, _)| times)
    }

    /// Returns the time from being ready to leave `from` at `ready_s` to the arrival at `to`, including holds; `None` if no path exists.
    pub(crate) fn time_s(&mut self, from: PointKey, to: PointKey, ready_s: f64) -> Option<f64> {
        self.times(from, to, ready_s).ok().map(|times| times.arrive_s - ready_s)
    }

    /// Returns the time that turns add to the straight legs of the path from `from` to `to`; 0 if no path exists.
    pub(crate) fn turns_s(&mut self, from: PointKey, to: PointKey, ready_s: f64) -> f64 {
        let Ok((layer, _, trip)) = self.find(from, to, ready_s) else { return 0.0 };
        self.layers.get_mut(layer).map_or(0.0, |layer| layer.network.turns_s(trip.way))
    }

    /// Returns a lower bound on the time of all paths from `from` to `to`.
    pub(crate) fn time_s_min(&self, from: PointKey, to: PointKey) -> f64 {
        if let Some(travel) = &self.problem.travel {
            return given_s_min(travel, from, to);
        }
        let (Some(start), Some(end)) = (self.spots.get(self.number(from)), self.spots.get(self.number(to))) else {
            return 0.0;
        };
        start.direction.distance_m_min(end.direction) / self.air.ground_speed_mps_max()
    }

    /// Returns the path from `from` to `to` of a vehicle that can leave at `ready_s`.
    ///
    /// # Errors
    /// A phrase that names the obstacle, for example "inside restricted area R-2515".
    pub(crate) fn way(&mut self, from: PointKey, to: PointKey, ready_s: f64) -> Result<TimedPath, String> {
        if let Some(travel) = &self.problem.travel {
            let arrive_s = ready_s + given_s(travel, from, to, ready_s).ok_or("no way leads there")?;
            let route = vec![place(self.problem, from).0, place(self.problem, to).0];
            return Ok(TimedPath { route, path: Vec::new(), depart_s: ready_s, arrive_s });
        }
        let (layer, times, trip) = self.find(from, to, ready_s)?;
        let limited = self.problem.vehicle.turn_radius_m > 0.0;
        let network = self.layers.get_mut(layer).map(|layer| &mut layer.network);
        let (route, path) = network.map_or_else(Default::default, |network| {
            let path = if limited { network.path(trip.way, trip.depart_s) } else { Vec::new() };
            (network.positions(trip.way), path)
        });
        Ok(TimedPath { route, path, depart_s: times.depart_s, arrive_s: times.arrive_s })
    }

    /// Returns the layer, the times and the trip; climbs and descents take their time. The altitude changes at the beginning of the way.
    /// Where zones leave no such way, it changes in circles over the end, as below a zone that is flown under.
    fn find(&mut self, from: PointKey, to: PointKey, ready_s: f64) -> Result<(usize, Times, Trip), String> {
        let is_at_base = |base| geodesy::distance_m(self.problem.start, base) <= 1.0;
        let is_flying = match from {
            PointKey::Exit(..) => true,
            PointKey::Start => !self.problem.base.is_some_and(is_at_base),
            PointKey::Base | PointKey::Entry(..) => false,
        };
        let (from, to) = (self.number(from), self.number(to));
        let (Some(start), Some(end)) = (self.spots.get(from).copied(), self.spots.get(to).copied()) else {
            return Err("no way was found".to_string());
        };
        let climb_s = self.climb_s(start.altitude_m, end.altitude_m);
        let at_once = self.zones_between(from, start.altitude_m, end.altitude_m, climb_s);
        let at_end = self.zones_between(to, end.altitude_m, start.altitude_m, climb_s);
        let mut found = self.find_where(at_once, (from, to), ready_s);
        let mut circles_s = 0.0;
        if found.is_err() && is_flying && at_end != at_once {
            let late = self.find_where(at_end, (from, to), ready_s);
            circles_s = if late.is_ok() { climb_s } else { 0.0 };
            found = late.or(found);
        }
        if found.is_err() && is_flying {
            let level = self.zones_below_circles(to, start.altitude_m, end.altitude_m);
            if let Some(level) = level.and_then(|zones| self.find_where(zones, (from, to), ready_s).ok()) {
                (found, circles_s) = (Ok(level), climb_s);
            }
        }
        let (number, trip) = found?;
        let arrive_s = (trip.arrive_s + circles_s).max(trip.depart_s + climb_s);
        Ok((number, Times { depart_s: trip.depart_s, arrive_s }, trip))
    }

    /// Returns the zones of a path at the altitude of its beginning, if there is space around its end for circles up or down to the other
    /// altitude.
    fn zones_below_circles(&self, to: usize, from_m: f64, to_m: f64) -> Option<ZoneSet> {
        let room_m = CIRCLES_RADII * self.problem.vehicle.turn_radius_m + self.problem.zone_margin_m;
        let (low_m, high_m) = (from_m.min(to_m), from_m.max(to_m));
        let distances = self.zones_m.get(to)?;
        let is_open = |(number, zone): (usize, &AirspaceZone)| {
            let is_passed = zone.altitude_m_min <= high_m && low_m < zone.altitude_m_max;
            let is_far = distances.get(number).is_some_and(|distance_m| *distance_m > room_m);
            zone.kind == ZoneKind::Permitted || !is_passed || is_far
        };
        let place = self.spots.get(to)?.position;
        let is_within = |limit_m| landing::leg_is_within(&self.problem.landing_places, place, place, limit_m - room_m);
        let is_open = self.problem.zones.iter().enumerate().all(is_open)
            && self.problem.landing_distance_m_max.is_none_or(is_within);
        is_open.then(|| {
            self.zones_where(|zone, _| holds(zone, from_m) && (zone.kind == ZoneKind::Restricted || holds(zone, to_m)))
        })
    }

    /// Returns the layer in which these zones count, and the trip in it.
    fn find_where(
        &mut self,
        zones: ZoneSet,
        (from, to): (usize, usize),
        ready_s: f64,
    ) -> Result<(usize, Trip), String> {
        let number = self.layer(zones)?;
        let (start, end) = (self.spots.get(from).copied(), self.spots.get(to).copied());
        let layer = self.layers.get_mut(number).ok_or("no way was found")?;
        let (start, end) = start.zip(end).ok_or("no way was found")?;
        let mut place = |number: usize, spot: &Spot| layer.place(number, spot.position, spot.track_rad);
        let places = place(from, &start).and_then(|from| Ok((from, place(to, &end)?)));
        let trip = places.and_then(|(from, to)| layer.network.trip(from, to, ready_s));
        Ok((number, trip.map_err(|trouble| trouble.to_string())?))
    }

    /// Returns the zones that count at this altitude.
    fn zones_at(&self, altitude_m: f64) -> ZoneSet {
        self.zones_where(|zone, _| holds(zone, altitude_m))
    }

    /// Returns the zones of a path from `from` to an altitude that is reached in `climb_s`: those at that altitude, and those that the
    /// vehicle may reach before it has left their altitudes.
    fn zones_between(&self, from: usize, from_m: f64, to_m: f64, climb_s: f64) -> ZoneSet {
        let (low_m, high_m) = (from_m.min(to_m), from_m.max(to_m));
        let reach_m = |zone: &AirspaceZone| {
            let within_m = if to_m > from_m { zone.altitude_m_max - from_m } else { from_m - zone.altitude_m_min };
            let share = if high_m > low_m { (within_m / (high_m - low_m)).clamp(0.0, 1.0) } else { 1.0 };
            share * climb_s * self.air.ground_speed_mps_max() + self.problem.zone_margin_m
        };
        let distances = self.zones_m.get(from).map_or(&[][..], Vec::as_slice);
        self.zones_where(|zone, number| {
            if zone.kind == ZoneKind::Permitted {
                return holds(zone, from_m) && holds(zone, to_m);
            }
            let passed = zone.altitude_m_min <= high_m && low_m < zone.altitude_m_max;
            holds(zone, to_m) || (passed && distances.get(number).is_none_or(|distance_m| *distance_m <= reach_m(zone)))
        })
    }

    fn zones_where(&self, counts: impl Fn(&AirspaceZone, usize) -> bool) -> ZoneSet {
        let told_apart = self.problem.zones.iter().take(ZONES_TOLD_APART).enumerate();
        told_apart.fold(0, |set, (number, zone)| if counts(zone, number) { set | 1 << number } else { set })
    }

    /// Returns the number of the network for legs to which these zones apply.
    fn layer(&mut self, zones: ZoneSet) -> Result<usize, String> {
        if let Some(known) = self.layers.iter().position(|layer| layer.zones == zones) {
            return Ok(known);
        }
        if self.layers.len() >= NETWORKS_MAX {
            return match self.layers.iter().position(|layer| layer.zones == ZoneSet::MAX) {
                Some(known) => Ok(known),
                None => self.made(ZoneSet::MAX),
            };
        }
        self.made(zones)
    }

    fn made(&mut self, set: ZoneSet) -> Result<usize, String> {
        let problem = self.problem;
        let counts = |number: usize| number >= ZONES_TOLD_APART || set & (1 << number) != 0;
        // The set determines the zones: those in it reach to every altitude, the others to none.
        let zone = |(number, zone): (usize, &AirspaceZone)| {
            let altitude_m_min = if counts(number) { f64::NEG_INFINITY } else { f64::INFINITY };
            AirspaceZone { altitude_m_min, altitude_m_max: f64::INFINITY, ..zone.clone() }
        };
        let zones: Vec<AirspaceZone> = problem.zones.iter().enumerate().map(zone).collect();
        let setting = Setting {
            zones: &zones,
            margin_m: problem.zone_margin_m,
            turn_radius_m: problem.vehicle.turn_radius_m,
            circling: false,
            landing_places: &problem.landing_places,
            landing_distance_m_max: problem.landing_distance_m_max,
            around: &self.around,
            altitudes_m: (0.0, 0.0),
            time_s: time_s(problem),
        };
        let network = Network::new(&setting, self.air.clone())?;
        let places = vec![None; self.spots.len()];
        self.layers.push(Layer { zones: set, network, places });
        Ok(self.layers.len() - 1)
    }

    /// Returns the reason for which the vehicle must not be at a position and altitude at any instant from the beginning of the plan until
    /// `until_s`.
    ///
    /// # Errors
    /// Like [`Travel::new`].
    pub(crate) fn place_trouble(
        &mut self,
        (position, altitude_m): (Position, f64),
        until_s: f64,
    ) -> Result<Option<TravelError>, String> {
        let number = self.layer(self.zones_at(altitude_m))?;
        let time_s = (self.problem.start_s, until_s);
        let Some(layer) = self.layers.get_mut(number) else { return Ok(None) };
        Ok(match layer.network.add(position) {
            Ok(place) if layer.network.is_open_within(place, time_s) => None,
            Ok(place) => layer.network.place_trouble(place, time_s),
            Err(trouble) => Some(trouble),
        })
    }

    /// Returns the reason that forbids the lines of a manoeuvre from `begin_s` to `end_s`; `None` if allowed.
    pub(crate) fn lines_trouble(
        &mut self,
        target: usize,
        manoeuvre: usize,
        begin_s: f64,
        end_s: f64,
    ) -> Option<String> {
        let (entry, altitude_m) = place(self.problem, PointKey::Entry(target, manoeuvre));
        let number = match self.layer(self.zones_at(altitude_m)) {
            Ok(number) => number,
            Err(trouble) => return Some(trouble),
        };
        let entry_node = self.number(PointKey::Entry(target, manoeuvre));
        let problem = self.problem;
        let layer = self.layers.get_mut(number)?;
        let epochs = (layer.network.epoch(begin_s), layer.network.epoch(end_s));
        let key = (target, manoeuvre, epochs);
        if let Some(known) = self.lines.get(&key) {
            return known.clone();
        }
        let lines = self.problem.targets.get(target).and_then(|target| target.manoeuvres.get(manoeuvre));
        let lead_in = lines.and_then(|manoeuvre| Some((manoeuvre.entry?, manoeuvre.lines.first()?.0)));
        let lines = lines.map_or(&[][..], |manoeuvre| &manoeuvre.lines);
        let lead_m = lead_in.map_or(0.0, |(entry, begin)| geodesy::distance_m(entry, begin));
        let turns: Vec<TurnBetween> =
            lines.iter().zip(lines.iter().skip(1)).map(|(line, next)| TurnBetween::of(*line, *next, lead_m)).collect();
        let between = turns.iter().flat_map(|turn| [(turn.from, turn.to), (turn.to, turn.begin)]);
        let mut legs = lead_in.into_iter().chain(lines.iter().copied()).chain(between);
        let track_rad = self.spots.get(entry_node).and_then(|spot| spot.track_rad);
        let trouble = match layer.place(entry_node, entry, track_rad) {
            Ok(place) => layer.network.place_trouble(place, (begin_s, end_s)),
            Err(trouble) => Some(trouble),
        };
        let network = &mut layer.network;
        let trouble = trouble.or_else(|| legs.find_map(|(from, to)| network.leg_trouble(from, to, (begin_s, end_s))));
        let near = |turn: &&TurnBetween| turn.is_near_limits(problem, altitude_m);
        let trouble = trouble.or_else(|| turns.iter().filter(near).find_map(|turn| turn.trouble(network, begin_s)));
        let trouble = trouble.map(|trouble| trouble.to_string());
        self.lines.insert(key, trouble.clone());
        trouble
    }

    /// Returns the time to climb or descend between two altitudes, which is the least time of a leg.
    fn climb_s(&self, from_m: f64, to_m: f64) -> f64 {
        let vehicle = &self.problem.vehicle;
        let rate_mps = if to_m > from_m { vehicle.climb_rate_mps } else { vehicle.descent_rate_mps };
        if rate_mps > 0.0 { (to_m - from_m).abs() / rate_mps } else { 0.0 }
    }
}

impl Layer {
    /// Returns the number of a node in the network; adds the node when it is first needed.
    fn place(&mut self, node: usize, position: Position, track_rad: Option<f64>) -> Result<EndpointId, TravelError> {
        if let Some(Some(known)) = self.places.get(node) {
            return known.clone();
        }
        let place = self.network.add(position);
        if let Ok(place) = &place {
            self.network.head(*place, track_rad);
        }
        if let Some(slot) = self.places.get_mut(node) {
            *slot = Some(place.clone());
        }
        place
    }
}

/// Returns an interval that contains the whole flight, in seconds.
fn time_s(problem: &SingleVisitProblem) -> (f64, f64) {
    (problem.start_s, problem.start_s + 2.0 * problem.vehicle.endurance_s)
}
