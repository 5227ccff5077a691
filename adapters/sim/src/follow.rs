//! Following a path of points. Orbits, spirals, arcs and search patterns are commanded as such paths.
//!
//! A fixed wing follows the legs as lines, and chains of short legs as turns, at the airspeed that the command states for the beginning of
//! each leg. A rotorcraft keeps the ground speeds that the command states at points, brakes for corners and for the end, climbs along
//! the legs, and holds its nose in the direction that the command states.

use crate::arguments::{Nose, WayPoint};
use crate::motion::{ALTITUDE_CAPTURE_S, wrap_pi};
use crate::path::{Line, Path, bearing};
use crate::situation::Situation;
use apex_geo::geodesy::RAD_PER_DEG;
use apex_model::problem::Position;
use libm::{sin, sqrt};
use std::sync::Arc;

/// A rotorcraft treats a change of course above `CORNER_RAD` as a corner, in which its velocity turns within `CORNER_S`.
const CORNER_RAD: f64 = 25.0 * RAD_PER_DEG;
const CORNER_S: f64 = 1.0;
/// A fixed wing treats legs shorter than this multiple of its turn radius as chords of one turn.
const CHORD_SHARE: f64 = 0.5;
/// If the vehicle is closer than this to the first point of the path, no leg leads to that point.
const AT_FIRST_M: f64 = 15.0;
/// A fixed wing that has passed the first point is on the leg after it if it is this near to it.
const PASSED_ACROSS_M: f64 = 120.0;
/// A rotorcraft has arrived within this distance of the last point.
const ARRIVED_M: f64 = 1.0;

/// A path and the leg of it that is being flown.
#[derive(Clone, Debug)]
pub(crate) struct FollowedPath {
    points: Arc<[WayPoint]>,
    /// Maximum speed at each point, m/s: the commanded one, reduced so that braking suffices for the following points.
    speeds: Arc<[f64]>,
    /// Commanded maximum speed at each point, m/s; on a leg the higher one of its two ends applies.
    wanted: Arc<[f64]>,
    /// Index of the point at the end of the present leg.
    next: usize,
    leg: Line,
    from_altitude_m: f64,
    turn_rad_per_m: f64,
    is_fixed_wing: bool,
    /// Airspeed along this path, m/s; `None`: the airspeed commanded before the path.
    pub(crate) true_airspeed: Option<f64>,
    /// Airspeed of a fixed wing on the leg that begins at each point; empty for a constant one.
    airspeeds: Arc<[f64]>,
    /// Direction of the nose of a rotorcraft; `None`: along the track, or where a camera without pan needs it.
    pub(crate) nose: Option<Nose>,
}

impl FollowedPath {
    /// Begins a path from the vehicle's position; `None` for fewer than two points.
    pub(crate) fn new(points: Vec<WayPoint>, speeds: &[f64], here: &Situation) -> Option<FollowedPath> {
        let first = points.first()?;
        points.get(1)?;
        let is_fixed_wing = here.fixed();
        let wanted: Vec<f64> = if is_fixed_wing { Vec::new() } else { speeds.to_vec() };
        let airspeeds: Vec<f64> = if is_fixed_wing { speeds.to_vec() } else { Vec::new() };
        let speeds = if is_fixed_wing { Vec::new() } else { node_speeds(&points, speeds, here) };
        let mut path = FollowedPath {
            leg: Line::new(here.state.position, first.position),
            points: points.into(),
            speeds: speeds.into(),
            wanted: wanted.into(),
            next: 0,
            from_altitude_m: here.state.altitude_m,
            turn_rad_per_m: 0.0,
            is_fixed_wing,
            true_airspeed: None,
            airspeeds: airspeeds.into(),
            nose: None,
        };
        if path.leg.length_m < AT_FIRST_M || path.is_on_first_leg(here) {
            path.step(here);
        }
        Some(path)
    }

    /// Returns true if a fixed wing has passed the first point and is on the leg after it: it would have to turn back to that point.
    fn is_on_first_leg(&self, here: &Situation) -> bool {
        let (Some(first), Some(second)) = (self.points.first(), self.points.get(1)) else { return false };
        let leg = Line::new(first.position, second.position);
        let (along_m, across_m, _) = leg.locate(here.state.position);
        self.is_fixed_wing && (0.0..leg.length_m).contains(&along_m) && across_m.abs() <= PASSED_ACROSS_M
    }

    /// Returns the path to follow now.
    pub(crate) fn path(&self, here: &Situation) -> Path {
        if self.is_fixed_wing {
            return Path::Leg(self.leg.clone(), self.turn_rad_per_m);
        }
        let left_m = self.left_m(here.state.position);
        let at_next = self.speeds.get(self.next).copied().unwrap_or(0.0);
        let braking = here.model.braking_share * here.model.acceleration_m_s2_max;
        let to_brake = sqrt(at_next * at_next + 2.0 * braking * left_m.max(0.2));
        let before = self.next.checked_sub(1).and_then(|index| self.wanted.get(index)).copied().unwrap_or(0.0);
        let on_leg = self.wanted.get(self.next).map_or(f64::INFINITY, |speed| speed.max(before));
        Path::Paced(self.leg.clone(), self.level_share() * to_brake.min(on_leg))
    }

    /// Returns the altitude of the last point, if it states one.
    pub(crate) fn last_altitude_m(&self) -> Option<f64> {
        self.points.last().and_then(|point| point.altitude_m)
    }

    /// Returns the airspeed to fly now; `None`: the airspeed commanded before the path.
    pub(crate) fn true_airspeed(&self) -> Option<f64> {
        self.airspeeds.get(self.next.saturating_sub(1)).copied().or(self.true_airspeed)
    }

