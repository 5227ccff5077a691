//! Paths with turns along arcs: at both ends and at every bend, in the local wind.
//!
//! A path passes each of its bends in the direction halfway between its legs, so that around a zone it swings to the outside. Between
//! bends it is a turn-limited path ([`super::dubins`]) in the average wind of that piece; directions at its ends are those of their
//! places, if they have one, otherwise free. Of the path types the fastest is chosen that avoids everything that is closed forever. The
//! time of turns beyond the straight path is the same at every departure: that in the worst wind of the considered time, so that a later
//! departure never arrives earlier. From a circled place, a path takes its time from the worst point of the circle, and to one it ends on
//! the circle ([`super::circles`]).
//! Bound: eight path types for each piece and wind, and a query of the constraints for each chord of the paths tried.

use super::circles::{End, On, Passage, Rounds};
use super::dubins::{Flyer, Pose, TurnPath};
use super::ground::PreparedPoint;
use super::network::{EndpointId, Network};
use super::passing::ShutPart;
use super::spans::Span;
use super::ways::PathId;
use crate::direction::Direction;
use crate::geodesy::{self, EARTH_RADIUS_M_MEAN, Position};
use crate::plane::Point;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Greatest deviation of drawn paths from the flown one, as a share of the radius: 3 m of 3 km.
pub const TOLERANCE_SHARE: f64 = 1e-3;
/// Points of a piece, as shares of its length, at which the wind is sampled.
const WIND_SHARES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// Number of directions examined at a place whose direction is free.
const TRACKS: usize = 32;
/// Work of one piece in one wind, in examined legs.
const LOOKS_PER_PIECE: u64 = 20;

/// A path over ground as points, on the Earth and on the plane.
type Drawn = Vec<(Position, Point)>;

/// Departure from and arrival at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum At {
    /// In any direction.
    Free,
    /// In this direction, clockwise from north.
    Track(f64),
    /// On a circle around it.
    Circle,
}

/// Position on a circle around a place, and sense of the flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circling {
    /// Bearing of the vehicle from the place, clockwise from north.
    pub bearing_rad: f64,
    /// True if the vehicle turns to the right.
    pub clockwise: bool,
}

/// Effect of turns on a path.
#[derive(Clone, Debug)]
pub(super) struct Turned {
    /// Time in addition to the straight legs.
    pub(super) extra_s: f64,
    /// Departures at which a part of the flown path away from the legs is closed.
    pub(super) closed_s: Vec<Span>,
    /// For each span of the air the path over ground.
    spots: Vec<Drawn>,
}

/// A piece from one bend to the next, along the x axis of a local plane.
struct TurnLeg<'a> {
    from: &'a PreparedPoint,
    to: &'a PreparedPoint,
    length: f64,
    frame: Frame,
    /// Bearings of the straight line at both ends, clockwise from north.
    bearings_rad: (f64, f64),
}

/// Orientation of a piece's plane.
enum Frame {
    /// On the map: the directions of its axes.
    Plane(Point, Point),
    /// On the Earth: the directions up, along and to the left at its beginning, and radians per metre.
    Earth([Direction; 3], f64),
}

