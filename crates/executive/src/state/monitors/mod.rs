//! Monitors: the state of conditions being watched.

pub mod cyclic;
pub mod moments;
pub mod monitor;
pub mod numbers;
pub mod ordered_numbers;
mod parts;
mod unmet;
