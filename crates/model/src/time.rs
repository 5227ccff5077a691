//! Time as a value.
//!
//! Signed 64-bit nanoseconds of mission time everywhere; time stamps of other clocks are converted where they arrive.
//! PDL: durations and time points (`pdl.md`, Text). Paper: section III, histories.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::{Add, Neg, Sub};

/// Nanoseconds in one second.
pub const NANOSECONDS_PER_SECOND: i64 = 1_000_000_000;

/// A signed span of time in nanoseconds.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Duration(pub i64);

/// An instant of mission time: nanoseconds since the mission began. The executive uses no other times.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Time(pub i64);

impl Duration {
    /// No time at all.
    pub const ZERO: Duration = Duration(0);
    /// Longer than every mission; arithmetic saturates here.
    pub const MAX: Duration = Duration(i64::MAX);

    /// Returns the nearest duration to `seconds`; not-a-number is zero, infinities saturate.
    pub fn from_seconds(seconds: f64) -> Duration {
        Duration(libm::round(seconds * NANOSECONDS_PER_SECOND as f64) as i64)
    }

    /// Returns the duration in seconds.
    pub fn seconds(self) -> f64 {
        self.0 as f64 / NANOSECONDS_PER_SECOND as f64
    }
}

impl Time {
    /// The start of the mission.
    pub const ZERO: Time = Time(0);
    /// `+beginning-of-time+`: before every event.
    pub const BEGINNING: Time = Time(i64::MIN);
    /// `+end-of-time+`: after every event.
    pub const END: Time = Time(i64::MAX);

    /// Returns the instant `seconds` after the start of the mission.
    pub fn from_seconds(seconds: f64) -> Time {
        Time(Duration::from_seconds(seconds).0)
    }

    /// Returns seconds since the start of the mission.
    pub fn seconds(self) -> f64 {
        Duration(self.0).seconds()
    }
}

impl Add<Duration> for Time {
    type Output = Time;
    fn add(self, other: Duration) -> Time {
        Time(self.0.saturating_add(other.0))
    }
}

impl Sub<Duration> for Time {
    type Output = Time;
    fn sub(self, other: Duration) -> Time {
        Time(self.0.saturating_sub(other.0))
    }
}

impl Sub for Time {
    type Output = Duration;
    fn sub(self, other: Time) -> Duration {
        Duration(self.0.saturating_sub(other.0))
    }
}

impl Add for Duration {
    type Output = Duration;
    fn add(self, other: Duration) -> Duration {
        Duration(self.0.saturating_add(other.0))
    }
}

impl Sub for Duration {
    type Output = Duration;
    fn sub(self, other: Duration) -> Duration {
        Duration(self.0.saturating_sub(other.0))
    }
}

impl Neg for Duration {
    type Output = Duration;
    fn neg(self) -> Duration {
        Duration(self.0.saturating_neg())
    }
}

impl fmt::Display for Duration {
    /// Writes ISO 8601 with the short spelling of the original language: `P1H3M4.5S`, `P0S`, `-P2S`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let total = self.0.unsigned_abs();
        if self.0 < 0 {
            f.write_str("-")?;
        }
        f.write_str("P")?;
        let second = NANOSECONDS_PER_SECOND as u64;
        let (hours, minutes) = (total / (3600 * second), total / (60 * second) % 60);
        let (seconds, fraction) = (total / second % 60, total % second);
        if hours > 0 {
            write!(f, "{hours}H")?;
        }
        if minutes > 0 {
            write!(f, "{minutes}M")?;
        }
        if fraction > 0 {
            let digits = format!("{fraction:09}");
            write!(f, "{seconds}.{}S", digits.trim_end_matches('0'))
        } else if seconds > 0 || (hours == 0 && minutes == 0) {
            write!(f, "{seconds}S")
        } else {
            Ok(())
        }
    }
}

impl fmt::Display for Time {
    /// Writes mission elapsed time for operators: `12.5s`, `1:03:04.5`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Time::BEGINNING => return f.write_str("the beginning of time"),
            Time::END => return f.write_str("the end of time"),
            Time(_) => {}
        }
        let sign = if self.0 < 0 { "-" } else { "" };
        let total = self.0.unsigned_abs();
        let second = NANOSECONDS_PER_SECOND as u64;
        let digits = format!("{:09}", total % second);
        let fraction = match digits.trim_end_matches('0') {
            "" => String::new(),
            some => format!(".{some}"),
        };
        if total < 60 * second {
            write!(f, "{sign}{}{fraction}s", total / second)
        } else {
            let (hours, minutes) = (total / (3600 * second), total / (60 * second) % 60);
            write!(f, "{sign}{hours}:{minutes:02}:{:02}{fraction}", total / second % 60)
        }
    }
}

impl fmt::Debug for Duration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Debug for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_print_in_the_manuals_spelling() {
        assert_eq!(Duration::from_seconds(3784.5).to_string(), "P1H3M4.5S");
        assert_eq!(Duration::ZERO.to_string(), "P0S");
        assert_eq!(Duration::from_seconds(-7200.0).to_string(), "-P2H");
    }

    #[test]
    fn arithmetic_saturates_instead_of_wrapping() {
        assert_eq!(Time::END + Duration::from_seconds(1.0), Time::END);
        assert_eq!(Time::END - Time::BEGINNING, Duration::MAX);
    }
}
