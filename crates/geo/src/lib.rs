//! Geodesy, wind, airspace, coverage, radio links, the sun and the growth of fires: pure functions over the plain data of
//! `apex_model::problem`.
//!
//! No state, no clock, no randomness. Trigonometry is that of `libm`, so that results are equal on every platform; the only exception is
//! `geographiclib-rs` (geodesics on WGS84).

pub mod coverage;
pub mod direction;
pub mod fire;
pub mod functions;
pub mod geodesy;
pub mod landing;
pub mod link;
pub mod location;
pub mod perimeter;
pub mod plane;
pub mod sun;
pub mod terrain;
pub mod time_limit;
pub mod travel;
pub mod wind;
