//! Failing navigation: the autopilot flies by its estimated position, and the aircraft is somewhere else.
//!
//! The position in the vehicle's state is the estimated one: guidance, cameras and reports use it. The true position is the estimated one
//! minus the error; weather, ground, radios and the views of sensors use that. With a drift (`by`) the error grows eastwards at this
//! rate. Without any position the autopilot uses dead reckoning: it adds its airspeed and the last known wind, so that the error grows by
//! the change of the wind since then. After the failure the estimated position is the true one again.

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
    /// Returns the length of the error, m.
    pub(crate) fn length_m(&self) -> f64 {
        hypot(self.north_m, self.east_m)
    }

    pub(crate) fn is_none(&self) -> bool {
        self.north_m == 0.0 && self.east_m == 0.0
    }

    /// Returns the true place of the estimated `position`.
    pub(crate) fn truth(&self, position: Position) -> Position {
        if self.is_none() { position } else { moved(position, -self.north_m, -self.east_m) }
    }
}
