//! DataFlash as text, `.log`: one row on each line, `NAME, value, value, ..`; `FMT` rows define the columns.

use crate::bytes::Bytes;
use crate::dataflash::TimestampInterpolator;
use crate::dataflash_units::FormatTable;
use crate::{Cell, LogReader, MESSAGE_BYTES_MAX, Message, ReadErrors, Topic};
use std::io::{self, Read};

/// Reads a DataFlash log in text.
pub(crate) struct DataFlashText<R> {
    bytes: Bytes<R>,
    line: u64,
    table: FormatTable,
    stamper: TimestampInterpolator,
    damages: ReadErrors,
    ended: bool,
}

impl<R: Read> DataFlashText<R> {
    pub(crate) fn new(input: R) -> DataFlashText<R> {
        DataFlashText {
            bytes: Bytes::new(input),
            line: 0,
            table: FormatTable::default(),
            stamper: TimestampInterpolator::default(),
            damages: ReadErrors::default(),
            ended: false,
        }
    }

    fn row(&mut self, line: &str) {
        let number = self.line;
        let mut parts = line.split(',').map(str::trim);
        let name = parts.next().unwrap_or_default();
        if name == "FMT" {
            if self.define(&mut parts).is_none() {
                self.damages.add(|| format!("line {number}: this FMT row is malformed"));
            }
            return;
        }
        // Lines before the first row are a greeting, without commas.
        if !line.contains(',') {
            return;
        }
        let Some((kind, format)) = self.table.of_name(name) else {
            self.damages.add(|| format!("line {number}: no FMT row defines `{}`", shortened(name)));
            return;
        };
        // The letters of units and multipliers stay text, even those that look like numbers.
        let of_units = name == "FMTU" || name == "UNIT";
        let cells = parts.enumerate();
        let cells =
            cells.map(|(place, text)| if of_units && place >= 2 { Cell::Text(text.to_string()) } else { cell(text) });
        let values: Vec<Cell> = cells.collect();
        let whole = format.topic;
        self.table.note(whole, &values);
        let wanted = self.table.topics.get(whole).map_or(0, |topic| topic.fields.len());
        if values.len() < wanted {
            let found = values.len();
            self.damages.add(|| format!("line {number}: the row `{name}` has {found} of {wanted} values"));
        }
        let row = Message { topic: self.table.topic_of(kind, &values), values, ..Message::default() };
        if let Some(format) = self.table.of_kind(kind) {
            self.stamper.push(format, row);
        }
    }

    fn define<'a>(&mut self, parts: &mut impl Iterator<Item = &'a str>) -> Option<()> {
        let kind: u8 = parts.next()?.parse().ok()?;
        let length = parts.next()?.parse().unwrap_or_default();
        let name = parts.next()?;
        let letters = parts.next()?;
        let columns: Vec<String> = parts.filter(|column| !column.is_empty()).map(str::to_string).collect();
        self.table.define(kind, name, length, letters, &columns).then_some(())
    }
}

fn shortened(name: &str) -> String {
    name.chars().take(20).collect()
}

fn cell(text: &str) -> Cell {
    match text.parse::<f64>() {
        Ok(number) => Cell::Number(number),
        Err(_) if text.is_empty() => Cell::Nothing,
        Err(_) => Cell::Text(text.to_string()),
    }
}

impl<R: Read> LogReader for DataFlashText<R> {
    fn next(&mut self, message: &mut Message) -> io::Result<bool> {
        loop {
            if let Some(ready) = self.stamper.take() {
                *message = ready;
                return Ok(true);
            }
            if self.ended {
                return Ok(false);
            }
            self.line += 1;
            match self.bytes.line(MESSAGE_BYTES_MAX)? {
                Some(line) => self.row(&String::from_utf8_lossy(&line)),
                None => {
                    self.ended = true;
                    self.stamper.end();
                }
            }
        }
    }

    fn topics(&self) -> &[Topic] {
        &self.table.topics
    }

    fn damages(&self) -> &ReadErrors {
        &self.damages
    }
}
