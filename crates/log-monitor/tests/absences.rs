//! Absences in a file have their final intervals: from the end of what was there to its next beginning, or to the end of the input.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test that cannot continue fails")]

use apex_log_monitor::{Destinations, LogMonitor, LogMonitorTerms, Source};
use apex_mission::monitor_report::Style;
use apex_pdl::{CheckOptions, SourceText, check_conditions};
use std::path::Path;
use std::sync::Arc;

/// Returns the intervals and evidence that are printed for `condition` over samples of `(v a)` at these seconds.
fn printed(condition: &str, samples: &[(u32, u32)]) -> Vec<(f64, f64, String)> {
    watched(condition, samples, &|_| {})
}

fn watched(condition: &str, samples: &[(u32, u32)], note: &dyn Fn(&str)) -> Vec<(f64, f64, String)> {
    let lines =
        samples.iter().map(|(t, value)| format!("{{\"t\": {t}, \"measurement\": \"(v a)\", \"value\": {value}}}\n"));
    over(condition, lines.collect(), note)
}

/// Returns the intervals that are printed for `condition` over lines of input.
fn intervals(condition: &str, lines: &str) -> Vec<(f64, f64)> {
    over(condition, lines.to_string(), &|_| {}).into_iter().map(|(start, end, _)| (start, end)).collect()
}

fn over(condition: &str, lines: String, note: &dyn Fn(&str)) -> Vec<(f64, f64, String)> {
    let text = SourceText { name: "condition".to_string(), text: condition.to_string() };
    let mut resolve = |_| Err("nothing is required".into());
    let options = CheckOptions { fragment: false, host: &[], resolve: &mut resolve };
    let read = check_conditions(Vec::new(), vec![text], options);
    assert!(!read.checked.has_errors());
    let key: u64 = condition.bytes().chain(lines.bytes()).fold(7, |sum, byte| sum * 31 % 1_000_003 + u64::from(byte));
    let name = format!("absences-{key}.jsonl");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, lines).unwrap();
    let style = Style { json: true, live: false, several: false, utc_of_zero: None };
    let terms = LogMonitorTerms {
        library: Arc::new(read.checked.library),
        conditions: read.conditions,
        created: None,
        span: (None, None),
        style,
        is_drawn: false,
    };
    let mut out = Vec::new();
    let to = Destinations { out: &mut out, name: None, table: None, note };
    LogMonitor::new(terms, to).unwrap().run(Source::LinesFile(path)).unwrap();
    let results = String::from_utf8(out).unwrap();
    let results = results.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    let results = results.filter(|line| line.get("start_s").is_some());
    results
        .map(|line| {
            let seconds = |name: &str| line[name].as_f64().unwrap();
            (seconds("start_s"), seconds("end_s"), line["evidence"][0].as_str().unwrap().to_string())
        })
        .collect()
}

#[test]
fn an_absence_lasts_until_its_condition_comes_or_the_input_ends() {
    let samples = [(0, 0), (10, 0), (40, 9), (45, 9), (46, 0), (147, 0)];
    let found = printed("(:absent (v a > 5) :for 30s)", &samples);
    let expected = [(0.0, 40.0, "40s"), (45.0, 147.0, "0:02:27")];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for ((start, end, evidence), (from, until, text)) in found.iter().zip(expected) {
        assert_eq!((*start, *end), (from, until));
        assert!(evidence.ends_with(&format!("up to {text}")), "{evidence}");
    }
}

#[test]
fn a_variable_without_samples_is_noted_once() {
    let notes = std::cell::RefCell::new(Vec::new());
    watched("(:absent (w b > 5) :for 3s)", &[(0, 0), (10, 0)], &|note| notes.borrow_mut().push(note.to_string()));
    let about = notes.borrow().iter().filter(|note| note.contains("no sample of (w b)")).count();
    assert_eq!(about, 1, "{notes:?}");
}

#[test]
fn an_absence_of_an_episode_ends_where_the_episode_begins() {
    let samples = [(0, 0), (20, 0), (40, 9), (44, 9), (48, 9), (50, 0), (60, 0)];
    let condition =
        "(:absent (:episode (v a) :value (> 5) :quality (:max-gap 20s) :timing (:duration (>= 8s))) :for 15s)";
    let found = printed(condition, &samples);
    assert_eq!(found.first().map(|(start, end, _)| (*start, *end)), Some((0.0, 40.0)), "{found:?}");
}

const TWO_MESSAGES: &str = r#"{"t": 0, "event": "(begin)"}
{"t": 1, "event": "(p)"}
{"t": 5, "event": "(r)"}
{"t": 6, "event": "(r)"}
{"t": 10, "event": "(end)"}
"#;

#[test]
fn an_absence_of_a_combination_lasts_until_the_combination_occurs() {
    for length in ["500ms", "1500ms", "4500ms"] {
        let end = if length == "500ms" { 1.0 } else { 5.0 };
        for part in ["(:and (p) (r))", "(:in-order (p) (r))"] {
            let found = intervals(&format!("(:absent {part} :for {length})"), TWO_MESSAGES);
            assert_eq!(found.first(), Some(&(0.0, end)), "{part} {length}");
        }
    }
}

#[test]
fn an_absence_of_a_long_run_lasts_until_the_run_is_long_enough() {
    let samples = [(0, 1), (1, 5), (2, 5), (3, 5), (4, 5), (5, 5), (6, 1), (7, 1), (8, 1)];
    let run = "(:episode (v a) :quality (:max-gap 1s) :value (> 4) :timing (:duration (>= 3s)))";
    for (length, end) in [("500ms", 1.0), ("2s", 4.0), ("3500ms", 4.0)] {
        let found = printed(&format!("(:absent {run} :for {length})"), &samples);
        assert_eq!(found.first().map(|(start, end, _)| (*start, *end)), Some((0.0, end)), "{length}");
    }
    let short = "(:episode (v a) :quality (:max-gap 1s) :value (> 4) :timing (:duration (<= 4s)))";
    let found = printed(&format!("(:absent {short} :for 2s)"), &samples);
    assert_eq!(found.first().map(|(start, end, _)| (*start, *end)), Some((0.0, 2.0)), "{found:?}");
}

#[test]
fn an_absence_is_not_claimed_for_a_time_without_expected_samples() {
    let lines = r#"{"t": 0, "measurement": "(v a)", "value": 8}
{"t": 1, "measurement": "(v a)", "value": 8}
{"t": 4, "measurement": "(v a)", "value": 8}
{"t": 5, "measurement": "(v a)", "value": 8}
{"t": 20, "event": "(end)"}
"#;
    let run = "(:episode (v a) :quality (:max-gap 2s) :value (< 3) :timing (:duration (>= 1s)))";
    assert_eq!(intervals(&format!("(:absent {run} :for 9s)"), lines), []);
    assert_eq!(intervals(&format!("(:absent {run} :for 2s)"), lines), [(0.0, 5.0)]);
}
