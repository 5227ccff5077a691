//! Checks of plans that the shipped planners make.
#![allow(clippy::expect_used, clippy::indexing_slicing, clippy::panic, clippy::unwrap_used, reason = "tests")]

mod changing_wind;
mod checker;
mod circling;
mod left_out;
mod previous;
