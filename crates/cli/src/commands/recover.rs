//! `apex recover`: saves the valid part of a damaged or interrupted record to a new one.

use crate::error::{CliError, CliResult};
use crate::options::RecoverOptions;
use crate::{output, recording};
use apex_runtime::record::recover;
use std::path::{Path, PathBuf};

/// Recovers a record.
pub fn run(options: &RecoverOptions) -> CliResult {
    if !options.record.is_file() {
        // The error names the kind of file at the path.
        recording::open(&options.record)?;
    }
    let out = options.out.clone().unwrap_or_else(|| beside(&options.record));
    if out.exists() {
        return Err(CliError::user(format!("{} already exists", out.display()))
            .help("name another file with `--out`; a recovery never overwrites one"));
    }
    let recovered = recover(&options.record, &out).map_err(apex_mission::recording::read)?;
    if let Some(damage) = &recovered.damage {
        output::print_error(format_args!("warning: {}: {damage}", options.record.display()));
    }
    output::print_line(format_args!(
        "{} steps up to {} are saved in {}",
        recovered.steps,
        recovered.until,
        out.display()
    ))
}

/// Returns the path of the recovered record: `flight.apex` -> `flight-recovered.apex`
fn beside(record: &Path) -> PathBuf {
    let stem = record.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    record.with_file_name(format!("{stem}-recovered.apex"))
}
