//! Deliberation management services: selecting, invoking and using solvers (paper, section IV). One file per service.

pub(crate) mod plan_adoption;
pub(crate) mod planner_invocation;
pub(crate) mod solver_selection;
