//! Logs of real flights as samples: PX4 ULog, ArduPilot DataFlash (text and binary), MAVLink telemetry logs, MCAP and CSV.
//!
//! Each format has one file with a [`LogReader`]. It reads forward in bounded memory, never panics on any bytes, skips damaged places and
//! reports them. A [`Mapping`] turns fields into state variables.

mod bytes;
mod cdr;
mod civil_time;
mod csv_table;
mod dataflash;
mod dataflash_binary;
mod dataflash_text;
mod dataflash_units;
mod field_list;
mod fields;
mod log_file;
mod mapping;
mod mapping_doubts;
mod mapping_file;
mod mavlink;
mod mavlink_messages;
mod mcap;
mod nested;
mod open;
mod ordered;
mod protobuf;
mod ros_schema;
mod time_column;
mod ulog;
mod ulog_format;

pub use csv_table::TimeName;
pub use field_list::field_list;
pub use fields::{FieldSummary, LogInterval, survey};
pub use log_file::{Fed, LogError, LogFile};
pub use mapping::{Entry, Mapping, Sampled, Sampler, Take};
pub use mapping_doubts::WrittenEntry;
pub use mapping_file::{MappingError, MappingFile, ReadForm};
pub use open::{Format, open};
pub use ordered::Ordered;

use apex_model::time::Time;
use std::collections::BTreeSet;
use std::io;

/// Maximum number of kinds of messages that are distinguished in a log.
pub const TOPICS_MAX: usize = 4_096;
/// Maximum number of fields of one kind of message.
pub const FIELDS_MAX: usize = 4_096;
/// Maximum bytes of one message or line; a longer one counts as damage.
pub const MESSAGE_BYTES_MAX: usize = 1 << 24;
/// Number of damaged places that are described; further ones are only counted.
pub const DAMAGES_MAX: usize = 20;

/// The unit of a field as stated in the log.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldUnit {
    /// The unit's name in the log, `m/s`.
    pub label: String,
    /// Factor that converts numbers of the field into that unit.
    pub multiplier: f64,
}

/// A kind of message with its fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topic {
    /// Its name in the log.
    pub name: String,
    /// Names of its fields; elements of arrays are separate fields, `q[0]`.
    pub fields: Vec<String>,
    /// The units of the fields, as far as the log states them; empty if it states no units.
    pub units: Vec<Option<FieldUnit>>,
    /// True for each field that holds whole numbers which no format scales; empty if that is not known.
    pub integers: Vec<bool>,
}

/// The value of one field.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Cell {
    /// Not in this message.
    #[default]
    Nothing,
    /// A number, after the scaling of the log's format.
    Number(f64),
    /// A text.
    Text(String),
}

/// One message of a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Message {
    /// Index into [`LogReader::topics`].
    pub topic: usize,
    /// Instant by the log's clock.
    pub at: Time,
    /// The values in the order of the topic's fields; trailing ones may be missing.
    pub values: Vec<Cell>,
}

/// Places of a log that could not be read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadErrors {
    /// The first damaged places: the position and the problem of each.
    pub first: Vec<String>,
    /// Number of errors.
    pub count: u64,
}

impl ReadErrors {
    pub(crate) fn add(&mut self, what: impl FnOnce() -> String) {
        self.count += 1;
        if self.first.len() < DAMAGES_MAX {
            self.first.push(what());
        }
    }
}

/// Reads a log from its beginning to its end.
pub trait LogReader {
    /// Reads the next message into `message`; false at the end. Damaged places are skipped and noted.
    ///
    /// # Errors
    /// The log cannot be read from its medium.
    fn next(&mut self, message: &mut Message) -> io::Result<bool>;

    /// Returns the kinds of messages known so far; an assigned number never changes.
    fn topics(&self) -> &[Topic];

    /// States that only the fields in `carried` are needed; the reader may skip the others, whose values may then be empty texts.
    fn carry_only(&mut self, carried: BTreeSet<String>) {
        let _ = carried;
    }

    /// Returns the beginning of the log by its clock, if the log states it. Known after the first message.
    fn began(&self) -> Option<Time> {
        None
    }

    /// Returns the reading errors so far.
    fn damages(&self) -> &ReadErrors;
}
