//! Civil time of an instant of a mission, for files that other programs read.

use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

/// Returns `at_s` after `zero_unix_s` as RFC 3339 in whole seconds of UTC, for example `2007-09-08T02:30:00Z`.
pub(super) fn utc(zero_unix_s: Option<f64>, at_s: f64) -> Option<String> {
    let seconds = (zero_unix_s? + at_s).round();
    // Instants beyond these bounds (some 30,000 years) have no civil time.
    let time = (seconds.abs() < 1e12).then_some(seconds as i64)?;
    OffsetDateTime::from_unix_timestamp(time).ok()?.format(&Rfc3339).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_are_reported_in_utc() {
        assert_eq!(utc(Some(1_189_213_200.0), 5_400.4).as_deref(), Some("2007-09-08T02:30:00Z"));
        assert_eq!((utc(None, 0.0), utc(Some(f64::NAN), 0.0), utc(Some(1e300), 0.0)), (None, None, None));
    }
}
