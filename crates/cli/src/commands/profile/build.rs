//! `apex profile build` and `update`: measure profiles, and write each file completely or not at all.

use super::measuring::{self, cpu_s};
use super::{read, units};
use crate::options::{ProfileBuildOptions, ProfileUpdateOptions, ProfileWorkOptions};
use crate::output;

use crate::error::{CliError, CliResult};
use apex_planning::Registry;
use apex_planning::solver::Solver;
use apex_portfolio::profile::{Planner, Profile, conclusion, measure, named};
use std::path::Path;

/// Measures the requested planners, and writes a new profile or replaces an older one.
pub(super) fn build(options: &ProfileBuildOptions, registry: &Registry) -> CliResult {
    let cells = named::cells(&options.cells)?;
    let budgets = options.budgets.iter().map(|text| units(text, "--budgets")).collect::<CliResult<_>>()?;
    let budgets = named::rising(budgets, &options.budgets)?;
    named::missions(options.missions, "; the published table was measured with 50")?;
    let planners = named::planners(&options.planners, registry)?;
    let before = refuse_other(&options.profile)?;
    let mut profile = Profile::empty(&cells, options.missions, &budgets);
    for planner in &planners {
        measure(&mut profile, planner.as_ref(), &options.work)?;
    }
    write(&options.profile, before.as_deref(), &profile.to_string())?;
    write_table(options.table.as_deref(), &profile)
}

/// Measures the requested planners again, or new planners, and puts the results into the profile.
pub(super) fn update(options: &ProfileUpdateOptions, registry: &Registry) -> CliResult {
    let mut profile = read(Some(&options.profile))?;
    let before = profile.to_string();
    let planners = named::planners(&options.planners, registry)?;
    if let Some(why) = profile.outdated() {
        return Err(CliError::user(format!("{} cannot be updated", options.profile.display()))
            .because(why)
            .help("planners are compared on the same missions: measure all of them again with `apex profile build`"));
    }
    for planner in &planners {
        measure(&mut profile, planner.as_ref(), &options.work)?;
    }
    let after = profile.to_string();
    if after != before {
        let known = crate::error::read_text(&options.profile)?;
        apex_mission::replacing::replace(&options.profile, &known, &after)?;
    }
    write_table(options.table.as_deref(), &profile)
}

/// Measures one planner on every mission and prints its work.
fn measure(profile: &mut Profile, planner: &dyn Solver, work: &ProfileWorkOptions) -> CliResult {
    let missions = usize::try_from(profile.missions).unwrap_or(usize::MAX);
    let before_s = cpu_s();
    let measured = measuring::each(work, planner.name(), profile.rows.len() * missions, |task| {
        let row = profile
            .rows
            .get(task / missions)
            .ok_or("internal error: a measurement belongs to no cell; please report it with the command")?;
        measure::mission(&row.cell, (task % missions) as u64, planner, &profile.budgets)
    })?;
    let used: u64 = measured.iter().map(|one| one.used).sum();
    let spent_s = before_s.zip(cpu_s()).map(|(before_s, after_s)| after_s - before_s);
    if let Some(cpu_s) = spent_s.filter(|_| !work.no_progress) {
        let unit_ns = 1e9 * cpu_s / used.max(1) as f64;
        let name = planner.name();
        output::print_error(format_args!(
            "{name}: {used} units of work in {cpu_s:.1} CPU seconds, {unit_ns:.0} ns per unit"
        ));
    }
    let version = env!("CARGO_PKG_VERSION").to_string();
    profile.put_measured(Planner { name: planner.name().to_string(), version }, &measured);
    Ok(())
}

/// Returns the text of the profile or empty file at `path`, which may be replaced; `None` if there is no file.
///
/// # Errors
/// If another file is there. It is checked before the measurement, which can take hours.
pub(super) fn refuse_other(path: &Path) -> CliResult<Option<String>> {
    if !path.exists() {
        return Ok(None);
    }
    let text = crate::error::read_text(path)?;
    if text.parse::<Profile>().is_ok() || text.trim().is_empty() {
        return Ok(Some(text));
    }
    Err(CliError::user(format!("{} exists and is not a profile, so it is not overwritten", path.display()))
        .help("name another file, or remove this one"))
}

/// Writes a file completely; `before` is the content of the older one.
pub(super) fn write(path: &Path, before: Option<&str>, text: &str) -> CliResult {
    if let Some(before) = before {
        return Ok(apex_mission::replacing::replace(path, before, text)?);
    }
    std::fs::write(path, text).map_err(|error| {
        CliError::failure(format!("cannot write {}", path.display())).because(error).help("choose another path for it")
    })
}

/// Writes the extract of a profile for selection, if a path for it is given.
pub(super) fn write_table(path: Option<&Path>, profile: &Profile) -> CliResult {
    let Some(path) = path else { return Ok(()) };
    let before = if path.exists() { Some(crate::error::read_text(path)?) } else { None };
    if before.as_deref().is_some_and(|text| conclusion::read(text).is_err()) {
        return Err(CliError::user(format!(
            "{} exists and is not a profile table, so it is not overwritten",
            path.display()
        ))
        .help("name another file, or remove this one"));
    }
    write(path, before.as_deref(), &conclusion::written(profile))
}
