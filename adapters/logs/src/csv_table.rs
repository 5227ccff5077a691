//! Tables, `.csv`: a row of column names, then rows of values; one column is the time.

use crate::{Cell, FIELDS_MAX, LogReader, Message, ReadErrors, Topic};
use apex_model::time::Time;
use csv::{ByteRecord, Reader, ReaderBuilder};
use std::io::{self, Read};

/// Names of columns that are a time, with the nanoseconds of their unit.
const TIMES: &[(&str, f64)] = &[
    ("t", 1e9),
    ("time", 1e9),
    ("timestamp", 1e9),
    ("t_s", 1e9),
    ("time_s", 1e9),
    ("timestamp_s", 1e9),
    ("t_ms", 1e6),
    ("time_ms", 1e6),
    ("timestamp_ms", 1e6),
    ("t_us", 1e3),
    ("time_us", 1e3),
    ("timestamp_us", 1e3),
    ("t_ns", 1.0),
    ("time_ns", 1.0),
    ("timestamp_ns", 1.0),
];

/// Reads a table.
pub(crate) struct CsvTable<R> {
    reader: Reader<R>,
    record: ByteRecord,
    topics: Vec<Topic>,
    /// The column of the time and the nanoseconds of its unit.
    time: Option<(String, f64)>,
    column: Option<(usize, f64)>,
    damages: ReadErrors,
    begun: bool,
}

impl<R: Read> CsvTable<R> {
    /// `time` names the column of the time and the nanoseconds of its unit; without it a column is found by its name.
    pub(crate) fn new(input: R, time: Option<(String, f64)>) -> CsvTable<R> {
        CsvTable {
            reader: ReaderBuilder::new().has_headers(false).flexible(true).comment(Some(b'#')).from_reader(input),
            record: ByteRecord::new(),
            topics: Vec::new(),
            time,
            column: None,
            damages: ReadErrors::default(),
            begun: false,
        }
    }

    fn header(&mut self) -> io::Result<bool> {
        self.begun = true;
        if !self.reader.read_byte_record(&mut self.record)? {
            self.damages.add(|| "line 1: the table is empty".to_string());
            return Ok(false);
        }
        let name = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().trim_start_matches('\u{feff}').to_string();
        let fields: Vec<String> = self.record.iter().take(FIELDS_MAX).map(name).collect();
        let position = |wanted: &str| fields.iter().position(|field| field.eq_ignore_ascii_case(wanted));
        self.column = match &self.time {
            Some((wanted, unit)) => position(wanted).map(|column| (column, *unit)),
            None => TIMES.iter().find_map(|(wanted, unit)| position(wanted).map(|column| (column, *unit))),
        };
        if self.column.is_none() {
            let wanted = self.time.as_ref().map_or("t, time, timestamp, time_ms or the like", |(name, _)| name);
            let found = fields.join(", ");
            let shown: String = found.chars().take(200).collect();
            self.damages.add(|| format!("line 1: no column is called {wanted}; there are {shown}"));
            return Ok(false);
        }
        self.topics.push(Topic { name: "csv".to_string(), fields, ..Topic::default() });
        Ok(true)
    }
}

impl<R: Read> LogReader for CsvTable<R> {
    fn next(&mut self, message: &mut Message) -> io::Result<bool> {
        if !self.begun && !self.header()? {
            return Ok(false);
        }
        let Some((column, unit)) = self.column else { return Ok(false) };
        while self.reader.read_byte_record(&mut self.record)? {
            let line = self.record.position().map_or(0, csv::Position::line);
            message.topic = 0;
            message.values.clear();
            message.values.extend(self.record.iter().map(cell));
            match message.values.get(column) {
                Some(Cell::Number(number)) if number.is_finite() => {
                    message.at = Time((number * unit).round() as i64);
                    return Ok(true);
                }
                _ => self.damages.add(|| format!("line {line}: the row has no time")),
            }
        }
        Ok(false)
    }

    fn topics(&self) -> &[Topic] {
        &self.topics
    }

    fn damages(&self) -> &ReadErrors {
        &self.damages
    }
}

fn cell(bytes: &[u8]) -> Cell {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim();
    match text.parse::<f64>() {
        Ok(number) => Cell::Number(number),
        Err(_) if text.is_empty() => Cell::Nothing,
        Err(_) => Cell::Text(text.to_string()),
    }
}
