//! Round trips of every format, field by field.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "what cannot be read is a failed test")]

mod builders;

use apex_logs::{Cell, Entry, Format, LogReader, Mapping, Message, Sampled, Sampler, Take, open, survey};
use apex_model::event::StateVariable;
use apex_model::quantity::unit_named;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;

fn reader<'a>(bytes: &'a [u8], extension: &str) -> Box<dyn LogReader + 'a> {
    let (format, input) = open(bytes, extension).unwrap();
    format.unwrap().reader(input, None)
}

/// Instants in seconds and values of one field.
fn values(bytes: &[u8], extension: &str, topic: &str, field: &str) -> Vec<(f64, Cell)> {
    let mut reader = reader(bytes, extension);
    let (mut message, mut found) = (Message::default(), Vec::new());
    while reader.next(&mut message).unwrap() {
        let known = &reader.topics()[message.topic];
        if known.name == topic {
            let index = known.fields.iter().position(|each| each == field).unwrap_or_else(|| panic!("{known:?}"));
            found.push((message.at.seconds(), message.values.get(index).cloned().unwrap_or_default()));
        }
    }
    found
}

fn number(cell: &Cell) -> f64 {
    match cell {
        Cell::Number(number) => *number,
        other => panic!("{other:?}"),
    }
}

#[test]
fn formats_are_known_by_their_first_bytes() {
    let found: Vec<Option<Format>> =
        builders::all(3).iter().map(|(_, bytes)| open(bytes.as_slice(), "").unwrap().0).collect();
    let expected = [
        Some(Format::ULog),
        Some(Format::DataFlashBinary),
        Some(Format::DataFlashText),
        Some(Format::TelemetryLog),
        Some(Format::Mcap),
        None,
    ];
    assert_eq!(found, expected);
}

#[test]
fn every_format_gives_its_samples_and_times() {
    let fields = [
        ("ulg", "vehicle_attitude", "timestamp", 1.0),
        ("bin", "ATT", "Roll", 5.0),
        ("tlog", "ATTITUDE", "roll", 1_600_000_000.0),
        ("mcap", "/attitude", "euler.roll", 0.0),
        ("csv", "csv", "roll", 0.0),
    ];
    let logs = builders::all(20);
    for (extension, topic, field, origin_s) in fields {
        let bytes = &logs.iter().find(|(known, _)| *known == extension).unwrap().1;
        let found = values(bytes, extension, topic, field);
        assert_eq!(found.len(), 20, "{extension}");
        for (index, (at, value)) in found.iter().enumerate() {
            assert!((at - origin_s - index as f64 * 0.1).abs() < 1e-6, "{extension}: {at}");
            let expected = match extension {
                "ulg" => 1e6 + index as f64 * 1e5,
                "tlog" => (index as f64).to_radians(),
                _ => index as f64,
            };
            assert!((number(value) - expected).abs() < 1e-6, "{extension}: {value:?}");
        }
    }
}

#[test]
fn ulog_has_nested_fields_arrays_texts_and_instances() {
    let log = builders::ulog(2);
    assert_eq!(values(&log, "ulg", "vehicle_attitude", "rate.yz[1]")[0].1, Cell::Number(3.0));
    assert_eq!(values(&log, "ulg", "vehicle_attitude", "ok")[1].1, Cell::Number(1.0));
    assert_eq!(values(&log, "ulg", "battery_status#1", "remaining")[0].1, Cell::Number(-5.0));
    assert_eq!(values(&log, "ulg", "battery_status#1", "name")[0].1, Cell::Text("cell".into()));
    assert_eq!(values(&log, "ulg", "logged_message", "text"), [(1.5, Cell::Text("Takeoff detected".into()))]);
    let mut reader = reader(&log, "ulg");
    while reader.next(&mut Message::default()).unwrap() {}
    assert_eq!(reader.began(), Some(Time::from_seconds(1.0)));
    assert_eq!(reader.damages().count, 1);
    assert!(reader.damages().first[0].contains("lost 250 ms of data"));
}

#[test]
fn dataflash_numbers_are_scaled_as_their_letters_say() {
    let log = builders::dataflash_binary(3);
    assert!((number(&values(&log, "bin", "POS", "Lat")[0].1) + 35.362_990_4).abs() < 1e-9);
    assert!((number(&values(&log, "bin", "POS", "Alt")[0].1) - 584.12).abs() < 1e-9);
}

#[test]
fn instances_of_dataflash_messages_are_distinguished() {
    for (log, extension) in
        [(builders::dataflash_with_units(4, false), "bin"), (builders::dataflash_text_with_units(), "log")]
    {
        let below: Vec<f64> = values(&log, extension, "BARO", "Alt").iter().map(|(_, cell)| number(cell)).collect();
        let above: Vec<f64> = values(&log, extension, "BARO#1", "Alt").iter().map(|(_, cell)| number(cell)).collect();
        let expected: (&[f64], &[f64]) =
            if extension == "bin" { (&[0.0, -2.0], &[0.0, 0.0]) } else { (&[-1.5], &[0.5]) };
        assert_eq!((below.as_slice(), above.as_slice()), expected, "{extension}");
    }
}

