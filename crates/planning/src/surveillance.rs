//! Shared parts of surveillance planners: the times of a tour of targets, its expected cost, and the plan made from it.

pub mod previous;
mod reach;
pub mod scenario;
pub mod travel;
