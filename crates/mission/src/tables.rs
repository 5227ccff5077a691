//! CSV files with a header; every error names file, line and column.

use crate::error::{MissionError, MissionResult};
use crate::sources::DataFile;

/// A table whose columns are named by its first line.
#[derive(Debug)]
pub(crate) struct DataTable {
    file: String,
    header: Vec<String>,
    rows: Vec<(u64, Vec<String>)>,
}

/// One row of a table.
#[derive(Clone, Copy)]
pub(crate) struct TableRow<'a> {
    table: &'a DataTable,
    line: u64,
    cells: &'a [String],
}

/// Reads a table that has all of `columns`, perhaps some of `optional`, and no others. Lines that begin with `#` are
/// comments.
///
/// # Errors
/// Unreadable file, rows of unequal length, missing or unknown columns, no rows.
pub(crate) fn read(file: &DataFile, columns: &[&str], optional: &[&str]) -> MissionResult<DataTable> {
    let place = &file.place;
    let (header, rows) = rows(file)?;
    let missing: Vec<&str> =
        columns.iter().copied().filter(|column| !header.iter().any(|name| name == column)).collect();
    if !missing.is_empty() {
        return Err(MissionError::data(format!("missing columns: {}", missing.join(", ")))
            .at(place)
            .because(format!("the first line names {}", header.join(", ")))
            .help("add the columns; docs/reference/mission-data.md lists all of them"));
    }
    let known = |name: &&String| !columns.contains(&name.as_str()) && !optional.contains(&name.as_str());
    if let Some(unknown) = header.iter().find(known) {
        return Err(MissionError::data(format!("unknown column `{unknown}`"))
            .at(place)
            .help(format!("known are {}", [columns, optional].concat().join(", "))));
    }
    if rows.is_empty() {
        return Err(MissionError::data(format!("{place} has a header but no rows")));
    }
    Ok(DataTable { file: place.clone(), header, rows })
}

/// Returns a permitted range as text; a range from the smallest number on is one above 0.
pub(crate) fn range(low: f64, high: f64) -> String {
    if low == f64::MIN_POSITIVE { format!("above 0 and at most {high}") } else { format!("between {low} and {high}") }
}

/// A header in lower case, and line number and cells of each row.
pub(crate) type Rows = (Vec<String>, Vec<(u64, Vec<String>)>);

/// Reads the header and the rows of a table. Lines that begin with `#` are comments.
///
/// # Errors
/// Text that is not a table, rows of unequal length.
pub(crate) fn rows(file: &DataFile) -> MissionResult<Rows> {
    let place = &file.place;
    let broken = |error: csv::Error| {
        let help =
            "separate cells with commas, write decimals with a point, and put texts that contain commas in quotes";
        match error.kind() {
            csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
                let line = pos.as_ref().map_or(0, csv::Position::line);
                MissionError::data(format!(
                    "{place}:{line} has {len} cells, the first line of the table {expected_len}"
                ))
                .help(help)
            }
            _ => MissionError::data(format!("{place} is not a table")).because(error).help(help),
        }
    };
    let mut reader =
        csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(file.bytes.as_slice());
    let header: Vec<String> = reader.headers().map_err(broken)?.iter().map(str::to_lowercase).collect();
    for (number, name) in header.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
        if let Some(first) = header.iter().take(number).position(|other| other == name) {
            return Err(MissionError::data(format!("the column `{name}` is named twice"))
                .at(place)
                .because(format!("the columns {} and {} have this name", first + 1, number + 1))
                .help("give each column a name of its kind, or remove one of them"));
        }
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(broken)?;
        let line = record.position().map_or(0, csv::Position::line);
        rows.push((line, record.iter().map(str::to_string).collect()));
    }
    Ok((header, rows))
}

impl DataTable {
    /// Returns the rows in order.
    pub(crate) fn rows(&self) -> impl Iterator<Item = TableRow<'_>> {
        self.rows.iter().map(|(line, cells)| TableRow { table: self, line: *line, cells })
    }
}

impl TableRow<'_> {
    /// Returns an error in this row.
    pub(crate) fn trouble(&self, what: impl std::fmt::Display) -> MissionError {
        MissionError::data(what.to_string()).at(format!("{}:{}", self.table.file, self.line))
    }

    /// Returns the cell, if the column exists and the cell is not empty.
    pub(crate) fn text(&self, column: &str) -> Option<&str> {
        let index = self.table.header.iter().position(|name| name == column)?;
        self.cells.get(index).map(String::as_str).filter(|text| !text.is_empty())
    }

    /// Returns the cell as a number within `[low, high]`; `None` if it is empty.
    pub(crate) fn number(&self, column: &str, low: f64, high: f64) -> MissionResult<Option<f64>> {
        let Some(text) = self.text(column) else { return Ok(None) };
        match text.parse::<f64>() {
            Ok(number) if (low..=high).contains(&number) => Ok(Some(number)),
            Ok(number) => Err(self.trouble(format!("`{column}` is {number}, which is not {}", range(low, high)))),
            Err(_) => Err(self.trouble(format!("`{column}` is `{text}`, not a number"))),
        }
    }

    /// Returns the cell as a number that must be there.
    pub(crate) fn required(&self, column: &str, low: f64, high: f64) -> MissionResult<f64> {
        self.number(column, low, high)?.ok_or_else(|| self.trouble(format!("`{column}` is empty")))
    }
}
