//! Histories as tables: every sample and message with its status, as CSV or Parquet.

mod columns;
mod csv_writer;
mod parquet_writer;
mod plot;
mod result_writer;
mod sample_table;

pub use columns::{Cells, write_columns};
pub use csv_writer::CsvWriter;
pub use parquet_writer::ParquetWriter;
pub use plot::plot;
pub use result_writer::ResultWriter;
pub use sample_table::SampleTable;

use apex_executive::state::recorded::Recorded;
use apex_model::event::StateVariable;
use apex_model::quantity::unit_named;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use std::io;

/// The columns, in order.
pub const COLUMNS: [&str; 9] = ["number", "t_ns", "arrived_ns", "kind", "name", "value", "unit", "text", "status"];

/// One sample or message.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Order of arrival, from 1.
    pub number: i64,
    /// Instant of the measurement or event, ns of mission time.
    pub t_ns: i64,
    /// Arrival, ns of mission time.
    pub arrived_ns: i64,
    /// `sample` or `event`.
    pub kind: &'static str,
    /// The state variable, or the message's form.
    pub name: String,
    /// The sample's number, in `unit`.
    pub value: Option<f64>,
    /// The unit of `value`.
    pub unit: Option<&'static str>,
    /// The sample's value if it is not a number.
    pub text: Option<String>,
    /// Status: `kept`, `inserted` (late, sorted in), `replaced` (replaced another value of its instant), `repeated`, `late` (too late,
    /// kept separately), `missing` (not a number) or `refused`.
    pub status: &'static str,
}

impl Row {
    /// Returns the row of a sample. `unit` is the declared unit of its variable; `recorded` is `None` if the sample was rejected.
    pub fn sample(
        (number, at, arrived): (i64, Time, Time),
        variable: &StateVariable,
        value: &Value,
        unit: Option<&Symbol>,
        recorded: Option<Recorded>,
    ) -> Row {
        let declared = unit.and_then(|unit| unit_named(unit.printed()));
        let (value, unit, text) = match (value, value.as_number()) {
            (Value::Quantity(quantity), _) => {
                let own = declared.filter(|unit| unit.dimension == quantity.dimension).or(quantity.unit());
                match own {
                    Some(unit) => (Some(quantity.in_unit(unit)), Some(unit.name), None),
                    None => (Some(quantity.si), None, Some(value.to_string())),
                }
            }
            (_, Some((number, _))) => match (value, declared) {
                (Value::Duration(span), _) => (Some(span.seconds()), Some("s"), None),
                (_, unit) => (Some(number), unit.map(|unit| unit.name), None),
            },
            (_, None) => (None, None, Some(value.to_string())),
        };
        Row {
            number,
            t_ns: at.0,
            arrived_ns: arrived.0,
            kind: "sample",
            name: variable.to_string(),
            value,
            unit,
            text,
            status: status(recorded),
        }
    }

    /// Returns the row of a message.
    pub fn event((number, at, arrived): (i64, Time, Time), form: &Value) -> Row {
        Row {
            number,
            t_ns: at.0,
            arrived_ns: arrived.0,
            kind: "event",
            name: form.to_string(),
            value: None,
            unit: None,
            text: None,
            status: "kept",
        }
    }
}

fn status(recorded: Option<Recorded>) -> &'static str {
    match recorded {
        Some(Recorded::Appended) => "kept",
        Some(Recorded::Inserted) => "inserted",
        Some(Recorded::Replaced) => "replaced",
        Some(Recorded::Repeated) => "repeated",
        Some(Recorded::TooLate) => "late",
        Some(Recorded::Missing) => "missing",
        None => "refused",
    }
}

/// Writes rows of one table.
pub trait TableWriter {
    /// Adds a row.
    ///
    /// # Errors
    /// The table cannot be written.
    fn write(&mut self, row: Row) -> io::Result<()>;

    /// Writes the remaining rows. A table that was not finished is incomplete.
    ///
    /// # Errors
    /// The table cannot be written.
    fn finish(self: Box<Self>) -> io::Result<()>;
}

#[cfg(test)]
mod tests;
