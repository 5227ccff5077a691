//! Problems and plans, without any planner: the input and output of planners, and the evaluation of plans.
//!
//! [`solver`] is the contract that planners implement, [`registry`] holds the planners of a program. [`validate`] rejects invalid
//! problems, [`checker`] invalid plans. [`surveillance`] computes times and cost of visits, [`tour`] finds shortest tours: planners,
//! bounds and classifiers use both. The checker uses neither, so that it is a second witness.

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
