//! Tables, `.csv`: a row of column names, then rows of values; one column is the time. Columns are separated by commas,
//! semicolons or tabs; with the latter two a comma in a number is the decimal point.

use crate::bytes::Bytes;
use crate::time_column::TimeColumn;
use crate::{Cell, FIELDS_MAX, LogReader, Message, ReadErrors, Topic};
use apex_model::time::Time;
use csv::{ByteRecord, Reader, ReaderBuilder};
use std::collections::BTreeSet;
use std::io::{self, Read};

/// Bytes in which the row of names is looked for.
const HEADER_BYTES_MAX: usize = 1 << 16;
/// A line that some spreadsheets write before the names: `sep=;`.
const SEPARATOR_LINE: &[u8] = b"sep=";

/// Column of the time as named by a mapping, with the nanoseconds of its unit if the mapping states a unit.
pub type TimeName = (String, Option<i64>);

/// Reads a table.
pub(crate) struct CsvTable<R> {
    /// The bytes, until the header is read.
    input: Option<R>,
    reader: Option<Reader<Bytes<R>>>,
    record: ByteRecord,
    topics: Vec<Topic>,
    wanted: Option<TimeName>,
    column: Option<TimeColumn>,
    /// A comma in a number is the decimal point.
    decimal_comma: bool,
    /// Lines before the row of names that the parser does not see.
    lines_before: u64,
    newest: Option<Time>,
    /// Number of names.
    columns: usize,
    damages: ReadErrors,
    /// Names of the columns to read; `None` reads all.
    carried: Option<BTreeSet<String>>,
    /// True for each column, by number, that is read.
    carries: Vec<bool>,
}

impl<R: Read> CsvTable<R> {
    /// Returns a reader. `wanted` names the time column; without it, the column is found by its name.
    pub(crate) fn new(input: R, wanted: Option<TimeName>) -> CsvTable<R> {
        CsvTable {
            input: Some(input),
            reader: None,
            record: ByteRecord::new(),
            topics: Vec::new(),
            wanted,
            column: None,
            decimal_comma: false,
            lines_before: 0,
            newest: None,
            columns: 0,
            damages: ReadErrors::default(),
            carried: None,
            carries: Vec::new(),
        }
    }

    fn header(&mut self, input: R) -> io::Result<()> {
        let mut bytes = Bytes::new(input);
        let mut separator = separator(bytes.peek(HEADER_BYTES_MAX)?);
        let first = bytes.peek(SEPARATOR_LINE.len() + 1)?;
        if let Some(stated) = first.strip_prefix(SEPARATOR_LINE).and_then(<[u8]>::first) {
            separator = *stated;
            bytes.line(HEADER_BYTES_MAX)?;
            self.lines_before = 1;
        }
        self.decimal_comma = separator != b',';
        let mut options = ReaderBuilder::new();
        options.has_headers(false).flexible(true).comment(Some(b'#')).delimiter(separator);
        let mut reader = options.from_reader(bytes);
        if !reader.read_byte_record(&mut self.record)? {
            self.damages.add(|| "line 1: the table is empty".to_string());
            return Ok(());
        }
        let name = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().trim_start_matches('\u{feff}').to_string();
        let fields: Vec<String> = self.record.iter().take(FIELDS_MAX).map(name).collect();
        self.column = match &self.wanted {
            Some((name, unit_ns)) => TimeColumn::named(&fields, name, *unit_ns),
            None => TimeColumn::find(&fields),
        };
        if self.column.is_none() {
            let line = self.record.position().map_or(0, csv::Position::line) + self.lines_before;
            let found: String = fields.join(", ").chars().take(200).collect();
            self.damages.add(|| match &self.wanted {
                Some((name, _)) => format!("line {line}: there is no column `{name}`; the columns are {found}"),
                None => format!("line {line}: no column has the name of a time; the columns are {found}. Expected `t`, `time (s)`, `timestamp_ms`, `datetime` or the like, or a mapping with (time \"COLUMN\" :unit U)"),
            });
            return Ok(());
        }
        self.columns = self.record.len();
        let mut names = BTreeSet::new();
        for field in fields.iter().filter(|field| !field.is_empty()) {
            if !names.insert(field) {
                self.damages.add(|| format!("the row of names: two columns are called `{field}`: the first counts"));
            }
        }
        if let Some(carried) = &self.carried {
            self.carries = fields.iter().map(|field| carried.contains(field)).collect();
        }
        self.topics.push(Topic { name: "csv".to_string(), fields, ..Topic::default() });
        self.reader = Some(reader);
        Ok(())
    }

