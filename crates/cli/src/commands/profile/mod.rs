//! `apex profile`: determines the best planner for each kind of mission, measured on test missions.

mod build;
mod compare;
mod measuring;
mod merge;
mod regret;
mod show;

use crate::error::{CliError, CliResult, read_text};
use crate::options::ProfileCommand;
use crate::sources::parse_time;
use apex_model::time::{Duration, Time};
use apex_planning::Registry;
use apex_planning::solver::units_in;
use apex_portfolio::ProfileTable;
use apex_portfolio::format_error::FormatError;
use apex_portfolio::profile::error::ProfileError;
use apex_portfolio::profile::{Profile, SHIPPED, named};
use std::path::Path;
use std::sync::Arc;

/// Longest time for deliberation that is measured: a day.
const BUDGET_MAX: Duration = Duration(86_400_000_000_000);

/// Runs a command of `apex profile`.
pub fn run(command: &ProfileCommand, registry: &Registry) -> CliResult {
    match command {
        ProfileCommand::Build(options) => build::build(options, registry),
        ProfileCommand::Update(options) => build::update(options, registry),
        ProfileCommand::Merge(options) => merge::run(options),
        ProfileCommand::Show(options) => show::run(options),
        ProfileCommand::Compare(options) if options.regret => regret::run(options, registry),
        ProfileCommand::Compare(options) => compare::run(options),
    }
}

/// Returns the profile in `path`, or the shipped one.
fn read(path: Option<&Path>) -> CliResult<Profile> {
    let (name, text) = match path {
        Some(path) => (path.display().to_string(), read_text(path)?),
        None => ("the profile that ships".to_string(), SHIPPED.to_string()),
    };
    text.parse().map_err(|error| not_understood(&name, error))
}

fn not_understood(name: &str, error: FormatError) -> CliError {
    let place = format!("{name}:{}:{}", error.line, error.column);
    CliError::user(format!("{place}: {}\n  {}", error.message, error.text.trim()))
        .because(error.reason)
        .help(error.help)
}

/// Returns the table of solver selection in a file.
///
/// # Errors
/// The file cannot be read, or is not a profile table.
pub fn table(path: &Path) -> CliResult<Arc<ProfileTable>> {
    let text = read_text(path)?;
    let table = ProfileTable::read(&text).map_err(|error| not_understood(&path.display().to_string(), error))?;
    Ok(Arc::new(table))
}

/// Returns a budget in work units.
fn units(text: &str, option: &str) -> CliResult<u64> {
    let time = parse_time(text, option)? - Time::ZERO;
    if time <= Duration::ZERO || time > BUDGET_MAX {
        return Err(CliError::user(format!(
            "invalid value `{text}` for `{option}`: expected a duration greater than zero and at most one day"
        ))
        .help("write times above 0 and up to a day, for example `10ms`"));
    }
    Ok(units_in(time))
}

/// Returns the indices of the requested budgets in a profile; all if none is requested.
fn budgets(profile: &Profile, wanted: &[&str], option: &str) -> CliResult<Vec<usize>> {
    if wanted.is_empty() {
        return Ok((0..profile.budgets.len()).collect());
    }
    let place = |text: &&str| Ok(named::budget(profile, units(text, option)?, text)?);
    wanted.iter().map(place).collect()
}

impl From<ProfileError> for CliError {
    fn from(error: ProfileError) -> CliError {
        CliError { of_user: true, message: error.message, reason: error.reason, help: Some(error.help) }
    }
}
