//! Instants of the simulated world: whole milliseconds, so that every published time is exact and has few digits.

use apex_model::time::{Duration, NANOSECONDS_PER_SECOND, Time};

const NANOSECONDS_PER_MILLISECOND: i64 = NANOSECONDS_PER_SECOND / 1_000;

/// Rounds `at` up to a whole millisecond.
pub(crate) fn not_before(at: Time) -> Time {
    let up = at.0.checked_add(NANOSECONDS_PER_MILLISECOND - 1);
    up.map_or(at, |nanoseconds| Time(nanoseconds.div_euclid(NANOSECONDS_PER_MILLISECOND) * NANOSECONDS_PER_MILLISECOND))
}

/// Converts `seconds` to a duration, rounded to the nearest millisecond.
pub(crate) fn span(seconds: f64) -> Duration {
    let milliseconds = libm::round(seconds * 1e3) as i64;
    Duration(milliseconds.saturating_mul(NANOSECONDS_PER_MILLISECOND))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_are_rounded_up_and_spans_to_the_nearest() {
        assert_eq!(not_before(Time(1)), Time(1_000_000));
        assert_eq!(not_before(Time(2_000_000)), Time(2_000_000));
        assert_eq!(not_before(Time(-1)), Time::ZERO);
        assert_eq!(not_before(Time::END), Time::END);
        assert_eq!(span(57.546_988_764), Duration(57_547_000_000));
        assert_eq!(span(f64::INFINITY), Duration(i64::MAX));
    }
}
