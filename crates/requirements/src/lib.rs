//! Requirements of a flight: margins with units, time to violation along the commanded route, and when to act.
//!
//! Pure functions over plain data. A margin is positive while its requirement is kept. The structure follows run-time assurance
//! (ASTM F3269-21): a bounded function flies, a monitor predicts, a recovery function acts in time. Positions are points of a
//! local plane (`apex_geo::plane`) near the vehicle; mathematics is `libm`, so that results are equal on every platform.

pub mod alarm;
pub mod least_evil;
pub mod margin;
pub mod prediction;
pub mod response;
pub mod route;

pub use alarm::{Alarm, AlarmState, Concern, Thresholds};
pub use prediction::{Violation, first_violation};
pub use route::{Motion, Route, RouteState};

/// Standard acceleration of gravity.
pub const GRAVITY_M_S2: f64 = 9.806_65;
