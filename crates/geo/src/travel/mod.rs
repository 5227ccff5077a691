//! Travel: times and paths between places, around zones and through wind.
//!
//! A [`Network`] is made once for a set of zones and a wind. [`Network::trip`] returns departure, arrival and path for any departure,
//! [`Network::matrix`] those between many places. Paths avoid restricted zones while these are active, and stay inside permitted ones and
//! within reach of emergency landing places. Times are asymmetric under wind.
//!
//! Exact are: the parts of a leg that a zone closes, and the departures; progress through wind that changes with time; paths without wind
//! and margins, which are the shortest (decision 0036 states what is not exact).

mod air;
mod boxes;
mod circles;
mod course;
mod dubins;
mod error;
mod ground;
mod network;
mod passing;
mod path_vertices;
mod search;
mod setting;
mod solid;
mod spans;
#[cfg(test)]
mod tests;
mod turns;
mod ways;

pub use air::Air;
pub use dubins::{Flyer, Part, Pose, TurnPath, turn_radius_m};
pub use error::TravelError;
pub use network::{BENDS_MAX, EndpointId, Network};
pub use path_vertices::crossing;
pub use setting::{PlaneZone, Setting};
pub use turns::{Circling, TOLERANCE_SHARE};
pub use ways::{PathId, Trip};
