//! The way in a command's `:via`: the places that the flight passes before the command is flown.

use crate::arguments::WayPoint;
use crate::motion::{State, wrap_pi};
use crate::path::{Line, Path, bearing};
use crate::situation::Situation;
use apex_model::problem::Position;
use libm::cos;

/// A way and the leg of it that is being flown.
#[derive(Clone, Debug)]
pub(crate) struct Way {
    points: Vec<WayPoint>,
    /// The point that the present leg leads to.
    next: usize,
    leg: Line,
    /// Length of the remaining legs after this one.
    rest_m: f64,
    /// Change of course per metre of the leg, so that a chain of short legs is flown as an arc.
    turn_rad_per_m: f64,
    is_fixed_wing: bool,
}

/// Points within this distance behind a fixed wing count as passed, because the vehicle moved on while the command was sent.
const PASSED_M: f64 = 2_000.0;
/// Legs shorter than this share of the turn radius are chords of a turn.
const CHORD_SHARE: f64 = 0.5;
/// A rotorcraft is at a point of its way within this distance.
const ROTORCRAFT_NEAR_M: f64 = 3.0;

/// A goal nearer than this to the last point of its way is that point.
const SAME_PLACE_M: f64 = 1.0;

/// Returns the points of a way, followed by the place to which they lead. A fixed wing follows the last leg as a line. If it turned
/// towards the place instead, an error of a few degrees at the beginning of a short leg could put the place inside its turning circle,
/// and the vehicle would circle back through airspace that was not checked.
pub(crate) fn with_goal(mut points: Vec<WayPoint>, goal: Position) -> Vec<WayPoint> {
    if points.last().is_some_and(|last| bearing(last.position, goal).1 > SAME_PLACE_M) {
        points.push(WayPoint { position: goal, altitude_m: None });
    }
    points
}

impl Way {
    /// Returns the way over `points` from where the vehicle is; `None` for no points.
    pub(crate) fn new(points: Vec<WayPoint>, here: &Situation) -> Option<Way> {
        let is_fixed_wing = here.fixed();
        let is_passed = |point: &WayPoint| is_behind(point.position, here.state) && is_fixed_wing;
        let next = points.iter().position(|point| !is_passed(point)).unwrap_or(points.len().saturating_sub(1));
        let first = points.get(next)?;
        let leg = Line::new(here.state.position, first.position);
        let mut way = Way { points, next, leg, rest_m: 0.0, turn_rad_per_m: 0.0, is_fixed_wing };
        (way.turn_rad_per_m, way.rest_m) = (way.turn_rad_per_m(here), way.rest_m());
        Some(way)
    }

    /// Returns the same way, begun again at the vehicle's present position.
    pub(crate) fn restarted(self, here: &Situation) -> Option<Way> {
        Way::new(self.points, here)
    }

    /// Returns the path to follow now.
    pub(crate) fn path(&self) -> Path {
        match self.points.get(self.next) {
            Some(point) if !self.is_fixed_wing => Path::Point(point.position),
            _ => Path::Leg(self.leg.clone(), self.turn_rad_per_m),
        }
    }

    /// Returns the altitude that the present leg demands.
    pub(crate) fn altitude_m(&self) -> Option<f64> {
        self.points.get(self.next).and_then(|point| point.altitude_m)
    }

    /// Drops the altitudes of the way: another altitude was commanded.
    pub(crate) fn level(&mut self) {
        self.points.iter_mut().for_each(|point| point.altitude_m = None);
    }

    /// Returns the distance to the end of the present leg, and to the end of the way.
    pub(crate) fn distances_m(&self, position: Position) -> (f64, f64) {
        let left_m = match self.points.get(self.next) {
            Some(point) if !self.is_fixed_wing => bearing(position, point.position).1,
            _ => (self.leg.length_m - self.leg.locate(position).0).max(0.0),
        };
        (left_m, left_m + self.rest_m)
    }

    /// Returns the end of the way.
    pub(crate) fn end(&self) -> Option<Position> {
        self.points.last().map(|point| point.position)
    }

    fn rest_m(&self) -> f64 {
        let ahead = || self.points.iter().skip(self.next);
        ahead().zip(ahead().skip(1)).map(|(from, to)| bearing(from.position, to.position).1).sum()
    }

    /// Advances to the leg on which the vehicle is now. False when the whole way is flown.
    pub(crate) fn advance(&mut self, here: &Situation) -> bool {
        while let Some(point) = self.points.get(self.next) {
            let left_m = self.distances_m(here.state.position).0;
            let is_reached = if self.is_fixed_wing { left_m <= 0.0 } else { left_m < ROTORCRAFT_NEAR_M };
            if !is_reached {
                return true;
            }
            let Some(after) = self.points.get(self.next + 1) else { return false };
            self.leg = Line::new(point.position, after.position);
            self.next += 1;
            (self.turn_rad_per_m, self.rest_m) = (self.turn_rad_per_m(here), self.rest_m());
        }
        false
    }

    /// Returns the change of course per metre on the present leg. On a chord this is the change between the leg and the next one.
    fn turn_rad_per_m(&self, here: &Situation) -> f64 {
        let ends = self.points.get(self.next).zip(self.points.get(self.next + 1));
        let Some((here_to, after)) = ends else { return 0.0 };
        let next = Line::new(here_to.position, after.position);
        let longest_m = CHORD_SHARE * here.turn_radius_m();
        if self.leg.length_m > longest_m || next.length_m > longest_m || self.leg.length_m < 1.0 {
            return 0.0;
        }
        let (_, _, course_rad) = self.leg.locate(here_to.position);
        wrap_pi(next.azimuth_rad - course_rad) / (0.5 * (self.leg.length_m + next.length_m))
    }
}

fn is_behind(point: Position, state: &State) -> bool {
    let (azimuth_rad, distance_m) = bearing(state.position, point);
    distance_m < PASSED_M && cos(azimuth_rad - state.track_rad()) < 0.0
}
