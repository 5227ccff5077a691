//! Planners (`planners/`, one folder each) and bounds on the value of plans (`bounds/`). Both import `routing/`; `prove` imports both.
//!
//! A planner implements `apex_planning::solver::Solver`: it answers a problem with a plan, within a budget of work units. All are
//! deterministic in seed and budget. A new planner is a folder and a row in [`solvers`].

pub mod bounds;
pub mod planners;
mod prove;
mod routing;

pub use prove::prove;

use apex_planning::Registry;
use apex_planning::solver::Solver;
use planners::{
    nearest_neighbour::NearestNeighbour, single_visit::SingleVisit, tour_annealing::TourAnnealing, two_opt::TwoOpt,
    wam::Wam,
};
use std::sync::Arc;

/// Returns every planner that ships, in the order of their complexity.
pub fn solvers() -> Vec<Arc<dyn Solver>> {
    vec![Arc::new(NearestNeighbour), Arc::new(TwoOpt), Arc::new(Wam), Arc::new(TourAnnealing), Arc::new(SingleVisit)]
}

/// Returns the planner called `name`.
pub fn solver(name: &str) -> Option<Arc<dyn Solver>> {
    solvers().into_iter().find(|solver| solver.name() == name)
}

/// Returns a registry of the planners that ship.
pub fn shipped() -> Registry {
    Registry::of(solvers())
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
        let mut registry = Registry::default();
        solvers().into_iter().for_each(|solver| registry.add(solver).unwrap());
        assert!(registry.iter().map(|solver| solver.name()).eq(shipped().iter().map(|solver| solver.name())));
    }
}
