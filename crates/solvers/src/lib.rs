//! Planners, one folder each, with the checker that every plan must pass and the table that chooses between them.
//!
//! A solver implements `apex_model::solver::Solver`: problem in, plan out, within a budget of work units. All are
//! deterministic in seed and budget. A new planner is a folder and a row in [`solvers`].

pub mod nearest_neighbour;
pub mod random;
pub mod surveillance;
pub mod two_opt;
pub mod validate;