impl TurnLeg<'_> {
    fn of<'a>(from: &'a PreparedPoint, to: &'a PreparedPoint, on_plane: bool) -> TurnLeg<'a> {
        let bearing = |(east, north): (f64, f64)| libm::atan2(east, north);
        if on_plane {
            let apart = to.point.minus(from.point);
            let along = apart.unit().unwrap_or(Point { x: 1.0, y: 0.0 });
            let bearing_rad = bearing((along.x, along.y));
            let frame = Frame::Plane(along, Point { x: -along.y, y: along.x });
            return TurnLeg { from, to, length: apart.length(), frame, bearings_rad: (bearing_rad, bearing_rad) };
        }
        let up = from.direction;
        // Between two identical places the direction of the line is arbitrary.
        let beside = Direction::of(geodesy::destination(from.position, 90.0, 1_000.0));
        let near = up.quarter_turn_to(to.direction).is_none();
        let along = up.quarter_turn_to(if near { beside } else { to.direction }).unwrap_or(beside);
        let left = up.cross(along);
        let (length, angle_rad) = match near {
            true => (0.0, 0.0),
            false => (up.distance_m(to.direction), up.angle_rad(to.direction)),
        };
        let per_m = if length > 0.0 { angle_rad / length } else { 1.0 / EARTH_RADIUS_M_MEAN };
        let ahead = up.blended(-libm::sin(angle_rad), along, libm::cos(angle_rad));
        let bearings_rad = (bearing(up.east_north(along)), bearing(to.direction.east_north(ahead)));
        TurnLeg { from, to, length, frame: Frame::Earth([up, along, left], per_m), bearings_rad }
    }

    /// Returns a point of the piece's plane on the ground.
    fn place(&self, point: Point) -> (Position, Point, Direction) {
        match &self.frame {
            Frame::Plane(along, left) => {
                let there = self.from.point.plus(point.x, *along).plus(point.y, *left);
                (Position::default(), there, Direction::default())
            }
            Frame::Earth([up, along, left], per_m) => {
                let (x, y) = (point.x * per_m, point.y * per_m);
                let below = up.blended(libm::cos(x), *along, libm::sin(x));
                let there = below.blended(libm::cos(y), *left, libm::sin(y));
                (there.position(), Point::default(), there)
            }
        }
    }

    /// Returns the mean wind of an interval of the air, along the piece and to its left.
    fn wind(&self, network: &Network, span: usize) -> Point {
        let mut mean = Point::default();
        for share in WIND_SHARES {
            let (east_mps, north_mps) = match &self.frame {
                Frame::Plane(..) => network.air.wind(span, Position::default()),
                Frame::Earth(..) => network.air.wind(span, self.place(Point { x: share * self.length, y: 0.0 }).0),
            };
            let bearing_rad = self.bearings_rad.0 + share * turn_rad(self.bearings_rad.1 - self.bearings_rad.0);
            let (east, north) = (libm::sin(bearing_rad), libm::cos(bearing_rad));
            let here = Point { x: east_mps * east + north_mps * north, y: north_mps * east - east_mps * north };
            mean = mean.plus(1.0 / WIND_SHARES.len() as f64, here);
        }
        mean
    }
}

impl TurnLeg<'_> {
    fn end(&self) -> Point {
        Point { x: self.length, y: 0.0 }
    }

    /// Returns the direction at the beginning or the end, from the x axis to the left; `None` if any direction will do.
    fn track_rad(&self, at: At, behind: bool) -> Option<f64> {
        let bearing_rad = if behind { self.bearings_rad.1 } else { self.bearings_rad.0 };
        if let At::Track(track_rad) = at { Some(bearing_rad - track_rad) } else { None }
    }

    fn target(&self, to: At) -> End {
        match (to, self.track_rad(to, true)) {
            (At::Circle, _) => End::Circle(self.end()),
            (_, Some(track_rad)) => End::Pose(self.end(), track_rad),
            (_, None) => End::Place(self.end()),
        }
    }

    /// Returns a position on the circle around the beginning.
    fn on(&self, from: Circling) -> On {
        let sense = if from.clockwise { -1.0 } else { 1.0 };
        let track_rad = self.bearings_rad.0 - from.bearing_rad + sense * FRAC_PI_2;
        On { centre: Point::default(), sense, track_rad }
    }

    /// Returns a position on the circle around the end.
    fn circling(&self, on: On) -> Circling {
        let bearing_rad = self.bearings_rad.1 - (on.track_rad - on.sense * FRAC_PI_2);
        Circling { bearing_rad, clockwise: on.sense < 0.0 }
    }

    fn shown(&self, point: Point) -> (Position, Point) {
        let (position, on_map, _) = self.place(point);
        (position, on_map)
    }
}

/// Returns the directions that are tried if no direction is required.
fn tracks() -> impl Iterator<Item = f64> {
    (0..TRACKS).map(|index| TAU * index as f64 / TRACKS as f64)
}

/// Returns the directions in which a place inside a vehicle's turns can be reached.
fn poses(point: Point) -> Vec<End> {
    tracks().map(|track_rad| End::Pose(point, track_rad)).collect()
}

/// Returns an angle between minus half a circle and half a circle.
fn turn_rad(angle_rad: f64) -> f64 {
    angle_rad - TAU * libm::round(angle_rad / TAU)
}