#[test]
fn units_of_dataflash_fields_are_known_with_their_multipliers() {
    for (log, extension) in
        [(builders::dataflash_with_units(4, false), "bin"), (builders::dataflash_text_with_units(), "log")]
    {
        let (fields, _) = survey(&mut *reader(&log, extension)).unwrap();
        let unit = |name: &str| fields.iter().find(|field| field.name == name).unwrap().unit.clone();
        assert_eq!(unit("BARO#1.Alt").as_deref(), Some("m"), "{extension}");
        assert_eq!(unit("BARO.Fld").as_deref(), Some("0.001 Gauss"), "{extension}");
        assert_eq!(unit("BARO.I"), None, "{extension}");
    }
}

/// A real log of an ArduSub; the expected figures come from pymavlink 2.4.50.
#[test]
fn every_barometer_of_a_real_log_is_read() {
    let path = "/work/shared/data/flight-logs/ap_sub_small.BIN";
    let Ok(log) = std::fs::read(path) else {
        eprintln!("skipped: {path} is not here");
        return;
    };
    let heights =
        |topic: &str| -> Vec<f64> { values(&log, "bin", topic, "Alt").iter().map(|(_, cell)| number(cell)).collect() };
    let least = |heights: &[f64]| heights.iter().copied().fold(f64::INFINITY, f64::min);
    let (first, second) = (heights("BARO"), heights("BARO#1"));
    assert_eq!((first.len(), second.len()), (237, 237));
    assert!((least(&first) + 10.3).abs() < 0.05 && least(&second) > -0.5, "{} {}", least(&first), least(&second));
}

#[test]
fn rows_without_a_time_are_spread_between_those_of_the_gps() {
    let found = values(&builders::dataflash_text(2), "log", "ATT", "Roll");
    let found: Vec<(f64, f64)> = found.iter().map(|(at, value)| (*at, number(value))).collect();
    assert_eq!(found, [(0.1, 0.0), (0.2, 0.5), (0.4, 1.0), (0.5, 1.5)]);
}

#[test]
fn other_systems_on_the_air_are_distinguished() {
    let log = builders::tlog(4);
    assert_eq!(values(&log, "tlog", "HEARTBEAT@255.190", "type").len(), 4);
    // Fields that were not sent are zero.
    assert_eq!(values(&log, "tlog", "ATTITUDE", "yawspeed")[1].1, Cell::Number(0.0));
}

#[test]
fn mcap_chunks_are_unpacked_and_what_is_not_json_is_named() {
    let log = builders::mcap(6);
    let mut reader = reader(&log, "mcap");
    while reader.next(&mut Message::default()).unwrap() {}
    assert_eq!(reader.damages().count, 1, "{:?}", reader.damages());
    assert!(reader.damages().first[0].contains("`/raw` in `cdr` are counted, but not read: its schema is missing"));
    assert_eq!(values(&log, "mcap", "/attitude", "mode").len(), 6);
}

#[test]
fn mcap_messages_of_ros_2_are_read_by_their_definition() {
    let log = builders::mcap_ros(5);
    let mut reader = reader(&log, "mcap");
    while reader.next(&mut Message::default()).unwrap() {}
    assert_eq!(reader.damages().count, 0, "{:?}", reader.damages());
    let fields =
        ["header.stamp.sec", "header.stamp.nanosec", "header.frame_id", "mode", "angle.x", "angle.y", "angle.z"];
    assert_eq!(reader.topics()[0].fields[..7], fields);
    assert_eq!(values(&log, "mcap", "/attitude", "angle.x")[4].1, Cell::Number(4.0));
    assert_eq!(values(&log, "mcap", "/attitude", "header.frame_id")[0].1, Cell::Text("map".into()));
    assert_eq!(values(&log, "mcap", "/attitude", "cells[1]")[2].1, Cell::Number(4.5));
}

#[test]
fn a_survey_counts_fields_and_their_ranges() {
    let log = builders::csv(11);
    let (fields, span) = survey(&mut *reader(&log, "csv")).unwrap();
    let roll = &fields[1];
    assert_eq!(
        (roll.name.as_str(), roll.count, roll.range, roll.rate_per_s),
        ("csv.roll", 11, Some((0.0, 10.0)), Some(10.0))
    );
    assert_eq!((fields[2].text.as_deref(), span), (Some("AUTO"), Some((Time::ZERO, Time::from_seconds(1.0)))));
}

fn entry(field: &str, attribute: &str, take: Take) -> Entry {
    let variable = StateVariable::new(Symbol::new(attribute), Value::symbol("uav"));
    let (field, words) = (field.into(), Vec::new());
    Entry { field, variable, take, scale: 1.0, integer_scale: None, offset: 0.0, words, missing: None, declared: None }
}