    /// Returns the heading that the command demands at a position.
    pub(crate) fn nose_rad(&self, position: Position) -> Option<f64> {
        match self.nose? {
            Nose::Heading(heading_rad) => Some(heading_rad),
            Nose::Towards(place) => {
                let (azimuth_rad, distance_m) = bearing(position, place);
                (distance_m > 1.0).then_some(azimuth_rad)
            }
        }
    }

    /// Returns the horizontal share of the speed along a climbing or descending leg.
    fn level_share(&self) -> f64 {
        let rise_m = self.rise_m();
        self.leg.length_m / sqrt(self.leg.length_m * self.leg.length_m + rise_m * rise_m).max(1e-3)
    }

    fn rise_m(&self) -> f64 {
        self.points.get(self.next).and_then(|point| point.altitude_m).map_or(0.0, |to| to - self.from_altitude_m)
    }

    /// Drops the altitudes of the path.
    pub(crate) fn level(&mut self) {
        self.points = self.points.iter().map(|point| WayPoint { altitude_m: None, ..*point }).collect();
    }

    /// Returns the altitude to command now: that of the leg, advanced by the lag of the altitude control.
    pub(crate) fn altitude_m(&self, here: &Situation) -> Option<f64> {
        let to_m = self.points.get(self.next)?.altitude_m?;
        let (rise_m, length_m) = (to_m - self.from_altitude_m, self.leg.length_m.max(1.0));
        if rise_m.abs() < 0.01 {
            return Some(to_m);
        }
        let along = (1.0 - self.left_m(here.state.position) / length_m).clamp(0.0, 1.0);
        let ahead_m = rise_m / length_m * here.state.ground_speed() * ALTITUDE_CAPTURE_S;
        Some(self.from_altitude_m + along * rise_m + ahead_m)
    }

    fn left_m(&self, position: Position) -> f64 {
        (self.leg.length_m - self.leg.locate(position).0).max(0.0)
    }

    /// Returns the distances to the end of the present leg and to the end of the path.
    pub(crate) fn distances_m(&self, position: Position) -> (f64, f64) {
        let left_m = self.left_m(position);
        let ahead = || self.points.iter().skip(self.next);
        let rest_m: f64 = ahead().zip(ahead().skip(1)).map(|(a, b)| bearing(a.position, b.position).1).sum();
        (left_m, left_m + rest_m)
    }

    /// Proceeds to the leg on which the vehicle is now. Returns false if the whole path is flown.
    pub(crate) fn advance(&mut self, here: &Situation) -> bool {
        loop {
            let is_last = self.next + 1 >= self.points.len();
            let near_m = if is_last && !self.is_fixed_wing { ARRIVED_M } else { 0.3 * here.state.ground_speed() };
            let near_m = if self.is_fixed_wing { 0.0 } else { near_m };
            if self.left_m(here.state.position) > near_m {
                return true;
            }
            if is_last {
                return false;
            }
            self.step(here);
        }
    }

    fn step(&mut self, here: &Situation) {
        let (Some(from), Some(to)) = (self.points.get(self.next), self.points.get(self.next + 1)) else { return };
        self.leg = Line::new(from.position, to.position);
        self.from_altitude_m = from.altitude_m.unwrap_or(here.state.altitude_m);
        self.next += 1;
        self.turn_rad_per_m = self.turn_rad_per_m(here);
    }

    /// Returns the change of course per metre of a chord, computed from the legs before and after it.
    fn turn_rad_per_m(&self, here: &Situation) -> f64 {
        let (Some(end), Some(after)) = (self.points.get(self.next), self.points.get(self.next + 1)) else { return 0.0 };
        let next = Line::new(end.position, after.position);
        let longest_m = CHORD_SHARE * here.turn_radius_m();
        if self.leg.length_m > longest_m || next.length_m > longest_m || self.leg.length_m < 1.0 {
            return 0.0;
        }
        wrap_pi(next.azimuth_rad - self.leg.locate(end.position).2) / (0.5 * (self.leg.length_m + next.length_m))
    }
}

/// Returns the maximum speeds of a rotorcraft at the points of a path: the commanded ones, limited by corners and by braking for
/// the following points.
fn node_speeds(points: &[WayPoint], wanted: &[f64], here: &Situation) -> Vec<f64> {
    let acceleration = here.model.acceleration_m_s2_max;
    let braking = here.model.braking_share * acceleration;
    let mut speeds: Vec<f64> =
        (0..points.len()).map(|index| wanted.get(index).copied().unwrap_or(f64::INFINITY)).collect();
    for (index, window) in points.windows(3).enumerate() {
        let [before, corner, after] = window else { continue };
        let (into, out) = (Line::new(before.position, corner.position), Line::new(corner.position, after.position));
        let turn_rad = wrap_pi(out.azimuth_rad - into.azimuth_rad).abs();
        if let (true, Some(speed)) = (turn_rad > CORNER_RAD, speeds.get_mut(index + 1)) {
            *speed = speed.min(acceleration * CORNER_S / (2.0 * sin(0.5 * turn_rad)).max(1e-6));
        }
    }
    let mut after: Option<(f64, Position)> = None;
    for (point, speed) in points.iter().zip(speeds.iter_mut()).rev() {
        let most = after
            .map_or(0.0, |(speed, position)| sqrt(speed * speed + 2.0 * braking * bearing(point.position, position).1));
        *speed = speed.min(most);
        after = Some((*speed, point.position));
    }
    speeds
}
