//! The final results of conditions as a table in CSV, one row per result.

use crate::error::{CliError, CliResult};
use apex_executive::{MonitorResult, ResultEvent};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// The columns, in order. Instants and durations are nanoseconds; `input` is empty where there is one input.
const COLUMNS: &str = "input,condition,start_ns,end_ns,duration_ns,recognised_at_ns,bindings,evidence\n";

/// A table that is being written.
pub struct ResultTable {
    path: PathBuf,
    out: BufWriter<File>,
}

impl ResultTable {
    /// Makes the file at `path`, which is none of the `inputs`.
    ///
    /// # Errors
    /// The file cannot be written, or is an input.
    pub fn create(path: &Path, inputs: &[PathBuf]) -> CliResult<ResultTable> {
        let real = |path: &Path| std::fs::canonicalize(path).ok();
        if real(path).is_some() && inputs.iter().any(|input| real(input) == real(path)) {
            return Err(CliError::user(format!("the table would be written over its source, {}", path.display()))
                .help("give `--results` another file"));
        }
        let file = File::create(path).map_err(|error| unwritten(path, &error))?;
        let mut table = ResultTable { path: path.to_path_buf(), out: BufWriter::new(file) };
        table.write(COLUMNS)?;
        Ok(table)
    }

    /// Adds a result, unless its interval may still grow.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, input: Option<&str>, result: &MonitorResult) -> CliResult {
        if result.telling == (ResultEvent::Recognised { open: true }) {
            return Ok(());
        }
        let satisfaction = &result.result;
        let (start, end) = satisfaction.interval;
        let bindings: Vec<String> =
            satisfaction.bindings.iter().map(|(name, value)| format!("?{name} = {value}")).collect();
        let evidence: Vec<String> = satisfaction.evidence.iter().map(|evidence| evidence.text()).collect();
        let row = format!(
            "{},{},{},{},{},{},{},{}\n",
            quoted(input.unwrap_or_default()),
            result.watch.0 + 1,
            start.0,
            end.0,
            (end - start).0,
            satisfaction.recognised_at.0,
            quoted(&bindings.join("; ")),
            quoted(&evidence.join("; "))
        );
        self.write(&row)
    }

    /// Writes the remaining rows.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(mut self) -> CliResult {
        self.out.flush().map_err(|error| unwritten(&self.path, &error))
    }

    fn write(&mut self, text: &str) -> CliResult {
        self.out.write_all(text.as_bytes()).map_err(|error| unwritten(&self.path, &error))
    }
}

/// A cell as CSV writes it: in quotes where it holds a comma, a quote or a line break (RFC 4180).
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_string() }
}

fn unwritten(path: &Path, error: &std::io::Error) -> CliError {
    CliError::failure(format!("cannot write {}", path.display()))
        .because(error)
        .help("the table is incomplete; look at the place and the space there")
}
