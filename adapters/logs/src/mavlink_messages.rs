//! Messages of MAVLink that are read field by field (mavlink.io, common.xml and ardupilotmega.xml): numbers, names, and fields
//! in the order in which they are sent.

use crate::Cell;
use crate::bytes::{array, text, u16_at, u32_at, u64_at};

/// Number, name, and fields as `type:name`.
const MESSAGES: &[(u32, &str, &str)] = &[
    (0, "HEARTBEAT", "u32:custom_mode u8:type u8:autopilot u8:base_mode u8:system_status u8:mavlink_version"),
    (
        1,
        "SYS_STATUS",
        "u32:onboard_control_sensors_present u32:onboard_control_sensors_enabled \
         u32:onboard_control_sensors_health u16:load u16:voltage_battery i16:current_battery \
         u16:drop_rate_comm u16:errors_comm u16:errors_count1 u16:errors_count2 u16:errors_count3 \
         u16:errors_count4 i8:battery_remaining",
    ),
    (2, "SYSTEM_TIME", "u64:time_unix_usec u32:time_boot_ms"),
    (
        24,
        "GPS_RAW_INT",
        "u64:time_usec i32:lat i32:lon i32:alt u16:eph u16:epv u16:vel u16:cog u8:fix_type \
         u8:satellites_visible",
    ),
    (
        27,
        "RAW_IMU",
        "u64:time_usec i16:xacc i16:yacc i16:zacc i16:xgyro i16:ygyro i16:zgyro i16:xmag i16:ymag \
         i16:zmag",
    ),
    (29, "SCALED_PRESSURE", "u32:time_boot_ms f32:press_abs f32:press_diff i16:temperature"),
    (30, "ATTITUDE", "u32:time_boot_ms f32:roll f32:pitch f32:yaw f32:rollspeed f32:pitchspeed f32:yawspeed"),
    (
        31,
        "ATTITUDE_QUATERNION",
        "u32:time_boot_ms f32:q1 f32:q2 f32:q3 f32:q4 f32:rollspeed f32:pitchspeed f32:yawspeed",
    ),
    (32, "LOCAL_POSITION_NED", "u32:time_boot_ms f32:x f32:y f32:z f32:vx f32:vy f32:vz"),
    (
        33,
        "GLOBAL_POSITION_INT",
        "u32:time_boot_ms i32:lat i32:lon i32:alt i32:relative_alt i16:vx i16:vy i16:vz u16:hdg",
    ),
    (
        35,
        "RC_CHANNELS_RAW",
        "u32:time_boot_ms u16:chan1_raw u16:chan2_raw u16:chan3_raw u16:chan4_raw u16:chan5_raw \
         u16:chan6_raw u16:chan7_raw u16:chan8_raw u8:port u8:rssi",
    ),
    (
        36,
        "SERVO_OUTPUT_RAW",
        "u32:time_usec u16:servo1_raw u16:servo2_raw u16:servo3_raw u16:servo4_raw u16:servo5_raw \
         u16:servo6_raw u16:servo7_raw u16:servo8_raw u8:port",
    ),
    (42, "MISSION_CURRENT", "u16:seq"),
    (46, "MISSION_ITEM_REACHED", "u16:seq"),
    (
        62,
        "NAV_CONTROLLER_OUTPUT",
        "f32:nav_roll f32:nav_pitch f32:alt_error f32:aspd_error f32:xtrack_error i16:nav_bearing \
         i16:target_bearing u16:wp_dist",
    ),
    (
        65,
        "RC_CHANNELS",
        "u32:time_boot_ms u16:chan1_raw u16:chan2_raw u16:chan3_raw u16:chan4_raw u16:chan5_raw \
         u16:chan6_raw u16:chan7_raw u16:chan8_raw u16:chan9_raw u16:chan10_raw u16:chan11_raw \
         u16:chan12_raw u16:chan13_raw u16:chan14_raw u16:chan15_raw u16:chan16_raw u16:chan17_raw \
         u16:chan18_raw u8:chancount u8:rssi",
    ),
    (74, "VFR_HUD", "f32:airspeed f32:groundspeed f32:alt f32:climb i16:heading u16:throttle"),
    (109, "RADIO_STATUS", "u16:rxerrors u16:fixed u8:rssi u8:remrssi u8:txbuf u8:noise u8:remnoise"),
    (125, "POWER_STATUS", "u16:Vcc u16:Vservo u16:flags"),
    (
        132,
        "DISTANCE_SENSOR",
        "u32:time_boot_ms u16:min_distance u16:max_distance u16:current_distance u8:type u8:id \
         u8:orientation u8:covariance",
    ),
    (136, "TERRAIN_REPORT", "i32:lat i32:lon f32:terrain_height f32:current_height u16:spacing u16:pending u16:loaded"),
    (
        141,
        "ALTITUDE",
        "u64:time_usec f32:altitude_monotonic f32:altitude_amsl f32:altitude_local f32:altitude_relative \
         f32:altitude_terrain f32:bottom_clearance",
    ),
    (
        147,
        "BATTERY_STATUS",
        "i32:current_consumed i32:energy_consumed i16:temperature u16[10]:voltages i16:current_battery \
         u8:id u8:battery_function u8:type i8:battery_remaining",
    ),
    (163, "AHRS", "f32:omegaIx f32:omegaIy f32:omegaIz f32:accel_weight f32:renorm_val f32:error_rp f32:error_yaw"),
    (166, "RADIO", "u16:rxerrors u16:fixed u8:rssi u8:remrssi u8:txbuf u8:noise u8:remnoise"),
    (168, "WIND", "f32:direction f32:speed f32:speed_z"),
    (173, "RANGEFINDER", "f32:distance f32:voltage"),
    (178, "AHRS2", "f32:roll f32:pitch f32:yaw f32:altitude i32:lat i32:lng"),
    (
        193,
        "EKF_STATUS_REPORT",
        "f32:velocity_variance f32:pos_horiz_variance f32:pos_vert_variance f32:compass_variance \
         f32:terrain_alt_variance u16:flags",
    ),
    (
        241,
        "VIBRATION",
        "u64:time_usec f32:vibration_x f32:vibration_y f32:vibration_z u32:clipping_0 u32:clipping_1 \
         u32:clipping_2",
    ),
    (253, "STATUSTEXT", "u8:severity char[50]:text"),
];

