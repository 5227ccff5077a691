//! Contradictions of a report: the smallest sets of tests without which the others are consistent.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test that cannot continue fails")]

use apex_diagnosis::{Diagnoser, Model, Outcome};
use std::sync::Arc;

/// Redundant supplies of several tests, so that passed tests exclude sets of failures: each decision about a set of tests is costly.
const REDUNDANT: &str = r#"{
  "format": "apex-diagnosis-1", "name": "m",
  "components": [
    {"name": "c0", "probability_per_hour": 0.015619},
    {"name": "c1", "probability_per_hour": 0.003647, "intermittent": true},
    {"name": "c2", "probability_per_hour": 0.077925},
    {"name": "c3", "probability_per_hour": 2.4e-05},
    {"name": "c4", "modes": [
      {"name": "c4-m0", "probability_per_hour": 0.022289, "affects": ["t3", "s2", "s1", "t1"]},
      {"name": "c4-m1", "probability_per_hour": 0.000408},
      {"name": "c4-m2", "probability_per_hour": 0.000166}]},
    {"name": "c5", "probability_per_hour": 1.4e-05},
    {"name": "c6", "probability_per_hour": 0.000386},
    {"name": "c7", "probability_per_hour": 0.001903}],
  "signals": [
    {"name": "s0", "needs": ["c7"]},
    {"name": "s1", "needs": ["c4", "c3", {"any_of": ["c0", "c6"]}]},
    {"name": "s2", "needs": ["c2", "c4", {"any_of": ["c1", "s0", "s1"]}]}],
  "tests": [
    {"name": "t0", "needs": ["s2", "c5"]},
    {"name": "t1", "needs": [{"any_of": ["c4", "c2"]}, {"any_of": ["c6", "c5"]}]},
    {"name": "t2", "needs": ["s1", "c5"]},
    {"name": "t3", "needs": ["c1", {"any_of": ["s0", "c4", "c0"]}]},
    {"name": "t4", "needs": ["c3", "c7", {"any_of": ["c5", "s1"]}, "s0"]},
    {"name": "t5", "needs": ["s1"]},
    {"name": "t6", "needs": [{"any_of": ["c0", "c5"]}]},
    {"name": "t7", "needs": ["s1"]},
    {"name": "t8", "needs": [{"any_of": ["s1", "c1"]}]}]
}"#;

/// Leaving out `t2` suffices. In flight the limit ends the search before; a report finds it.
#[test]
fn a_report_finds_the_smallest_set_of_tests() {
    let mut diagnoser = Diagnoser::thorough(Arc::new(Model::parse("m.json", REDUNDANT).unwrap()));
    let said = ["", "passed", "passed", "passed", "failed", "intermittent", "passed", "failed", ""];
    diagnoser.set_all(said.iter().enumerate().map(|(test, said)| {
        let outcome = match *said {
            "passed" => Outcome::Passed,
            "failed" => Outcome::Failed,
            "intermittent" => Outcome::Intermittent,
            _ => Outcome::Unknown,
        };
        (test, outcome)
    }));
    let contradiction = diagnoser.diagnosis().contradiction.clone().unwrap();
    assert!(contradiction.is_smallest && contradiction.are_all, "{}", diagnoser.text());
    assert!(contradiction.left_out.contains(&vec![2]), "{}", diagnoser.text());
    assert!(contradiction.left_out.iter().all(|set| set.len() == 1), "{}", diagnoser.text());
}
