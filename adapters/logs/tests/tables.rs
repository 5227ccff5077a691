//! Tables as written by spreadsheets and other programs: times in many forms, separators, decimal commas; no row is lost silently.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "what cannot be read is a failed test")]

use apex_logs::{Cell, Format, Message, ReadErrors};
use proptest::prelude::*;

/// Returns the instant of each row in nanoseconds with the cell of its last column, and the read errors.
fn rows(text: &str) -> (Vec<(i64, Cell)>, ReadErrors) {
    let mut reader = Format::Csv.reader(text.as_bytes(), None);
    let (mut message, mut found) = (Message::default(), Vec::new());
    while reader.next(&mut message).unwrap() {
        found.push((message.at.0, message.values.last().cloned().unwrap_or_default()));
    }
    (found, reader.damages().clone())
}

fn instants(text: &str) -> Vec<i64> {
    let (rows, damages) = rows(text);
    assert_eq!(damages.count, 0, "{text}: {damages:?}");
    rows.into_iter().map(|(at, _)| at).collect()
}

const SECOND: i64 = 1_000_000_000;

#[test]
fn times_are_read_in_every_usual_form() {
    for (header, first, second, expected) in [
        ("t", "1.5", "2", [SECOND * 3 / 2, SECOND * 2]),
        ("time (s)", "1.5", "2", [SECOND * 3 / 2, SECOND * 2]),
        ("Time [ms]", "1500", "2000", [SECOND * 3 / 2, SECOND * 2]),
        ("timestamp_us", "1500000", "2000000", [SECOND * 3 / 2, SECOND * 2]),
        ("elapsed time/ns", "1500000000", "2000000000", [SECOND * 3 / 2, SECOND * 2]),
        ("t (min)", "0.5", "1", [SECOND * 30, SECOND * 60]),
        // The magnitude of the first number shows the unit: seconds, milliseconds or microseconds since 1970.
        ("timestamp", "1700000000.123456789", "1700000001", [1_700_000_000_123_456_789, 1_700_000_001 * SECOND]),
        ("timestamp", "1700000000123", "1700000001000", [1_700_000_000_123_000_000, 1_700_000_001 * SECOND]),
        ("timestamp", "1700000000123456", "1700000001000000", [1_700_000_000_123_456_000, 1_700_000_001 * SECOND]),
        (
            "timestamp",
            "1700000000123456789",
            "1700000001000000000",
            [1_700_000_000_123_456_789, 1_700_000_001 * SECOND],
        ),
        (
            "datetime",
            "2023-11-14T22:13:20.5Z",
            "2023-11-14T23:13:21+01:00",
            [1_700_000_000_500_000_000, 1_700_000_001 * SECOND],
        ),
        ("UTC", "2023-11-14 22:13:20", "2023-11-14 22:13:21", [1_700_000_000 * SECOND, 1_700_000_001 * SECOND]),
        ("time", "00:01:00.25", "00:01:01", [60_250_000_000, 61 * SECOND]),
    ] {
        let text = format!("{header},v\n{first},1\n{second},2\n");
        assert_eq!(instants(&text), expected, "{header} {first}");
    }
}

/// The clock begins again at midnight; rows around midnight may be out of order by a little.
#[test]
fn times_of_day_continue_after_midnight() {
    let day = 86_400 * SECOND;
    let text =
        "time,v\n23:59:58,1\n00:00:00.5,2\n23:59:59,3\n00:00:02,4\n12:00:00,5\n11:59:59,6\n23:30:00,7\n00:10:00,8\n";
    let expected = [
        day - 2 * SECOND,
        day + SECOND / 2,
        day - SECOND,
        day + 2 * SECOND,
        day + 43_200 * SECOND,
        day + 43_199 * SECOND,
    ];
    assert_eq!(instants(text).get(..6), Some(expected.as_slice()));
    assert_eq!(instants(text).get(6..), Some([2 * day - 1_800 * SECOND, 2 * day + 600 * SECOND].as_slice()));
    // A single evening is not of another day.
    assert_eq!(instants("time,v\n01:00:00,1\n23:00:00,2\n"), [3_600 * SECOND, 82_800 * SECOND]);
}