impl Network {
    /// Returns the effect of turns on a path; `None` if there is no space for them. Called only if turns are limited.
    pub(super) fn turn(&mut self, way: PathId) -> Option<Turned> {
        let (spots, ends) = self.ends_and_bends(way)?;
        let (pieces, at) = self.pieces(&spots, ends);
        let circled = at.contains(&At::Circle);
        let mut turned = Turned { extra_s: 0.0, closed_s: Vec::new(), spots: Vec::new() };
        let (mut shut, mut flown, mut lasts_s) = (Vec::new(), false, 0.0_f64);
        for span in 0..self.air.spans() {
            let (mut extra_s, mut total_s, mut path) = (0.0, 0.0, Vec::new());
            let ends = at.iter().copied().zip(at.iter().copied().skip(1));
            let mut possible = true;
            for (piece, ends) in pieces.iter().zip(ends) {
                self.work += LOOKS_PER_PIECE;
                let wind_mps = piece.wind(self, span);
                let flyer = Flyer {
                    true_airspeed_mps: self.air.true_airspeed_mps(),
                    turn_radius_m: self.turns.radius,
                    wind_mps,
                };
                let Some(straight_s) = straight_s(&flyer, piece.length) else {
                    // The straight legs are closed while this wind blows.
                    possible = false;
                    break;
                };
                if let (At::Circle, _) | (_, At::Circle) = ends {
                    let time_s = self.circled_s(piece, wind_mps, ends)?;
                    extra_s += (time_s - straight_s).max(0.0);
                    total_s += time_s;
                    continue;
                }
                let (found, points, blocked) = self.free_path(piece, &flyer, ends)?;
                extra_s += (found.time_s - straight_s).max(0.0);
                let before = total_s * self.air.ground_speed_mps_max();
                shut.extend(blocked.into_iter().map(|part| part.after(before)));
                total_s += found.time_s;
                path.extend(points);
            }
            if possible {
                (flown, lasts_s) = (true, lasts_s.max(total_s));
                turned.extra_s = turned.extra_s.max(extra_s);
            }
            // Between circles, the flown path depends on where the previous circle was left.
            turned.spots.push(if circled { Vec::new() } else { path });
        }
        turned.closed_s = ShutPart::closed_s(shut, &self.air, (lasts_s, turned.extra_s));
        flown.then_some(turned)
    }

    /// Returns the fastest path over a piece that avoids what is closed forever, as points over ground, and its parts that zones shut.
    fn free_path(
        &self,
        piece: &TurnLeg<'_>,
        flyer: &Flyer,
        (from, to): (At, At),
    ) -> Option<(TurnPath, Drawn, Vec<ShutPart>)> {
        let begin = Pose { point: Point::default(), track_rad: piece.track_rad(from, false) };
        let end = Pose { point: piece.end(), track_rad: piece.track_rad(to, true) };
        let tolerance = TOLERANCE_SHARE * self.turns.radius;
        flyer.paths(begin, end).into_iter().find_map(|path| {
            let mut spots: Vec<PreparedPoint> = vec![piece.from.clone()];
            let inner = path.points(tolerance);
            for point in inner.get(1..inner.len().saturating_sub(1)).unwrap_or_default() {
                let (position, on_map, _) = piece.place(*point);
                spots.push(self.ground.between((piece.from, piece.to), position, on_map)?);
            }
            spots.push(piece.to.clone());
            let (mut blocked, mut before) = (Vec::new(), 0.0);
            for (ends, chord) in spots.windows(2).zip(inner.windows(2)) {
                let ([from, to], [first, last]) = (ends, chord) else { continue };
                let blocks = self.ground.blocks_wider(from, to, 1.05 * tolerance).ok()?;
                let after = before + last.minus(*first).length();
                blocked.extend(blocks.into_iter().map(|block| ShutPart::of(block, (before, after))));
                before = after;
            }
            Some((path, spots.into_iter().map(|spot| (spot.position, spot.point)).collect(), blocked))
        })
    }

