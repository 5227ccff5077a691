//! Requirement `terrain`: the ground below the vehicle and along the commanded route.

use super::commanded::FlightOrder;
use super::readings::{Reading, Scene};
use super::response::Response;
use apex_geo::geodesy::{Position, distance_m};
use apex_geo::plane::Point;
use apex_model::quantity::Dimension;
use apex_requirements::Concern;
use apex_requirements::margin::terrain;

/// Deceleration with which a descent is stopped.
const PULL_UP_M_S2: f64 = 1.0;
/// Length of the final landing per height: a glide of 3 degrees, the flattest usual one, with a reserve.
const GLIDE_RATIO: f64 = 20.0;

impl Scene<'_> {
    /// Returns true while the vehicle is near the ground on purpose: by its flight phase, otherwise by the commanded take-off or the last
    /// part of the commanded landing, where a glide is below the clearance.
    pub(super) fn is_near_ground(&self) -> bool {
        let clearance_m = self.requirements().terrain_clearance_m.unwrap_or(0.0);
        let is_final = |goal: &Position| distance_m(self.here, *goal) <= GLIDE_RATIO * clearance_m;
        self.flown.is_near_ground.unwrap_or_else(|| match self.order {
            Some(FlightOrder::TakeOff(_)) => true,
            Some(FlightOrder::Land(points)) => points.last().is_none_or(is_final),
            _ => false,
        })
    }

    /// Returns the elevation of the ground below the vehicle, computed from its height above ground.
    pub(super) fn ground_below_m(&self) -> Option<f64> {
        Some(self.flown.altitude_m - self.flown.height_above_ground_m?)
    }

    /// Returns the highest known ground within a second's flight of a position.
    pub(super) fn known_ground_m(&self, position: Position) -> Option<f64> {
        self.mission.terrain.as_ref()?.highest_m_near(position, self.motion.true_airspeed_mps)
    }

    /// Returns the highest known ground around a point of the plane.
    fn known_ground_below_m(&self, point: Point) -> Option<f64> {
        // Without terrain the position need not be known.
        self.mission.terrain.as_ref().and_then(|_| self.known_ground_m(self.plane.position(point)))
    }

    /// Returns true if the ground counts as flat and the route keeps clear of it. The altitude is monotonic along the route, so its ends
    /// decide.
    fn is_clear_of_flat_ground(&self, ground_m: f64, clearance_m: f64) -> bool {
        let ends_s = [0.0, self.route.end_s().min(self.requirements().look_ahead_s)];
        let is_clear = |after_s: f64| {
            let state = self.route.at(after_s);
            state.is_some_and(|state| terrain::terrain_m(state.altitude_m, ground_m, clearance_m) >= 0.0)
        };
        self.mission.terrain.is_none() && ends_s.into_iter().all(is_clear)
    }

    /// Returns the highest ground along the route within the look-ahead, and below the vehicle.
    pub(super) fn ground_ahead_m(&self) -> f64 {
        let below_m = self.ground_below_m().unwrap_or(f64::NEG_INFINITY);
        let until_s = self.route.end_s().min(self.requirements().look_ahead_s);
        let instants = (0..=until_s as u32).map(f64::from);
        let ahead = instants.filter_map(|after_s| self.known_ground_below_m(self.route.at(after_s)?.point));
        ahead.fold(below_m, f64::max)
    }

    /// Returns the reading of the clearance of the ground, below and along the route.
    pub(super) fn terrain(&self) -> Option<Reading> {
        let clearance_m = self.requirements().terrain_clearance_m?;
        if self.is_near_ground() {
            return None;
        }
        let below_m = self.ground_below_m()?;
        let margin = terrain::terrain_m(self.flown.altitude_m, below_m, clearance_m);
        let look_ahead_s = self.requirements().look_ahead_s;
        let ground_m = |point: Point| self.known_ground_below_m(point).unwrap_or(below_m);
        let is_clear = self.is_clear_of_flat_ground(below_m, clearance_m);
        let lost = if is_clear { None } else { terrain::first_loss(&self.route, look_ahead_s, clearance_m, ground_m) };
        // The time until the climb must begin decides, not the instant of the loss itself: a high ridge is climbed over early.
        let climb = self.mission.terrain.as_ref().and_then(|_| {
            terrain::latest_climb(&self.route, look_ahead_s, clearance_m, self.motion.climb_mps, ground_m)
        });
        let after_s = lost.map(|lost| lost.after_s);
        let level_off_s = self.motion.descent_mps / PULL_UP_M_S2;
        let response_s = match (after_s, climb) {
            (Some(after_s), Some(climb)) => level_off_s.max(after_s - climb.latest_start_s),
            _ => level_off_s,
        };
        // Straight ahead it is too late for a climb: a turn leads away from the ground.
        let is_too_late = climb.is_some_and(|climb| climb.latest_start_s < -level_off_s);
        Some(Reading {
            concern: Concern::Terrain,
            name: "terrain",
            margin,
            unit: Dimension::LENGTH,
            after_s,
            response_s,
            what: "ground".to_string(),
            response: if is_too_late { Response::TurnAway } else { Response::Climb },
        })
    }
}
