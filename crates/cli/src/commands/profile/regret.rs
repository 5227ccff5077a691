//! `apex profile compare --regret`: the additional cost of selected planners over the best planner, on missions that are in no profile.

use super::{measuring, read, units};
use crate::error::CliResult;
use crate::options::ProfileCompareOptions;
use crate::output;
use apex_planning::Registry;
use apex_portfolio::profile::regret::{self, Summary};
use apex_portfolio::profile::{budget_words, named};

/// Measures and prints the regret for each budget and each number of targets.
pub(super) fn run(options: &ProfileCompareOptions, registry: &Registry) -> CliResult {
    let profile = read(None)?;
    named::missions(options.missions, "")?;
    named::counts(&options.counts)?;
    let budgets = match options.budgets.as_slice() {
        [] => profile.budgets.clone(),
        wanted => wanted.iter().map(|text| units(text, "--budgets")).collect::<CliResult<Vec<u64>>>()?,
    };
    let names: Vec<String> = profile.planners.iter().map(|planner| planner.name.clone()).collect();
    let solvers = named::planners(&names, registry)?;
    let missions = usize::try_from(options.missions).unwrap_or(usize::MAX);
    for budget in budgets {
        for count in &options.counts {
            let cells = regret::cells(*count);
            let title = format!("{count} targets at {}", budget_words(budget));
            let outcomes = measuring::each(&options.work, &title, cells.len() * missions, |task| {
                let cell = cells
                    .get(task / missions)
                    .ok_or("internal error: a measurement belongs to no cell; please report it with the command")?;
                regret::mission(cell, (task % missions) as u64, &solvers, (registry, budget))
            })?;
            let summary = Summary::of(*count, budget, &names, &outcomes);
            match options.json {
                true => output::print_line(summary.json())?,
                false => output::print_line(summary.text())?,
            }
        }
    }
    Ok(())
}
