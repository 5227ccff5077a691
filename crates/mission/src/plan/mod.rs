//! Plans made before the flight: the input problem, plans from outside, and the quality of a plan.

pub mod import;
pub mod input;
pub mod problem_file;
pub mod proof;
pub mod turns;
