//! Whole flights of missions that no shipped one resembles: other vehicles, zones and winds in odd places, updates while the aircraft
//! waits. Tracks are compared with zones and grounds here, from the recorded locations alone.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a failed test should stop")]
#![allow(clippy::disallowed_methods, reason = "this check computes distances apart from the product")]

#[path = "odd/changed_altitude.rs"]
mod changed_altitude;
#[path = "odd/closed_base.rs"]
mod closed_base;
#[path = "odd/descent.rs"]
mod descent;
#[path = "odd/engine_out.rs"]
mod engine_out;
#[path = "odd/fixed_wing_sites.rs"]
mod fixed_wing_sites;
#[path = "odd/growth.rs"]
mod growth;
#[path = "odd/harness.rs"]
mod harness;
#[path = "odd/images.rs"]
mod images;
#[path = "odd/looks.rs"]
mod looks;
#[path = "odd/low_sun.rs"]
mod low_sun;
#[path = "odd/low_zone.rs"]
mod low_zone;
#[path = "odd/measured_wind.rs"]
mod measured_wind;
#[path = "odd/near_zone.rs"]
mod near_zone;
#[path = "odd/over_hills.rs"]
mod over_hills;
#[path = "odd/partly_shut.rs"]
mod partly_shut;
#[path = "odd/still_air.rs"]
mod still_air;
#[path = "odd/strong_wind.rs"]
mod strong_wind;
#[path = "odd/tight_circles.rs"]
mod tight_circles;
#[path = "odd/unplanned_end.rs"]
mod unplanned_end;
#[path = "odd/waiting.rs"]
mod waiting;
