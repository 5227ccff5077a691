//! Opens flight records and prints their warnings.

use crate::error::{CliError, CliResult};
use crate::output;
pub use apex_mission::recording::{create, of_mission};
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::time::Time;
use apex_runtime::RecordError;
use apex_runtime::ports::{News, Observer};
use apex_runtime::record::{Durability, RecordOptions, RecordReader, SigningKey};
use std::path::{Path, PathBuf};

/// Opens a record and prints a warning if it is incomplete.
///
/// # Errors
/// A missing file, another kind of file, a record of a newer Apex, or a damaged one.
pub fn open(path: &Path) -> CliResult<RecordReader> {
    let (reader, warning) = apex_mission::recording::open(path)?;
    if let Some(warning) = warning {
        output::print_error(format_args!("warning: {warning}"));
    }
    Ok(reader)
}

/// Returns the error for a record that cannot be written, with its exit code.
pub fn written(error: RecordError) -> CliError {
    apex_mission::recording::written(error).into()
}

/// Returns the options of a record as stated on the command line.
pub fn options(power_safe: bool, spare_folder: Option<&PathBuf>) -> RecordOptions {
    let durability = if power_safe { Durability::Power } else { Durability::Program };
    RecordOptions { durability, spare_folder: spare_folder.cloned(), ..RecordOptions::default() }
}

/// Returns the signing key in a file.
///
/// # Errors
/// The file cannot be read, or does not hold a key.
pub fn signing_key(path: &Path) -> CliResult<SigningKey> {
    SigningKey::read(path).map_err(|why| {
        CliError::user(format!("{} is not a signing key", path.display()))
            .because(why)
            .help("write one with `openssl rand -hex 32 > flight.key`")
    })
}

/// Informs the operator at once when a flight is no longer recorded, and when it is recorded again.
pub struct RecordingWatch;

impl Observer for RecordingWatch {
    fn observe(&mut self, _: &Batch, _: &[Effect]) -> Result<(), String> {
        Ok(())
    }

    fn hear_news(&mut self, at: Time, news: &News) -> Result<(), String> {
        output::print_error(format_args!("warning: at {at} {}", news.note));
        Ok(())
    }
}
