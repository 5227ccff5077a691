//! Travel: how long from one place to another, around what and through which wind.
//!
//! [`Network`] is made once for a set of zones and a wind. It answers [`Network::trip`] (when to leave, when one is there,
//! by which way) for any departure, and [`Network::matrix`] for many places at once. Ways keep out of restricted zones
//! while these are active, inside permitted ones, and within reach of emergency landing places. Not symmetric under wind.
//!
//! What is exact: which parts of a leg a zone shuts and at which departures; progress through wind that changes in time;
//! ways without wind and margins are the shortest there are (decision 0036 says what is not exact).

mod air;
mod boxes;
mod circles;
mod course;
mod dubins;
mod error;
mod ground;
mod network;
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
