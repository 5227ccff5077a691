//! The time column of a table: its detection, its unit, and the conversion of its texts to exact instants.

use apex_model::time::Time;

/// Names of time columns, the preferred ones first.
const NAMES: &[&str] = &[
    "t",
    "time",
    "timestamp",
    "datetime",
    "date time",
    "elapsed",
    "elapsed time",
    "mission time",
    "epoch",
    "unix",
    "unix time",
    "epoch time",
    "utc",
    "utc time",
    "gps time",
    "date",
];
/// Units of time in names of columns, with their nanoseconds.
const UNITS: &[(&str, i64)] = &[
    ("s", 1_000_000_000),
    ("sec", 1_000_000_000),
    ("secs", 1_000_000_000),
    ("second", 1_000_000_000),
    ("seconds", 1_000_000_000),
    ("ms", 1_000_000),
    ("msec", 1_000_000),
    ("milliseconds", 1_000_000),
    ("us", 1_000),
    ("usec", 1_000),
    ("µs", 1_000),
    ("microseconds", 1_000),
    ("ns", 1),
    ("nsec", 1),
    ("nanoseconds", 1),
    ("min", 60_000_000_000),
    ("minutes", 60_000_000_000),
    ("h", 3_600_000_000_000),
    ("hours", 3_600_000_000_000),
];
/// Limits of numbers without a unit: below the first they are seconds, below the second milliseconds, below the third
/// microseconds. As seconds since 1970, 10^11 lies in the year 5138; as milliseconds, in 1973.
const EPOCHS: [(u64, i64); 3] =
    [(100_000_000_000, 1_000_000_000), (100_000_000_000_000, 1_000_000), (100_000_000_000_000_000, 1_000)];
/// Maximum number of digits behind the decimal point that are read.
const DIGITS_MAX: usize = 18;

/// The column that holds the time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimeColumn {
    pub(crate) index: usize,
    /// Nanoseconds of the column's unit; `None` until the first number reveals it.
    unit_ns: Option<i64>,
    /// The last time of day, and the number of midnights before it.
    clock: Option<(Time, i64)>,
}

impl TimeColumn {
    /// Returns the column called `name`. Without `unit_ns`, its name or its first number determines the unit.
    pub(crate) fn named(fields: &[String], name: &str, unit_ns: Option<i64>) -> Option<TimeColumn> {
        let index = fields.iter().position(|field| field.eq_ignore_ascii_case(name))?;
        let of_name = fields.get(index).and_then(|field| split(field).1);
        Some(TimeColumn { index, unit_ns: unit_ns.or(of_name), clock: None })
    }

    /// Returns the column with the most preferred time name; `None` if no column has such a name.
    pub(crate) fn find(fields: &[String]) -> Option<TimeColumn> {
        let split: Vec<(String, Option<i64>)> = fields.iter().map(|field| split(field)).collect();
        NAMES.iter().find_map(|name| {
            let index = split.iter().position(|(base, _)| base == name)?;
            Some(TimeColumn { index, unit_ns: split.get(index)?.1, clock: None })
        })
    }

    /// Returns the instant of `text`: a number in the column's unit, a date with a time (ISO 8601; UTC without a zone), or a time of
    /// day, which is of the next day if it is over twelve hours before the last one. `None` if it is none of these or lies beyond 292
    /// years.
    pub(crate) fn instant(&mut self, text: &str) -> Option<Time> {
        if let Some(decimal) = Decimal::parse(text) {
            let unit_ns = *self.unit_ns.get_or_insert_with(|| {
                let epoch = EPOCHS.iter().find(|(below, _)| decimal.whole < u128::from(*below));
                epoch.map_or(1, |(_, unit)| *unit)
            });
            return decimal.times(unit_ns);
        }
        if let Ok(number) = text.parse::<f64>() {
            let nanoseconds = libm::rint(number * self.unit_ns.unwrap_or(1_000_000_000) as f64);
            // Nanoseconds below 2^63 (9.22e18) fit into an `i64`.
            return (nanoseconds.abs() < 9.2e18).then_some(Time(nanoseconds as i64));
        }
        match clock(text) {
            Some(time) => Some(self.of_day(time)),
            None => civil_instant(text),
        }
    }

    /// Returns the time of day with the midnights that have passed since the first one. A time that is a little earlier than the last one
    /// is a row out of order, and one before midnight after rows from behind it is of the day before.
    fn of_day(&mut self, time: Time) -> Time {
        let (last, days) = self.clock.unwrap_or((time, 0));
        let days = match time - last {
            fallen if fallen.0 < -HALF_DAY_NS => days + 1,
            risen if risen.0 > HALF_DAY_NS && days > 0 => days - 1,
            _ => days,
        };
        self.clock = Some((time, days));
        Time(time.0 + days * DAY_NS)
    }
}

