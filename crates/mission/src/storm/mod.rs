//! Convective cells on the weather radar: where they are, how they move, and the air that plans and paths avoid because of them.

mod areas;
mod cell;
mod memory;

pub(crate) use areas::{KEPT_M, area_of};
pub(crate) use cell::{AHEAD_S, StormTrack};
pub use memory::StormMemory;
