//! MAVLink telemetry logs, `.tlog`: eight bytes of civil time before each packet of version 1 or 2 (mavlink.io, "Packet
//! Serialization").

use crate::bytes::{Bytes, array, u16_at};
use crate::mavlink_messages::{CRC_BEGIN, MessageDefinition, checksum, definitions};
use crate::{LogReader, Message, ReadErrors, TOPICS_MAX, Topic};
use apex_model::time::Time;
use std::collections::BTreeMap;
use std::io::{self, Read};

const STAMP: usize = 8;
/// First bytes of packets of both versions.
pub(crate) const VERSION_1: u8 = 0xfe;
pub(crate) const VERSION_2: u8 = 0xfd;
/// The component that flies the vehicle.
const AUTOPILOT: u8 = 1;
/// Maximum difference between the times of adjacent packets, in microseconds: a day. A packet further apart is a damaged place.
const SPAN_US_MAX: u64 = 86_400_000_000;

/// Reads a telemetry log.
pub(crate) struct TelemetryLog<R> {
    bytes: Bytes<R>,
    definitions: Vec<MessageDefinition>,
    known: BTreeMap<(u8, u8, u32), usize>,
    topics: Vec<Topic>,
    /// The first system with an autopilot: the topics of its messages have no suffix `@SYSTEM.COMPONENT`.
    vehicle: Option<u8>,
    stamp: Option<u64>,
    damages: ReadErrors,
}

/// A packet in its frame.
struct Packet {
    length: usize,
    system: u8,
    component: u8,
    id: u32,
    /// True for version 2, whose payload may contain extension fields.
    extensions: bool,
    payload: Vec<u8>,
}

impl<R: Read> TelemetryLog<R> {
    pub(crate) fn new(input: R) -> TelemetryLog<R> {
        TelemetryLog {
            bytes: Bytes::new(input),
            definitions: definitions(),
            known: BTreeMap::new(),
            topics: Vec::new(),
            vehicle: None,
            stamp: None,
            damages: ReadErrors::default(),
        }
    }

    fn definition(&self, id: u32) -> Option<&MessageDefinition> {
        let index = self.definitions.binary_search_by_key(&id, |definition| definition.id).ok()?;
        self.definitions.get(index)
    }

    /// Returns the packet at the beginning of `window`, if its checksum is right, or cannot be checked.
    fn packet(&self, window: &[u8]) -> Option<Packet> {
        let frame = window.get(STAMP..)?;
        let length = usize::from(*frame.get(1)?);
        let (header, signature) = match *frame.first()? {
            VERSION_1 => (6, 0),
            VERSION_2 => (10, if frame.get(2)? & 1 == 0 { 0 } else { 13 }),
            _ => return None,
        };
        let (system, component, id) = match header {
            6 => (*frame.get(3)?, *frame.get(4)?, u32::from(*frame.get(5)?)),
            _ => {
                let [low, middle, high] = array(frame, 7)?;
                (*frame.get(5)?, *frame.get(6)?, u32::from_le_bytes([low, middle, high, 0]))
            }
        };
        let end = header + length;
        let sent = u16_at(frame, end)?;
        frame.get(..end + 2 + signature)?;
        if let Some(definition) = self.definition(id) {
            let crc = checksum(CRC_BEGIN, frame.get(1..end)?);
            if checksum(crc, &[definition.crc_extra]) != sent {
                return None;
            }
        }
        let payload = frame.get(header..end)?.to_vec();
        Some(Packet { length: STAMP + end + 2 + signature, system, component, id, extensions: header == 10, payload })
    }

    fn plausible(&self, stamp: u64) -> bool {
        match self.stamp {
            Some(before) => stamp.abs_diff(before) < SPAN_US_MAX,
            None => stamp < 1 << 53,
        }
    }

