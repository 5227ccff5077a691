//! The civil time of a log: the reading of the log's clock at an instant of UTC.

use crate::{Cell, Format, LogReader, Message};
use apex_model::time::Time;
use std::io;

/// A clock that shows more than this, in nanoseconds, counts from 1970: 10^9 s were over in September 2001.
const EPOCH_NS_MIN: i64 = 1_000_000_000_000_000_000;
/// Beginning of the time of GPS, 1980-01-06, in nanoseconds of UTC.
const GPS_EPOCH_NS: i64 = 315_964_800_000_000_000;
/// Seconds that GPS is ahead of UTC, from the week of GPS on (IERS Bulletin C); none was added after 2016.
const LEAP_SECONDS: [(f64, i64); 5] = [(1930.0, 18), (1851.0, 17), (1695.0, 16), (1512.0, 15), (0.0, 14)];

/// Returns the UTC, in nanoseconds, at zero of the log's clock; `None` if the log does not state it.
pub(crate) fn utc_of_clock(format: Format, reader: &mut dyn LogReader) -> io::Result<Option<i64>> {
    let mut message = Message::default();
    while reader.next(&mut message)? {
        let found = match format {
            Format::TelemetryLog | Format::Mcap | Format::Csv => {
                return Ok((message.at.0 > EPOCH_NS_MIN).then_some(0));
            }
            Format::ULog => of_ulog(&message, &|name| field(reader, &message, name)),
            Format::DataFlashBinary | Format::DataFlashText => of_dataflash(&|name| field(reader, &message, name)),
        };
        if let Some(utc) = found {
            return Ok(Some(utc - message.at.0));
        }
    }
    Ok(None)
}

/// Returns the civil time from `vehicle_gps_position.time_utc_usec`, in newer logs from `sensor_gps`.
fn of_ulog(message: &Message, number: &dyn Fn(&str) -> Option<f64>) -> Option<i64> {
    let names = ["vehicle_gps_position.time_utc_usec", "sensor_gps.time_utc_usec"];
    let us = names.into_iter().find_map(number).filter(|us| *us > 0.0 && message.at > Time::ZERO)?;
    Some(libm::rint(us * 1e3) as i64)
}

/// Returns the civil time from week and milliseconds of GPS, in old and new logs.
fn of_dataflash(number: &dyn Fn(&str) -> Option<f64>) -> Option<i64> {
    let week = number("GPS.GWk").or_else(|| number("GPS.Week")).filter(|week| *week > 0.0)?;
    let ms = number("GPS.GMS").or_else(|| number("GPS.TimeMS")).or_else(|| number("GPS.Time"))?;
    let leap = LEAP_SECONDS.iter().find(|(from, _)| week >= *from).map_or(0, |(_, seconds)| *seconds);
    Some(GPS_EPOCH_NS + (week as i64) * 604_800_000_000_000 + (ms as i64) * 1_000_000 - leap * 1_000_000_000)
}

fn field(reader: &dyn LogReader, message: &Message, name: &str) -> Option<f64> {
    let topic = reader.topics().get(message.topic)?;
    let wanted = name.strip_prefix(topic.name.as_str())?.strip_prefix('.')?;
    let index = topic.fields.iter().position(|field| field == wanted)?;
    match message.values.get(index) {
        Some(Cell::Number(number)) => Some(*number),
        _ => None,
    }
}
