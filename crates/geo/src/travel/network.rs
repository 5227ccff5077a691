//! The network of legs between places and bends, made once for a set of zones.
//!
//! Legs between bends are found when the network is made, those of a place on its first use. A leg is kept if it is not closed forever;
//! the times at which it is closed are part of it. Bound: O(n^2) queries of the ground for n bends; a place adds n.

use super::air::Air;
use super::circles;
use super::course::{Block, Course, Timing, first_open};
use super::error::TravelError;
use super::ground::{PathConstraints, PreparedPoint};
use super::setting::{self, PlaneZone, Setting};
use super::spans::Span;
use crate::plane::Point;
use apex_model::problem::Position;
use std::collections::BTreeMap;

/// Maximum number of bends of one network: two hundred zones of five corners with two bends each. Further ones are left out, which can
/// make paths longer but never lets them cross a zone.
pub const BENDS_MAX: usize = 2_000;

/// The number of a place of a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct EndpointId(pub(crate) usize);

/// A straight leg that is not closed forever.
#[derive(Clone, Debug)]
struct Leg {
    course: Course,
    blocks: Vec<Block>,
    /// Timings in the forward and in the backward direction.
    timings: [Timing; 2],
}

/// A leg in one of its directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct DirectedLeg {
    leg: usize,
    backwards: bool,
}

impl DirectedLeg {
    fn reversed(self) -> DirectedLeg {
        DirectedLeg { backwards: !self.backwards, ..self }
    }
}

/// A directed leg and the bend at its end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArrivalTurn {
    pub(crate) bend: usize,
    pub(crate) ride: DirectedLeg,
}

#[derive(Clone, Debug)]
pub(super) struct Endpoint {
    pub(super) spot: PreparedPoint,
    /// Times at which the place is allowed.
    pub(super) open_s: Vec<Span>,
    /// Direction in which the place is left and reached, clockwise from north; `None` for any.
    pub(super) track_rad: Option<f64>,
    /// True if the vehicle circles around the place instead of flying over it.
    pub(super) is_circled: bool,
    /// Legs to bends, once they are known.
    joins: Option<Vec<ArrivalTurn>>,
}

/// Turns of the vehicle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turns {
    /// Least radius of turns; 0 if they take neither time nor space.
    pub(super) radius: f64,
    /// Radius of the circles over ground around places; 0 if no place is circled.
    pub(super) circle_radius: f64,
}

impl Turns {
    fn of(radius: f64, circling: bool, air: &Air) -> Turns {
        let circle = circles::radius(radius, air.true_airspeed_mps(), air.ground_speed_mps_max());
        Turns { radius, circle_radius: if circling && radius > 0.0 { circle } else { 0.0 } }
    }

    /// Returns the greatest distance of circles and turns from a straight path.
    pub(super) fn room(self) -> f64 {
        3.0 * self.circle_radius
    }
}

/// Places, bends and the legs between them.
#[derive(Clone, Debug)]
pub struct Network {
    pub(super) ground: PathConstraints,
    pub(super) air: Air,
    pub(super) time_s: Span,
    /// Instants at which zones open or close, in order.
    pub(super) changes_s: Vec<f64>,
    pub(super) on_plane: bool,
    pub(super) turns: Turns,
    path_vertices: Vec<PreparedPoint>,
    /// For each bend the times at which flight is permitted there.
    pub(super) bends_open_s: Vec<Vec<Span>>,
    /// For each bend the legs to other bends.
    joins: Vec<Vec<ArrivalTurn>>,
    pub(super) places: Vec<Endpoint>,
    /// Legs between places, the one with the lower number first; an error if the leg is closed forever.
    direct: BTreeMap<(usize, usize), Result<usize, TravelError>>,
    legs: Vec<Leg>,
    pub(super) found: super::ways::FoundPaths,
    pub(super) work: u64,
}

impl Network {
    /// Returns the network of a setting on the Earth, flown through `air`.
    ///
    /// # Errors
    /// An error message with the zone that is not a polygon, crosses itself or is too far away.
    pub fn new(setting: &Setting<'_>, air: Air) -> Result<Network, String> {
        let turns = Turns::of(setting.turn_radius_m, setting.circling, &air);
        Ok(Network::over(setting::ground(setting, turns.room())?, air, setting.time_s, (false, turns)))
    }

    /// Returns the network of zones drawn on a plane, each kept at `margin`, with bends of at least `turn_radius`.
    ///
    /// # Errors
    /// An error message with the zone that is not a polygon.
    pub fn on_plane(
        zones: &[PlaneZone],
        (margin, turn_radius): (f64, f64),
        air: Air,
        time_s: Span,
    ) -> Result<Network, String> {
        Network::circling_on_plane(zones, (margin, turn_radius), air, time_s, false)
    }

    /// Returns a network on a plane whose places the vehicle may circle.
    pub(super) fn circling_on_plane(
        zones: &[PlaneZone],
        (margin, turn_radius): (f64, f64),
        air: Air,
        time_s: Span,
        circling: bool,
    ) -> Result<Network, String> {
        let turns = Turns::of(turn_radius, circling, &air);
        let ground = setting::drawn(zones, margin + turns.room(), turn_radius, time_s)?;
        Ok(Network::over(ground, air, time_s, (true, turns)))
    }

