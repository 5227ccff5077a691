//! Errors of the command line: one type, two exit codes, human-readable messages.

use apex_mission::error::{ErrorKind, MissionError};
use apex_mission::files;
use std::fmt;
use std::path::Path;
use std::process::ExitCode;

/// Maximum number of characters of a line of an error.
const LINE_CHARS_MAX: usize = 2_000;

/// A failure of a command, ready to be printed.
#[derive(Debug)]
pub struct CliError {
    /// True: the user's input is wrong (exit code 2); false: an operation failed (exit code 1).
    pub of_user: bool,
    /// Failure with its place, one line; empty if diagnostics were printed already.
    pub message: String,
    /// Reason, if known.
    pub reason: Option<String>,
    /// Remedy.
    pub help: Option<String>,
}

impl CliError {
    /// Returns an error caused by the user's input.
    pub fn user(message: impl Into<String>) -> CliError {
        CliError { of_user: true, message: message.into(), reason: None, help: None }
    }

    /// Returns an error with another cause than the input: a disk, a port, a record that no longer matches.
    pub fn failure(message: impl Into<String>) -> CliError {
        CliError { of_user: false, message: message.into(), reason: None, help: None }
    }

    /// Returns an error whose diagnostics were printed already: only its exit code counts.
    pub fn already_reported() -> CliError {
        CliError::user("")
    }

    /// Adds the reason.
    pub fn because(mut self, reason: impl fmt::Display) -> CliError {
        self.reason = Some(reason.to_string());
        self
    }

    /// Adds the remedy.
    pub fn help(mut self, help: impl Into<String>) -> CliError {
        self.help = Some(help.into());
        self
    }

    /// Returns exit code 2 for errors of the user's input, 1 for other failures.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(if self.of_user { 2 } else { 1 })
    }
}

impl fmt::Display for CliError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_part(f, "error: ", &self.message)?;
        for (label, part) in [("\n  why: ", &self.reason), ("\n  help: ", &self.help)] {
            if let Some(part) = part {
                write_part(f, label, part)?;
            }
        }
        Ok(())
    }
}

/// Writes a part of a message. Long lines are cut: a message may quote a line of a file of any kind.
fn write_part(f: &mut fmt::Formatter<'_>, label: &str, text: &str) -> fmt::Result {
    f.write_str(label)?;
    for (index, line) in text.split('\n').enumerate() {
        if index > 0 {
            f.write_str("\n")?;
        }
        match line.char_indices().nth(LINE_CHARS_MAX).and_then(|(end, _)| line.get(..end)) {
            Some(part) => write!(f, "{part} ..")?,
            None => f.write_str(line)?,
        }
    }
    Ok(())
}

/// Result of a command.
pub type CliResult<T = ()> = Result<T, CliError>;

impl From<MissionError> for CliError {
    fn from(error: MissionError) -> CliError {
        let of_user =
            !matches!(error.kind, ErrorKind::Flight | ErrorKind::Record | ErrorKind::Output | ErrorKind::Input);
        CliError { of_user, message: error.headline(), reason: error.reason, help: error.help }
    }
}

/// Reads a text file.
///
/// # Errors
/// An error with the file, the reason and the remedy.
pub fn read_text(path: &Path) -> CliResult<String> {
    Ok(files::read_text(path)?)
}
