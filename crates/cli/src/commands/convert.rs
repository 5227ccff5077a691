//! `apex convert`: writes a record of the previous format version in the present one.

use crate::error::{CliError, CliResult};
use crate::options::ConvertOptions;
use crate::output;
use apex_runtime::record::convert;

/// Converts a record.
pub fn run(options: &ConvertOptions) -> CliResult {
    let ConvertOptions { record, out } = options;
    if out.exists() {
        return Err(CliError::user(format!("{} already exists", out.display()))
            .help("name another file: a conversion never overwrites a file"));
    }
    let steps = convert(record, out).map_err(apex_mission::recording::read)?;
    output::print_line(format_args!("{steps} steps of {} are written to {}", record.display(), out.display()))
}
