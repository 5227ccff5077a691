//! Data acquisition: manoeuvres for the mission's vehicle and targets, as PDL writes and flies them.

mod form;
mod paths;
mod predicted;
mod vehicle;

pub(crate) use paths::register;
pub use predicted::{PerformedManoeuvre, forecast};
