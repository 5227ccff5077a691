//! Tables as CSV: a row of names, then the rows; absent values are empty.

use crate::{COLUMNS, Row, TableWriter};
use std::io::{self, Write};

/// Writes CSV.
pub struct CsvWriter<W: Write> {
    writer: csv::Writer<W>,
}

impl<W: Write> CsvWriter<W> {
    /// Returns a table on `output`, begun with the names of its columns.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn new(output: W) -> io::Result<CsvWriter<W>> {
        let mut writer = csv::Writer::from_writer(output);
        writer.write_record(COLUMNS)?;
        Ok(CsvWriter { writer })
    }
}

impl<W: Write> TableWriter for CsvWriter<W> {
    fn write(&mut self, row: Row) -> io::Result<()> {
        let value = row.value.map(|value| value.to_string()).unwrap_or_default();
        let record = [
            &row.number.to_string(),
            &row.t_ns.to_string(),
            &row.arrived_ns.to_string(),
            row.kind,
            &row.name,
            &value,
            row.unit.unwrap_or_default(),
            row.text.as_deref().unwrap_or_default(),
            row.status,
        ];
        Ok(self.writer.write_record(record)?)
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.writer.flush()
    }
}
