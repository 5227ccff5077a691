//! Regret of selection: how much more the chosen planner costs than the best one would have, on missions that no profile has
//! seen.

use super::measure;
use crate::cell::Cell;
use crate::table;
use apex_model::problem::Problem;
use apex_planning::Registry;
use apex_planning::solver::Solver;
use std::sync::Arc;

/// The first number of missions that are never part of a profile.
pub const UNSEEN: u64 = 1_000_000;

/// What became of one mission.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Name of the chosen planner.
    pub chosen: String,
    /// Logarithm of each planner's cost over the least, in the order given: 0 is the best.
    pub excess: Vec<f64>,
    /// The same for the chosen planner.
    pub regret: f64,
}

/// Selects one of `planners` for unseen mission `number` of `cell` within `units`, and runs all of `solvers`.
///
/// # Errors
/// A sentence where a planner finds no valid plan, or the chosen one is not among them.
pub fn mission(
    cell: &Cell,
    number: u64,
    solvers: &[Arc<dyn Solver>],
    (planners, units): (&Registry, u64),
) -> Result<Outcome, String> {
    let problem = Problem::Surveillance(cell.mission(UNSEEN + number));
    let chosen = table::select_within(&problem, units, planners).solver;
    let mut logarithms = Vec::with_capacity(solvers.len());
    for solver in solvers {
        let (cost, _) = measure::cost(&problem, number, solver.as_ref(), units)
            .map_err(|why| format!("{} on mission {cell}@{}: {why}", solver.name(), UNSEEN + number))?;
        logarithms.push(libm::log(cost));
    }
    let least = logarithms.iter().copied().fold(f64::INFINITY, f64::min);
    let excess: Vec<f64> = logarithms.iter().map(|logarithm| logarithm - least).collect();
    let regret = solvers.iter().zip(&excess).find(|(solver, _)| solver.name() == chosen).map(|(_, excess)| *excess);
    let regret = regret.ok_or_else(|| format!("selection chose {chosen}, which is not among the planners compared"))?;
    Ok(Outcome { chosen, excess, regret })
}
