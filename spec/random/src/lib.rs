//! Random programs: made from a seed, run by the executive and by the reference, and compared.
//!
//! [`generate`] makes a case, [`compare`] judges it, [`shrink`] reduces it, [`page`] stores it as a page, and [`campaign`] does all this
//! for many cases.

pub mod campaign;
pub mod compare;
pub mod coverage;
pub mod executive;
pub mod generate;
pub mod page;
#[cfg(feature = "planted-bugs")]
pub mod planted;
pub mod print;
mod rng;
pub mod shrink;
mod steps;
