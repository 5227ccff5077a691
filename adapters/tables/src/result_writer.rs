//! The final results of conditions as CSV, one row per result.

use apex_executive::{MonitorResult, ResultEvent};
use std::io::{self, Write};

/// The columns, in order. Instants and durations are nanoseconds; `input` is empty where there is one input.
const COLUMNS: [&str; 8] =
    ["input", "condition", "start_ns", "end_ns", "duration_ns", "recognised_at_ns", "bindings", "evidence"];

/// Writes results as CSV (RFC 4180).
pub struct ResultWriter<W: Write> {
    writer: csv::Writer<W>,
}

impl<W: Write> ResultWriter<W> {
    /// A table on `output`, begun with the names of its columns.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn new(output: W) -> io::Result<ResultWriter<W>> {
        let mut writer = csv::Writer::from_writer(output);
        writer.write_record(COLUMNS)?;
        Ok(ResultWriter { writer })
    }

    /// Adds a result, unless its interval may still grow. `input` names what was watched, where there are several.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn write(&mut self, input: Option<&str>, result: &MonitorResult) -> io::Result<()> {
        if result.telling == (ResultEvent::Recognised { open: true }) {
            return Ok(());
        }
        let satisfaction = &result.result;
        let (start, end) = satisfaction.interval;
        let bindings: Vec<String> =
            satisfaction.bindings.iter().map(|(name, value)| format!("?{name} = {value}")).collect();
        let evidence: Vec<String> = satisfaction.evidence.iter().map(|evidence| evidence.text()).collect();
        let times = [start.0, end.0, (end - start).0, satisfaction.recognised_at.0].map(|time| time.to_string());
        let condition = (result.watch.0 + 1).to_string();
        let fields = [input.unwrap_or_default(), &condition].into_iter().chain(times.iter().map(String::as_str));
        Ok(self.writer.write_record(fields.chain([bindings.join("; ").as_str(), evidence.join("; ").as_str()]))?)
    }

    /// Writes the remaining rows.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.writer.flush()
    }
}
