//! Opening flight records, with their warnings on the terminal.

use crate::error::{CliError, CliResult};
use crate::output;
pub use apex_mission::recording::{create, of_mission};
use apex_runtime::RecordError;
use apex_runtime::record::RecordReader;
use std::path::Path;

/// Opens a record and prints a warning if it is incomplete.
///
/// # Errors
/// A missing file, another kind of file, a record of a newer Apex, a damaged one.
pub fn open(path: &Path) -> CliResult<RecordReader> {
    let (reader, warning) = apex_mission::recording::open(path)?;
    if let Some(warning) = warning {
        output::print_error(format_args!("warning: {warning}"));
    }
    Ok(reader)
}

/// A record that cannot be written, with the exit code that it deserves.
pub fn written(error: RecordError) -> CliError {
    apex_mission::recording::written(error).into()
}
