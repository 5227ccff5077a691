//! PX4 ULog, `.ulg`: definitions, then data; each message begins with its size and a letter (PX4 user guide, "ULog File Format").

use crate::bytes::{Bytes, text, u16_at, u64_at};
use crate::ulog_format::{Formats, Leaf};
use crate::{Cell, LogReader, Message, ReadErrors, TOPICS_MAX, Topic};
use apex_model::time::Time;
use std::collections::BTreeMap;
use std::io::{self, Read};

/// First bytes of the format; version and start time follow.
pub(crate) const MAGIC: &[u8] = &[0x55, 0x4c, 0x6f, 0x67, 0x01, 0x12, 0x35];
const HEADER: usize = 16;
const MESSAGE_HEADER: usize = 3;
/// Letters of the known types of messages.
const LETTERS: &[u8] = b"BFIMPQARDLCSO";

/// Topic and instance of a subscription number.
struct Subscription {
    topic: usize,
    leaves: Vec<Leaf>,
    timestamp: Option<usize>,
    size: usize,
}

/// Reads a ULog file.
pub(crate) struct ULog<R> {
    bytes: Bytes<R>,
    begun: bool,
    /// True if the file begins as a ULog file does.
    is_whole: bool,
    began: Option<Time>,
    formats: Formats,
    subscriptions: BTreeMap<u16, Subscription>,
    topics: Vec<Topic>,
    messages: Option<usize>,
    damages: ReadErrors,
}

impl<R: Read> ULog<R> {
    pub(crate) fn new(input: R) -> ULog<R> {
        ULog {
            bytes: Bytes::new(input),
            begun: false,
            is_whole: false,
            began: None,
            formats: Formats::default(),
            subscriptions: BTreeMap::new(),
            topics: Vec::new(),
            messages: None,
            damages: ReadErrors::default(),
        }
    }

    fn header(&mut self) -> io::Result<()> {
        self.begun = true;
        let header = self.bytes.peek(HEADER)?;
        let whole = header.starts_with(MAGIC) && header.len() == HEADER;
        self.began = u64_at(header, 8).filter(|_| whole).map(instant);
        if !whole {
            self.damages.add(|| "byte 0: this is not the beginning of a ULog file".to_string());
        }
        self.is_whole = whole;
        self.bytes.skip(HEADER);
        Ok(())
    }

    /// Processes one message of the file; returns true if `message` then holds a message for the caller.
    fn take(&mut self, letter: u8, payload: &[u8], at: u64, message: &mut Message) -> bool {
        match letter {
            b'F' => {
                if !self.formats.define(&text(payload)) {
                    self.damages.add(|| format!("byte {at}: this definition of a format is malformed"));
                }
                false
            }
            b'A' => {
                self.subscribe(payload, at);
                false
            }
            b'D' => self.data(payload, at, message),
            b'L' => self.said(payload, 1, message),
            b'C' => self.said(payload, 3, message),
            b'O' => {
                let span = u16_at(payload, 0).unwrap_or_default();
                self.damages.add(|| format!("byte {at}: the logger itself lost {span} ms of data here (drop-out)"));
                false
            }
            b'B' => {
                let unknown = payload.get(8..16).unwrap_or_default().iter().enumerate();
                if unknown.into_iter().any(|(index, flags)| *flags & if index == 0 { !1 } else { !0 } != 0) {
                    self.damages
                        .add(|| format!("byte {at}: the log needs a feature that this reader does not support"));
                }
                false
            }
            _ => false,
        }
    }

    fn subscribe(&mut self, payload: &[u8], at: u64) {
        let (Some(instance), Some(number)) = (payload.first(), u16_at(payload, 1)) else { return };
        let format = text(payload.get(3..).unwrap_or_default());
        let (leaves, size) = match self.formats.leaves(&format) {
            Ok(found) => found,
            Err(reason) => return self.damages.add(|| format!("byte {at}: {reason}")),
        };
        if self.topics.len() >= TOPICS_MAX {
            return self.damages.add(|| format!("byte {at}: more than {TOPICS_MAX} kinds of messages"));
        }
        let name = if *instance == 0 { format } else { format!("{format}#{instance}") };
        let fields = leaves.iter().map(|leaf| leaf.name.clone()).collect();
        let timestamp = leaves.iter().position(|leaf| leaf.name == "timestamp");
        let topic = self.topics.len();
        self.topics.push(Topic { name, fields, ..Topic::default() });
        self.subscriptions.insert(number, Subscription { topic, leaves, timestamp, size });
    }

