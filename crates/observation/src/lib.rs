//! One model of observing: what a sensor on a moving vehicle sees of the wanted ground, how well, and what it is worth.
//!
//! No state of the flight, no clock, no file, no randomness; trigonometry goes through `libm`. Planned lines and recorded
//! flights go through the same accumulation and the same score; only the source of the samples differs.

pub mod assess;
pub mod attitude;
pub mod clarity;
pub mod flown;
pub mod footprint;
pub mod grid;
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
