//! Circling over ground: from a point on a circle around one place to a circle around another, or to a pose.
//!
//! A vehicle that observes a place and cannot stop there circles around it, and may be anywhere on the circle when the observation ends.
//! Everything is flown over ground on arcs of one radius and straight lines. The radius is sufficient for the strongest wind
//! ([`radius`]), so wind changes only the times of arcs and lines. A flight leaves by its circle or by the opposite turn, flies a line
//! that touches both circles, and arrives where it touches the other one. The greatest time of leaving ([`Rounds::worst`]) is bounded:
//! from each point of a circle the vehicle may first fly to the next of [`POINTS`], so that no point between them is missed.
//! Bound: [`POINTS`] points of the circle, mostly some tens, and four path types for each.

use super::dubins::{angle, left, turned, unit};
use crate::plane::Point;
use std::f64::consts::TAU;

/// Number of pieces of a full circle over which the time of a turn is summed.
const PIECES: usize = 120;
/// Number of points of a circle at which leaving it is evaluated, and the initial step between them.
const POINTS: usize = 192;
const APART: usize = 32;
/// A turn nearer than this to a full circle counts as no turn.
const NO_TURN_RAD: f64 = 1e-9;
/// Number of directions that are tried if the place before a circle may be left in any direction.
const TRACKS: usize = 16;

/// Returns the radius of a ground circle that can be flown in every wind up to the one in which `ground_speed_mps_max` is the highest
/// speed: with a tail wind the heading turns fastest, at the square of that speed divided by radius and airspeed.
pub(super) fn radius(turn_radius: f64, true_airspeed_mps: f64, ground_speed_mps_max: f64) -> f64 {
    let quicker = ground_speed_mps_max / true_airspeed_mps;
    turn_radius * quicker * quicker
}

/// A state on a circle: its centre, its sense (left 1, right -1), and the present direction over ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct On {
    pub(super) centre: Point,
    pub(super) sense: f64,
    pub(super) track_rad: f64,
}

/// End of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// On a circle around this place, in either sense.
    Circle(Point),
    /// At this place, in this direction.
    Pose(Point, f64),
    /// At this place, in any direction.
    Place(Point),
}

/// A flight from circle to end: a part of the circle, a turn to leave it, a line and perhaps a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Passage {
    pub(super) time_s: f64,
    along: (On, f64),
    first: (On, f64),
    /// End of the line.
    line: Point,
    /// On the circle at the end: the final state, and the flown angle.
    last: Option<(On, f64)>,
}

/// Circles of one radius in one wind.
#[derive(Clone, Debug)]
pub(super) struct Rounds {
    radius: f64,
    true_airspeed_mps: f64,
    wind_mps: Point,
    /// Seconds for turning to each of [`PIECES`] directions from 0, for a radius of 1.
    turned_s: Vec<f64>,
}

impl Rounds {
    /// Returns the circles; `None` if the wind is too strong to fly against.
    pub(super) fn new(radius: f64, true_airspeed_mps: f64, wind_mps: Point) -> Option<Rounds> {
        if wind_mps.length() >= true_airspeed_mps || radius.is_nan() || radius <= 0.0 {
            return None;
        }
        let mut rounds = Rounds { radius, true_airspeed_mps, wind_mps, turned_s: Vec::with_capacity(PIECES + 1) };
        let step_rad = TAU / PIECES as f64;
        let (mut sum_s, mut before) = (0.0, 1.0 / rounds.speed_mps(0.0));
        rounds.turned_s.push(0.0);
        for piece in 0..PIECES {
            let begin_rad = step_rad * piece as f64;
            let middle = 1.0 / rounds.speed_mps(begin_rad + 0.5 * step_rad);
            let after = 1.0 / rounds.speed_mps(begin_rad + step_rad);
            sum_s += step_rad * (before + 4.0 * middle + after) / 6.0;
            rounds.turned_s.push(sum_s);
            before = after;
        }
        Some(rounds)
    }

    /// Returns the speed over ground in a direction.
    fn speed_mps(&self, track_rad: f64) -> f64 {
        let across = self.wind_mps.dot(left(track_rad));
        let ahead = self.true_airspeed_mps * self.true_airspeed_mps - across * across;
        libm::sqrt(ahead.max(0.0)) + self.wind_mps.dot(unit(track_rad))
    }

    /// Returns the time of turning from 0 to a direction, full circles included, in seconds for a radius of 1.
    fn turned_until_s(&self, track_rad: f64) -> f64 {
        let circles = libm::floor(track_rad / TAU);
        let share = (track_rad / TAU - circles) * PIECES as f64;
        let index = (share as usize).min(PIECES - 1);
        let at = |index: usize| self.turned_s.get(index).copied().unwrap_or(0.0);
        circles * at(PIECES) + at(index) + (share - index as f64) * (at(index + 1) - at(index))
    }

    /// Returns the time of an arc.
    fn arc_s(&self, on: On, by_rad: f64) -> f64 {
        let end_rad = on.track_rad + on.sense * by_rad;
        self.radius * (self.turned_until_s(end_rad) - self.turned_until_s(on.track_rad)).abs()
    }

