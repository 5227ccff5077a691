//! DataFlash in binary form, `.bin`: each message begins with A3 95 and its type; messages of type 128 define the formats of the others
//! (ArduPilot developer documentation, "Logging").

use crate::bytes::{Bytes, array, text, u16_at, u32_at};
use crate::dataflash::TimestampInterpolator;
use crate::dataflash_units::FormatTable;
use crate::{Cell, LogReader, Message, ReadErrors, Topic};
use std::io::{self, Read};

/// First bytes of each message.
pub(crate) const MAGIC: [u8; 2] = [0xa3, 0x95];
/// Type of the messages that define formats (`FMT`), and their length in bytes.
const FORMAT_TYPE: u8 = 128;
const FORMAT_LENGTH: usize = 89;
const HEADER: usize = 3;

/// Reads a binary DataFlash log.
pub(crate) struct DataFlashBinary<R> {
    bytes: Bytes<R>,
    table: FormatTable,
    stamper: TimestampInterpolator,
    damages: ReadErrors,
    ended: bool,
}

impl<R: Read> DataFlashBinary<R> {
    pub(crate) fn new(input: R) -> DataFlashBinary<R> {
        DataFlashBinary {
            bytes: Bytes::new(input),
            table: FormatTable::default(),
            stamper: TimestampInterpolator::default(),
            damages: ReadErrors::default(),
            ended: false,
        }
    }

    /// Reads one message, or skips one byte where none begins; returns false at the end of the file.
    fn step(&mut self) -> io::Result<bool> {
        let at = self.bytes.offset;
        let header = self.bytes.peek(HEADER)?;
        let Some(kind) = header.get(2).copied().filter(|_| header.starts_with(&MAGIC)) else {
            if header.is_empty() {
                return Ok(false);
            }
            self.bytes.skip(1);
            return self.look_for_next(at);
        };
        let known = self.table.of_kind(kind).map(|format| format.length);
        let length = known.unwrap_or(if kind == FORMAT_TYPE { FORMAT_LENGTH } else { 0 });
        if length < HEADER {
            self.damages.add(|| format!("byte {at}: no definition of messages of type {kind}"));
            self.bytes.skip(HEADER);
            return self.look_for_next(at);
        }
        let whole = self.bytes.peek(length)?.to_vec();
        if whole.len() < length {
            self.damages.add(|| format!("byte {at}: the log ends within a message"));
            self.bytes.skip(length);
            return Ok(false);
        }
        self.bytes.skip(length);
        let payload = whole.get(HEADER..).unwrap_or_default();
        if kind == FORMAT_TYPE {
            self.define(payload, at);
        } else if let Some(format) = self.table.of_kind(kind) {
            let (values, whole) = (values(&format.letters, payload), format.topic);
            self.table.note(whole, &values);
            let row = Message { topic: self.table.topic_of(kind, &values), values, ..Message::default() };
            if let Some(format) = self.table.of_kind(kind) {
                self.stamper.push(format, row);
            }
        }
        Ok(true)
    }

    fn look_for_next(&mut self, at: u64) -> io::Result<bool> {
        self.damages.add(|| format!("byte {at}: no message begins here; looking for the next one"));
        loop {
            let window = self.bytes.peek(1 << 12)?;
            if window.len() < MAGIC.len() {
                let rest = window.len();
                self.bytes.skip(rest);
                return Ok(false);
            }
            let found = window.windows(MAGIC.len()).position(|pair| pair == MAGIC);
            let passed = found.unwrap_or(window.len() - 1);
            self.bytes.skip(passed);
            if found.is_some() {
                return Ok(true);
            }
        }
    }

    fn define(&mut self, payload: &[u8], at: u64) {
        let (Some(kind), Some(length)) = (payload.first().copied(), payload.get(1).copied()) else { return };
        let part = |from: usize, to: usize| text(payload.get(from..to).unwrap_or_default());
        let (name, letters, columns) = (part(2, 6), part(6, 22), part(22, 86));
        if kind == FORMAT_TYPE {
            return;
        }
        let columns: Vec<String> =
            columns.split(',').map(|column| column.trim().to_string()).filter(|column| !column.is_empty()).collect();
        let sizes: Option<usize> = letters.chars().map(size).sum();
        if sizes.is_none_or(|sizes| sizes + HEADER != usize::from(length)) {
            return self.damages.add(|| format!("byte {at}: the definition of `{name}` contradicts itself"));
        }
        self.table.define(kind, &name, usize::from(length), &letters, &columns);
    }
}

/// Returns the size in bytes of a field with this format letter.
fn size(letter: char) -> Option<usize> {
    Some(match letter {
        'b' | 'B' | 'M' => 1,
        'h' | 'H' | 'c' | 'C' | 'g' => 2,
        'i' | 'I' | 'f' | 'e' | 'E' | 'L' | 'n' => 4,
        'd' | 'q' | 'Q' => 8,
        'N' => 16,
        'Z' | 'a' => 64,
        _ => return None,
    })
}

fn values(letters: &[char], payload: &[u8]) -> Vec<Cell> {
    let mut at = 0;
    let mut values = Vec::with_capacity(letters.len());
    for letter in letters {
        let length = size(*letter).unwrap_or_default();
        values.push(value(*letter, payload, at, length));
        at += length;
    }
    values
}

/// Decodes a field by its format letter. Letters `c C e E` are scaled by 100, `L` (degrees) by 10,000,000.
fn value(letter: char, payload: &[u8], at: usize, length: usize) -> Cell {
    let i16_at = || array(payload, at).map(i16::from_le_bytes).map(f64::from);
    let i32_at = || array(payload, at).map(i32::from_le_bytes).map(f64::from);
    let number = match letter {
        'b' => array(payload, at).map(i8::from_le_bytes).map(f64::from),
        'B' | 'M' => payload.get(at).map(|byte| f64::from(*byte)),
        'h' => i16_at(),
        'H' => u16_at(payload, at).map(f64::from),
        'c' => i16_at().map(|number| number / 100.0),
        'C' => u16_at(payload, at).map(|number| f64::from(number) / 100.0),
        'g' => u16_at(payload, at).map(half),
        'i' => i32_at(),
        'I' => u32_at(payload, at).map(f64::from),
        'f' => array(payload, at).map(f32::from_le_bytes).map(f64::from),
        'e' => i32_at().map(|number| number / 100.0),
        'E' => u32_at(payload, at).map(|number| f64::from(number) / 100.0),
        'L' => i32_at().map(|number| number / 1e7),
        'd' => array(payload, at).map(f64::from_le_bytes),
        'q' => array(payload, at).map(i64::from_le_bytes).map(|number| number as f64),
        'Q' => array(payload, at).map(u64::from_le_bytes).map(|number| number as f64),
        'n' | 'N' | 'Z' => return Cell::Text(text(payload.get(at..at + length).unwrap_or_default())),
        _ => None,
    };
    number.map_or(Cell::Nothing, Cell::Number)
}

/// Decodes a half-precision number (IEEE 754 binary16).
fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    sign * match exponent {
        0 => fraction / 16_777_216.0,
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        exponent => (1.0 + fraction / 1024.0) * libm::exp2(f64::from(exponent - 15)),
    }
}

impl<R: Read> LogReader for DataFlashBinary<R> {
    fn next(&mut self, message: &mut Message) -> io::Result<bool> {
        loop {
            if let Some(ready) = self.stamper.take() {
                *message = ready;
                return Ok(true);
            }
            if self.ended {
                return Ok(false);
            }
            if !self.step()? {
                self.ended = true;
                self.stamper.end();
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
