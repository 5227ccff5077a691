//! The values of a trace line and their JSON form, which programs read: a change here is a change of an interface.

use apex_model::time::{NANOSECONDS_PER_SECOND, Time};
use apex_model::value::Value;
use serde::{Serialize, Serializer};
use serde_json::ser::Formatter;
use std::io::{self, Write};

/// A value of a trace line.
#[derive(Clone, Debug)]
pub(super) enum FieldValue {
    /// A text; values without a JSON form are PDL text.
    Text(String),
    /// The number of a command, request or question.
    Number(u64),
    /// A whole number.
    Integer(i64),
    /// A finite real.
    Real(f64),
    /// An instant or a length in seconds.
    Seconds(Time),
    /// Several values.
    List(Vec<FieldValue>),
}

impl From<u64> for FieldValue {
    fn from(number: u64) -> FieldValue {
        FieldValue::Number(number)
    }
}

impl From<Time> for FieldValue {
    fn from(time: Time) -> FieldValue {
        FieldValue::Seconds(time)
    }
}

impl From<&Value> for FieldValue {
    /// Returns a number for a plain number, otherwise PDL text.
    fn from(value: &Value) -> FieldValue {
        FieldValue::of(value, value.to_string())
    }
}

impl FieldValue {
    /// Returns what `from` returns for a value whose PDL text is known.
    pub(super) fn of(value: &Value, text: String) -> FieldValue {
        match value {
            Value::Integer(integer) => FieldValue::Integer(*integer),
            Value::Real(real) if real.is_finite() => FieldValue::Real(*real),
            Value::Text(text) => FieldValue::Text(text.to_string()),
            _ => FieldValue::Text(text),
        }
    }
}

impl Serialize for FieldValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            FieldValue::Text(text) => serializer.serialize_str(text),
            FieldValue::Number(number) => serializer.serialize_u64(*number),
            FieldValue::Integer(integer) => serializer.serialize_i64(*integer),
            FieldValue::Real(real) => serializer.serialize_f64(*real),
            // A float would lose nanoseconds of long flights; see `LineFormatter`.
            FieldValue::Seconds(time) => serializer.serialize_i128(time.0.into()),
            FieldValue::List(values) => serializer.collect_seq(values),
        }
    }
}

/// Compact JSON with the number format of trace lines: reals as Rust prints them (`1e-5`, `12.0`), and instants, which are passed as
/// 128-bit nanoseconds, as exact seconds.
pub(super) struct LineFormatter;

impl Formatter for LineFormatter {
    fn write_i128<W: ?Sized + Write>(&mut self, writer: &mut W, nanoseconds: i128) -> io::Result<()> {
        let nanoseconds = i64::try_from(nanoseconds).map_err(io::Error::other)?;
        writer.write_all(seconds_text(Time(nanoseconds)).as_bytes())
    }

    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        write!(writer, "{value:?}")
    }

    /// Escapes control characters that JSON permits and a terminal would obey: DEL and the second set.
    fn write_string_fragment<W: ?Sized + Write>(&mut self, writer: &mut W, fragment: &str) -> io::Result<()> {
        let is_unsafe = |each: char| matches!(each, '\u{7f}'..='\u{9f}');
        for part in fragment.split_inclusive(is_unsafe) {
            match part.char_indices().next_back() {
                Some((at, last)) if is_unsafe(last) => {
                    writer.write_all(part.as_bytes().get(..at).unwrap_or_default())?;
                    write!(writer, "\\u{:04x}", u32::from(last))?;
                }
                _ => writer.write_all(part.as_bytes())?,
            }
        }
        Ok(())
    }
}

/// Returns seconds as the shortest exact decimal: `1.5`, `0.3`, `-2`, never `0.30000000000000004`.
pub fn seconds_text(time: Time) -> String {
    let total = time.0.unsigned_abs();
    let second = NANOSECONDS_PER_SECOND.unsigned_abs();
    let sign = if time.0 < 0 { "-" } else { "" };
    let digits = format!("{:09}", total % second);
    match digits.trim_end_matches('0') {
        "" => format!("{sign}{}", total / second),
        fraction => format!("{sign}{}.{fraction}", total / second),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn json(value: impl Into<FieldValue>) -> String {
        let mut out = Vec::new();
        value.into().serialize(&mut serde_json::Serializer::with_formatter(&mut out, LineFormatter)).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn seconds_are_exact_and_short() {
        let cases =
            [(300_000_000, "0.3"), (1_500_000_000, "1.5"), (-2_000_000_000, "-2"), (1, "0.000000001"), (0, "0")];
        for (nanoseconds, text) in cases {
            assert_eq!(seconds_text(Time(nanoseconds)), text);
            assert_eq!(json(Time(nanoseconds)), text);
        }
        assert_eq!(json(Time(i64::MAX)), "9223372036.854775807");
    }

    #[test]
    fn values_are_json_whatever_they_hold() {
        assert_eq!(json(&Value::Real(f64::NAN)), "\"NaN\"");
        assert_eq!(json(&Value::Real(1e300)), "1e300");
        assert_eq!(json(&Value::Real(1e-5)), "1e-5");
        assert_eq!(json(&Value::Real(12.0)), "12.0");
        assert_eq!(json(&Value::text("a\u{9b}2Jü\u{7f}")), "\"a\\u009b2Jü\\u007f\"");
        assert_eq!(json(&Value::Integer(i64::MIN)), i64::MIN.to_string());
        assert_eq!(json(&Value::text("say \"hi\"\n")), r#""say \"hi\"\n""#);
        assert_eq!(json(&Value::list([Value::Integer(1), Value::symbol("A")])), "\"(1 A)\"");
    }
}