    /// Returns the time of a full circle.
    pub(super) fn circle_s(&self) -> f64 {
        self.radius * self.turned_until_s(TAU)
    }

    fn position(&self, on: On) -> Point {
        on.centre.plus(-on.sense * self.radius, left(on.track_rad))
    }

    /// Returns the two circles that a pose touches.
    fn touching(&self, point: Point, track_rad: f64) -> [On; 2] {
        [1.0, -1.0].map(|sense| On { centre: point.plus(sense * self.radius, left(track_rad)), sense, track_rad })
    }

    /// Returns the state on a circle after some seconds, and the angle flown until then.
    pub(super) fn after(&self, on: On, lasts_s: f64) -> (On, f64) {
        let circles = libm::floor(lasts_s / self.circle_s()).max(0.0);
        let rest_s = lasts_s - circles * self.circle_s();
        let (mut low, mut high) = (0.0, TAU);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if self.arc_s(on, middle) <= rest_s { low = middle } else { high = middle }
        }
        (On { track_rad: on.track_rad + on.sense * low, ..on }, circles * TAU + low)
    }

    /// Returns the fastest flight from a point of a circle, along which the vehicle may first continue; including the opposite turn if
    /// there is space for it. `None` if the end is inside the turns.
    pub(super) fn passage(&self, on: On, end: End, opposite: bool) -> Option<Passage> {
        let share = on.sense * on.track_rad / TAU;
        let first = (share - libm::floor(share)) * POINTS as f64;
        let later = (0..POINTS).filter_map(|number| {
            let there = point(on.centre, on.sense, first as usize + 1 + number);
            let by_rad = turned(on.sense, there.track_rad - on.track_rad);
            let leaving = self.leaving(there, end, opposite)?;
            Some(Passage { time_s: leaving.time_s + self.arc_s(on, by_rad), along: (on, by_rad), ..leaving })
        });
        let all = self.leaving(on, end, opposite).into_iter().chain(later);
        all.min_by(|a, b| a.time_s.total_cmp(&b.time_s))
    }

    /// Returns the fastest flight of a vehicle that leaves the circle at once.
    fn leaving(&self, on: On, end: End, opposite: bool) -> Option<Passage> {
        let other = On {
            centre: on.centre.plus(-2.0 * on.sense * self.radius, left(on.track_rad)),
            sense: -on.sense,
            track_rad: on.track_rad,
        };
        let mut best: Option<Passage> = None;
        let mut offer = |found: Option<Passage>| {
            if found.is_some_and(|found| best.is_none_or(|best| found.time_s < best.time_s)) {
                best = found;
            }
        };
        for first in [on].into_iter().chain(opposite.then_some(other)) {
            match end {
                End::Circle(centre) => {
                    [1.0, -1.0].into_iter().for_each(|sense| offer(self.between(first, (centre, sense), None)));
                }
                End::Pose(point, track_rad) => self
                    .touching(point, track_rad)
                    .into_iter()
                    .for_each(|last| offer(self.between(first, (last.centre, last.sense), Some(track_rad)))),
                End::Place(point) => offer(self.to_place(first, point)),
            }
        }
        best
    }

    /// Returns the fastest flight to a circle from a pose, or from a place that may be left in any direction.
    pub(super) fn to_circle(&self, point: Point, track_rad: Option<f64>, centre: Point) -> Option<Passage> {
        let tries = if track_rad.is_some() { 1 } else { TRACKS };
        let tracks = (0..tries).map(|index| track_rad.unwrap_or(TAU * index as f64 / TRACKS as f64));
        let ons = tracks.flat_map(|track_rad| self.touching(point, track_rad));
        let found = ons.filter_map(|on| self.leaving(on, End::Circle(centre), false));
        found.min_by(|a, b| a.time_s.total_cmp(&b.time_s))
    }

    /// Returns the passage along the line that touches two circles in their senses.
    fn between(&self, first: On, (centre, sense): (Point, f64), until_rad: Option<f64>) -> Option<Passage> {
        let apart = centre.minus(first.centre);
        let distance = apart.length();
        let beside = self.radius * (first.sense - sense);
        let squared = distance * distance - beside * beside;
        if squared < 0.0 {
            return None;
        }
        let length = libm::sqrt(squared);
        // If both circles are the same, the vehicle is on the final circle already.
        let same = distance <= NO_TURN_RAD * self.radius;
        let line_rad = if same { first.track_rad } else { angle(apart) + libm::atan2(beside, length) };
        let last = On { centre, sense, track_rad: line_rad };
        let by_rad = until_rad.map_or(0.0, |until_rad| turned(sense, until_rad - line_rad));
        Some(self.made(first, line_rad, length, Some((last, by_rad)), self.position(last)))
    }

    fn to_place(&self, first: On, point: Point) -> Option<Passage> {
        let apart = point.minus(first.centre);
        let squared = apart.dot(apart) - self.radius * self.radius;
        let length = libm::sqrt(if squared < 0.0 { return None } else { squared });
        let line_rad = angle(apart) + libm::atan2(first.sense * self.radius, length);
        Some(self.made(first, line_rad, length, None, point))
    }

    fn made(&self, first: On, line_rad: f64, length: f64, last: Option<(On, f64)>, line: Point) -> Passage {
        let by_rad = turned(first.sense, line_rad - first.track_rad);
        let line_s = if length > 0.0 { length / self.speed_mps(line_rad) } else { 0.0 };
        let last_s = last.map_or(0.0, |(on, by_rad)| self.arc_s(on, by_rad));
        let time_s = self.arc_s(first, by_rad) + line_s + last_s;
        Passage { time_s, along: (first, 0.0), first: (first, by_rad), line, last }
    }

    /// Returns the greatest time, over all points of the circle around `centre` in either sense, of the fastest flight to its end; `None`
    /// if the end cannot be reached from some point.
    pub(super) fn worst(&self, centre: Point, end: End, opposite: bool) -> Option<f64> {
        if end == End::Circle(centre) {
            return Some(0.0);
        }
        let one = self.worst_of(centre, 1.0, end, opposite)?;
        Some(one.max(self.worst_of(centre, -1.0, end, opposite)?))
    }

    fn worst_of(&self, centre: Point, sense: f64, end: End, opposite: bool) -> Option<f64> {
        let leaving_s = |number: usize| {
            let found = self.leaving(point(centre, sense, number), end, opposite);
            found.map(|found| (number, found.time_s))
        };
        let on_s =
            |from: usize, to: usize| self.arc_s(point(centre, sense, from), TAU * (to - from) as f64 / POINTS as f64);
        let mut known: Vec<(usize, f64)> = (0..POINTS).step_by(APART).map(leaving_s).collect::<Option<_>>()?;
        loop {
            // Backwards around the circle, twice: a vehicle leaves the circle at each point, or continues to the next one.
            let mut best_s: Vec<f64> = known.iter().map(|(_, time_s)| *time_s).collect();
            // The interval with the greatest time from its beginning, and the one with the greatest time from just past it; then the
            // times.
            let (mut from_worst, mut past_worst) = (((0, 0), 0.0), ((0, 0), 0.0));
            for round in 0..2 {
                for (index, (from, _)) in known.iter().enumerate().rev() {
                    let after = if index + 1 < known.len() { index + 1 } else { 0 };
                    let to = known.get(after).map_or(POINTS, |(to, _)| if after == 0 { to + POINTS } else { *to });
                    let later_s = best_s.get(after).map_or(0.0, |there_s| on_s(*from, to) + there_s);
                    let Some(best_s) = best_s.get_mut(index) else { continue };
                    *best_s = best_s.min(later_s);
                    if round == 1 && later_s > past_worst.1 {
                        past_worst = ((*from, to), later_s);
                    }
                    if round == 1 && *best_s > from_worst.1 {
                        from_worst = ((*from, to), *best_s);
                    }
                }
            }
            let is_near = past_worst.1 <= from_worst.1 + self.circle_s() / POINTS as f64;
            let (from, to) = if is_near { from_worst.0 } else { past_worst.0 };
            if to - from <= 1 {
                return Some(past_worst.1);
            }
            let middle = (from + to) / 2;
            let at = known.partition_point(|(number, _)| *number < middle);
            known.insert(at, leaving_s(middle)?);
        }
    }

    /// Returns the passage over ground as points that deviate by at most `tolerance`.
    pub(super) fn points(&self, passage: &Passage, tolerance: f64) -> Vec<Point> {
        let mut points = self.arc(passage.along.0, passage.along.1, tolerance);
        points.extend(self.arc(passage.first.0, passage.first.1, tolerance));
        points.push(passage.line);
        points.dedup();
        if let Some((on, by_rad)) = passage.last {
            points.extend(self.arc(on, by_rad, tolerance).into_iter().skip(1));
        }
        points
    }

    /// Returns an arc as points, its beginning included.
    pub(super) fn arc(&self, on: On, by_rad: f64, tolerance: f64) -> Vec<Point> {
        // A chord is off by an eighth of the radius times the square of its angle.
        let step_rad = libm::sqrt(8.0 * tolerance / self.radius);
        let count = libm::ceil(by_rad / step_rad).clamp(0.0, 10_000.0) as usize;
        let at = |index: usize| {
            let by_rad = by_rad * index as f64 / count.max(1) as f64;
            self.position(On { track_rad: on.track_rad + on.sense * by_rad, ..on })
        };
        (0..=count).map(at).collect()
    }
}

/// Returns a point of a circle by its number, counted in the sense of the flight.
fn point(centre: Point, sense: f64, number: usize) -> On {
    On { centre, sense, track_rad: sense * TAU * (number % POINTS) as f64 / POINTS as f64 }
}

impl Passage {
    /// Returns the final state on the circle at the end; `None` if it ends at a place or a pose.
    pub(super) fn end(&self) -> Option<On> {
        self.last.map(|(on, by_rad)| On { track_rad: on.track_rad + on.sense * by_rad, ..on })
    }
}

#[cfg(test)]
mod tests;
