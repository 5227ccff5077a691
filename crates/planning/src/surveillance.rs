//! Shared parts of surveillance planners: flying a tour of targets, its expected cost, and the plan made of it.

pub mod previous;
mod reach;
pub mod scenario;
pub mod travel;
