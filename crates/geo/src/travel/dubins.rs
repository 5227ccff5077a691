//! Turn-limited paths: the fastest path from one pose to another for a vehicle with a least turn radius, in a steady
//! wind.
//!
//! Without wind such a path is a turn, a straight line or an opposite turn, and a turn (Dubins 1957). A wind that is the same everywhere
//! moves the air as a whole: seen from the air the end moves against the wind, and the solution is the first instant at which a path of
//! exactly that duration reaches it (McGee, Spry and Hedrick 2005; Techy and Woolsey 2009). This instant is searched for each path type
//! separately, beginning with the arrival of a straight flight. A track that is not given is free: the turn at that end is then left out.
//! Bound: [`INSTANTS_MAX`] instants for each of eight path types, mostly some tens; one without wind.

mod idle;
mod instants;
mod search;

use crate::plane::{Point, point_to_segment};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Instants examined within the time of a full circle, and in total; bisection steps between two of them.
const INSTANTS_PER_CIRCLE: f64 = 48.0;
const INSTANTS_MAX: f64 = 2_000.0;
const HALVINGS: usize = 52;
/// The instant is known to this share of the time.
const EXACT: f64 = 1e-9;
/// A turn that is nearer than this to a full circle counts as no turn.
const NO_TURN_RAD: f64 = 1e-9;
/// Number of tracks that are examined if one is free and the two places are too near for a path without a turn there.
const TRACKS: usize = 16;

/// A place with a direction over ground, counter-clockwise from the x axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position.
    pub point: Point,
    /// Direction over ground; `None` for any direction.
    pub track_rad: Option<f64>,
}

/// Vehicle and wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flyer {
    /// Speed through the air.
    pub true_airspeed_mps: f64,
    /// Least radius of a turn through the air.
    pub turn_radius_m: f64,
    /// Velocity of the wind (direction in which the air moves).
    pub wind_mps: Point,
}

/// A turn to the left (1), to the right (-1) or none (0), and its length through the air.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Part {
    /// Sense.
    pub turn: f64,
    /// Length.
    pub length_m: f64,
}

/// A path from pose to pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnPath {
    from: Point,
    heading_rad: f64,
    flyer: Flyer,
    /// Its parts in order.
    pub parts: [Part; 3],
    /// Duration.
    pub time_s: f64,
}

/// Returns the least radius of a level turn at `true_airspeed_mps` with a roll angle of `roll_rad`, from the balance of weight and lift.
pub fn turn_radius_m(true_airspeed_mps: f64, roll_rad: f64) -> f64 {
    const GRAVITY_MPS2: f64 = 9.806_65;
    true_airspeed_mps * true_airspeed_mps / (GRAVITY_MPS2 * libm::tan(roll_rad))
}

pub(super) fn unit(angle_rad: f64) -> Point {
    Point { x: libm::cos(angle_rad), y: libm::sin(angle_rad) }
}

/// Returns the direction to the left of `angle_rad`.
pub(super) fn left(angle_rad: f64) -> Point {
    Point { x: -libm::sin(angle_rad), y: libm::cos(angle_rad) }
}

pub(super) fn angle(vector: Point) -> f64 {
    libm::atan2(vector.y, vector.x)
}

/// Returns the angle of a turn in the sense `turn` that changes the direction by `by_rad` to the left.
pub(super) fn turned(turn: f64, by_rad: f64) -> f64 {
    let around = turn * by_rad;
    let rest = around - TAU * libm::floor(around / TAU);
    if rest > TAU - NO_TURN_RAD { 0.0 } else { rest }
}

impl Flyer {
    /// Returns the heading that gives the track; `None` if the wind does not permit it.
    pub fn heading_rad(&self, track_rad: f64) -> Option<f64> {
        let across = self.wind_mps.dot(left(track_rad)) / self.true_airspeed_mps;
        let along = self.wind_mps.dot(unit(track_rad));
        if across.abs() >= 1.0 {
            return None;
        }
        let heading_rad = track_rad - libm::asin(across);
        let ahead_mps = self.true_airspeed_mps * libm::cos(heading_rad - track_rad) + along;
        (ahead_mps > 0.0).then_some(heading_rad)
    }

    /// Returns all paths from one pose to the other, each the fastest of its type, fastest first; empty if the wind is too strong for a
    /// pose, or faster than the vehicle.
    pub fn paths(&self, from: Pose, to: Pose) -> Vec<TurnPath> {
        let Some((start, end)) = self.headings(from, to) else { return Vec::new() };
        let search = PathSearch::new(self, (from, start), (to, end));
        let mut found: Vec<TurnPath> =
            words(start.is_some(), end.is_some()).filter_map(|word| search.path(word, f64::INFINITY)).collect();
        if found.is_empty() {
            // The places are too near for a turn at one end only: directions at intervals of a full circle over [`TRACKS`] are examined
            // at the other.
            let tracks = (0..TRACKS).map(|index| Some(index as f64 * TAU / TRACKS as f64));
            for track_rad in tracks.filter(|_| start.is_none() || end.is_none()) {
                let from = Pose { track_rad: from.track_rad.or(track_rad), ..from };
                let to = Pose { track_rad: to.track_rad.or(track_rad), ..to };
                found.extend(self.paths(from, to));
            }
        }
        found.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        found
    }

