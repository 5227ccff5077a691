//! The profile of planners: measured on test missions, merged, and turned into the table by which planners are selected.

use crate::errors::mission as failed;
use crate::planning::{Means, positive};
use apex_mission::error::{MissionError, MissionResult};
use apex_model::time::Duration;
use apex_planning::solver::{Solver, units_in};
use apex_portfolio::format_error::FormatError;
use apex_portfolio::profile::error::ProfileError;
use apex_portfolio::profile::{Planner, Profile, conclusion, measure, merge, named};
use pyo3::prelude::*;
use std::sync::Arc;

/// Returns the names of cells; `all` and `subset` in `names` each mean several cells.
#[pyfunction]
pub(crate) fn cell_names(python: Python<'_>, names: Vec<String>) -> PyResult<Vec<String>> {
    let found = named::cells(&names).map_err(|error| failed(python, refused(error)))?;
    Ok(found.iter().map(ToString::to_string).collect())
}

/// Measures planners in cells of test missions, or on the missions of an existing profile; returns the profile's text.
#[pyfunction]
pub(crate) fn measured(
    python: Python<'_>,
    profile: Option<&str>,
    grid: (Vec<String>, u64, Vec<f64>),
    planners: Vec<String>,
    means: &Means,
) -> PyResult<String> {
    let (cells, missions, budgets_s) = grid;
    let budgets_s =
        budgets_s.into_iter().map(|budget_s| positive(budget_s, "budgets_s")).collect::<PyResult<Vec<_>>>()?;
    let start = || -> MissionResult<(Profile, Vec<Arc<dyn Solver>>)> {
        let profile = match profile {
            Some(text) => continued(text)?,
            None => empty(&cells, missions, &budgets_s).map_err(refused)?,
        };
        Ok((profile, named::planners(&planners, &means.inner.planners).map_err(refused)?))
    };
    let (mut profile, solvers) = start().map_err(|failure| failed(python, failure))?;
    for solver in &solvers {
        let mut measured = Vec::new();
        for row in &profile.rows {
            for number in 0..profile.missions {
                python.check_signals()?;
                let one = python.detach(|| measure::mission(&row.cell, number, solver.as_ref(), &profile.budgets));
                measured.push(one.map_err(|why| {
                    let abandoned = MissionError::planning("the measurement was abandoned").because(why);
                    failed(python, abandoned.help("correct the planner"))
                })?);
            }
        }
        let version = env!("CARGO_PKG_VERSION").to_string();
        profile.put_measured(Planner { name: solver.name().to_string(), version }, &measured);
    }
    Ok(profile.to_string())
}

/// Returns a profile in which nothing has been measured yet.
fn empty(cells: &[String], missions: u64, budgets_s: &[f64]) -> Result<Profile, ProfileError> {
    let cells = named::cells(cells)?;
    named::missions(missions, "")?;
    let units = budgets_s.iter().map(|budget_s| units_in(Duration::from_seconds(*budget_s))).collect();
    let texts: Vec<String> = budgets_s.iter().map(|budget_s| format!("{budget_s} s")).collect();
    Ok(Profile::empty(&cells, missions, &named::rising(units, &texts)?))
}

/// Merges parts that were measured separately into one profile.
#[pyfunction]
pub(crate) fn merged_profile(python: Python<'_>, parts: Vec<String>) -> PyResult<String> {
    let merged = || -> MissionResult<String> {
        let part = |(number, text): (usize, &String)| {
            let place = format!("part {number}");
            read(text, &place).map(|profile| (place.clone(), profile))
        };
        let parts = parts.iter().enumerate().map(part).collect::<MissionResult<Vec<(String, Profile)>>>()?;
        let whole = merge::merged(&parts).map_err(|why| {
            MissionError::data("these profiles are not parts of one profile")
                .because(why)
                .help("measure all parts with the same version, missions and budgets, and each planner in all cells")
        })?;
        Ok(whole.to_string())
    };
    merged().map_err(|failure| failed(python, failure))
}

/// Returns the table that chooses planners, concluded from a profile.
#[pyfunction]
pub(crate) fn profile_table(python: Python<'_>, profile: &str) -> PyResult<String> {
    let profile = read(profile, "the profile").map_err(|failure| failed(python, failure))?;
    Ok(conclusion::written(&profile))
}

fn read(text: &str, place: &str) -> MissionResult<Profile> {
    text.parse().map_err(|error: FormatError| {
        let place = format!("{place}:{}:{}", error.line, error.column);
        MissionError::data(error.message).at(place).because(error.reason).help(error.help)
    })
}

/// Returns a profile that can be continued with this version's test missions.
fn continued(text: &str) -> MissionResult<Profile> {
    let profile = read(text, "the profile")?;
    match profile.outdated() {
        None => Ok(profile),
        Some(why) => Err(MissionError::data("the profile cannot be continued")
            .because(why)
            .help("planners are compared on the same missions: measure all of them again")),
    }
}

/// Returns a request that cannot be met, as a failure of a mission's data.
fn refused(error: ProfileError) -> MissionError {
    let failure = MissionError::data(error.message).help(error.help);
    match error.reason {
        Some(reason) => failure.because(reason),
        None => failure,
    }
}
