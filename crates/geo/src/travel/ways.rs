//! Paths between places, and their arrivals.
//!
//! Between two places the straight leg is flown if it is never closed. Otherwise a set of paths is found once, each the best for
//! departing at some instant (the beginning, and every change of zones or wind); from then on the pair's arrival is that of the best of
//! them, after a hold at the departure if needed. On one path no vehicle overtakes another, so that a later departure never means an
//! earlier arrival. Bound of a query: O(paths x legs), mostly O(1).

use super::course::first_open;
use super::error::TravelError;
use super::ground::PreparedPoint;
use super::network::{DirectedLeg, Endpoint, EndpointId, Network};
use super::search::{FoundPath, Tree};
use super::spans::{Span, merged};
use super::turns::{At, Turned};
use crate::plane::Point;
use apex_model::problem::Position;
use std::collections::BTreeMap;

/// Maximum number of instants of departure for which ways are searched.
const INSTANTS_MAX: usize = 16;

/// The number of a way of a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathId(usize);

/// Departure and arrival.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trip {
    /// Departure; later than requested if holding first is better.
    pub depart_s: f64,
    /// Arrival.
    pub arrive_s: f64,
    /// The way that is flown.
    pub way: PathId,
}

#[derive(Clone, Debug)]
struct TravelPath {
    from: EndpointId,
    to: EndpointId,
    path_vertices: Vec<usize>,
    rides: Vec<DirectedLeg>,
    /// Departures at which some part is closed: open spans, sorted.
    closed_s: Vec<Span>,
    /// Effect of turns, once it was computed; the inner `None` if there is no space for them.
    turned: Option<Option<Turned>>,
}

/// The ways found so far.
#[derive(Clone, Debug, Default)]
pub(super) struct FoundPaths {
    ways: Vec<TravelPath>,
    /// Numbers of sets of ways.
    between: BTreeMap<(usize, usize), Result<usize, TravelError>>,
    sets: Vec<Vec<PathId>>,
    /// Straight paths; true if a path is never closed.
    straight: BTreeMap<(usize, usize), Result<(PathId, bool), TravelError>>,
    trees: BTreeMap<usize, Vec<Tree>>,
    instants_s: Option<Vec<f64>>,
}

impl Network {
    /// Returns the first arrival at `to` of a vehicle that is at `from` at `ready_s`.
    ///
    /// # Errors
    /// The obstacle that blocks the path.
    pub fn trip(&mut self, from: EndpointId, to: EndpointId, ready_s: f64) -> Result<Trip, TravelError> {
        let key = (from.0, to.0);
        let set = match self.found.between.get(&key) {
            Some(Ok(set)) => *set,
            Some(Err(trouble)) => return Err(trouble.clone()),
            None => {
                let set = self.find(from, to).map(|ways| {
                    self.found.sets.push(ways);
                    self.found.sets.len() - 1
                });
                self.found.between.insert(key, set.clone());
                set?
            }
        };
        let mut best: Option<Trip> = None;
        for index in 0..self.found.sets.get(set).map_or(0, Vec::len) {
            let way = self.found.sets.get(set).and_then(|ways| ways.get(index)).copied();
            let trip = way.and_then(|way| self.trip_by(way, ready_s));
            if let Some(trip) = trip.filter(|trip| best.is_none_or(|best| trip.arrive_s < best.arrive_s)) {
                best = Some(trip);
            }
        }
        if best.is_none() && self.turns.radius > 0.0 {
            let ways = self.found.sets.get(set).cloned().unwrap_or_default();
            if !ways.into_iter().any(|way| self.has_room(way)) {
                return Err(TravelError::NoRoomToTurn);
            }
        }
        best.ok_or(TravelError::Shut)
    }

    /// Returns the first arrival by one path; `None` if it is closed, or the vehicle must not hold at `from` for that time.
    fn trip_by(&mut self, number: PathId, ready_s: f64) -> Option<Trip> {
        let extra_s = if self.turns.radius > 0.0 { self.turned(number)?.extra_s } else { 0.0 };
        let way = self.found.ways.get(number.0)?;
        let depart_s = first_open(&way.closed_s, ready_s);
        let (from, rides) = (way.from, way.rides.len());
        if depart_s > ready_s && self.may_hold_until_s(from, ready_s).is_none_or(|until_s| until_s < depart_s) {
            return None;
        }
        let mut now_s = depart_s;
        for index in 0..rides {
            let ride = self.found.ways.get(number.0).and_then(|way| way.rides.get(index)).copied()?;
            now_s = self.arrive(ride, now_s);
        }
        now_s.is_finite().then_some(Trip { depart_s, arrive_s: now_s + extra_s, way: number })
    }

