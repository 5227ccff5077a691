//! `apex profile compare --regret`: what the choices of selection cost more than the best planner, on missions that no
//! profile has seen.

use super::{measuring, planners, read, units};
use crate::options::ProfileCompareOptions;
use crate::output;
use crate::trouble::{Outcome, Trouble};
use apex_planning::Registry;
use apex_planning::solver::Solver;
use apex_planning::validate::TARGETS_MAX;
use apex_portfolio::cell::Cell;
use apex_portfolio::profile::regret::{self, Outcome as Mission};
use apex_portfolio::profile::{MISSIONS_MAX, budget_words};
use std::fmt::Write;
use std::sync::Arc;

/// Measures and prints, by budget and count.
pub(super) fn run(options: &ProfileCompareOptions, registry: &Registry) -> Outcome {
    let profile = read(None)?;
    if options.missions == 0 || options.missions > MISSIONS_MAX {
        return Err(Trouble::user(format!("{} missions of each cell cannot be measured", options.missions))
            .help(format!("write a number from 1 to {MISSIONS_MAX}")));
    }
    if let Some(count) = options.counts.iter().find(|count| **count == 0 || **count > TARGETS_MAX) {
        return Err(Trouble::user(format!("there are no missions of {count} targets"))
            .help(format!("write numbers from 1 to {TARGETS_MAX}")));
    }
    let budgets = match options.budgets.as_slice() {
        [] => profile.budgets.clone(),
        wanted => wanted.iter().map(|text| units(text, "--budgets")).collect::<Outcome<Vec<u64>>>()?,
    };
    let names: Vec<String> = profile.planners.iter().map(|planner| planner.name.clone()).collect();
    let solvers = planners(&names, registry)?;
    for budget in budgets {
        for count in &options.counts {
            let outcomes = outcomes(options, *count, &solvers, (registry, budget))?;
            report(options, *count, budget, &names, &outcomes)?;
        }
    }
    Ok(())
}

/// Every space, scale and spread with this count, some missions each.
fn outcomes(
    options: &ProfileCompareOptions,
    count: usize,
    solvers: &[Arc<dyn Solver>],
    (registry, budget): (&Registry, u64),
) -> Outcome<Vec<Mission>> {
    let mut cells: Vec<Cell> = Cell::all().into_iter().map(|cell| Cell { count, ..cell }).collect();
    cells.sort();
    cells.dedup();
    let missions = usize::try_from(options.missions).unwrap_or(usize::MAX);
    let title = format!("{count} targets at {}", budget_words(budget));
    measuring::each(&options.work, &title, cells.len() * missions, |task| {
        let cell = cells.get(task / missions).ok_or("there is no such cell")?;
        regret::mission(cell, (task % missions) as u64, solvers, (registry, budget))
    })
}

fn report(
    options: &ProfileCompareOptions,
    count: usize,
    budget: u64,
    names: &[String],
    outcomes: &[Mission],
) -> Outcome {
    let percent = |mean_of: &dyn Fn(&Mission) -> f64| {
        100.0 * (libm::exp(outcomes.iter().map(mean_of).sum::<f64>() / outcomes.len().max(1) as f64) - 1.0)
    };
    let regret = percent(&|one| one.regret);
    let worst = outcomes.iter().map(|one| 100.0 * (libm::exp(one.regret) - 1.0)).fold(0.0, f64::max);
    let found = outcomes.iter().filter(|one| one.regret == 0.0).count();
    let always: Vec<(&String, f64)> = names
        .iter()
        .enumerate()
        .map(|(at, name)| (name, percent(&|one| one.excess.get(at).copied().unwrap_or(0.0))))
        .collect();
    let at = budget_words(budget);
    if options.json {
        let always: serde_json::Map<String, serde_json::Value> =
            always.into_iter().map(|(name, percent)| (name.clone(), serde_json::json!(percent))).collect();
        return output::print_line(serde_json::json!({
            "targets": count, "budget": at, "missions": outcomes.len(), "regret_percent": regret,
            "worst_percent": worst, "best_chosen": found, "always_percent": always,
        }));
    }
    let mut text = format!(
        "{count} targets at {at}, {} missions: regret {regret:.2} % (worst {worst:.1} %), the best was chosen in {found}\n",
        outcomes.len()
    );
    // Writing to a string cannot fail.
    let _ = write!(text, "  always the same one:");
    let _ = always.iter().try_for_each(|(name, percent)| write!(text, " {name} {percent:.2} %;"));
    output::print_line(text.trim_end_matches(';'))
}