    fn over(ground: PathConstraints, air: Air, time_s: Span, (on_plane, turns): (bool, Turns)) -> Network {
        let mut path_vertices = ground.path_vertices();
        path_vertices.truncate(BENDS_MAX);
        let bends_open_s = path_vertices.iter().map(|bend| ground.open_s(bend)).collect();
        let joins = path_vertices.iter().map(|_| Vec::new()).collect();
        let changes_s = ground.changes_s();
        let mut network = Network {
            changes_s,
            ground,
            air,
            time_s,
            on_plane,
            turns,
            path_vertices: Vec::new(),
            bends_open_s,
            joins,
            places: Vec::new(),
            direct: BTreeMap::new(),
            legs: Vec::new(),
            found: super::ways::FoundPaths::default(),
            work: 0,
        };
        for (number, bend) in path_vertices.iter().enumerate() {
            for (other, there) in path_vertices.iter().enumerate().skip(number + 1) {
                let Some(ride) = network.tangent(bend, there) else { continue };
                if let Some(joins) = network.joins.get_mut(number) {
                    joins.push(ArrivalTurn { bend: other, ride });
                }
                if let Some(joins) = network.joins.get_mut(other) {
                    joins.push(ArrivalTurn { bend: number, ride: ride.reversed() });
                }
            }
        }
        network.path_vertices = path_vertices;
        network
    }

    /// Returns the number of bends, for operators and tests.
    pub fn path_vertices(&self) -> usize {
        self.path_vertices.len()
    }

    /// Returns the number of examined legs and labels since the last call, for budgets.
    pub fn take_work(&mut self) -> u64 {
        std::mem::take(&mut self.work)
    }

    /// Adds a place.
    ///
    /// # Errors
    /// [`TravelError::TooFar`] if the projection does not reach the position, or if the network is one on a plane.
    pub fn add(&mut self, position: Position) -> Result<EndpointId, TravelError> {
        let spot = if self.on_plane { Err(TravelError::TooFar) } else { self.ground.spot(position) };
        spot.map(|spot| self.admit(spot))
    }

    /// Adds a place of the plane.
    ///
    /// # Errors
    /// The point is not finite.
    pub fn add_point(&mut self, point: Point) -> Result<EndpointId, TravelError> {
        self.ground.spot_on_plane(point).map(|spot| self.admit(spot))
    }

    fn admit(&mut self, spot: PreparedPoint) -> EndpointId {
        let open_s = self.ground.open_s(&spot);
        self.places.push(Endpoint { spot, open_s, track_rad: None, is_circled: false, joins: None });
        EndpointId(self.places.len() - 1)
    }

    /// Sets the direction in which a place is left and reached, clockwise from north. It counts only if turns are limited, and only for
    /// paths that are requested later.
    pub fn head(&mut self, place: EndpointId, track_rad: Option<f64>) {
        if let Some(place) = self.places.get_mut(place.0) {
            place.track_rad = track_rad.filter(|track_rad| track_rad.is_finite());
        }
    }

    /// Returns the radius of the circles over ground around places; 0 if no place is circled.
    pub fn circle_radius_m(&self) -> f64 {
        self.turns.circle_radius
    }

    /// Marks a place as circled: a path to it ends on the circle, and one from it begins anywhere on the circle, so that it takes the
    /// time from the worst point. It counts only in a [`Setting::circling`] with a turn radius, and only for paths that are requested
    /// later.
    pub fn circle(&mut self, place: EndpointId) {
        if let Some(place) = self.places.get_mut(place.0) {
            place.is_circled = self.turns.circle_radius > 0.0;
        }
    }

    /// Returns an obstacle that forbids flight at `place` at any time in `time_s`; `None` if flight is permitted throughout.
    pub fn place_trouble(&self, place: EndpointId, time_s: Span) -> Option<TravelError> {
        self.places.get(place.0).and_then(|place| self.ground.place_trouble(&place.spot, time_s))
    }

    /// Returns true if `place` is allowed at some instant of `time_s`.
    pub fn is_open_within(&self, place: EndpointId, (from_s, until_s): Span) -> bool {
        let open_s = self.places.get(place.0).map_or(&[][..], |place| &place.open_s);
        let opens = |(begin_s, end_s): &Span| {
            let at_s = begin_s.max(from_s);
            at_s <= until_s && at_s < *end_s && self.place_trouble(place, (at_s, at_s)).is_none()
        };
        open_s.iter().any(opens)
    }

    /// Returns the number of instants up to `time_s` at which zones open or close: equal numbers mean equal permissions.
    pub fn epoch(&self, time_s: f64) -> usize {
        self.changes_s.partition_point(|change_s| *change_s <= time_s)
    }

    /// Returns an obstacle on the straight leg between two positions at any time of the span.
    pub fn leg_trouble(&self, from: Position, to: Position, (from_s, until_s): Span) -> Option<TravelError> {
        let spots = self.ground.spot(from).and_then(|from| Ok((from, self.ground.spot(to)?)));
        match spots {
            Ok((from, to)) => self.ground.leg_trouble(&from, &to, (from_s, until_s)),
            Err(trouble) => Some(trouble),
        }
    }

