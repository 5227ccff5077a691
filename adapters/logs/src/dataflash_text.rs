//! DataFlash as text, `.log`: one row a line, `NAME, value, value, ..`; `FMT` rows tell the columns.

use crate::bytes::Bytes;
use crate::dataflash::{Format, TimestampInterpolator};
use crate::{Cell, LogReader, MESSAGE_BYTES_MAX, Message, ReadErrors, TOPICS_MAX, Topic};
use std::collections::BTreeMap;
use std::io::{self, Read};

/// Reads a DataFlash log in text.
pub(crate) struct DataFlashText<R> {
    bytes: Bytes<R>,
    line: u64,
    formats: BTreeMap<String, Format>,
    topics: Vec<Topic>,
    stamper: TimestampInterpolator,
    damages: ReadErrors,
    ended: bool,
}

impl<R: Read> DataFlashText<R> {
    pub(crate) fn new(input: R) -> DataFlashText<R> {
        DataFlashText {
            bytes: Bytes::new(input),
            line: 0,
            formats: BTreeMap::new(),
            topics: Vec::new(),
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
                self.damages.add(|| format!("line {number}: this FMT row cannot be understood"));
            }
            return;
        }
        // Lines before the first row are a greeting, without commas.
        if !line.contains(',') {
            return;
        }
        let Some(format) = self.formats.get(name) else {
            self.damages.add(|| format!("line {number}: no FMT row defines `{}`", shortened(name)));
            return;
        };
        let values: Vec<Cell> = parts.map(cell).collect();
        let wanted = self.topics.get(format.topic).map_or(0, |topic| topic.fields.len());
        if values.len() < wanted {
            let found = values.len();
            self.damages.add(|| format!("line {number}: the row `{name}` has {found} of {wanted} values"));
        }
        let row = Message { topic: format.topic, values, ..Message::default() };
        self.stamper.push(format, row);
    }

    fn define<'a>(&mut self, parts: &mut impl Iterator<Item = &'a str>) -> Option<()> {
        let _type = parts.next()?;
        let length = parts.next()?.parse().unwrap_or_default();
        let name = parts.next()?;
        let letters = parts.next()?;
        let columns: Vec<String> = parts.filter(|column| !column.is_empty()).map(str::to_string).collect();
        let known = self.formats.get(name).map(|format| format.topic);
        if known.is_none() && self.topics.len() >= TOPICS_MAX {
            return None;
        }
        let (format, topic) = Format::new(known.unwrap_or(self.topics.len()), name, length, letters, &columns);
        match known.and_then(|known| self.topics.get_mut(known)) {
            Some(slot) => *slot = topic,
            None => self.topics.push(topic),
        }
        self.formats.insert(name.to_string(), format);
        Some(())
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
        &self.topics
    }

    fn damages(&self) -> &ReadErrors {
        &self.damages
    }
}