    /// Notes a row that has more or fewer cells than there are names: what a cell means is then not certain.
    fn count_cells(&mut self, line: u64) {
        let (cells, columns) = (self.record.len(), self.columns);
        let decimal =
            if self.decimal_comma { "" } else { "; a decimal comma needs semicolons or tabs between columns" };
        if self.record.iter().skip(columns).any(|cell| !cell.is_empty()) {
            self.damages.add(|| format!("line {line}: the row has {cells} cells and the row of names {columns}: the last ones are left out{decimal}"));
        } else if cells < columns {
            self.damages.add(|| {
                format!("line {line}: the row has {cells} cells and the row of names {columns}: it may be cut off")
            });
        }
    }

    /// Returns the instant of the row that was read last; `None` if its text is not a time, which is noted.
    fn instant(&mut self, line: u64) -> Option<Time> {
        let column = self.column.as_mut()?;
        let text = String::from_utf8_lossy(self.record.get(column.index).unwrap_or_default());
        let text = text.trim();
        if text.is_empty() {
            self.damages.add(|| format!("line {line}: the row has no time"));
            return None;
        }
        let at = if self.decimal_comma { column.instant(&text.replace(',', ".")) } else { column.instant(text) };
        match at {
            None => self.damages.add(|| format!("line {line}: `{}` is not a time", text.chars().take(40).collect::<String>())),
            Some(_) if at == self.newest => self.damages.add(|| {
                format!("line {line}: it has the time of the row before, `{text}`; if both measure a state variable, the later value counts")
            }),
            Some(_) => {}
        }
        self.newest = at.or(self.newest);
        at
    }
}

/// Returns the column separator, from the first line that is not a comment: a tab or semicolon if the line has one outside of quotes.
fn separator(bytes: &[u8]) -> u8 {
    let mut lines =
        bytes.split(|byte| *byte == b'\n').filter(|line| !line.starts_with(b"#") && !line.trim_ascii().is_empty());
    let mut quoted = false;
    let outside: Vec<u8> = lines
        .next()
        .unwrap_or_default()
        .iter()
        .copied()
        .filter(|byte| {
            quoted ^= *byte == b'"';
            !quoted
        })
        .collect();
    [b'\t', b';'].into_iter().find(|each| outside.contains(each)).unwrap_or(b',')
}

impl<R: Read> LogReader for CsvTable<R> {
    fn next(&mut self, message: &mut Message) -> io::Result<bool> {
        if let Some(input) = self.input.take() {
            self.header(input)?;
        }
        loop {
            let Some(reader) = &mut self.reader else { return Ok(false) };
            if !reader.read_byte_record(&mut self.record)? {
                return Ok(false);
            }
            let line = self.record.position().map_or(0, csv::Position::line) + self.lines_before;
            self.count_cells(line);
            if let Some(at) = self.instant(line) {
                let decimal_comma = self.decimal_comma;
                message.topic = 0;
                message.at = at;
                message.values.clear();
                let carries = |index: usize| self.carries.get(index).copied().unwrap_or(true);
                message.values.extend(self.record.iter().enumerate().map(|(index, bytes)| {
                    if carries(index) || bytes.is_empty() {
                        cell(bytes, decimal_comma)
                    } else {
                        Cell::Text(String::new())
                    }
                }));
                return Ok(true);
            }
        }
    }

    fn carry_only(&mut self, carried: BTreeSet<String>) {
        self.carried = Some(carried);
    }

    fn topics(&self) -> &[Topic] {
        &self.topics
    }

    fn damages(&self) -> &ReadErrors {
        &self.damages
    }
}

fn cell(bytes: &[u8], decimal_comma: bool) -> Cell {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim();
    if text.is_empty() {
        return Cell::Nothing;
    }
    let number = text.parse::<f64>().ok();
    let number = number.or_else(|| {
        let one_comma = decimal_comma && text.bytes().filter(|byte| *byte == b',').count() == 1;
        if one_comma { text.replace(',', ".").parse().ok() } else { None }
    });
    number.map_or_else(|| Cell::Text(text.to_string()), Cell::Number)
}