/// Splits the name of a column into the name without unit, in lower case with single spaces, and the nanoseconds of the unit.
fn split(name: &str) -> (String, Option<i64>) {
    let spaced: String = name
        .to_lowercase()
        .chars()
        .map(|letter| if letter.is_whitespace() || "_-()[]/.".contains(letter) { ' ' } else { letter })
        .collect();
    let mut words: Vec<&str> = spaced.split(' ').filter(|word| !word.is_empty()).collect();
    let unit = words.last().and_then(|last| UNITS.iter().find(|(unit, _)| unit == last)).map(|(_, unit)| *unit);
    if unit.is_some() && words.len() > 1 {
        words.pop();
        return (words.join(" "), unit);
    }
    (words.join(" "), None)
}

/// A decimal number without an exponent.
struct Decimal {
    negative: bool,
    whole: u128,
    /// The digits behind the point as a whole number, and ten to the power of their count.
    part: u128,
    scale: u128,
}

impl Decimal {
    fn parse(text: &str) -> Option<Decimal> {
        let (negative, digits) = match text.strip_prefix('-') {
            Some(rest) => (true, rest),
            None => (false, text.strip_prefix('+').unwrap_or(text)),
        };
        let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
        let all_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
        if whole.len() + part.len() == 0 || whole.len() > 30 || !all_digits(whole) || !all_digits(part) {
            return None;
        }
        let part = part.get(..DIGITS_MAX).unwrap_or(part);
        let number = |text: &str| if text.is_empty() { Some(0) } else { text.parse().ok() };
        let scale = 10_u128.pow(u32::try_from(part.len()).ok()?);
        Some(Decimal { negative, whole: number(whole)?, part: number(part)?, scale })
    }

    /// Returns this number of units of `unit_ns` nanoseconds, rounded to the nearest nanosecond.
    fn times(&self, unit_ns: i64) -> Option<Time> {
        let unit = u128::try_from(unit_ns).ok()?;
        let size = self.whole.checked_mul(unit)?.checked_add((self.part * unit + self.scale / 2) / self.scale)?;
        let size = i64::try_from(size).ok()?;
        Some(Time(if self.negative { -size } else { size }))
    }
}

/// Parses `2023-11-14T22:13:20.5+01:00` or `2023-11-14`.
fn civil_instant(text: &str) -> Option<Time> {
    let Some((date, rest)) = text.split_once(['T', 't', ' ']) else {
        return Some(Time(days(text)?.checked_mul(DAY_NS)?));
    };
    let (clock_text, zone_ns) = zone(rest.trim())?;
    let at = days(date)?.checked_mul(DAY_NS)?.checked_add(clock(clock_text)?.0)?;
    Some(Time(at.checked_sub(zone_ns)?))
}

const DAY_NS: i64 = 86_400_000_000_000;
const HALF_DAY_NS: i64 = DAY_NS / 2;

/// Splits off the time zone: returns the text before it, and its offset from UTC in nanoseconds.
fn zone(text: &str) -> Option<(&str, i64)> {
    let text = text.trim_end_matches("UTC").trim_end();
    if let Some(before) = text.strip_suffix(['Z', 'z']) {
        return Some((before, 0));
    }
    let Some(sign) = text.rfind(['+', '-']) else { return Some((text, 0)) };
    let (before, offset) = (text.get(..sign)?, text.get(sign + 1..)?);
    let (hours, minutes) = match offset.split_once(':') {
        Some(parts) => parts,
        None if offset.len() == 4 => offset.split_at_checked(2)?,
        None => (offset, "0"),
    };
    let (hours, minutes): (i64, i64) = (hours.parse().ok()?, minutes.parse().ok()?);
    let size = (hours * 60 + minutes) * 60_000_000_000;
    (hours < 24 && minutes < 60).then_some((before, if text.get(sign..)?.starts_with('-') { -size } else { size }))
}

/// Parses the time of day `22:13:20.5`; returns the time since midnight.
fn clock(text: &str) -> Option<Time> {
    let mut parts = text.trim().splitn(3, ':');
    let (hours, minutes) = (parts.next()?.parse::<u32>().ok()?, parts.next()?.parse::<u32>().ok()?);
    let seconds =
        parts.next().map_or(Some(Time::ZERO), |text| Decimal::parse(&text.replace(',', "."))?.times(1_000_000_000))?;
    let whole = i64::from(hours * 60 + minutes) * 60_000_000_000;
    let inside = hours < 24 && minutes < 60 && (0..61_000_000_000).contains(&seconds.0);
    inside.then_some(Time(whole + seconds.0))
}

/// Parses a date of the Gregorian calendar; returns the days since 1970-01-01.
fn days(text: &str) -> Option<i64> {
    let mut parts = text.trim().splitn(3, ['-', '/']);
    let mut next = || parts.next()?.parse::<i64>().ok();
    let (year, month, day) = (next()?, next()?, next()?);
    if !(1..=9_999).contains(&year) || !(1..=12).contains(&month) || !(1..=length_of(year, month)).contains(&day) {
        return None;
    }
    let months: i64 = (1..month).map(|month| length_of(year, month)).sum();
    let before = year - 1;
    let leap_days = |year: i64| year / 4 - year / 100 + year / 400;
    let since = before * 365 + leap_days(before) - (1_969 * 365 + leap_days(1_969));
    Some(since + months + day - 1)
}

fn length_of(year: i64, month: i64) -> i64 {
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    match month {
        2 if leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}
