//! One model of observation: which wanted ground a sensor on a moving vehicle sees, how well, and the value of that.
//!
//! The crate uses no state of the flight, clock, file or randomness; trigonometry is that of `libm`. Planned lines and recorded flights
//! use the same accumulation and the same score; only the source of the samples differs.

pub mod assess;
pub mod attitude;
pub mod clarity;
pub mod flown;
pub mod footprint;
pub mod grid;
pub mod growth;
pub mod look_needs;
pub mod looks;
pub mod manoeuvres;
pub mod pictures;
pub mod plane;
pub mod predict;
pub mod resolution;
pub mod result;
pub mod score;
pub mod sensor;
pub mod strip;
pub mod target;
pub mod timing;
