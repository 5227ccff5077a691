//! Ways of who cannot turn at once: turns at both ends and at every bend, in the wind that blows there.
//!
//! A way is flown through its bends, each in the direction halfway between its legs, so that around a zone it swings to the
//! outside. From bend to bend it is a turn-limited path ([`super::dubins`]) in the mean wind of that piece; directions at its
//! ends are those of their places, where they have one, and free else. Of the words the quickest is taken that keeps out of
//! all that is shut for ever. What turning costs beyond the straight way is the same at every departure, namely what it costs
//! in the worst of the winds of the time looked at, so that nobody who leaves later is there earlier.
//! Bound: eight words for each piece and wind, a question to the ground for each chord of some.

use super::dubins::{Flyer, Pose, TurnPath};
use super::ground::Spot;
use super::network::Network;
use super::spans::Span;
use super::ways::WayId;
use crate::direction::Direction;
use crate::geodesy::{self, EARTH_RADIUS_M_MEAN, Position};
use crate::plane::Point;
use std::f64::consts::TAU;

/// Drawn paths are never farther than this share of the radius from what is flown: 3 m of 3 km.
pub const TOLERANCE_SHARE: f64 = 1e-3;
/// Places of a piece where its wind is taken.
const WIND_SHARES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// Work of one piece in one wind, in legs looked at.
const LOOKS_PER_PIECE: u64 = 20;

/// A path over ground as points, on the Earth and on the plane.
type Drawn = Vec<(Position, Point)>;
/// Directions in which a way begins and ends, clockwise from north; none is any.
pub(super) type Tracks = (Option<f64>, Option<f64>);

/// What turning makes of a way.
#[derive(Clone, Debug)]
pub(super) struct Turned {
    /// What it takes more than the straight legs.
    pub(super) extra_s: f64,
    /// Departures at which something is shut beside the legs.
    pub(super) closed_s: Vec<Span>,
    /// For each span of the air the path over ground.
    spots: Vec<Drawn>,
}

/// From one bend to the next: along the x axis of its own plane.
struct Piece<'a> {
    from: &'a Spot,
    to: &'a Spot,
    length: f64,
    frame: Frame,
    /// Bearings of the straight line at both ends, clockwise from north.
    bearings_rad: (f64, f64),
}

/// How a piece's own plane lies.
enum Frame {
    /// On the map: the directions of its axes.
    Plane(Point, Point),
    /// On the Earth: up, along and to the left where it begins, and radians for a metre.
    Earth([Direction; 3], f64),
}

impl Piece<'_> {
    fn of<'a>(from: &'a Spot, to: &'a Spot, on_plane: bool) -> Piece<'a> {
        let bearing = |(east, north): (f64, f64)| libm::atan2(east, north);
        if on_plane {
            let apart = to.point.minus(from.point);
            let along = apart.unit().unwrap_or(Point { x: 1.0, y: 0.0 });
            let bearing_rad = bearing((along.x, along.y));
            let frame = Frame::Plane(along, Point { x: -along.y, y: along.x });
            return Piece { from, to, length: apart.length(), frame, bearings_rad: (bearing_rad, bearing_rad) };
        }
        let up = from.direction;
        // Between two places that are one, any line will do.
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
        Piece { from, to, length, frame: Frame::Earth([up, along, left], per_m), bearings_rad }
    }

    /// A point of the piece's plane on the ground.
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

    /// The mean wind of a span of the air, along the piece and to its left.
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

/// An angle between minus half a circle and half a circle.
fn turn_rad(angle_rad: f64) -> f64 {
    angle_rad - TAU * libm::round(angle_rad / TAU)
}

