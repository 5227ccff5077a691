//! The planners, one folder each, and the plans of operators (`human`).

pub mod human;
pub mod nearest_neighbour;
pub mod single_visit;
pub mod tour_annealing;
pub mod two_opt;
pub mod wam;
