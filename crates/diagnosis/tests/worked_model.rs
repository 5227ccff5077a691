//! The worked model: its D-matrix, its testability figures, and twelve diagnosed outcomes, compared with separately computed figures.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test that cannot continue fails")]

use apex_diagnosis::{Diagnoser, Health, Model, Outcome, SearchEnd, testability};
use std::sync::Arc;

const MODEL: &str = include_str!("../../../library/diagnosis/observation-uav.json");
/// Rows are failure modes 1 to 17, columns tests 1 to 25.
const D_MATRIX: [&str; 17] = [
    "1100000000000000000000000",
    "0110000000001111011101111",
    "0010000000000000011101111",
    "1101000000000000100000000",
    "1101100000000000100000000",
    "0000011010000000000000000",
    "0000001100010000000000000",
    "0000000011000000100000000",
    "0000000000110010010000000",
    "0000000000001100000000000",
    "0000000000001000000000000",
    "0000000000000001000000001",
    "0000000000000000011010000",
    "0000000000000000000111001",
    "0000000000000000000100111",
    "0000000000001000000000000",
    "0000000000000000000000000",
];

fn model() -> Model {
    Model::parse("observation-uav.json", MODEL).unwrap()
}

#[test]
fn the_d_matrix_and_the_figures_are_those_of_the_worked_model() {
    let model = model();
    let report = testability(&model);
    for (row, expected) in report.rows.iter().zip(D_MATRIX) {
        let cells: String = (0..25).map(|test| if row.contains(test) { '1' } else { '0' }).collect();
        assert_eq!(cells, expected);
    }
    assert_eq!((report.detected.len(), report.undetected.as_slice()), (16, [16].as_slice()));
    assert!((report.detection - 0.941).abs() < 5e-4 && (report.detection_weighted - 0.9875).abs() < 5e-5);
    assert_eq!(report.isolation, [0.875, 1.0, 1.0]);
    assert_eq!(report.ambiguity_groups, [[10, 15]]);
    assert_eq!(report.equal_tests, [[22, 23]]);
    let hidden: Vec<(usize, usize)> = report.hidden.iter().map(|(a, b)| (a + 1, b + 1)).collect();
    let expected = [
        (2, 3),
        (2, 10),
        (2, 11),
        (2, 12),
        (2, 15),
        (2, 16),
        (3, 15),
        (4, 1),
        (5, 1),
        (5, 4),
        (10, 11),
        (10, 16),
        (11, 16),
    ];
    assert_eq!(hidden, expected);
    assert_eq!((report.test_set.tests.len(), report.test_set.is_smallest), (11, true));
}

/// A case: failed tests, tests that were not run, bad, suspect, unknown, candidates with shares; numbers from 1.
type Case<'a> = (&'a [usize], &'a [usize], &'a [usize], &'a [usize], &'a [usize], &'a [(&'a [usize], f64)]);

#[test]
fn twelve_outcomes_are_diagnosed_as_expected() {
    let but_20_and_24: Vec<usize> = (1..=25).filter(|test| ![20, 24].contains(test)).collect();
    let cases: [Case<'_>; 12] = [
        (&[], &[], &[], &[], &[17], &[(&[], 1.0)]),
        (&[13], &[], &[], &[11, 16], &[17], &[(&[16], 0.667), (&[11], 0.333)]),
        (&[18, 19, 21], &[], &[13], &[], &[17], &[(&[13], 1.0)]),
        (&[3, 18, 19, 20, 22, 23, 24, 25], &[], &[3], &[], &[15, 17], &[(&[3], 1.0)]),
        (&[20, 25], &[21, 22, 23, 24], &[], &[14, 15], &[17], &[(&[14], 0.556), (&[15], 0.444)]),
        (&[13, 15, 16, 25], &[], &[12], &[11, 16], &[17], &[(&[12, 16], 0.667), (&[11, 12], 0.333)]),
        (&[13, 14, 15, 16, 25], &[], &[10, 12], &[], &[11, 16, 17], &[(&[10, 12], 1.0)]),
        (&[1, 2, 4, 17], &[], &[4], &[], &[1, 17], &[(&[4], 1.0)]),
        (&[1, 2, 4, 5, 17], &[], &[5], &[], &[1, 4, 17], &[(&[5], 1.0)]),
        (&[7, 9], &[], &[], &[], &[17], &[(&[], 1.0)]),
        (&[20], &but_20_and_24, &[14], &[], &[1, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 16, 17], &[(&[14], 1.0)]),
        (&[9, 10, 17, 18, 19, 21], &[], &[8, 13], &[], &[17], &[(&[8, 13], 1.0)]),
    ];
    let model = Arc::new(model());
    for (case, (failed, not_run, bad, suspect, unknown, candidates)) in cases.into_iter().enumerate() {
        let mut diagnoser = Diagnoser::new(Arc::clone(&model));
        diagnoser.set_all((1..=25).map(|test| {
            let outcome = match (failed.contains(&test), not_run.contains(&test)) {
                (true, _) => Outcome::Failed,
                (_, true) => Outcome::Unknown,
                _ => Outcome::Passed,
            };
            (test - 1, outcome)
        }));
        let diagnosis = diagnoser.diagnosis();
        for (health, expected) in [(Health::Bad, bad), (Health::Suspect, suspect), (Health::Unknown, unknown)] {
            let modes: Vec<usize> = (1..=17).filter(|mode| diagnosis.modes[mode - 1] == health).collect();
            assert_eq!(modes, expected, "case {case}: {health}");
        }
        let found = diagnosis.candidates(64);
        assert_eq!(found.len(), candidates.len(), "case {case}: {found:?}");
        for (found, (modes, share)) in found.iter().zip(candidates) {
            assert_eq!(found.modes.iter().map(|mode| mode + 1).collect::<Vec<_>>(), *modes, "case {case}");
            assert!((found.share - share).abs() < 5e-4, "case {case}: {}", found.share);
        }
        assert_eq!(diagnosis.end(), SearchEnd::All);
        let contradiction = diagnosis.contradiction.as_ref();
        assert_eq!(contradiction.is_some(), case == 9);
        if let Some(contradiction) = contradiction {
            // Without the GPS fix, its receiver explains both failed tests.
            assert_eq!(contradiction.unexplained, [6, 8]);
            assert_eq!((contradiction.left_out.as_slice(), contradiction.is_smallest), ([vec![5]].as_slice(), true));
        }
    }
}