    /// Returns the first of [`Flyer::paths`]. A path type is not tried at instants at which another type has already arrived, so the types
    /// that are probably short are tried first.
    pub fn quickest(&self, from: Pose, to: Pose) -> Option<TurnPath> {
        let (start, end) = self.headings(from, to)?;
        let search = PathSearch::new(self, (from, start), (to, end));
        let mut tried: Vec<(f64, usize, PathType)> = words(start.is_some(), end.is_some())
            .enumerate()
            .map(|(number, word)| (search.guess_m(word), number, word))
            .collect();
        tried.sort_by(|(a_m, a, _), (b_m, b, _)| a_m.total_cmp(b_m).then(a.cmp(b)));
        let mut best: Option<(TurnPath, usize)> = None;
        for (_, number, word) in tried {
            let until_s = best.map_or(f64::INFINITY, |(best, _)| best.time_s);
            let Some(path) = search.path(word, until_s) else { continue };
            // Of equally fast paths the one of the first type counts.
            let is_better = |(best, first): (TurnPath, usize)| {
                path.time_s < best.time_s || (path.time_s == best.time_s && number < first)
            };
            if best.is_none_or(is_better) {
                best = Some((path, number));
            }
        }
        best.map(|(best, _)| best).or_else(|| self.paths(from, to).first().copied())
    }

    /// Returns the headings at both ends, for stated tracks; `None` if the wind permits no path.
    fn headings(&self, from: Pose, to: Pose) -> Option<(Option<f64>, Option<f64>)> {
        let slow = libm::hypot(self.wind_mps.x, self.wind_mps.y) >= self.true_airspeed_mps;
        if slow || self.turn_radius_m.is_nan() || self.turn_radius_m <= 0.0 {
            return None;
        }
        let heading = |pose: Pose| pose.track_rad.map(|track_rad| self.heading_rad(track_rad));
        match (heading(from), heading(to)) {
            (Some(None), _) | (_, Some(None)) => None,
            (start, end) => Some((start.flatten(), end.flatten())),
        }
    }
}

/// Paths from one pose to another, whatever their types.
struct PathSearch<'a> {
    flyer: &'a Flyer,
    from: (Pose, Option<f64>),
    to: (Pose, Option<f64>),
    /// Duration of the straight flight; `None` if the wind permits none.
    direct_s: Option<f64>,
}

/// A path type with its length at some instant.
#[derive(Clone, Copy, Debug)]
struct PathCandidate {
    time_s: f64,
    /// Duration of the path less the time until the instant.
    missed_s: f64,
    heading_rad: f64,
    parts: [Part; 3],
}

impl PathCandidate {
    /// Returns true if a turn has become a full circle, or vanished, between this candidate and the other.
    fn jumps_to(&self, other: &PathCandidate, radius: f64) -> bool {
        let pairs = self.parts.iter().zip(&other.parts);
        pairs.into_iter().any(|(a, b)| a.turn != 0.0 && (a.length_m - b.length_m).abs() > PI * radius)
    }
}

/// Senses of the turns at both ends and of one in between, and which of two possible centres that one has.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PathType {
    first: f64,
    between: f64,
    last: f64,
    side: f64,
}

fn words(turn_first: bool, turn_last: bool) -> impl Iterator<Item = PathType> {
    let senses = |turns: bool| if turns { vec![1.0, -1.0] } else { vec![0.0] };
    let straight = senses(turn_first).into_iter().flat_map(move |first| {
        senses(turn_last).into_iter().map(move |last| PathType { first, between: 0.0, last, side: 0.0 })
    });
    let turning = [1.0, -1.0].into_iter().flat_map(|first| {
        [1.0, -1.0].into_iter().map(move |side| PathType { first, between: -first, last: first, side })
    });
    straight.chain(turning.filter(move |_| turn_first && turn_last))
}

/// Constants of a path type while its end moves.
struct PathEnds {
    radius: f64,
    start: Option<f64>,
    end: Option<f64>,
    /// Centre of the first turn.
    first: Point,
    /// Centre of the last turn, relative to the end.
    last: Point,
}

impl PathEnds {
    fn new(word: PathType, radius: f64, (from, start): (Point, Option<f64>), end: Option<f64>) -> PathEnds {
        let left = |heading: Option<f64>| heading.map_or(Point::default(), left);
        PathEnds { radius, start, end, first: from.plus(radius * word.first, left(start)), last: left(end) }
    }
}

