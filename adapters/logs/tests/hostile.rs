//! Damaged logs: readers neither panic nor hang, read every intact message, and report every damaged place.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "what cannot be read is a failed test")]

mod builders;

use apex_logs::{Format, Message, survey};
use proptest::prelude::*;

const FORMATS: &[Format] =
    &[Format::ULog, Format::DataFlashBinary, Format::DataFlashText, Format::TelemetryLog, Format::Mcap, Format::Csv];

/// Returns the number of messages read and of damaged places reported.
fn read(format: Format, bytes: &[u8]) -> (u64, u64) {
    let mut reader = format.reader(bytes, None);
    let (mut message, mut count) = (Message::default(), 0);
    while reader.next(&mut message).unwrap() {
        count += 1;
        assert!(message.topic < reader.topics().len());
        assert!(count <= bytes.len() as u64, "more messages than bytes");
    }
    (count, reader.damages().count)
}

#[test]
fn a_log_that_is_cut_anywhere_gives_what_was_before() {
    for ((_, bytes), format) in builders::all(6).into_iter().zip(FORMATS) {
        let (whole, _) = read(*format, &bytes);
        let mut before = 0;
        for length in 0..bytes.len() {
            let (count, _) = read(*format, &bytes[..length]);
            assert!(count <= whole && count + 2 >= before, "{format:?} cut at {length}: {count} of {whole}");
            before = count;
        }
    }
}

#[test]
fn a_hole_costs_only_what_was_in_it() {
    for ((_, bytes), format) in builders::all(40).into_iter().zip(FORMATS) {
        // MCAP has no markers at which a reader could resume after a gap.
        if matches!(format, Format::Mcap) {
            continue;
        }
        let (whole, flaws) = read(*format, &bytes);
        let middle = bytes.len() / 2;
        let holed = [&bytes[..middle], &bytes[middle + 37..]].concat();
        let (count, damages) = read(*format, &holed);
        assert!(count + 6 >= whole, "{format:?}: {count} of {whole}");
        // In a table or a text, a gap looks like short rows, which readers accept.
        if !matches!(format, Format::Csv | Format::DataFlashText) {
            assert!(damages > flaws, "{format:?}: no damage is reported for the hole");
        }
    }
}

/// The time before the second packet of the vehicle is a hundred million seconds later; its bytes and its checksum are right.
#[test]
fn a_packet_at_an_impossible_time_is_named_as_such() {
    let mut log = builders::tlog(3);
    let packet = builders::tlog(1).len();
    let stamp = u64::from_be_bytes(log[packet..packet + 8].try_into().unwrap()) + 100_000_000_000_000;
    log[packet..packet + 8].copy_from_slice(&stamp.to_be_bytes());
    let mut reader = Format::TelemetryLog.reader(&log[..], None);
    let (mut message, mut count) = (Message::default(), 0);
    while reader.next(&mut message).unwrap() {
        count += 1;
    }
    assert_eq!(count, 5, "all others are read");
    let note = "the packet's time is 100000000 s after the time of the packet before, more than a day; it is skipped";
    assert_eq!(reader.damages().first, [format!("byte {packet}: {note}")]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn any_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..2_000)) {
        for format in FORMATS {
            read(*format, &bytes);
        }
    }

    #[test]
    fn changed_bytes_are_survived(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..20)) {
        for ((_, mut bytes), format) in builders::all(8).into_iter().zip(FORMATS) {
            for (place, byte) in &changes {
                let index = place.index(bytes.len());
                bytes[index] = *byte;
            }
            read(*format, &bytes);
            survey(&mut *format.reader(bytes.as_slice(), None)).unwrap();
        }
    }
}
