//! `apex profile show`: prints a profile as text, JSON lines, or a heat map.

use super::{budgets, read};
use crate::error::{CliError, CliResult};
use crate::options::ProfileShowOptions;
use crate::output;
use apex_portfolio::profile::{named, picture, text};

/// Prints the requested budgets of a profile, or draws them as heat maps.
pub(super) fn run(options: &ProfileShowOptions) -> CliResult {
    let profile = read(options.profile.as_deref())?;
    let wanted: Vec<&str> = options.budget.iter().map(String::as_str).collect();
    let budgets = budgets(&profile, &wanted, "--budget")?;
    if let Some(path) = &options.svg {
        let maps = if options.figure_4 {
            picture::beside_figure_4(&profile, budgets.last().copied().unwrap_or(0))?.into()
        } else {
            budgets.iter().map(|budget| picture::best(&profile, *budget)).collect::<Vec<_>>()
        };
        return std::fs::write(path, picture::svg(&maps)).map_err(|error| {
            CliError::failure(format!("cannot write {}", path.display()))
                .because(error)
                .help("choose another path for it")
        });
    }
    if options.json {
        return output::print(text::json_lines(&profile, &budgets));
    }
    let row = options.cell.as_ref().map(|cell| named::row(&profile, cell)).transpose()?;
    output::print(text::shown(&profile, &budgets, row))
}