/// A message as it is sent.
#[derive(Clone, Debug)]
pub(crate) struct Definition {
    pub(crate) id: u32,
    pub(crate) name: &'static str,
    fields: Vec<Field>,
    /// Goes into the checksum, so that sender and receiver mean the same fields.
    pub(crate) crc_extra: u8,
}

#[derive(Clone, Copy, Debug)]
struct Field {
    kind: &'static str,
    name: &'static str,
    count: Option<usize>,
}

impl Field {
    fn parse(text: &'static str) -> Option<Field> {
        let (kind, name) = text.split_once(':')?;
        Some(match kind.split_once('[') {
            None => Field { kind, name, count: None },
            Some((kind, count)) => Field { kind, name, count: count.strip_suffix(']')?.parse().ok() },
        })
    }

    fn size(self) -> usize {
        match self.kind {
            "u64" => 8,
            "u32" | "i32" | "f32" => 4,
            "u16" | "i16" => 2,
            _ => 1,
        }
    }

    /// The type's name in MAVLink's definitions.
    fn long_kind(self) -> &'static str {
        match self.kind {
            "u64" => "uint64_t",
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

/// All definitions, in order of their numbers.
pub(crate) fn definitions() -> Vec<Definition> {
    MESSAGES.iter().map(|(id, name, fields)| define(*id, name, fields)).collect()
}

fn define(id: u32, name: &'static str, fields: &'static str) -> Definition {
    let fields: Vec<Field> = fields.split_whitespace().filter_map(Field::parse).collect();
    let mut crc = checksum(CRC_BEGIN, format!("{name} ").as_bytes());
    for field in &fields {
        crc = checksum(crc, format!("{} {} ", field.long_kind(), field.name).as_bytes());
        if let Some(count) = field.count {
            crc = checksum(crc, &[u8::try_from(count).unwrap_or(u8::MAX)]);
        }
    }
    let [low, high] = crc.to_le_bytes();
    Definition { id, name, fields, crc_extra: low ^ high }
}

/// Before the first byte.
pub(crate) const CRC_BEGIN: u16 = 0xffff;

/// MAVLink's checksum, CRC-16/MCRF4XX, over `bytes` after those that `crc` covers.
pub(crate) fn checksum(crc: u16, bytes: &[u8]) -> u16 {
    bytes.iter().fold(crc, |crc, byte| {
        let mixed = byte ^ crc.to_le_bytes()[0];
        let mixed = u16::from(mixed ^ (mixed << 4));
        (crc >> 8) ^ (mixed << 8) ^ (mixed << 3) ^ (mixed >> 4)
    })
}

impl Definition {
    /// The names of its fields, elements of arrays apart.
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

    /// The values in a payload. Zeros at the end are not sent.
    pub(crate) fn values(&self, payload: &[u8]) -> Vec<Cell> {
        let mut padded = payload.to_vec();
        padded.resize(padded.len().max(usize::from(u8::MAX)), 0);
        let mut values = Vec::new();
        let mut at = 0;
        for field in &self.fields {
            let count = field.count.unwrap_or(1);
            if field.kind == "char" {
                values.push(Cell::Text(text(padded.get(at..at + count).unwrap_or_default())));
                at += count;
                continue;
            }
            for _ in 0..count {
                values.push(number(field.kind, &padded, at).map_or(Cell::Nothing, Cell::Number));
                at += field.size();
            }
        }
        values
    }
}

fn number(kind: &str, bytes: &[u8], at: usize) -> Option<f64> {
    match kind {
        "u64" => u64_at(bytes, at).map(|number| number as f64),
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

    /// As the reference implementations have them.
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
        for (definition, (name, crc_extra)) in definitions().iter().zip(CRC_EXTRAS) {
            assert_eq!((definition.name, definition.crc_extra), (*name, *crc_extra));
        }
        assert_eq!(definitions().len(), CRC_EXTRAS.len());
        assert!(definitions().is_sorted_by_key(|definition| definition.id));
    }
}