    /// Returns the pieces of a path, and the directions at the places between them: halfway between two legs.
    fn pieces<'a>(&self, spots: &'a [PreparedPoint], ends: (At, At)) -> (Vec<TurnLeg<'a>>, Vec<At>) {
        let pairs = spots.iter().zip(spots.iter().skip(1));
        let pieces: Vec<TurnLeg<'a>> = pairs.map(|(from, to)| TurnLeg::of(from, to, self.on_plane)).collect();
        let mut at = vec![ends.0];
        for (into, out) in pieces.iter().zip(pieces.iter().skip(1)) {
            let (into_rad, out_rad) = (into.bearings_rad.1, out.bearings_rad.0);
            at.push(At::Track(into_rad + 0.5 * turn_rad(out_rad - into_rad)));
        }
        at.push(ends.1);
        (pieces, at)
    }

    /// Returns the greatest time of a piece with a circle at one or both ends; `None` if there is no space for it.
    fn circled_s(&self, piece: &TurnLeg<'_>, wind_mps: Point, ends: (At, At)) -> Option<f64> {
        let rounds = self.rounds(wind_mps)?;
        if ends.0 != At::Circle {
            return Some(self.passage(piece, &rounds, ends, None)?.time_s);
        }
        let opposite = self.has_room_for_the_opposite_turn(piece, ends.1)?;
        let worst_s = |end: End| rounds.worst(Point::default(), end, opposite);
        let least_s = |ends: Vec<End>| ends.into_iter().filter_map(worst_s).min_by(f64::total_cmp);
        match ends.1 {
            At::Free => worst_s(End::Place(piece.end())).or_else(|| least_s(poses(piece.end()))),
            to => worst_s(piece.target(to)),
        }
    }

    fn rounds(&self, wind_mps: Point) -> Option<Rounds> {
        Rounds::new(self.turns.circle_radius, self.air.true_airspeed_mps(), wind_mps)
    }

    /// Returns true if a circle at the beginning of a piece may be left by the opposite turn; `None` without room for circles.
    fn has_room_for_the_opposite_turn(&self, piece: &TurnLeg<'_>, to: At) -> Option<bool> {
        let (radius, room) = (self.turns.circle_radius, self.turns.room());
        let clear = |width: f64| self.ground.is_clear(piece.from, piece.to, (width, room));
        let narrow = if let At::Track(_) = to { 2.0 * radius } else { radius };
        match (clear(room), clear(narrow)) {
            (true, _) => Some(true),
            (_, narrow) => narrow.then_some(false),
        }
    }

    /// Returns the fastest flight over a piece with a circle at one or both ends, from `on` if it begins on a circle, otherwise from the
    /// best point of the circle.
    fn passage(&self, piece: &TurnLeg<'_>, rounds: &Rounds, ends: (At, At), on: Option<On>) -> Option<Passage> {
        if ends.0 != At::Circle {
            let wide = (2.0 * self.turns.circle_radius, self.turns.room());
            let track_rad = piece.track_rad(ends.0, false);
            let clear = self.ground.is_clear(piece.from, piece.to, wide);
            return rounds.to_circle(Point::default(), track_rad, piece.end()).filter(|_| clear);
        }
        let opposite = self.has_room_for_the_opposite_turn(piece, ends.1)?;
        let anywhere = || [1.0, -1.0].into_iter().flat_map(|sense| tracks().map(move |track_rad| (sense, track_rad)));
        let ons: Vec<On> = match on {
            Some(on) => vec![on],
            None => anywhere().map(|(sense, track_rad)| On { centre: Point::default(), sense, track_rad }).collect(),
        };
        let mut targets = vec![piece.target(ends.1)];
        if ends.1 == At::Free {
            targets.extend(poses(piece.end()));
        }
        let quickest = |end: End| {
            let found = ons.iter().filter_map(|on| rounds.passage(*on, end, opposite));
            found.min_by(|a, b| a.time_s.total_cmp(&b.time_s))
        };
        targets.into_iter().find_map(quickest)
    }

    /// Returns the flight along a path with a circle at one or both ends, for a vehicle that leaves the first circle at `from` (`None`:
    /// at the best point), as points within [`TOLERANCE_SHARE`] of the radius; and the position on the circle at its end. Empty if the
    /// space does not suffice.
    pub fn circling_path(
        &mut self,
        way: PathId,
        depart_s: f64,
        from: Option<Circling>,
    ) -> (Vec<Position>, Option<Circling>) {
        let (spots, there) = self.circling_spots(way, depart_s, from).unwrap_or_default();
        (spots.into_iter().map(|(position, _)| position).collect(), there)
    }

    pub(super) fn circling_spots(
        &self,
        way: PathId,
        depart_s: f64,
        from: Option<Circling>,
    ) -> Option<(Drawn, Option<Circling>)> {
        let (spots, ends) = self.ends_and_bends(way)?;
        let (pieces, at) = self.pieces(&spots, ends);
        let (mut drawn, mut there) = (Drawn::new(), from);
        let tolerance = TOLERANCE_SHARE * self.turns.radius;
        for (piece, ends) in pieces.iter().zip(at.iter().copied().zip(at.iter().copied().skip(1))) {
            let wind_mps = piece.wind(self, self.air.span_at(depart_s));
            if let (At::Circle, _) | (_, At::Circle) = ends {
                let rounds = self.rounds(wind_mps)?;
                let passage = self.passage(piece, &rounds, ends, there.map(|there| piece.on(there)))?;
                let points = rounds.points(&passage, tolerance);
                drawn.extend(points.into_iter().map(|point| piece.shown(point)));
                there = passage.end().filter(|_| ends.1 == At::Circle).map(|on| piece.circling(on));
            } else {
                let true_airspeed_mps = self.air.true_airspeed_mps();
                let flyer = Flyer { true_airspeed_mps, turn_radius_m: self.turns.radius, wind_mps };
                drawn.extend(self.free_path(piece, &flyer, ends)?.1);
            }
        }
        drawn.dedup();
        Some((drawn, there))
    }

    /// Returns the points of some time on the circle around a place, and the position afterwards.
    pub fn circling_arc(
        &self,
        place: EndpointId,
        from: Circling,
        (begin_s, lasts_s): (f64, f64),
    ) -> (Vec<Position>, Circling) {
        let (spots, there) = self.circling_arc_spots(place, from, (begin_s, lasts_s)).unwrap_or((Drawn::new(), from));
        (spots.into_iter().map(|(position, _)| position).collect(), there)
    }

    pub(super) fn circling_arc_spots(
        &self,
        place: EndpointId,
        from: Circling,
        (begin_s, lasts_s): (f64, f64),
    ) -> Option<(Drawn, Circling)> {
        let spot = &self.places.get(place.0)?.spot;
        let piece = TurnLeg::of(spot, spot, self.on_plane);
        let rounds = self.rounds(piece.wind(self, self.air.span_at(begin_s)))?;
        let on = piece.on(from);
        let (after, by_rad) = rounds.after(on, lasts_s);
        // Many rounds are drawn as one round and the remainder.
        let shown_rad = if by_rad > TAU { TAU + by_rad % TAU } else { by_rad };
        let points = rounds.arc(on, shown_rad, TOLERANCE_SHARE * self.turns.radius);
        Some((points.into_iter().map(|point| piece.shown(point)).collect(), piece.circling(after)))
    }

    /// Returns true if there is space to circle around a place.
    pub fn has_room_to_circle(&self, place: EndpointId) -> bool {
        let Some(spot) = self.places.get(place.0).map(|place| &place.spot) else { return false };
        let wide = (self.turns.circle_radius, self.turns.room());
        self.turns.circle_radius <= 0.0 || self.ground.is_clear(spot, spot, wide)
    }

    /// Returns the time that turns add to the straight legs of a path; 0 if turns are not limited.
    pub fn turns_s(&mut self, way: PathId) -> f64 {
        self.turned(way).map_or(0.0, |turned| turned.extra_s)
    }

    /// Returns the path over ground of a trip, turns included, as points within [`TOLERANCE_SHARE`] of the radius. Without limits of
    /// turns, the ends and bends.
    pub fn path(&mut self, way: PathId, depart_s: f64) -> Vec<Position> {
        self.path_spots(way, depart_s).into_iter().map(|(position, _)| position).collect()
    }

    /// Returns the path on the plane.
    pub fn path_points(&mut self, way: PathId, depart_s: f64) -> Vec<Point> {
        self.path_spots(way, depart_s).into_iter().map(|(_, point)| point).collect()
    }

    fn path_spots(&mut self, way: PathId, depart_s: f64) -> Drawn {
        let span = self.air.span_at(depart_s);
        let turned = self.turned(way).and_then(|turned| turned.spots.get(span)).filter(|spots| !spots.is_empty());
        let mut spots = turned.cloned().unwrap_or_else(|| self.spots(way));
        spots.dedup();
        spots
    }
}

/// Returns the time of the straight line; `None` if the wind does not permit it.
fn straight_s(flyer: &Flyer, length: f64) -> Option<f64> {
    let heading_rad = flyer.heading_rad(0.0)?;
    let speed_mps = flyer.true_airspeed_mps * libm::cos(heading_rad) + flyer.wind_mps.x;
    (speed_mps > 0.0).then(|| length / speed_mps)
}
