//! Seeded problems for tests of planners, bounds and classifiers, in this crate and in others.

pub mod single_visit;
pub mod surveillance;
