//! `apex profile compare`: compares two profiles, or one and the paper's Figure 4.

use super::{budgets, read};
use crate::error::CliResult;
use crate::options::ProfileCompareOptions;
use crate::output;
use apex_portfolio::profile::compare::compared;
use apex_portfolio::profile::published::Agreement;

/// Prints the agreement about the best planner in each cell, for each requested budget.
pub(super) fn run(options: &ProfileCompareOptions) -> CliResult {
    let profile = read(options.profile.as_deref())?;
    let wanted: Vec<&str> = options.budgets.iter().map(String::as_str).collect();
    let budgets = budgets(&profile, &wanted, "--budgets")?;
    if let Some(other) = &options.with {
        let each = compared(&profile, &read(Some(other))?, &budgets)?;
        return each.iter().try_for_each(|one| match options.json {
            true => output::print_line(one.json()),
            false => output::print(one.text()),
        });
    }
    budgets.iter().try_for_each(|budget| {
        let agreement = Agreement::of(&profile, *budget)?;
        match options.json {
            true => output::print_line(agreement.json()),
            false => output::print(agreement.text()),
        }
    })
}