    fn data(&mut self, payload: &[u8], at: u64, message: &mut Message) -> bool {
        let number = u16_at(payload, 0);
        let Some(subscription) = number.and_then(|number| self.subscriptions.get(&number)) else {
            self.damages.add(|| format!("byte {at}: data of a message that was not announced"));
            return false;
        };
        let payload = payload.get(2..).unwrap_or_default();
        let stamp = subscription.timestamp.and_then(|index| subscription.leaves.get(index));
        let Some(microseconds) = stamp.and_then(|leaf| leaf.microseconds(payload)) else {
            self.damages.add(|| format!("byte {at}: data without a time stamp"));
            return false;
        };
        message.topic = subscription.topic;
        message.at = instant(microseconds);
        message.values.clear();
        message.values.extend(subscription.leaves.iter().map(|leaf| leaf.value(payload)));
        true
    }

    /// Processes a message of the vehicle's software: level, time stamp and text.
    fn said(&mut self, payload: &[u8], stamp: usize, message: &mut Message) -> bool {
        // Arbitrary bytes can look like such texts: in a file without the beginning of a log, definitions of data must come first.
        if !self.is_whole && self.subscriptions.is_empty() {
            return false;
        }
        let (Some(level), Some(microseconds)) = (payload.first(), u64_at(payload, stamp)) else { return false };
        let topics = &mut self.topics;
        let topic = *self.messages.get_or_insert_with(|| {
            let fields = vec!["level".into(), "text".into()];
            topics.push(Topic { name: "logged_message".into(), fields, ..Topic::default() });
            topics.len() - 1
        });
        let words = text(payload.get(stamp + 8..).unwrap_or_default());
        let level = f64::from(level.saturating_sub(b'0'));
        *message = Message { topic, at: instant(microseconds), values: vec![Cell::Number(level), Cell::Text(words)] };
        true
    }

    /// Returns true if a message can begin here.
    fn plausible(&self, window: &[u8]) -> bool {
        let (Some(size), Some(letter)) = (u16_at(window, 0), window.get(2)) else { return false };
        match letter {
            b'D' => {
                let known = u16_at(window, MESSAGE_HEADER).and_then(|number| self.subscriptions.get(&number));
                // The logger may leave out padding at the end of a message.
                known.is_some_and(|known| {
                    let size = usize::from(size).saturating_sub(2);
                    size <= known.size && size + 16 >= known.size
                })
            }
            b'S' => size == 8,
            b'O' => size == 2,
            letter => LETTERS.contains(letter) && self.subscriptions.is_empty() && size > 0,
        }
    }
}

fn instant(microseconds: u64) -> Time {
    Time(i64::try_from(microseconds).unwrap_or(i64::MAX).saturating_mul(1_000))
}

impl<R: Read> LogReader for ULog<R> {
    fn next(&mut self, message: &mut Message) -> io::Result<bool> {
        if !self.begun {
            self.header()?;
        }
        loop {
            let at = self.bytes.offset;
            let header = self.bytes.peek(MESSAGE_HEADER)?;
            if header.is_empty() {
                return Ok(false);
            }
            let (Some(size), Some(letter)) = (u16_at(header, 0), header.get(2).copied()) else {
                self.damages.add(|| format!("byte {at}: the log ends within a message"));
                self.bytes.skip(MESSAGE_HEADER);
                return Ok(false);
            };
            let length = MESSAGE_HEADER + usize::from(size);
            let whole = self.bytes.peek(length)?;
            let cut = whole.len() < length;
            if !LETTERS.contains(&letter) || cut {
                if cut && LETTERS.contains(&letter) {
                    self.damages.add(|| format!("byte {at}: the log ends within a message"));
                } else {
                    self.damages.add(|| format!("byte {at}: no message begins here; looking for the next one"));
                }
                self.bytes.skip(1);
                loop {
                    let window = self.bytes.peek(MESSAGE_HEADER + 2)?.to_vec();
                    if window.is_empty() {
                        return Ok(false);
                    }
                    if self.plausible(&window) {
                        break;
                    }
                    self.bytes.skip(1);
                }
                continue;
            }
            let payload = whole.get(MESSAGE_HEADER..).unwrap_or_default().to_vec();
            self.bytes.skip(length);
            if self.take(letter, &payload, at, message) {
                return Ok(true);
            }
        }
    }

    fn topics(&self) -> &[Topic] {
        &self.topics
    }

    fn began(&self) -> Option<Time> {
        self.began
    }

    fn damages(&self) -> &ReadErrors {
        &self.damages
    }
}