fn sampled(log: &[u8], extension: &str, entries: Vec<Entry>) -> Vec<Sampled> {
    let mut reader = reader(log, extension);
    let mut sampler = Sampler::new(Mapping { entries, ..Mapping::default() });
    let (mut message, mut samples) = (Message::default(), Vec::new());
    while reader.next(&mut message).unwrap() {
        sampler.sample(reader.topics(), &message, &mut samples);
    }
    samples
}

#[test]
fn whole_numbers_and_units_of_the_log_are_scaled() {
    // Volts are floats, and whole hundredths of a volt in older logs.
    let volts = Entry { integer_scale: Some(0.01), ..entry("CURR.Volt", "volts", Take::Value) };
    let angle = unit_named("rad").map(|unit| (unit.factor, unit.dimension));
    for integers in [false, true] {
        let samples = sampled(&builders::dataflash_with_units(2, integers), "bin", vec![volts.clone()]);
        let Value::Real(value) = samples[0].value else { panic!() };
        assert!((value - 12.6).abs() < 1e-6, "{integers}: {value}");
    }
    // The log states metres; the variable is declared in feet. An angle cannot be had from metres.
    let feet = unit_named("ft").map(|unit| (unit.factor, unit.dimension));
    let wanted = vec![
        Entry { declared: feet, ..entry("BARO.Alt", "height", Take::Value) },
        Entry { declared: angle, ..entry("BARO.Alt", "angle", Take::Value) },
    ];
    let samples = sampled(&builders::dataflash_with_units(4, false), "bin", wanted);
    let last = |number: usize| samples.iter().rfind(|each| each.entry == number).unwrap().value.clone();
    assert_eq!((last(0).to_string(), last(1).to_string()), ((-2.0 / 0.3048_f64).to_string(), "-2.0".to_string()));
}

#[test]
fn quaternions_become_angles_and_the_first_field_that_is_there_counts() {
    let entries = vec![
        entry("no_such_topic.roll", "roll", Take::Value),
        entry("vehicle_attitude.q", "roll", Take::Roll),
        entry("battery_status#1.remaining", "roll", Take::Value),
    ];
    let samples = sampled(&builders::ulog(5), "ulg", entries);
    assert_eq!(samples.len(), 5);
    let Value::Real(roll) = samples[4].value else { panic!() };
    assert!((roll.to_degrees() - 4.0).abs() < 1e-5);
}

#[test]
fn words_scales_and_numbers_for_not_known() {
    let scaled = Entry { scale: 2.0, offset: 1.0, missing: Some(1.0), ..entry("roll", "roll", Take::Value) };
    let worded = Entry { words: vec![(3.0, Value::symbol("three"))], ..entry("roll", "word", Take::Value) };
    let samples = sampled(&builders::csv(4), "csv", vec![scaled, worded, entry("mode", "mode", Take::Value)]);
    let of = |number: usize| samples.iter().filter(move |each| each.entry == number).map(|each| each.value.to_string());
    assert_eq!(of(0).collect::<Vec<_>>(), ["1.0", "5.0", "7.0"]);
    assert_eq!(of(1).collect::<Vec<_>>(), ["0.0", "1.0", "2.0", "three"]);
    assert!(of(2).all(|word| word == "auto"));
}

#[test]
fn coordinates_that_do_not_exist_are_not_samples_and_are_noted_once() {
    // The log counts 0 to 10: latitudes of 0 to 300 degrees, longitudes of 0 to 600 degrees.
    let of = |attribute: &str, scale: f64| Entry { scale, ..entry("roll", attribute, Take::Value) };
    let (log, entries) = (builders::csv(11), vec![of("latitude", 30.0), of("longitude", 60.0)]);
    let mut reader = reader(&log, "csv");
    let mut sampler = Sampler::new(Mapping { entries, ..Mapping::default() });
    let (mut message, mut samples) = (Message::default(), Vec::new());
    while reader.next(&mut message).unwrap() {
        sampler.sample(reader.topics(), &message, &mut samples);
    }
    let count = |number: usize| samples.iter().filter(|each| each.entry == number).count();
    assert_eq!((count(0), count(1)), (4, 7));
    let doubts = sampler.doubts();
    assert_eq!(doubts.len(), 2, "{doubts:?}");
    assert!(doubts[0].contains("`roll` is 120 deg at 0.4s, which is not a latitude"), "{doubts:?}");
}

/// Arbitrary bytes can look like a text that the vehicle's software logged.
#[test]
fn texts_alone_are_not_a_log_without_its_beginning() {
    let mut text = vec![12, 0, b'L', b'6'];
    text.extend(1_000_000_u64.to_le_bytes());
    text.extend(b"hey");
    let mut bytes = vec![0x5a; 16];
    bytes.extend(&text);
    let count = |bytes: &[u8]| {
        let (mut reader, mut message, mut count) = (reader(bytes, "ulg"), Message::default(), 0);
        while reader.next(&mut message).unwrap() {
            count += 1;
        }
        count
    };
    assert_eq!(count(&bytes), 0);
    let whole = [builders::ulog(1).get(..16).unwrap(), &text].concat();
    assert_eq!(count(&whole), 1);
}
