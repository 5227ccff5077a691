//! Files that commands write tables into.

use crate::error::{CliError, CliResult};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Refuses to write a table over one of the files that it is made from; `option` named `out`.
///
/// # Errors
/// `out` is one of `inputs`.
pub fn refuse_to_overwrite(out: &Path, inputs: &[PathBuf], option: &str) -> CliResult {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    if real(out).is_some() && inputs.iter().any(|input| real(input) == real(out)) {
        return Err(CliError::user(format!("the table would be written over its source, {}", out.display()))
            .help(format!("give `{option}` another file")));
    }
    Ok(())
}

/// Makes the file.
///
/// # Errors
/// The file cannot be made.
pub fn created(path: &Path) -> CliResult<BufWriter<File>> {
    let file = File::create(path).map_err(|error| unwritten(Some(path), &error))?;
    Ok(BufWriter::new(file))
}

/// Returns the error of a table that could not be written; without a path it is on standard output.
pub fn unwritten(path: Option<&Path>, error: &std::io::Error) -> CliError {
    apex_log_monitor::unwritten_table(path, error).into()
}
