//! Standard output and standard error. A reader that closes the output (`apex trace F | head -1`) is not a failure; a full disk is one,
//! and never a panic.

use crate::error::{CliError, CliResult};
use apex_runtime::escaping::Escaped;
use std::cell::Cell;
use std::fmt;
use std::io::{self, BufWriter, ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;
use std::rc::Rc;

/// Prints to standard output.
///
/// # Errors
/// The output cannot be written. A reader that went away is not an error.
pub fn print(text: impl fmt::Display) -> CliResult {
    let mut out = standard();
    match write!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(unwritable(error)),
        Ok(()) | Err(_) => Ok(()),
    }
}

/// Prints one line to standard output.
///
/// # Errors
/// Like [`print`].
pub fn print_line(text: impl fmt::Display) -> CliResult {
    print(format_args!("{text}\n"))
}

/// Rejects an output file that is a flight record: a record is never replaced by a text or a table.
///
/// # Errors
/// `path` is a flight record.
pub fn refuse_record(path: &Path) -> CliResult {
    if apex_runtime::record::is_record(path) {
        return Err(CliError::user(format!("{} is a flight record, which would be overwritten", path.display()))
            .help("name another file, or remove the record first"));
    }
    Ok(())
}

/// Writes `text` to the file `out`, or to standard output where there is none.
///
/// # Errors
/// The file cannot be written; or as [`print`].
pub fn put(out: Option<&Path>, text: &str) -> CliResult {
    let Some(path) = out else { return print(text) };
    if path.is_dir() {
        return Err(CliError::user(format!("{} is a folder", path.display())).help("name a file in it"));
    }
    refuse_record(path)?;
    std::fs::write(path, text).map_err(|error| {
        let help = match error.kind() {
            ErrorKind::NotFound => "the folder does not exist; make it, or name another file",
            ErrorKind::PermissionDenied => "name a file that you may write",
            _ => "the file is incomplete; check the free space there",
        };
        CliError::failure(format!("cannot write {}", path.display())).because(error).help(help)
    })
}

/// Prints text with colours, such as diagnostics; the renderer has escaped text from outside.
///
/// # Errors
/// Like [`print`].
pub fn print_rendered(text: impl fmt::Display) -> CliResult {
    let mut out = io::stdout().lock();
    match write!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(unwritable(error)),
        Ok(()) | Err(_) => Ok(()),
    }
}

/// Prints an answer of `clap`: a help text, the version, or an error in the arguments. Returns its exit code, 1 if a text that the user
/// asked for cannot be written.
pub fn print_answer(answer: &clap::Error) -> ExitCode {
    let printed = answer.print().and_then(|()| io::stdout().flush());
    match printed {
        Err(error) if !answer.use_stderr() && error.kind() != ErrorKind::BrokenPipe => {
            let error = unwritable(error);
            print_error(&error);
            error.exit_code()
        }
        Ok(()) | Err(_) => ExitCode::from(if answer.use_stderr() { 2 } else { 0 }),
    }
}

/// Prints one line to standard error. A failure to write it is ignored: the exit code still reports the error. Control
/// characters of names and messages are escaped: they must not move a terminal's cursor or change its title.
pub fn print_error(text: impl fmt::Display) {
    // The error cannot be reported, and the exit code still states the result.
    let _ = writeln!(Escaped::new(io::stderr().lock()), "{text}");
}

/// Like [`print_error`], for text with colour codes of this command, which are not escaped.
pub fn print_error_rendered(text: impl fmt::Display) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Returns the standard output; on a terminal, control characters are escaped.
fn standard() -> Box<dyn Write> {
    let out = io::stdout();
    if out.is_terminal() { Box::new(Escaped::new(out)) } else { Box::new(out) }
}

/// Returns the error for a failed write to standard output.
fn unwritable(error: io::Error) -> CliError {
    CliError::failure("cannot write to standard output")
        .because(error)
        .help("the output is incomplete; check its destination and the free space there")
}

/// A buffered output that records whether its reader has closed it.
pub struct Listened {
    out: BufWriter<Box<dyn Write>>,
    gone: Rc<Cell<bool>>,
}

impl Listened {
    /// Returns the standard output.
    pub fn standard() -> Listened {
        Listened::new(standard())
    }

    /// Returns a writer for the output `out`.
    pub fn new(out: Box<dyn Write>) -> Listened {
        Listened { out: BufWriter::new(out), gone: Rc::new(Cell::new(false)) }
    }

    /// Returns a flag that becomes true when the reader closes the output.
    pub fn gone(&self) -> Rc<Cell<bool>> {
        Rc::clone(&self.gone)
    }

    fn watch<T>(&self, done: io::Result<T>) -> io::Result<T> {
        if done.as_ref().is_err_and(|error| error.kind() == ErrorKind::BrokenPipe) {
            self.gone.set(true);
        }
        done
    }
}

impl Write for Listened {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let done = self.out.write(bytes);
        self.watch(done)
    }

    fn flush(&mut self) -> io::Result<()> {
        let done = self.out.flush();
        self.watch(done)
    }
}
