//! Parts that the text and the binary form of ArduPilot DataFlash logs share: formats of messages, and times of rows.

use crate::{Cell, Message, Topic};
use apex_model::time::Time;
use std::collections::VecDeque;

/// Maximum number of rows that wait for the next row with a time. Beyond it, waiting rows get the time of the last row before
/// them.
const WAITING_MAX: usize = 10_000;

/// The format of one kind of message, as `FMT` rows define it.
#[derive(Clone, Debug)]
pub(crate) struct Format {
    pub(crate) topic: usize,
    /// Bytes of a whole message in the binary form.
    pub(crate) length: usize,
    /// Format letter of each field.
    pub(crate) letters: Vec<char>,
    clock: Option<Clock>,
}

/// Field of a row that holds its time.
#[derive(Clone, Copy, Debug)]
struct Clock {
    field: usize,
    nanoseconds: f64,
    /// True if rows without a time take theirs from rows of this kind.
    leads: bool,
}

impl Format {
    /// Returns the format and the topic that an `FMT` row defines.
    pub(crate) fn new(topic: usize, name: &str, length: usize, letters: &str, columns: &[String]) -> (Format, Topic) {
        let field = |wanted: &str| columns.iter().position(|column| column == wanted);
        let own = field("TimeUS").map(|field| (field, 1e3)).or_else(|| field("TimeMS").map(|field| (field, 1e6)));
        // In old logs only GPS rows have a time, in milliseconds of the GPS week.
        let of_gps = (name == "GPS").then(|| field("T").or_else(|| field("Time"))).flatten().map(|field| (field, 1e6));
        let clock = match (own, of_gps) {
            (Some((field, nanoseconds)), _) => Some(Clock { field, nanoseconds, leads: false }),
            (None, Some((field, nanoseconds))) => Some(Clock { field, nanoseconds, leads: true }),
            (None, None) => None,
        };
        let format = Format { topic, length, letters: letters.chars().collect(), clock };
        (format, Topic { name: name.to_string(), fields: columns.to_vec(), ..Topic::default() })
    }

    fn time_of(&self, values: &[Cell]) -> Option<(Time, bool)> {
        let clock = self.clock?;
        match values.get(clock.field)? {
            Cell::Number(number) if *number >= 0.0 => {
                Some((Time((number * clock.nanoseconds).round() as i64), clock.leads))
            }
            _ => None,
        }
    }
}

/// Gives rows their times. Rows that carry none are spread evenly between the GPS rows around them.
#[derive(Debug, Default)]
pub(crate) struct TimestampInterpolator {
    newest: Option<Time>,
    waiting: VecDeque<Message>,
    ready: VecDeque<Message>,
}

impl TimestampInterpolator {
    /// Adds the next row of the log.
    pub(crate) fn push(&mut self, format: &Format, mut row: Message) {
        match format.time_of(&row.values) {
            Some((at, leads)) => {
                row.at = at;
                if leads {
                    self.spread(at);
                    self.newest = Some(at);
                } else {
                    // Rows of this log have their own times, so no row waits for a GPS row.
                    self.newest = self.newest.max(Some(at));
                    self.release();
                }
                self.ready.push_back(row);
            }
            None => {
                self.waiting.push_back(row);
                if self.waiting.len() > WAITING_MAX {
                    self.release();
                }
            }
        }
    }

    /// Ends the log: rows after the last time get that time.
    pub(crate) fn end(&mut self) {
        self.release();
    }

    pub(crate) fn take(&mut self) -> Option<Message> {
        self.ready.pop_front()
    }

    fn spread(&mut self, until: Time) {
        let from = self.newest.unwrap_or(until);
        let (span, count) = ((until - from).0.max(0), self.waiting.len() as i64 + 1);
        for (index, mut row) in std::mem::take(&mut self.waiting).into_iter().enumerate() {
            row.at = Time(from.0 + span / count * (index as i64 + 1));
            self.ready.push_back(row);
        }
    }

    fn release(&mut self) {
        let at = self.newest.unwrap_or(Time::ZERO);
        for mut row in std::mem::take(&mut self.waiting) {
            row.at = at;
            self.ready.push_back(row);
        }
    }
}