impl Network {
    /// What turning makes of a way; none where there is no room for it. Only asked where turns are limited.
    pub(super) fn turn(&mut self, way: WayId) -> Option<Turned> {
        let (spots, tracks_rad) = self.ends_and_bends(way)?;
        let pieces: Vec<Piece<'_>> =
            spots.iter().zip(spots.iter().skip(1)).map(|(from, to)| Piece::of(from, to, self.on_plane)).collect();
        let mut tracks: Vec<Option<f64>> = vec![tracks_rad.0];
        for (into, out) in pieces.iter().zip(pieces.iter().skip(1)) {
            let (into_rad, out_rad) = (into.bearings_rad.1, out.bearings_rad.0);
            tracks.push(Some(into_rad + 0.5 * turn_rad(out_rad - into_rad)));
        }
        tracks.push(tracks_rad.1);
        let mut turned = Turned { extra_s: 0.0, closed_s: Vec::new(), spots: Vec::new() };
        let (mut shut, mut flown, mut lasts_s) = (Vec::new(), false, 0.0_f64);
        for span in 0..self.air.spans() {
            let (mut extra_s, mut total_s, mut path) = (0.0, 0.0, Vec::new());
            let ends = tracks.iter().zip(tracks.iter().skip(1));
            let mut possible = true;
            for (piece, (from_rad, to_rad)) in pieces.iter().zip(ends) {
                self.work += LOOKS_PER_PIECE;
                let wind_mps = piece.wind(self, span);
                let flyer = Flyer {
                    true_airspeed_mps: self.air.true_airspeed_mps(),
                    turn_radius_m: self.turn_radius,
                    wind_mps,
                };
                let Some(straight_s) = straight_s(&flyer, piece.length) else {
                    // The legs themselves are shut while this wind blows.
                    possible = false;
                    break;
                };
                let (found, points, blocked) = self.free_path(piece, &flyer, (*from_rad, *to_rad))?;
                extra_s += (found.time_s - straight_s).max(0.0);
                total_s += found.time_s;
                shut.extend(blocked);
                path.extend(points);
            }
            if possible {
                (flown, lasts_s) = (true, lasts_s.max(total_s));
                turned.extra_s = turned.extra_s.max(extra_s);
            }
            turned.spots.push(path);
        }
        // Who leaves before a zone shuts must be through, wherever on the way it lies; winds between two pieces count too.
        let longest_s = 2.0 * lasts_s + turned.extra_s;
        turned.closed_s.extend(shut.into_iter().map(|(shut_s, open_s): Span| (shut_s - longest_s, open_s)));
        flown.then_some(turned)
    }

    /// The quickest path over a piece that keeps out of what is shut for ever, as points over ground, and when zones that it
    /// meets are shut.
    fn free_path(
        &self,
        piece: &Piece<'_>,
        flyer: &Flyer,
        (from_rad, to_rad): Tracks,
    ) -> Option<(TurnPath, Drawn, Vec<Span>)> {
        let pose = |x: f64, track_rad: Option<f64>, bearing_rad: f64| Pose {
            point: Point { x, y: 0.0 },
            track_rad: track_rad.map(|track_rad| bearing_rad - track_rad),
        };
        let begin = pose(0.0, from_rad, piece.bearings_rad.0);
        let end = pose(piece.length, to_rad, piece.bearings_rad.1);
        let tolerance = TOLERANCE_SHARE * self.turn_radius;
        flyer.paths(begin, end).into_iter().find_map(|path| {
            let mut spots: Vec<Spot> = vec![piece.from.clone()];
            let inner = path.points(tolerance);
            let between = inner.len().saturating_sub(2);
            for point in inner.into_iter().skip(1).take(between) {
                let (position, on_map, _) = piece.place(point);
                spots.push(self.ground.between((piece.from, piece.to), position, on_map)?);
            }
            spots.push(piece.to.clone());
            let mut blocked = Vec::new();
            for (from, to) in spots.iter().zip(spots.iter().skip(1)) {
                let blocks = self.ground.blocks_wider(from, to, 1.05 * tolerance).ok()?;
                blocked.extend(blocks.into_iter().map(|block| block.time_s));
            }
            Some((path, spots.into_iter().map(|spot| (spot.position, spot.point)).collect(), blocked))
        })
    }

    /// The path over ground of a trip, turns included: points never farther than [`TOLERANCE_SHARE`] of the radius from it.
    /// Without limits of turns, the ends and bends.
    pub fn path(&mut self, way: WayId, depart_s: f64) -> Vec<Position> {
        self.path_spots(way, depart_s).into_iter().map(|(position, _)| position).collect()
    }

    /// The same on the plane.
    pub fn path_points(&mut self, way: WayId, depart_s: f64) -> Vec<Point> {
        self.path_spots(way, depart_s).into_iter().map(|(_, point)| point).collect()
    }

    fn path_spots(&mut self, way: WayId, depart_s: f64) -> Drawn {
        let span = self.air.span_at(depart_s);
        let turned = self.turned(way).and_then(|turned| turned.spots.get(span)).filter(|spots| !spots.is_empty());
        let mut spots = turned.cloned().unwrap_or_else(|| self.spots(way));
        spots.dedup();
        spots
    }
}

/// What the straight line takes; none where the wind does not allow it.
fn straight_s(flyer: &Flyer, length: f64) -> Option<f64> {
    let heading_rad = flyer.heading_rad(0.0)?;
    let speed_mps = flyer.true_airspeed_mps * libm::cos(heading_rad) + flyer.wind_mps.x;
    (speed_mps > 0.0).then(|| length / speed_mps)
}