    /// Returns the leg between two bends or a place and a bend, if it can be part of a shortest path.
    fn tangent(&mut self, from: &PreparedPoint, to: &PreparedPoint) -> Option<DirectedLeg> {
        let along = to.point.minus(from.point);
        if !from.takes(along) || !to.takes(along) {
            return None;
        }
        let leg = self.straight(from, to).ok()?;
        Some(DirectedLeg { leg, backwards: false })
    }

    fn straight(&mut self, from: &PreparedPoint, to: &PreparedPoint) -> Result<usize, TravelError> {
        self.work += 1;
        let blocks = self.ground.blocks(from, to)?;
        let course = if self.on_plane {
            Course::on_plane(from.point, to.point)
        } else {
            Course::on_earth(from.direction, to.direction)
        };
        let course = course.ok_or(TravelError::TooFar)?;
        self.legs.push(Leg { course, blocks, timings: Default::default() });
        Ok(self.legs.len() - 1)
    }

    /// Returns the straight leg between two places.
    ///
    /// # Errors
    /// The obstacle that closes the leg forever.
    pub(super) fn direct(&mut self, from: EndpointId, to: EndpointId) -> Result<DirectedLeg, TravelError> {
        let key = (from.0.min(to.0), from.0.max(to.0));
        let backwards = from.0 > to.0;
        if let Some(known) = self.direct.get(&key) {
            return known.clone().map(|leg| DirectedLeg { leg, backwards });
        }
        let spots = self.places.get(key.0).zip(self.places.get(key.1));
        let (a, b) = spots.map(|(a, b)| (a.spot.clone(), b.spot.clone())).ok_or(TravelError::TooFar)?;
        let leg = self.straight(&a, &b);
        self.direct.insert(key, leg.clone());
        leg.map(|leg| DirectedLeg { leg, backwards })
    }

    /// Returns the legs from a place to bends.
    pub(super) fn joins_of_place(&mut self, place: EndpointId) -> Vec<ArrivalTurn> {
        let Some(found) = self.places.get(place.0) else { return Vec::new() };
        if let Some(joins) = &found.joins {
            return joins.clone();
        }
        let spot = found.spot.clone();
        let path_vertices = std::mem::take(&mut self.path_vertices);
        let tangents = path_vertices.iter().enumerate();
        let joins: Vec<ArrivalTurn> = tangents
            .filter_map(|(bend, there)| Some(ArrivalTurn { bend, ride: self.tangent(&spot, there)? }))
            .collect();
        self.path_vertices = path_vertices;
        if let Some(place) = self.places.get_mut(place.0) {
            place.joins = Some(joins.clone());
        }
        joins
    }

    /// Returns the legs from a bend to other bends.
    pub(super) fn joins_of_bend(&self, bend: usize) -> &[ArrivalTurn] {
        self.joins.get(bend).map_or(&[], Vec::as_slice)
    }

    /// Returns the arrival at the end of a leg for a departure at `depart_s`.
    pub(super) fn arrive(&mut self, ride: DirectedLeg, depart_s: f64) -> f64 {
        let Some(leg) = self.legs.get_mut(ride.leg) else { return f64::INFINITY };
        let timing = leg.timings.get_mut(usize::from(ride.backwards));
        timing.map_or(f64::INFINITY, |timing| leg.course.arrive(&self.air, ride.backwards, timing, depart_s))
    }

    /// Returns the departure on a leg for an arrival at `arrive_s`.
    pub(super) fn retreat(&self, ride: DirectedLeg, arrive_s: f64) -> f64 {
        let leg = self.legs.get(ride.leg);
        leg.map_or(f64::NEG_INFINITY, |leg| leg.course.retreat(&self.air, ride.backwards, arrive_s, 1.0))
    }

    /// Returns the departures at which a leg is closed.
    pub(super) fn closed(&mut self, ride: DirectedLeg) -> &[Span] {
        let Some(leg) = self.legs.get_mut(ride.leg) else { return &[] };
        let timing = leg.timings.get_mut(usize::from(ride.backwards));
        timing.map_or(&[], |timing| leg.course.closed(&self.air, ride.backwards, &leg.blocks, timing))
    }

    /// Returns the first departure from `ready_s` on at which the leg is open.
    pub(super) fn first_open(&mut self, ride: DirectedLeg, ready_s: f64) -> f64 {
        first_open(self.closed(ride), ready_s)
    }

    /// Returns the length of a leg.
    pub(super) fn length(&self, ride: DirectedLeg) -> f64 {
        self.legs.get(ride.leg).map_or(f64::INFINITY, |leg| leg.course.length())
    }

    /// Returns the position of a bend.
    pub(super) fn bend(&self, bend: usize) -> Option<&PreparedPoint> {
        self.path_vertices.get(bend)
    }
}

/// Returns the leg in the opposite direction.
pub(super) fn reversed(join: &ArrivalTurn) -> DirectedLeg {
    join.ride.reversed()
}
