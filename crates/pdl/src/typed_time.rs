//! Instants of mission time as they are typed at a prompt or in an option.

use crate::read_value;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Maximum hours of a clock time, so that its nanoseconds fit into 64 bits.
const FIRST_PART_MAX: f64 = 1e6;

/// Reads seconds (`90`, `2.5`), a PDL duration (`20s`, `2h`, `P1M30S`), or hours, minutes and seconds (`1:30:00`, `1:30`). `None` for any
/// other text. An instant before 0 is read too.
pub fn read_time(text: &str) -> Option<Time> {
    if text.contains(':') {
        return clock_time(text);
    }
    match read_value(text).ok()? {
        Value::Duration(Duration(nanoseconds)) => Some(Time(nanoseconds)),
        Value::Integer(seconds) => Some(Time::from_seconds(seconds as f64)),
        Value::Real(seconds) if seconds.is_finite() => Some(Time::from_seconds(seconds)),
        _ => None,
    }
}

/// Parses `1:30:00` or `1:30`: hours, minutes and seconds, or minutes and seconds.
fn clock_time(text: &str) -> Option<Time> {
    let parts: Vec<f64> = text.split(':').map(str::parse).collect::<Result<_, _>>().ok()?;
    let rest_in_range = parts.iter().skip(1).all(|part| (0.0..60.0).contains(part));
    let first_in_range = parts.first().is_some_and(|part| (0.0..FIRST_PART_MAX).contains(part));
    let seconds = parts.iter().fold(0.0, |seconds, part| seconds * 60.0 + part);
    (parts.len() <= 3 && first_in_range && rest_in_range).then(|| Time::from_seconds(seconds))
}

#[cfg(test)]
mod tests {
    use super::read_time;
    use apex_model::time::Time;

    #[test]
    fn times_are_seconds_durations_or_clock_times() {
        for (text, seconds) in
            [("90", 90.0), ("2.5", 2.5), ("2h", 7200.0), ("1:30", 90.0), ("1:30:00", 5400.0), ("-5", -5.0)]
        {
            assert_eq!(read_time(text), Some(Time::from_seconds(seconds)), "{text}");
        }
        for text in ["", "soon", "1:60", "1:2:3:4", "-1:30", "90m 5", "inf"] {
            assert_eq!(read_time(text), None, "{text}");
        }
    }
}
