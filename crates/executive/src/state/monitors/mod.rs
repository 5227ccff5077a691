//! Monitors: the state of watched conditions.

pub mod cyclic;
pub mod moments;
pub mod monitor;
pub mod numbers;
pub mod ordered_numbers;
mod orders;
mod parts;
mod unmet;
