//! Definitions of MAVLink messages (mavlink.io, common.xml and ardupilotmega.xml): numbers, names, and fields in the order in
//! which they are sent, with the extension fields of version 2.

use crate::Cell;
use crate::bytes::{array, text, u16_at, u32_at, u64_at};

/// The messages of the dialect `ardupilotmega` and of those that it includes (`common` and others), one per line, in
/// order of their numbers; `data/mavlink_messages.py` writes it from MAVLink's definitions.
const MESSAGES: &str = include_str!("../data/mavlink_messages.tsv");

/// A message as sent.
#[derive(Clone, Debug)]
pub(crate) struct MessageDefinition {
    pub(crate) id: u32,
    pub(crate) name: &'static str,
    fields: Vec<MessageField>,
    /// Number of fields that both versions have; the fields after them are extensions of version 2.
    base: usize,
    /// Extra byte of the checksum: it differs if sender and receiver define different fields.
    pub(crate) crc_extra: u8,
}

#[derive(Clone, Copy, Debug)]
struct MessageField {
    kind: &'static str,
    name: &'static str,
    count: Option<usize>,
}

impl MessageField {
    fn parse(text: &'static str) -> Option<MessageField> {
        let (kind, name) = text.split_once(':')?;
        Some(match kind.split_once('[') {
            None => MessageField { kind, name, count: None },
            Some((kind, count)) => MessageField { kind, name, count: count.strip_suffix(']')?.parse().ok() },
        })
    }

    fn size(self) -> usize {
        match self.kind {
            "u64" | "i64" | "f64" => 8,
            "u32" | "i32" | "f32" => 4,
            "u16" | "i16" => 2,
            _ => 1,
        }
    }

    #[cfg(test)]
    /// Returns the name of the type in MAVLink's definitions.
    fn long_kind(self) -> &'static str {
        match self.kind {
            "u64" => "uint64_t",
            "i64" => "int64_t",
            "f64" => "double",
            "u32" => "uint32_t",
            "i32" => "int32_t",
            "f32" => "float",
            "u16" => "uint16_t",
            "i16" => "int16_t",
            "i8" => "int8_t",
            "char" => "char",
            _ => "uint8_t",
        }
    }
}

/// Returns all definitions, in order of their numbers.
pub(crate) fn definitions() -> Vec<MessageDefinition> {
    MESSAGES.lines().filter_map(define).collect()
}

/// Parses a line of the table; `None` if it is malformed, which a test excludes.
fn define(line: &'static str) -> Option<MessageDefinition> {
    let mut columns = line.split('\t');
    let (id, name, crc_extra) = (columns.next()?.parse().ok()?, columns.next()?, columns.next()?.parse().ok()?);
    let mut fields: Vec<MessageField> = columns.next()?.split_whitespace().filter_map(MessageField::parse).collect();
    let base = fields.len();
    fields.extend(columns.next()?.split_whitespace().filter_map(MessageField::parse));
    Some(MessageDefinition { id, name, fields, base, crc_extra })
}

/// Initial value of the checksum.
pub(crate) const CRC_BEGIN: u16 = 0xffff;

/// Continues MAVLink's checksum (CRC-16/MCRF4XX) `crc` with `bytes`.
pub(crate) fn checksum(crc: u16, bytes: &[u8]) -> u16 {
    bytes.iter().fold(crc, |crc, byte| {
        let mixed = byte ^ crc.to_le_bytes()[0];
        let mixed = u16::from(mixed ^ (mixed << 4));
        (crc >> 8) ^ (mixed << 8) ^ (mixed << 3) ^ (mixed >> 4)
    })
}

impl MessageDefinition {
    /// Returns the names of all fields; each element of an array counts as a field.
    pub(crate) fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        for field in &self.fields {
            match field.count.filter(|_| field.kind != "char") {
                None => names.push(field.name.to_string()),
                Some(count) => names.extend((0..count).map(|index| format!("{}[{index}]", field.name))),
            }
        }
        names
    }

    /// Returns the values of a payload. Version 2 omits trailing zeros; version 1 has no `extensions`.
    pub(crate) fn values(&self, payload: &[u8], extensions: bool) -> Vec<Cell> {
        let mut padded = payload.to_vec();
        padded.resize(padded.len().max(usize::from(u8::MAX)), 0);
        let mut values = Vec::new();
        let mut at = 0;
        for (index, field) in self.fields.iter().enumerate() {
            let count = field.count.unwrap_or(1);
            let sent = extensions || index < self.base;
            if field.kind == "char" {
                let words = padded.get(at..at + count).unwrap_or_default();
                values.push(if sent { Cell::Text(text(words)) } else { Cell::Nothing });
                at += count;
                continue;
            }
            for _ in 0..count {
                let value = number(field.kind, &padded, at).filter(|_| sent);
                values.push(value.map_or(Cell::Nothing, Cell::Number));
                at += field.size();
            }
        }
        values
    }
}