/// Share by which an end must be farther than a path of turns reaches, so that no rounding decides.
const SURELY_BEYOND: f64 = 1.0 + 1e-6;

impl PathType {
    /// Returns true if no path of three turns reaches the end while it moves straight between two places: its circles are then too far
    /// apart all the time. False for paths with a line.
    fn is_out_of_reach(self, ends: &PathEnds, between: [Point; 2]) -> bool {
        if self.between == 0.0 {
            return false;
        }
        let [from, to] = between.map(|to| to.plus(ends.radius * self.last, ends.last));
        point_to_segment(ends.first, from, to) > SURELY_BEYOND * 4.0 * ends.radius
    }

    /// Returns the parts from one pose in the air to another, with the heading at the beginning.
    fn parts(self, ends: &PathEnds, to: Point) -> Option<(f64, [Part; 3])> {
        let PathEnds { radius, start, end, first, .. } = *ends;
        let last = to.plus(radius * self.last, ends.last);
        let apart = last.minus(first);
        let distance = apart.length();
        let of = |turns: [f64; 3], lengths: [f64; 3]| {
            let mut parts = [Part::default(); 3];
            for ((part, turn), length) in parts.iter_mut().zip(turns).zip(lengths) {
                *part = Part { turn, length_m: if turn == 0.0 { length } else { radius * length } };
            }
            parts
        };
        if self.between == 0.0 {
            // The line touches both circles: its offset from their centres is the difference of the senses.
            let beside = radius * (self.first - self.last);
            let squared = distance * distance - beside * beside;
            if squared < 0.0 {
                return None;
            }
            let length = libm::sqrt(squared);
            // Between circles of one sense the line is parallel to the line between their centres.
            let aside = if beside == 0.0 { 0.0 } else { libm::atan2(beside, length) };
            let line = if distance > 0.0 { angle(apart) + aside } else { start.or(end)? };
            let heading = start.unwrap_or(line);
            let turns = [turned(self.first, line - heading), length, turned(self.last, end.unwrap_or(line) - line)];
            return Some((heading, of([self.first, 0.0, self.last], turns)));
        }
        let (start, end) = (start?, end?);
        let high = 4.0 * radius * radius - 0.25 * distance * distance;
        if high < 0.0 || distance <= 0.0 {
            return None;
        }
        let up = Point { x: -apart.y / distance, y: apart.x / distance };
        let between = first.plus(0.5, apart).plus(self.side * libm::sqrt(high), up);
        // Where two circles touch, the centre is to the left of a vehicle that turns left.
        let heading_at = |centre: Point| angle(between.minus(centre)) + self.first * FRAC_PI_2;
        let (into, out) = (heading_at(first), heading_at(last));
        let turns = [turned(self.first, into - start), turned(self.between, out - into), turned(self.last, end - out)];
        Some((start, of([self.first, self.between, self.last], turns)))
    }
}

impl TurnPath {
    /// Returns the position over ground `time_s` after the beginning, and the heading.
    pub fn at(&self, time_s: f64) -> (Point, f64) {
        let mut left_m = time_s * self.flyer.true_airspeed_mps;
        let (mut point, mut heading_rad) = (self.from.plus(time_s, self.flyer.wind_mps), self.heading_rad);
        for part in self.parts {
            let length_m = left_m.clamp(0.0, part.length_m);
            left_m -= length_m;
            if part.turn == 0.0 {
                point = point.plus(length_m, unit(heading_rad));
            } else {
                let radius = self.flyer.turn_radius_m * part.turn;
                let centre = point.plus(radius, left(heading_rad));
                heading_rad += length_m / radius;
                point = centre.plus(-radius, left(heading_rad));
            }
        }
        (point, heading_rad)
    }

    /// Returns the path over ground as points from beginning to end, with a deviation of at most `tolerance_m`.
    pub fn points(&self, tolerance_m: f64) -> Vec<Point> {
        let speed_mps = self.flyer.true_airspeed_mps;
        // A chord is off by at most an eighth of the acceleration times the time squared.
        let step_s = libm::sqrt(8.0 * tolerance_m * self.flyer.turn_radius_m) / speed_mps;
        let mut points = vec![self.from];
        let mut begin_s = 0.0;
        for part in self.parts.iter().filter(|part| part.length_m > 0.0) {
            let lasts_s = part.length_m / speed_mps;
            let count = if part.turn == 0.0 { 1 } else { libm::ceil(lasts_s / step_s).clamp(1.0, 10_000.0) as usize };
            points.extend((1..=count).map(|index| self.at(begin_s + lasts_s * index as f64 / count as f64).0));
            begin_s += lasts_s;
        }
        points
    }
}

#[cfg(test)]
mod tests;
