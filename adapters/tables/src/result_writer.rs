//! The final results of conditions as a table, CSV or Parquet, one row per result.

use crate::parquet_writer::{column, failed, field};
use apex_executive::{MonitorResult, ResultEvent};
use parquet::basic::Type as Physical;
use parquet::data_type::{ByteArray, ByteArrayType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io::{self, Write};
use std::sync::Arc;

/// The columns, in order. Instants and durations are in nanoseconds; `input` is empty if there is only one input.
const COLUMNS: [&str; 8] =
    ["input", "condition", "start_ns", "end_ns", "duration_ns", "recognised_at_ns", "bindings", "evidence"];
/// Rows in one group, which is held in memory.
const GROUP_ROWS: usize = 1 << 16;

/// Writes results as CSV (RFC 4180) or Parquet.
pub struct ResultWriter<W: Write + Send> {
    output: Output<W>,
}

enum Output<W: Write + Send> {
    Csv(csv::Writer<W>),
    Parquet(SerializedFileWriter<W>, Vec<ResultRow>),
}

struct ResultRow {
    input: String,
    /// Condition (counted from 1), then in nanoseconds: start, end, duration and instant of recognition.
    numbers: [i64; 5],
    bindings: String,
    evidence: String,
}

impl<W: Write + Send> ResultWriter<W> {
    /// Returns a CSV table on `output`, begun with the names of its columns.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn csv(output: W) -> io::Result<ResultWriter<W>> {
        let mut writer = csv::Writer::from_writer(output);
        writer.write_record(COLUMNS)?;
        Ok(ResultWriter { output: Output::Csv(writer) })
    }

    /// Returns a Parquet table on `output`.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn parquet(output: W) -> io::Result<ResultWriter<W>> {
        let properties =
            WriterProperties::builder().set_created_by(format!("apex {}", env!("CARGO_PKG_VERSION"))).build();
        let fields = COLUMNS.iter().map(|name| {
            let is_text = ["input", "bindings", "evidence"].contains(name);
            field(name, if is_text { Physical::BYTE_ARRAY } else { Physical::INT64 }, true)
        });
        let schema = fields.collect::<Result<Vec<_>, _>>();
        let schema = schema
            .and_then(|fields| Type::group_type_builder("results").with_fields(fields).build())
            .map_err(failed)?;
        let writer = SerializedFileWriter::new(output, Arc::new(schema), Arc::new(properties)).map_err(failed)?;
        Ok(ResultWriter { output: Output::Parquet(writer, Vec::new()) })
    }

    /// Adds a result, unless its interval may still grow. `input` names the watched input if there are several.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn write(&mut self, input: Option<&str>, result: &MonitorResult) -> io::Result<()> {
        if result.telling == (ResultEvent::Recognised { open: true }) {
            return Ok(());
        }
        let row = row(input, result);
        match &mut self.output {
            Output::Csv(writer) => {
                let numbers = row.numbers.map(|number| number.to_string());
                let fields = [row.input.as_str()].into_iter().chain(numbers.iter().map(String::as_str));
                Ok(writer.write_record(fields.chain([row.bindings.as_str(), row.evidence.as_str()]))?)
            }
            Output::Parquet(writer, rows) => {
                rows.push(row);
                if rows.len() >= GROUP_ROWS { write_group(writer, rows).map_err(failed) } else { Ok(()) }
            }
        }
    }

    /// Writes the remaining rows.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn finish(self) -> io::Result<()> {
        match self.output {
            Output::Csv(mut writer) => writer.flush(),
            Output::Parquet(mut writer, mut rows) => {
                if !rows.is_empty() {
                    write_group(&mut writer, &mut rows).map_err(failed)?;
                }
                writer.finish().map(|_| ()).map_err(failed)
            }
        }
    }
}

fn row(input: Option<&str>, result: &MonitorResult) -> ResultRow {
    let satisfaction = &result.result;
    let (start, end) = satisfaction.interval;
    let bindings: Vec<String> =
        satisfaction.bindings.iter().map(|(name, value)| format!("?{name} = {value}")).collect();
    let evidence: Vec<String> = satisfaction.evidence.iter().map(|evidence| evidence.text()).collect();
    let condition = i64::try_from(result.watch.0 + 1).unwrap_or(i64::MAX);
    ResultRow {
        input: input.unwrap_or_default().to_string(),
        numbers: [condition, start.0, end.0, (end - start).0, satisfaction.recognised_at.0],
        bindings: bindings.join("; "),
        evidence: evidence.join("; "),
    }
}

fn write_group<W: Write + Send>(
    writer: &mut SerializedFileWriter<W>,
    rows: &mut Vec<ResultRow>,
) -> Result<(), ParquetError> {
    let rows = std::mem::take(rows);
    let mut group = writer.next_row_group()?;
    let text = |text: &String| Some(ByteArray::from(text.as_bytes().to_vec()));
    column::<ByteArrayType, _>(&mut group, rows.iter().map(|row| text(&row.input)), true)?;
    for number in 0..5 {
        column::<Int64Type, _>(&mut group, rows.iter().map(|row| row.numbers.get(number).copied()), true)?;
    }
    column::<ByteArrayType, _>(&mut group, rows.iter().map(|row| text(&row.bindings)), true)?;
    column::<ByteArrayType, _>(&mut group, rows.iter().map(|row| text(&row.evidence)), true)?;
    group.close().map(|_| ())
}
