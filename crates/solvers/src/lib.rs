//! Planners, one folder each, with the checker that every plan must pass and the table that chooses between them.
//!
//! A solver implements `apex_model::solver::Solver`: problem in, plan out, within a budget of work units. All are
//! deterministic in seed and budget. A new planner is a folder and a row in [`solvers`].

pub mod anytime;
pub mod bound;
pub mod checker;
pub mod features;
pub mod formats;
pub mod human;
pub mod nearest_neighbour;
pub mod profile;
pub mod random;
pub mod registry;
pub mod single_visit;
pub mod surveillance;
pub mod table;
pub mod test_missions;
pub mod two_opt;
pub mod validate;
pub mod wam;

pub use registry::Registry;
pub use table::{ProfileTable, Selection, select, select_within};

use apex_model::solver::Solver;

/// Every planner, in the order of their complexity.
pub fn solvers() -> Vec<Box<dyn Solver>> {
    vec![
        Box::new(nearest_neighbour::NearestNeighbour),
        Box::new(two_opt::TwoOpt),
        Box::new(wam::Wam),
        Box::new(anytime::Anytime),
        Box::new(single_visit::SingleVisit),
    ]
}

/// The planner called `name`.
pub fn solver(name: &str) -> Option<Box<dyn Solver>> {
    solvers().into_iter().find(|solver| solver.name() == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_found() {
        let all = solvers();
        let names: Vec<&str> = all.iter().map(|solver| solver.name()).collect();
        assert_eq!(names, ["nearest-neighbour", "two-opt", "wam", "anytime", "single-visit"]);
        assert!(names.iter().all(|name| solver(name).is_some()) && solver("human").is_none());
    }
}
