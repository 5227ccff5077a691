//! Navigation that fails: the autopilot flies by its estimate of the position, and the aircraft is somewhere else.
//!
//! The position of the vehicle's state is the estimated one: guidance, cameras and reports use it. The true one is the estimated one less
//! the error; weather, ground, radios and what sensors see use that. With a drift (`by`) the error grows to the east at this rate.
//! Without any position the autopilot reckons: it adds its airspeed and the wind that it knew last, so that the error grows by what
//! the wind has changed since. When the failure is over the estimated position is the true one again.

use crate::motion::moved;
use apex_geo::wind::Wind;
use apex_model::problem::Position;
use libm::hypot;

/// Error of the estimated position.
#[derive(Clone, Debug, Default)]
pub(crate) struct NavigationError {
    pub(crate) north_m: f64,
    pub(crate) east_m: f64,
    /// The wind when the position was lost.
    pub(crate) known_wind: Option<Wind>,
}

impl NavigationError {
    /// Length of the error.
    pub(crate) fn length_m(&self) -> f64 {
        hypot(self.north_m, self.east_m)
    }

    pub(crate) fn is_none(&self) -> bool {
        self.north_m == 0.0 && self.east_m == 0.0
    }

    /// The true place of what is estimated to be at `position`.
    pub(crate) fn truth(&self, position: Position) -> Position {
        if self.is_none() { position } else { moved(position, -self.north_m, -self.east_m) }
    }
}