fn number(kind: &str, bytes: &[u8], at: usize) -> Option<f64> {
    match kind {
        "u64" => u64_at(bytes, at).map(|number| number as f64),
        "i64" => array(bytes, at).map(i64::from_le_bytes).map(|number| number as f64),
        "f64" => array(bytes, at).map(f64::from_le_bytes),
        "u32" => u32_at(bytes, at).map(f64::from),
        "i32" => array(bytes, at).map(i32::from_le_bytes).map(f64::from),
        "f32" => array(bytes, at).map(f32::from_le_bytes).map(f64::from),
        "u16" => u16_at(bytes, at).map(f64::from),
        "i16" => array(bytes, at).map(i16::from_le_bytes).map(f64::from),
        "i8" => array(bytes, at).map(i8::from_le_bytes).map(f64::from),
        _ => bytes.get(at).map(|byte| f64::from(*byte)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the reference implementations.
    const CRC_EXTRAS: &[(&str, u8)] = &[
        ("HEARTBEAT", 50),
        ("SYS_STATUS", 124),
        ("SYSTEM_TIME", 137),
        ("GPS_RAW_INT", 24),
        ("RAW_IMU", 144),
        ("SCALED_PRESSURE", 115),
        ("ATTITUDE", 39),
        ("ATTITUDE_QUATERNION", 246),
        ("LOCAL_POSITION_NED", 185),
        ("GLOBAL_POSITION_INT", 104),
        ("RC_CHANNELS_RAW", 244),
        ("SERVO_OUTPUT_RAW", 222),
        ("MISSION_CURRENT", 28),
        ("MISSION_ITEM_REACHED", 11),
        ("NAV_CONTROLLER_OUTPUT", 183),
        ("RC_CHANNELS", 118),
        ("VFR_HUD", 20),
        ("RADIO_STATUS", 185),
        ("POWER_STATUS", 203),
        ("DISTANCE_SENSOR", 85),
        ("TERRAIN_REPORT", 1),
        ("ALTITUDE", 47),
        ("BATTERY_STATUS", 154),
        ("AHRS", 127),
        ("RADIO", 21),
        ("WIND", 1),
        ("RANGEFINDER", 83),
        ("AHRS2", 47),
        ("EKF_STATUS_REPORT", 71),
        ("VIBRATION", 90),
        ("STATUSTEXT", 83),
    ];

    #[test]
    fn definitions_agree_with_the_published_checksums() {
        let all = definitions();
        for (name, crc_extra) in CRC_EXTRAS {
            let found = all.iter().find(|definition| definition.name == *name);
            assert_eq!(found.map(|definition| definition.crc_extra), Some(*crc_extra), "{name}");
        }
    }

    /// `crc_extra` depends on the names, types, lengths and order of all fields. The test computes it from the fields that Apex
    /// reads, and compares it with the table, whose values come from the definitions.
    #[test]
    fn every_line_of_the_table_is_read_and_gives_its_checksum() {
        let all = definitions();
        assert_eq!(all.len(), MESSAGES.lines().count());
        assert!(all.len() > 300 && all.is_sorted_by(|one, other| one.id < other.id));
        for definition in &all {
            let mut crc = checksum(CRC_BEGIN, format!("{} ", definition.name).as_bytes());
            for field in definition.fields.iter().take(definition.base) {
                crc = checksum(crc, format!("{} {} ", field.long_kind(), field.name).as_bytes());
                if let Some(count) = field.count {
                    crc = checksum(crc, &[u8::try_from(count).unwrap()]);
                }
            }
            let [low, high] = crc.to_le_bytes();
            assert_eq!(definition.crc_extra, low ^ high, "{}", definition.name);
            let bytes: usize = definition.fields.iter().map(|field| field.size() * field.count.unwrap_or(1)).sum();
            assert!(bytes <= usize::from(u8::MAX), "{}: {bytes} bytes do not fit into a packet", definition.name);
        }
    }

    #[test]
    fn version_1_has_no_extension_and_version_2_ends_without_zeros() {
        let all = definitions();
        let gps = all.iter().find(|definition| definition.name == "GPS_RAW_INT").unwrap();
        let mut payload = vec![0; 30];
        payload.extend(1_234_i32.to_le_bytes());
        let at = |values: &[Cell], name: &str| values[gps.names().iter().position(|one| one == name).unwrap()].clone();
        let sent = gps.values(&payload, true);
        assert_eq!(at(&sent, "alt_ellipsoid"), Cell::Number(1_234.0));
        assert_eq!(at(&sent, "h_acc"), Cell::Number(0.0));
        assert_eq!(at(&gps.values(&payload[..30], false), "alt_ellipsoid"), Cell::Nothing);
    }
}
