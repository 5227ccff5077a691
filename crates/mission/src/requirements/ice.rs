//! Ice that the vehicle has met.
//!
//! The extent of a cloud is unknown to a vehicle that flies in it: within [`NEAR_M`] of ice that was met, the same cloud is assumed, for
//! [`KEPT_S`].
//! Bound: O(places) with at most [`PLACES_MAX`].

use apex_geo::geodesy;
use apex_model::problem::Position;
use serde::{Deserialize, Serialize};

/// Distance from ice within which the same cloud is assumed.
const NEAR_M: f64 = 60_000.0;
/// Time after which ice is forgotten.
const KEPT_S: f64 = 7_200.0;
/// Places are remembered at this distance from each other.
const APART_M: f64 = 5_000.0;
const PLACES_MAX: usize = 100;

/// Ice that was met in the flight.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct IceMemory {
    /// Instants and places.
    met: Vec<(f64, Position)>,
    /// True while the flight is near to it and leads through air in which ice may form.
    pub(super) is_near: bool,
    /// The altitude without ice that is flown meanwhile.
    pub(super) level_m: Option<f64>,
    pub(super) is_reported: bool,
}

impl IceMemory {
    /// Returns true if ice may form at an altitude with freezing air, because ice was met near there.
    pub(super) fn is_met_near(&self, place: Position) -> bool {
        self.met.iter().any(|(_, met)| geodesy::distance_m(*met, place) <= NEAR_M)
    }

    /// Returns true if no ice is remembered.
    pub(super) fn is_empty(&self) -> bool {
        self.met.is_empty()
    }

    pub(super) fn remember(&mut self, now_s: f64, here: Position, is_icing: bool) {
        self.met.retain(|(at_s, _)| now_s - at_s < KEPT_S);
        if !is_icing {
            return;
        }
        match self.met.iter_mut().find(|(_, met)| geodesy::distance_m(*met, here) < APART_M) {
            Some((at_s, _)) => *at_s = now_s,
            None => self.met.push((now_s, here)),
        }
        if self.met.len() > PLACES_MAX {
            self.met.remove(0);
        }
    }
}
