//! Value of a mission: the expected cost of ignorance and the mission score (paper, sections II.A and II.B).
//!
//! Pure functions over the plain data of `apex_model::problem`. No state, no clock, no randomness.

pub mod eci;
pub mod mission_score;
pub mod quadrature;
pub mod survival;
pub mod tabulate;
pub mod user_cost;
