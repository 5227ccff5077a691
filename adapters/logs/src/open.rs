//! Recognition of a log's format, and the reader of each format.

use crate::csv_table::{CsvTable, TimeName};
use crate::dataflash_binary::{self, DataFlashBinary};
use crate::dataflash_text::DataFlashText;
use crate::mavlink::{self, TelemetryLog};
use crate::mcap::{self, Mcap};
use crate::ulog::{self, ULog};
use crate::{LogReader, bytes::Bytes};
use std::io::{self, Read};

/// Formats of logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// PX4, `.ulg`.
    ULog,
    /// ArduPilot, `.bin`.
    DataFlashBinary,
    /// ArduPilot, `.log`.
    DataFlashText,
    /// MAVLink telemetry, `.tlog`.
    TelemetryLog,
    /// `.mcap`
    Mcap,
    /// `.csv`
    Csv,
}

impl Format {
    /// Returns the format recognised from the first bytes of a log, otherwise from the extension of its name, otherwise from typical bytes.
    pub fn of(first: &[u8], extension: &str) -> Option<Format> {
        if first.starts_with(ulog::MAGIC) {
            return Some(Format::ULog);
        }
        if first.starts_with(mcap::MAGIC) {
            return Some(Format::Mcap);
        }
        if first.starts_with(&dataflash_binary::MAGIC) {
            return Some(Format::DataFlashBinary);
        }
        let marks = [mavlink::VERSION_1, mavlink::VERSION_2];
        Some(match extension.to_ascii_lowercase().as_str() {
            "ulg" | "ulog" => Format::ULog,
            "bin" => Format::DataFlashBinary,
            "log" => Format::DataFlashText,
            "tlog" => Format::TelemetryLog,
            "mcap" => Format::Mcap,
            "csv" | "tsv" => Format::Csv,
            _ if first.get(8).is_some_and(|byte| marks.contains(byte)) => Format::TelemetryLog,
            _ if first.windows(4).any(|word| word == b"FMT,") => Format::DataFlashText,
            _ => return None,
        })
    }

    /// Returns its usual name.
    pub fn name(self) -> &'static str {
        match self {
            Format::ULog => "PX4 ULog",
            Format::DataFlashBinary => "ArduPilot DataFlash",
            Format::DataFlashText => "ArduPilot DataFlash text",
            Format::TelemetryLog => "MAVLink telemetry log",
            Format::Mcap => "MCAP",
            Format::Csv => "CSV",
        }
    }

    /// Returns the reader of a log in this format. `time` names the time's column of a table.
    pub fn reader<'a>(self, input: impl Read + 'a, time: Option<TimeName>) -> Box<dyn LogReader + 'a> {
        match self {
            Format::ULog => Box::new(ULog::new(input)),
            Format::DataFlashBinary => Box::new(DataFlashBinary::new(input)),
            Format::DataFlashText => Box::new(DataFlashText::new(input)),
            Format::TelemetryLog => Box::new(TelemetryLog::new(input)),
            Format::Mcap => Box::new(Mcap::new(input)),
            Format::Csv => Box::new(CsvTable::new(input, time)),
        }
    }
}

/// Number of leading bytes by which a format is recognised.
const SHOWN: usize = 512;

/// Recognises the format of `input`, which has a name with `extension`.
///
/// # Errors
/// The log cannot be read from its medium.
pub fn open<'a>(input: impl Read + 'a, extension: &str) -> io::Result<(Option<Format>, Box<dyn Read + 'a>)> {
    let mut bytes = Bytes::new(input);
    let first = bytes.peek(SHOWN)?.to_vec();
    Ok((Format::of(&first, extension), Box::new(bytes)))
}

impl<R: Read> Read for Bytes<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let window = self.peek(buffer.len())?;
        let length = window.len().min(buffer.len());
        for (to, from) in buffer.iter_mut().zip(window) {
            *to = *from;
        }
        self.skip(length);
        Ok(length)
    }
}
