//! The performance profile (paper, section V.C and Figure 4): measured costs of planners on test missions, and conclusions from them.
//!
//! A [`Profile`] contains every measured cost, by cell, planner, budget and mission. Comparisons of planners are computed from it
//! ([`verdict`]), never stored. Missions are independent and planners deterministic in their work, so any machine and any number of
//! threads give the same profile. Selection reads its extract `data/profile-table.csv`.

pub mod compare;
pub mod conclusion;
pub mod error;
mod file;
pub mod measure;
pub mod merge;
pub mod named;
pub mod picture;
pub mod published;
pub mod regret;
pub mod statistics;
pub mod text;
pub mod verdict;

use crate::cell::Cell;
use crate::test_missions::GENERATOR_VERSION;
use apex_planning::solver::time_of;
use measure::Measured;

/// The measured profile that ships with the product.
pub const SHIPPED: &str = include_str!("../../data/profile.txt");

/// Maximum number of missions of a cell.
pub const MISSIONS_MAX: u64 = file::MISSIONS_MAX;

/// A planner that was measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Planner {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
}

/// One cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Cell.
    pub cell: Cell,
    /// Hash of its missions.
    pub hash: String,
    /// `costs[planner][budget][mission]`.
    pub costs: Vec<Vec<Vec<f64>>>,
}

impl Row {
    /// Returns the costs of a planner at a budget (indices), by mission; empty if there is no such planner or budget.
    pub fn costs(&self, planner: usize, budget: usize) -> &[f64] {
        self.costs.get(planner).and_then(|budgets| budgets.get(budget)).map_or(&[], Vec::as_slice)
    }
}

/// Measured costs, with the parameters of the measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Version of the test missions' generator.
    pub generator: u32,
    /// Number of missions of each cell, which have the numbers 0, 1, ..; a planner's seed is the number of the mission.
    pub missions: u64,
    /// Budgets in work units, rising.
    pub budgets: Vec<u64>,
    /// Planners.
    pub planners: Vec<Planner>,
    /// Cells.
    pub rows: Vec<Row>,
}

impl Profile {
    /// Returns a profile in which nothing has been measured yet.
    pub fn empty(cells: &[Cell], missions: u64, budgets: &[u64]) -> Profile {
        let row = |cell: &Cell| Row { cell: *cell, hash: cell.hash(missions), costs: Vec::new() };
        Profile {
            generator: GENERATOR_VERSION,
            missions,
            budgets: budgets.to_vec(),
            planners: Vec::new(),
            rows: cells.iter().map(row).collect(),
        }
    }

    /// Returns the index of the planner called `name`.
    pub fn planner(&self, name: &str) -> Option<usize> {
        self.planners.iter().position(|planner| planner.name == name)
    }

    /// Stores the costs of `planner`, `costs[cell][budget][mission]`, in place of earlier ones under its name.
    pub fn put(&mut self, planner: Planner, costs: Vec<Vec<Vec<f64>>>) {
        let place = self.planner(&planner.name).unwrap_or(self.planners.len());
        if let Some(known) = self.planners.get_mut(place) {
            *known = planner;
        } else {
            self.planners.push(planner);
        }
        for (row, costs) in self.rows.iter_mut().zip(costs) {
            match row.costs.get_mut(place) {
                Some(known) => *known = costs,
                None => row.costs.push(costs),
            }
        }
    }

    /// Stores the measurements of `planner` on every mission, cell after cell.
    pub fn put_measured(&mut self, planner: Planner, measured: &[Measured]) {
        let budgets = self.budgets.len();
        let at = |missions: &[Measured], budget: usize| -> Vec<f64> {
            missions.iter().filter_map(|one| one.costs.get(budget).copied()).collect()
        };
        let of_cell = |missions: &[Measured]| (0..budgets).map(|budget| at(missions, budget)).collect();
        let missions = usize::try_from(self.missions).unwrap_or(usize::MAX).max(1);
        self.put(planner, measured.chunks(missions).map(of_cell).collect());
    }

    /// Returns the reason for which this profile cannot be completed with new measurements: its missions are from another version of the
    /// generator.
    pub fn outdated(&self) -> Option<String> {
        if self.generator != GENERATOR_VERSION {
            return Some(format!(
                "its missions are of version {} of the generator, ours of {GENERATOR_VERSION}",
                self.generator
            ));
        }
        let other = self.rows.iter().find(|row| row.hash != row.cell.hash(self.missions))?;
        Some(format!("its missions of {} have the hash {}, ours another", other.cell, other.hash))
    }
}

/// Returns a budget as text: `10 ms`.
pub fn budget_words(units: u64) -> String {
    let milliseconds = 1e3 * time_of(units).seconds();
    if milliseconds >= 1000.0 { format!("{} s", milliseconds / 1000.0) } else { format!("{milliseconds} ms") }
}

#[cfg(test)]
mod tests;
