//! Regret of selection: the additional cost of the chosen planner over the best one, on missions that are in no profile.

use super::{budget_words, measure};
use crate::cell::Cell;
use crate::table;
use apex_model::problem::Problem;
use apex_planning::Registry;
use apex_planning::solver::Solver;
use serde_json::{Map, Value, json};
use std::sync::Arc;

/// The first number of missions that are never part of a profile.
pub const UNSEEN: u64 = 1_000_000;

/// Regret of one mission.
#[derive(Clone, Debug, PartialEq)]
pub struct MissionRegret {
    /// Name of the chosen planner.
    pub chosen: String,
    /// For each planner, in the order given, the logarithm of the ratio of its cost to the least cost: 0 is the best.
    pub excess: Vec<f64>,
    /// The same logarithm for the chosen planner.
    pub regret: f64,
}

/// Selects one of `planners` for mission `number` of `cell`, which no profile contains, within `units`, and runs all of `solvers`.
///
/// # Errors
/// An error message if a planner finds no valid plan, or the chosen one is not among them.
pub fn mission(
    cell: &Cell,
    number: u64,
    solvers: &[Arc<dyn Solver>],
    (planners, units): (&Registry, u64),
) -> Result<MissionRegret, String> {
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
    Ok(MissionRegret { chosen, excess, regret })
}

/// Returns all missions with `count` targets: every space, scale and spread.
pub fn cells(count: usize) -> Vec<Cell> {
    let mut cells: Vec<Cell> = Cell::all().into_iter().map(|cell| Cell { count, ..cell }).collect();
    cells.sort();
    cells.dedup();
    cells
}

/// Regret of many missions.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Number of targets of each.
    pub targets: usize,
    /// The budget as text.
    pub budget: String,
    /// Number of missions.
    pub missions: usize,
    /// Additional cost of the chosen planner over the best one, in percent: the geometric mean over the missions.
    pub regret_percent: f64,
    /// The greatest additional cost of the chosen planner on one mission, in percent.
    pub worst_percent: f64,
    /// Number of missions for which the best was chosen.
    pub best_chosen: usize,
    /// The regret of each planner, if it were always chosen.
    pub always_percent: Vec<(String, f64)>,
}

impl Summary {
    /// Sums up `outcomes` of planners called `names`.
    pub fn of(targets: usize, units: u64, names: &[String], outcomes: &[MissionRegret]) -> Summary {
        let percent = |mean_of: &dyn Fn(&MissionRegret) -> f64| {
            100.0 * (libm::exp(outcomes.iter().map(mean_of).sum::<f64>() / outcomes.len().max(1) as f64) - 1.0)
        };
        let always =
            |(at, name): (usize, &String)| (name.clone(), percent(&|one| one.excess.get(at).copied().unwrap_or(0.0)));
        Summary {
            targets,
            budget: budget_words(units),
            missions: outcomes.len(),
            regret_percent: percent(&|one| one.regret),
            worst_percent: outcomes.iter().map(|one| 100.0 * (libm::exp(one.regret) - 1.0)).fold(0.0, f64::max),
            best_chosen: outcomes.iter().filter(|one| one.regret == 0.0).count(),
            always_percent: names.iter().enumerate().map(always).collect(),
        }
    }

    /// Returns the summary as an object for programs.
    pub fn json(&self) -> Value {
        let always: Map<String, Value> =
            self.always_percent.iter().map(|(name, percent)| (name.clone(), json!(percent))).collect();
        json!({
            "targets": self.targets, "budget": self.budget, "missions": self.missions,
            "regret_percent": self.regret_percent, "worst_percent": self.worst_percent,
            "best_chosen": self.best_chosen, "always_percent": always,
        })
    }

    /// Returns the summary as text for operators.
    pub fn text(&self) -> String {
        let always: Vec<String> =
            self.always_percent.iter().map(|(name, percent)| format!(" {name} {percent:.2} %")).collect();
        format!(
            "{} targets at {}, {} missions: regret {:.2} % (worst {:.1} %), the best was chosen in {}\n  regret of a single planner in all missions:{}",
            self.targets,
            self.budget,
            self.missions,
            self.regret_percent,
            self.worst_percent,
            self.best_chosen,
            always.join(";")
        )
    }
}
