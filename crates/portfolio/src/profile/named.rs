//! Names given by users: cells, budgets, planners and numbers of missions, all checked before any measurement.

use super::error::ProfileError;
use super::{MISSIONS_MAX, Profile, Row, budget_words};
use crate::cell::{Cell, Scale, Space, Spread};
use apex_model::problem::Problem;
use apex_planning::Registry;
use apex_planning::solver::Solver;
use apex_planning::validate::TARGETS_MAX;
use std::sync::Arc;

/// Maximum number of budgets in one profile.
const BUDGETS_MAX: usize = 32;

/// Returns the cells with these names; `all` and `subset` are names of several cells.
///
/// # Errors
/// A name is unknown, or one occurs twice.
pub fn cells(names: &[String]) -> Result<Vec<Cell>, ProfileError> {
    let mut cells: Vec<Cell> = Vec::new();
    for name in names {
        let named = match name.as_str() {
            "all" => Cell::all(),
            "subset" => Cell::subset(),
            name => {
                vec![cell(name, "docs/reference/test-missions.md names the cells; `all` and `subset` are known too")?]
            }
        };
        for cell in named {
            if cells.contains(&cell) {
                return Err(ProfileError::new(format!("the cell {cell} is named twice"), "name each cell once"));
            }
            cells.push(cell);
        }
    }
    Ok(cells)
}

fn cell(name: &str, help: &str) -> Result<Cell, ProfileError> {
    name.parse().map_err(|why: String| ProfileError::new(format!("there is no cell {name}"), help).because(why))
}

/// Returns the measurements of the cell called `name`.
///
/// # Errors
/// If there is no such cell, or it was not measured.
pub fn row<'a>(profile: &'a Profile, name: &str) -> Result<&'a Row, ProfileError> {
    let cell = cell(name, "docs/reference/test-missions.md names the cells")?;
    profile.rows.iter().find(|row| row.cell == cell).ok_or_else(|| {
        ProfileError::new(format!("{cell} was not measured"), "`apex profile show` lists the cells of this profile")
    })
}

/// Checks that budgets increase; `texts` are the texts that the user wrote.
///
/// # Errors
/// If there are none, too many, or they do not increase.
pub fn rising(budgets: Vec<u64>, texts: &[String]) -> Result<Vec<u64>, ProfileError> {
    if budgets.is_empty() || budgets.len() > BUDGETS_MAX || !budgets.is_sorted_by(|a, b| a < b) {
        let message = format!("invalid budgets `{}`", texts.join(", "));
        let help = format!("write one to {BUDGETS_MAX} different times, the shortest first");
        return Err(ProfileError::new(message, help));
    }
    Ok(budgets)
}

/// Returns the index of a budget of `units` in a profile; `text` is the text that the user wrote.
///
/// # Errors
/// It was not measured.
pub fn budget(profile: &Profile, units: u64, text: &str) -> Result<usize, ProfileError> {
    profile.budgets.iter().position(|known| *known == units).ok_or_else(|| {
        let known: Vec<String> = profile.budgets.iter().map(|units| budget_words(*units)).collect();
        ProfileError::new(format!("{text} was not measured"), format!("this profile has {}", known.join(", ")))
    })
}

/// Checks how many missions of each cell are to be measured.
///
/// # Errors
/// None, or too many; `hint` is added to the help.
pub fn missions(number: u64, hint: &str) -> Result<(), ProfileError> {
    if number == 0 || number > MISSIONS_MAX {
        let message = format!("{number} missions of each cell cannot be measured");
        return Err(ProfileError::new(message, format!("write a number from 1 to {MISSIONS_MAX}{hint}")));
    }
    Ok(())
}

/// Checks counts of targets.
///
/// # Errors
/// If there are no missions with this number of targets.
pub fn counts(counts: &[usize]) -> Result<(), ProfileError> {
    match counts.iter().find(|count| **count == 0 || **count > TARGETS_MAX) {
        Some(count) => Err(ProfileError::new(
            format!("there are no missions of {count} targets"),
            format!("write numbers from 1 to {TARGETS_MAX}"),
        )),
        None => Ok(()),
    }
}

/// Returns the surveillance planners with these names.
///
/// # Errors
/// A name is unknown, or one occurs twice.
pub fn planners(names: &[String], registry: &Registry) -> Result<Vec<Arc<dyn Solver>>, ProfileError> {
    let any = Cell { scale: Scale::Small, rate: Spread::Fixed, cost: Spread::Fixed, count: 4, space: Space::Uniform };
    let serving = registry.serving(&Problem::Surveillance(any.mission(0)));
    let mut found: Vec<Arc<dyn Solver>> = Vec::with_capacity(names.len());
    for name in names {
        if found.iter().any(|known| known.name() == name) {
            return Err(ProfileError::new(format!("the planner {name} is named twice"), "name each planner once"));
        }
        let solver = serving.iter().find(|solver| solver.name() == name).cloned();
        found.push(solver.ok_or_else(|| {
            let known: Vec<&str> = serving.iter().map(|solver| solver.name()).collect();
            let message = format!("surveillance planner `{name}` not found");
            ProfileError::new(message, format!("known planners: {}", known.join(", ")))
        })?);
    }
    Ok(found)
}