#[test]
fn the_explanation_as_json_names_the_tests_that_the_text_names() {
    let mut diagnoser = Diagnoser::new(Arc::new(model()));
    let rows: Vec<usize> = (0..25).filter(|test| D_MATRIX[5].as_bytes()[*test] == b'1').collect();
    diagnoser.set_all((0..25).map(|test| (test, if rows.contains(&test) { Outcome::Failed } else { Outcome::Passed })));
    let shipped = diagnoser.model().clone();
    let broken = &shipped.components[shipped.modes[5].component].name;
    let json = apex_diagnosis::explain_json(&diagnoser, broken).unwrap();
    assert_eq!((json["health"].as_str(), json["component"].as_str()), (Some("bad"), Some(broken.as_str())));
    let failed = json["failure_modes"][0]["failed"].as_array().unwrap();
    let named: Vec<&str> = failed.iter().map(|one| one["test"].as_str().unwrap()).collect();
    assert_eq!(named, rows.iter().map(|test| shipped.test_name(*test)).collect::<Vec<_>>());
    let text = apex_diagnosis::explain(&diagnoser, broken).unwrap();
    assert_eq!(json["text"].as_str(), Some(text.as_str()));
    assert!(named.iter().all(|test| text.contains(test)));
    assert!(apex_diagnosis::explain_json(&diagnoser, "no such component").is_none());
}

/// Numbers of tests and failure modes of the payload: voltage 0, mount 1, frames 2; converter 0, drive 1, sensor 2.
fn payload() -> Diagnoser {
    let text = r#"{"format": "apex-diagnosis-1", "name": "payload",
        "components": [{"name": "converter", "probability_per_hour": 1e-4}, {"name": "drive", "probability_per_hour": 8e-4},
                       {"name": "sensor", "probability_per_hour": 5e-4}],
        "signals": [],
        "tests": [{"name": "voltage", "needs": ["converter"]}, {"name": "mount", "needs": ["converter", "drive"]},
                  {"name": "frames", "needs": ["converter", "sensor"]}]}"#;
    Diagnoser::new(Arc::new(Model::parse("payload.json", text).unwrap()))
}

#[test]
fn a_pass_that_is_older_than_a_failure_is_doubted() {
    use Outcome::{Failed, Passed};
    let healths = |diagnoser: &Diagnoser| diagnoser.diagnosis().modes.iter().map(|one| one.word()).collect::<Vec<_>>();
    let mut diagnoser = payload();
    // All at one instant: the failure is left out, as in a results file.
    diagnoser.report_all([(0, Failed, 900), (1, Passed, 900), (2, Failed, 900)]);
    assert_eq!(healths(&diagnoser), ["good", "good", "bad"]);
    assert_eq!(diagnoser.diagnosis().contradiction.as_ref().map(|found| found.unexplained.clone()), Some(vec![0]));
    // The pass is older.
    diagnoser.report_all([(1, Passed, 617)]);
    assert_eq!(healths(&diagnoser), ["bad", "unknown", "unknown"]);
    let doubts: Vec<_> =
        diagnoser.diagnosis().doubts.iter().map(|doubt| (doubt.test, doubt.failed, doubt.age_ns)).collect();
    assert_eq!((doubts, diagnoser.diagnosis().contradiction.is_none()), (vec![(1, 0, 283)], true));
    assert_eq!(diagnoser.outcomes(), [Failed, Outcome::Unknown, Failed]);
    let text = apex_diagnosis::explain(&diagnoser, "drive").unwrap();
    assert!(text.contains("mount is doubted: it passed") && text.contains("before voltage failed"), "{text}");
    // The mount passes again: its evidence is newer than the failure.
    diagnoser.report_all([(1, Passed, 901)]);
    assert_eq!(healths(&diagnoser), ["good", "good", "bad"]);
    assert!(diagnoser.diagnosis().doubts.is_empty());
    // With the power back nothing contradicts an old pass.
    diagnoser.report_all([(0, Passed, 950), (1, Passed, 617), (2, Passed, 950)]);
    assert_eq!(healths(&diagnoser), ["good", "good", "good"]);
}

#[test]
fn an_old_pass_is_not_doubted_where_a_newer_one_contradicts_the_failure_as_well() {
    use Outcome::{Failed, Passed};
    let mut diagnoser = payload();
    diagnoser.report_all([(0, Failed, 900), (1, Passed, 617), (2, Passed, 950)]);
    let diagnosis = diagnoser.diagnosis();
    assert!(diagnosis.doubts.is_empty(), "{:?}", diagnosis.doubts);
    let found = diagnosis.contradiction.as_ref().unwrap();
    assert_eq!((found.unexplained.as_slice(), found.left_out.as_slice()), ([0].as_slice(), [vec![0]].as_slice()));
}
