//! Files into which commands write tables.

use crate::error::{CliError, CliResult};
use crate::output;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Rejects an output file, named by `option`, that is one of the input files.
///
/// # Errors
/// `out` is one of `inputs`.
pub fn refuse_to_overwrite(out: &Path, inputs: &[PathBuf], option: &str) -> CliResult {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    if real(out).is_some() && inputs.iter().any(|input| real(input) == real(out)) {
        return Err(CliError::user(format!("the table would overwrite its source, {}", out.display()))
            .help(format!("give `{option}` another file")));
    }
    Ok(())
}

/// Creates the file.
///
/// # Errors
/// The file cannot be created, or is a flight record.
pub fn created(path: &Path) -> CliResult<BufWriter<File>> {
    output::refuse_record(path)?;
    let file = File::create(path).map_err(|error| unwritten(Some(path), &error))?;
    Ok(BufWriter::new(file))
}

/// Returns the error for a table that could not be written to `path`, or to standard output without a path.
pub fn unwritten(path: Option<&Path>, error: &std::io::Error) -> CliError {
    apex_log_monitor::unwritten_table(path, error).into()
}
