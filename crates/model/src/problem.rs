//! Planning problems and plans: what solvers are asked and what they answer.

/// A planning problem.
#[derive(Clone, Debug)]
pub struct Problem;

/// A plan.
#[derive(Clone, Debug)]
pub struct Plan;