    fn topic(&mut self, packet: &Packet) -> Option<usize> {
        if self.vehicle.is_none() && packet.component == AUTOPILOT {
            self.vehicle = Some(packet.system);
        }
        let key = (packet.system, packet.component, packet.id);
        if let Some(topic) = self.known.get(&key) {
            return Some(*topic);
        }
        if self.topics.len() >= TOPICS_MAX {
            return None;
        }
        let definition = self.definition(packet.id);
        let fields = definition.map(MessageDefinition::names).unwrap_or_default();
        let plain = definition.map_or_else(|| format!("message-{}", packet.id), |known| known.name.to_string());
        let own = packet.component == AUTOPILOT && self.vehicle == Some(packet.system);
        let name = if own { plain } else { format!("{plain}@{}.{}", packet.system, packet.component) };
        self.topics.push(Topic { name, fields, ..Topic::default() });
        self.known.insert(key, self.topics.len() - 1);
        Some(self.topics.len() - 1)
    }

    /// Notes what is wrong at `at`, and skips bytes until a packet begins. `stamp` is the time before a packet that is whole.
    fn resume(&mut self, at: u64, stamp: Option<u64>) -> io::Result<()> {
        self.damages.add(|| match (stamp, self.stamp) {
            (Some(stamp), Some(before)) => format!(
                "byte {at}: the packet's time is {} s {} the time of the packet before, more than a day; it is skipped",
                stamp.abs_diff(before) / 1_000_000,
                if stamp > before { "after" } else { "before" }
            ),
            (Some(stamp), None) => {
                format!(
                    "byte {at}: the packet's time is {stamp} us after 1970, which is not the time of a flight; it is skipped"
                )
            }
            (None, _) => {
                format!("byte {at}: no packet begins here, or its checksum is wrong; looking for the next one")
            }
        });
        loop {
            self.bytes.skip(1);
            let window = self.bytes.peek(STAMP + LONGEST)?.to_vec();
            if window.len() <= STAMP {
                let rest = window.len();
                self.bytes.skip(rest);
                return Ok(());
            }
            let begins = window.get(STAMP).is_some_and(|first| [VERSION_1, VERSION_2].contains(first));
            let stamp = array(&window, 0).map(u64::from_be_bytes);
            if begins && stamp.is_some_and(|stamp| self.plausible(stamp)) && self.packet(&window).is_some() {
                return Ok(());
            }
        }
    }
}

/// Returns true if the packet in `window` is longer than the remaining bytes.
fn is_cut(window: &[u8]) -> bool {
    let fixed = match window.get(STAMP) {
        Some(&VERSION_1) => 8,
        Some(&VERSION_2) => 12,
        Some(_) => return false,
        None => return true,
    };
    window.get(STAMP + 1).is_none_or(|length| window.len() < STAMP + fixed + usize::from(*length))
}

/// Bytes of the longest packet.
const LONGEST: usize = 280;

impl<R: Read> LogReader for TelemetryLog<R> {
    fn next(&mut self, message: &mut Message) -> io::Result<bool> {
        loop {
            let at = self.bytes.offset;
            let window = self.bytes.peek(STAMP + LONGEST)?.to_vec();
            let Some(stamp) = array(&window, 0).map(u64::from_be_bytes) else {
                if !window.is_empty() {
                    self.damages.add(|| format!("byte {at}: the log ends within a packet"));
                    self.bytes.skip(STAMP);
                }
                return Ok(false);
            };
            let whole = self.packet(&window);
            let untimely = whole.as_ref().map(|_| stamp);
            let Some(packet) = whole.filter(|_| self.plausible(stamp)) else {
                if window.len() < STAMP + LONGEST && is_cut(&window) {
                    self.damages.add(|| format!("byte {at}: the log ends within a packet"));
                    self.bytes.skip(window.len());
                    return Ok(false);
                }
                self.resume(at, untimely)?;
                continue;
            };
            self.bytes.skip(packet.length);
            self.stamp = Some(stamp);
            let Some(topic) = self.topic(&packet) else { continue };
            message.topic = topic;
            message.at = Time(i64::try_from(stamp).unwrap_or(i64::MAX).saturating_mul(1_000));
            message.values = self
                .definition(packet.id)
                .map(|known| known.values(&packet.payload, packet.extensions))
                .unwrap_or_default();
            return Ok(true);
        }
    }

    fn topics(&self) -> &[Topic] {
        &self.topics
    }

    fn damages(&self) -> &ReadErrors {
        &self.damages
    }
}
