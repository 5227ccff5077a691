//! Single-visit problems in the form that planners and bounds use: paths with travel times, schedules of orders, networks in ticks.
//!
//! Planners and bounds both import this folder; it imports neither.

pub(crate) mod flight_limit;
mod flown_legs;
pub(crate) mod network;
mod places;
pub(crate) mod reach;
pub(crate) mod schedule;
pub(crate) mod travel;
mod turns_between;
mod zones;