    /// Returns the effect of turns on a path, with its closed departures; `None` if there is no space for them.
    pub(super) fn turned(&mut self, number: PathId) -> Option<&Turned> {
        if self.turns.radius <= 0.0 {
            return None;
        }
        if self.found.ways.get(number.0)?.turned.is_none() {
            let turned = self.turn(number);
            let way = self.found.ways.get_mut(number.0)?;
            if let Some(turned) = &turned {
                way.closed_s.extend_from_slice(&turned.closed_s);
                way.closed_s = merged(std::mem::take(&mut way.closed_s), 0.0);
            }
            way.turned = Some(turned);
        }
        self.found.ways.get(number.0)?.turned.as_ref()?.as_ref()
    }

    /// Returns true if a path has space for its turns.
    fn has_room(&mut self, number: PathId) -> bool {
        self.turns.radius <= 0.0 || self.turned(number).is_some()
    }

    /// Returns the ends and bends of a path, and the directions or circles in which its ends are left and reached.
    pub(super) fn ends_and_bends(&self, number: PathId) -> Option<(Vec<PreparedPoint>, (At, At))> {
        let way = self.found.ways.get(number.0)?;
        let (from, to) = (self.places.get(way.from.0)?, self.places.get(way.to.0)?);
        let between = way.path_vertices.iter().filter_map(|bend| self.bend(*bend));
        let spots = [&from.spot].into_iter().chain(between).chain([&to.spot]).cloned().collect();
        let at = |place: &Endpoint| match place.track_rad {
            _ if place.is_circled => At::Circle,
            Some(track_rad) => At::Track(track_rad),
            None => At::Free,
        };
        Some((spots, (at(from), at(to))))
    }

    /// Returns both ends of a way and the bends between, on the Earth.
    pub fn positions(&self, way: PathId) -> Vec<Position> {
        self.spots(way).into_iter().map(|(position, _)| position).collect()
    }

    /// Returns the positions of the path on the plane.
    pub fn points(&self, way: PathId) -> Vec<Point> {
        self.spots(way).into_iter().map(|(_, point)| point).collect()
    }

    pub(super) fn spots(&self, way: PathId) -> Vec<(Position, Point)> {
        let Some(way) = self.found.ways.get(way.0) else { return Vec::new() };
        let ends = |place: EndpointId| self.places.get(place.0).map(|place| &place.spot);
        let between = way.path_vertices.iter().filter_map(|bend| self.bend(*bend));
        let spots = ends(way.from).into_iter().chain(between).chain(ends(way.to));
        spots.map(|spot| (spot.position, spot.point)).collect()
    }

    /// Returns the length of a way over ground.
    pub fn length_of(&self, way: PathId) -> f64 {
        self.found.ways.get(way.0).map_or(f64::INFINITY, |way| way.rides.iter().map(|ride| self.length(*ride)).sum())
    }

    /// Returns the trips between all places for a vehicle that is ready at `ready_s`: a row for each place of departure. A trip from a
    /// place to itself takes no time.
    pub fn matrix(&mut self, from: &[EndpointId], to: &[EndpointId], ready_s: f64) -> Vec<Vec<Option<Trip>>> {
        let row = |here: &EndpointId| {
            let mut tree = None;
            to.iter().map(|there| self.trip_now(*here, *there, ready_s, &mut tree)).collect()
        };
        from.iter().map(row).collect()
    }

    /// Like [`Network::trip`], by the path that is best for departing at `ready_s`.
    fn trip_now(&mut self, from: EndpointId, to: EndpointId, ready_s: f64, tree: &mut Option<Tree>) -> Option<Trip> {
        let straight = self.straight_way(from, to).ok();
        let direct = straight.and_then(|(way, _)| self.trip_by(way, ready_s));
        if straight.is_some_and(|(way, free)| free && self.has_room(way)) {
            return direct;
        }
        if tree.is_none() {
            *tree = Some(self.tree(from, ready_s));
        }
        let found = tree.as_ref().and_then(|tree| self.way_over(tree, to));
        let around = found.and_then(|found| {
            let way = self.keep(from, to, found);
            self.trip_by(way, ready_s)
        });
        match (direct, around) {
            (Some(direct), Some(around)) if around.arrive_s < direct.arrive_s => Some(around),
            (direct, around) => direct.or(around),
        }
    }