#[test]
fn separators_and_decimal_commas_are_understood() {
    for text in [
        "time (s);roll\n0,5;1,25\n1,5;-2\n",
        "time (s)\troll\n0.5\t1.25\n1.5\t-2\n",
        "time (s)\troll\n0,5\t1,25\n1,5\t-2\n",
        "# comment; with, both\ntime (s);roll\n0.5;1.25\n1.5;-2\n",
        "sep=;\ntime (s);roll\n0,5;1,25\n1,5;-2\n",
    ] {
        let (found, damages) = rows(text);
        let expected = [(SECOND / 2, Cell::Number(1.25)), (SECOND * 3 / 2, Cell::Number(-2.0))];
        assert_eq!((found.as_slice(), damages.count), (expected.as_slice(), 0), "{text}");
    }
    // In a table with commas between columns, a comma is never part of a number.
    assert_eq!(rows("t,a,b\n1,2,5\n").0, [(SECOND, Cell::Number(5.0))]);
}

#[test]
fn rows_of_one_instant_are_reported() {
    let (found, damages) = rows("t,roll\n1,5\n1,6\n1,7\n2,8\n");
    assert_eq!(found.len(), 4);
    assert_eq!(damages.count, 2);
    assert!(damages.first[0].starts_with("line 3: it has the time of the row before"), "{damages:?}");
}

#[test]
fn rows_of_other_lengths_and_equal_names_are_noted() {
    for (text, expected) in [
        (
            "t,roll\n1,2,345\n",
            "line 2: the row has 3 cells and the row of names 2: the last ones are left out; a decimal comma needs",
        ),
        ("t;roll\n1;2;3\n", "line 2: the row has 3 cells and the row of names 2: the last ones are left out"),
        ("t,roll,pitch\n1,2,3\n2,4\n", "line 3: the row has 2 cells and the row of names 3: it may be cut off"),
        ("t,roll,roll\n1,2,3\n", "the row of names: two columns are called `roll`: the first counts"),
    ] {
        let (found, damages) = rows(text);
        assert!(damages.count == 1 && damages.first[0].starts_with(expected), "{text}: {damages:?}");
        assert!(!found.is_empty(), "{text}: the row is read all the same");
    }
    // A separator at the end of each row adds an empty cell, which says nothing.
    assert_eq!(rows("t,roll\n1,2,\n").1.count, 0);
}

#[test]
fn times_that_are_invalid_are_reported_with_their_text() {
    for (text, expected) in [
        ("t,roll\n1,5\nlater,6\n", "line 3: `later` is not a time"),
        ("t,roll\n1,5\n,6\n", "line 3: the row has no time"),
        ("t_s,roll\n1,5\n99999999999999,6\n", "line 3: `99999999999999` is not a time"),
        ("datetime,roll\n2023-02-30T00:00:00Z,6\n", "line 2: `2023-02-30T00:00:00Z` is not a time"),
        ("speed,roll\n1,5\n", "line 1: no column has the name of a time; the columns are speed, roll"),
    ] {
        let (_, damages) = rows(text);
        assert!(damages.count == 1 && damages.first[0].contains(expected), "{text}: {damages:?}");
    }
}

proptest! {
    /// An instant in whole nanoseconds is read back exactly, in whichever unit it is written.
    #[test]
    fn instants_are_exact(at in 0i64..4_000_000_000 * SECOND) {
        let digits = format!("{at:010}");
        let (whole, part) = digits.split_at(digits.len() - 9);
        prop_assert_eq!(instants(&format!("time (s),v\n{whole}.{part},1\n")), [at]);
        prop_assert_eq!(instants(&format!("time (ns),v\n{at},1\n")), [at]);
        prop_assert_eq!(instants(&format!("time (s);v\n{whole},{part};1\n")), [at]);
    }
}
