//! `apex profile`: which planner is best where, measured on test missions.

mod build;
mod compare;
mod measuring;
mod merge;
mod regret;
mod show;

use crate::options::ProfileCommand;
use crate::sources::parse_time;
use crate::trouble::{Outcome, Trouble, read_text};
use apex_model::problem::Problem;
use apex_model::time::{Duration, Time};
use apex_planning::Registry;
use apex_planning::solver::{Solver, units_in};
use apex_portfolio::ProfileTable;
use apex_portfolio::cell::{Cell, Scale, Space, Spread};
use apex_portfolio::format_error::FormatTrouble;
use apex_portfolio::profile::{Profile, SHIPPED, budget_words};
use std::path::Path;
use std::sync::Arc;

/// Longest time for deliberation that is measured: a day.
const BUDGET_MAX: Duration = Duration(86_400_000_000_000);

/// Runs one of its commands.
pub fn run(command: &ProfileCommand, registry: &Registry) -> Outcome {
    match command {
        ProfileCommand::Build(options) => build::build(options, registry),
        ProfileCommand::Update(options) => build::update(options, registry),
        ProfileCommand::Merge(options) => merge::run(options),
        ProfileCommand::Show(options) => show::run(options),
        ProfileCommand::Compare(options) if options.regret => regret::run(options, registry),
        ProfileCommand::Compare(options) => compare::run(options),
    }
}

/// The profile in `path`, or the one that ships.
fn read(path: Option<&Path>) -> Outcome<Profile> {
    let (name, text) = match path {
        Some(path) => (path.display().to_string(), read_text(path)?),
        None => ("the profile that ships".to_string(), SHIPPED.to_string()),
    };
    text.parse().map_err(|trouble| not_understood(&name, trouble))
}

fn not_understood(name: &str, trouble: FormatTrouble) -> Trouble {
    let place = format!("{name}:{}:{}", trouble.line, trouble.column);
    Trouble::user(format!("{place}: {}\n  {}", trouble.message, trouble.text.trim()))
        .because(trouble.reason)
        .help(trouble.help)
}

/// The table of solver selection in a file.
///
/// # Errors
/// It cannot be read, or a place in it is not understood.
pub fn table(path: &Path) -> Outcome<Arc<ProfileTable>> {
    let text = read_text(path)?;
    let table = ProfileTable::read(&text).map_err(|trouble| not_understood(&path.display().to_string(), trouble))?;
    Ok(Arc::new(table))
}

/// The planners of these names, each once.
fn planners(names: &[String], registry: &Registry) -> Outcome<Vec<Arc<dyn Solver>>> {
    let any = Cell { scale: Scale::Small, rate: Spread::Fixed, cost: Spread::Fixed, count: 4, space: Space::Uniform };
    let problem = Problem::Surveillance(any.mission(0));
    let serving = registry.serving(&problem);
    let mut found: Vec<Arc<dyn Solver>> = Vec::with_capacity(names.len());
    for name in names {
        if found.iter().any(|known| known.name() == name) {
            return Err(Trouble::user(format!("the planner {name} is named twice")).help("name each planner once"));
        }
        let solver = serving.iter().find(|solver| solver.name() == name).cloned();
        found.push(solver.ok_or_else(|| {
            let known: Vec<&str> = serving.iter().map(|solver| solver.name()).collect();
            Trouble::user(format!("there is no planner of surveillance `{name}`"))
                .help(format!("known are {}", known.join(", ")))
        })?);
    }
    Ok(found)
}

/// A budget in work units.
fn units(text: &str, option: &str) -> Outcome<u64> {
    let time = parse_time(text, option)? - Time::ZERO;
    if time <= Duration::ZERO || time > BUDGET_MAX {
        return Err(Trouble::user(format!("`{option} {text}` is no time to plan in"))
            .help("write times above 0 and up to a day, for example `10ms`"));
    }
    Ok(units_in(time))
}

/// The indices of the wanted budgets in a profile; all where none is wanted.
fn budgets(profile: &Profile, wanted: &[&str], option: &str) -> Outcome<Vec<usize>> {
    if wanted.is_empty() {
        return Ok((0..profile.budgets.len()).collect());
    }
    let known: Vec<String> = profile.budgets.iter().map(|units| budget_words(*units)).collect();
    let place = |text: &&str| {
        let wanted = units(text, option)?;
        profile.budgets.iter().position(|units| *units == wanted).ok_or_else(|| {
            Trouble::user(format!("{text} was not measured")).help(format!("this profile has {}", known.join(", ")))
        })
    };
    wanted.iter().map(place).collect()
}