    /// Returns the straight path, and true if it is never closed.
    fn straight_way(&mut self, from: EndpointId, to: EndpointId) -> Result<(PathId, bool), TravelError> {
        if let Some(known) = self.found.straight.get(&(from.0, to.0)) {
            return known.clone();
        }
        let straight = self.direct(from, to).map(|ride| {
            let free = self.closed(ride).is_empty();
            let found = FoundPath { arrive_s: 0.0, rides: vec![ride], path_vertices: Vec::new() };
            (self.keep(from, to, found), free)
        });
        self.found.straight.insert((from.0, to.0), straight.clone());
        straight
    }

    fn find(&mut self, from: EndpointId, to: EndpointId) -> Result<Vec<PathId>, TravelError> {
        let straight = self.straight_way(from, to);
        if let Ok((way, true)) = straight
            && self.has_room(way)
        {
            return Ok(vec![way]);
        }
        for place in [from, to] {
            let trouble = self.place_trouble(place, (f64::NEG_INFINITY, f64::INFINITY));
            if let Some(trouble) = trouble.filter(|_| !self.is_ever_open(place)) {
                return Err(trouble);
            }
        }
        let mut ways: Vec<PathId> = straight.iter().map(|(way, _)| *way).collect();
        if !self.found.trees.contains_key(&from.0) {
            let instants_s = self.instants_s();
            let trees = instants_s.into_iter().map(|instant_s| self.tree(from, instant_s)).collect();
            self.found.trees.insert(from.0, trees);
        }
        let trees = self.found.trees.remove(&from.0).unwrap_or_default();
        for tree in &trees {
            let Some(found) = self.way_over(tree, to) else { continue };
            let known = |way: &PathId| self.found.ways.get(way.0).is_some_and(|way| way.rides == found.rides);
            if !ways.iter().any(known) {
                ways.push(self.keep(from, to, found));
            }
        }
        self.found.trees.insert(from.0, trees);
        if ways.is_empty() { Err(straight.err().unwrap_or(TravelError::Shut)) } else { Ok(ways) }
    }

    /// Returns true if zones and landing places ever allow `place`.
    fn is_ever_open(&self, place: EndpointId) -> bool {
        let Some(open_s) = self.places.get(place.0).map(|place| &place.open_s) else { return false };
        open_s.iter().any(|(from_s, until_s)| self.place_trouble(place, (*from_s, until_s.next_down())).is_none())
    }

    fn instants_s(&mut self) -> Vec<f64> {
        if let Some(instants_s) = &self.found.instants_s {
            return instants_s.clone();
        }
        let (begin_s, end_s) = self.time_s;
        let mut all_s = self.changes_s.clone();
        all_s.extend_from_slice(self.air.changes_s());
        all_s.retain(|time_s| begin_s < *time_s && *time_s < end_s);
        all_s.push(begin_s);
        all_s.sort_by(f64::total_cmp);
        all_s.dedup();
        let every = all_s.len().div_ceil(INSTANTS_MAX).max(1);
        let chosen: Vec<f64> = all_s.into_iter().step_by(every).collect();
        self.found.instants_s = Some(chosen.clone());
        chosen
    }

    /// Stores a path, with the departures at which some part of it is closed.
    fn keep(&mut self, from: EndpointId, to: EndpointId, found: FoundPath) -> PathId {
        let mut closed_s: Vec<Span> = Vec::new();
        for (number, ride) in found.rides.iter().enumerate() {
            for (mut first_s, mut second_s) in self.closed(*ride).to_vec() {
                for before in found.rides.iter().take(number).rev() {
                    first_s = if first_s.is_finite() { self.retreat(*before, first_s) } else { first_s };
                    second_s = if second_s.is_finite() { self.retreat(*before, second_s) } else { second_s };
                }
                closed_s.push((first_s, second_s));
            }
        }
        let closed_s = merged(closed_s, 0.0);
        self.found.ways.push(TravelPath {
            from,
            to,
            path_vertices: found.path_vertices,
            rides: found.rides,
            closed_s,
            turned: None,
        });
        PathId(self.found.ways.len() - 1)
    }
}
