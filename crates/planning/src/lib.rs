//! Problems and plans, without any planner: what planners are given and answer, and how an answer is judged.
//!
//! [`solver`] is the contract that planners implement, [`registry`] holds those of a program. [`validate`] refuses problems
//! that are invalid, [`checker`] plans that are. [`surveillance`] flies and prices visits, [`tour`] finds shortest tours:
//! planners, bounds and classifiers build on both. The checker uses neither, so that it is a second witness.

pub mod checker;
pub mod examples;
pub mod meter;
pub mod obstacle;
pub mod random;
pub mod registry;
pub mod solver;
pub mod surveillance;
pub mod tour;
pub mod validate;

pub use registry::Registry;
