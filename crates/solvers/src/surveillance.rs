//! What all surveillance planners share: flying a word of targets, its expected cost, and the plan made of it.

pub mod previous;
pub mod scenario;
pub mod travel;

#[cfg(test)]
pub(crate) mod examples;

#[cfg(test)]
mod changing_wind_tests;
#[cfg(test)]
mod circling_tests;
