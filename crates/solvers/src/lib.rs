//! Planners, one folder each, with the checker that every plan must pass and the table that chooses between them.
//!
//! A solver implements `apex_model::solver::Solver`: problem in, plan out, within a budget of work units. All are
//! deterministic in seed and budget. A new planner is a folder and a row in [`solvers`].

pub mod anytime;
pub mod checker;
pub mod features;
pub mod nearest_neighbour;
pub mod random;
pub mod single_visit;
pub mod surveillance;
pub mod two_opt;
pub mod validate;
pub mod wam;

use apex_model::solver::Solver;

/// Every planner, in the order of their complexity.
pub fn solvers() -> Vec<Box<dyn Solver>> {
    vec![Box::new(nearest_neighbour::NearestNeighbour), Box::new(two_opt::TwoOpt), Box::new(single_visit::SingleVisit)]
}

/// The planner called `name`.
pub fn solver(name: &str) -> Option<Box<dyn Solver>> {
    solvers().into_iter().find(|solver| solver.name() == name)
}
