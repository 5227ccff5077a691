//! `apex profile merge`: merges separately measured parts into one profile.

use super::build::{refuse_other, write, write_table};
use super::read;
use crate::error::{CliError, CliResult};
use crate::options::ProfileMergeOptions;
use apex_portfolio::profile::Profile;
use apex_portfolio::profile::merge::merged;

/// Reads all parts, then writes the merged profile.
pub(super) fn run(options: &ProfileMergeOptions) -> CliResult {
    let before = refuse_other(&options.profile)?;
    let part = |path: &std::path::PathBuf| Ok((path.display().to_string(), read(Some(path))?));
    let parts: Vec<(String, Profile)> = options.parts.iter().map(part).collect::<CliResult<_>>()?;
    let whole = merged(&parts).map_err(|why| {
        CliError::user("these profiles are not parts of one profile")
            .because(why)
            .help("measure all parts by the same program with the same `--missions` and `--budgets`, and each planner in all cells")
    })?;
    write(&options.profile, before.as_deref(), &whole.to_string())?;
    write_table(options.table.as_deref(), &whole)
}
