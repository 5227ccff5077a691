//! An independent check: small random models, diagnosed by trying all fault sets. It reads the model's JSON separately, follows the needs
//! of each test for each fault set, and shares no code with the crate.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test that cannot continue fails")]

mod witness;

use apex_diagnosis::{Diagnoser, Health, Model, Outcome, SearchEnd, testability};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;
use witness::{Choices, Faults, Said, Witness, random_model};

const SAID: [(Said, Outcome); 4] = [
    (Said::Nothing, Outcome::Unknown),
    (Said::Pass, Outcome::Passed),
    (Said::Fail, Outcome::Failed),
    (Said::Both, Outcome::Intermittent),
];

fn outcome(said: Said) -> Outcome {
    SAID.iter().find(|(known, _)| *known == said).map(|(_, outcome)| *outcome).unwrap()
}

/// Returns a model with results: either results that some fault set explains, or arbitrary ones.
fn case(bytes: Vec<u8>) -> (Arc<Model>, Witness, Vec<Said>) {
    let mut choices = Choices::new(bytes);
    let text = random_model(&mut choices);
    let model = Model::parse("random.json", &text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let witness = Witness::read(&text);
    let is_consistent = choices.below(4) > 0;
    let present = choices.below(1 << witness.modes.len()) & choices.below(1 << witness.modes.len());
    let said = (0..witness.tests.len()).map(|test| {
        let fails = witness.fails(test, present);
        match (choices.below(8), is_consistent) {
            (0, _) => Said::Nothing,
            (1, _) if fails => Said::Both,
            (2 | 3, false) => Said::Fail,
            _ if fails => Said::Fail,
            _ => Said::Pass,
        }
    });
    let said = said.collect();
    (Arc::new(model), witness, said)
}

fn sets(diagnoser: &Diagnoser) -> BTreeSet<Faults> {
    let candidates = diagnoser.diagnosis().candidates(10_000);
    candidates.iter().map(|candidate| candidate.modes.iter().map(|mode| 1 << mode).sum()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn diagnoses_equal_those_of_all_fault_sets(bytes in prop::collection::vec(any::<u8>(), 160)) {
        let (model, witness, said) = case(bytes);
        let mut diagnoser = Diagnoser::new(Arc::clone(&model));
        // Outcomes are set one at a time, because state kept from earlier diagnoses must not influence later ones.
        for (test, said) in said.iter().enumerate() {
            diagnoser.set(test, outcome(*said));
        }
        let mut fresh = Diagnoser::new(Arc::clone(&model));
        fresh.set_all(said.iter().map(|said| outcome(*said)).enumerate());
        prop_assert_eq!(diagnoser.diagnosis(), fresh.diagnosis());

        let diagnosis = diagnoser.diagnosis();
        let mut explained = said.clone();
        let contradiction = diagnosis.contradiction.as_ref();
        prop_assert_eq!(contradiction.is_some(), witness.candidates(&said).is_empty(), "{}", diagnoser.text());
        for test in contradiction.iter().flat_map(|contradiction| &contradiction.unexplained) {
            explained[*test] = Said::Nothing;
        }
        let candidates = witness.candidates(&explained);
        prop_assert!(!candidates.is_empty());
        if diagnosis.end() == SearchEnd::All {
            prop_assert_eq!(&sets(&diagnoser), &candidates, "{}", diagnoser.text());
            let good = witness.good(&said);
            for (mode, health) in diagnosis.modes.iter().enumerate() {
                let within = candidates.iter().filter(|set| **set >> mode & 1 == 1).count();
                let expected = match within {
                    0 if good >> mode & 1 == 1 => Health::Good,
                    0 => Health::Unknown,
                    count if count == candidates.len() => Health::Bad,
                    _ => Health::Suspect,
                };
                prop_assert_eq!(*health, expected, "mode {}\n{}", mode, diagnoser.text());
            }
            for (component, own) in witness.components().into_iter().enumerate() {
                let is_bad = candidates.iter().all(|set| set & own != 0);
                prop_assert_eq!(diagnosis.components[component] == Health::Bad, is_bad, "component {}", component);
            }
            // Shares: prior odds by multiplication, instead of sums of logarithms.
            let odds = |set: Faults| witness.odds(set);
            let all: f64 = candidates.iter().map(|set| odds(*set)).sum();
            for candidate in diagnosis.candidates(10_000) {
                let set = candidate.modes.iter().map(|mode| 1 << mode).sum();
                prop_assert!((candidate.share - odds(set) / all).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn no_smaller_set_of_tests_explains_a_contradiction(bytes in prop::collection::vec(any::<u8>(), 160)) {
        let (model, witness, said) = case(bytes);
        for (mut diagnoser, is_thorough) in
            [(Diagnoser::new(Arc::clone(&model)), false), (Diagnoser::thorough(Arc::clone(&model)), true)]
        {
            diagnoser.set_all(said.iter().map(|said| outcome(*said)).enumerate());
            let Some(contradiction) = &diagnoser.diagnosis().contradiction else { return Ok(()) };
            // Without the limits of a flight the search comes to its end in models of this size.
            prop_assert!(contradiction.is_smallest || !is_thorough, "{}", diagnoser.text());
            let without = |left_out: u32| {
                let keep = |(test, said): (usize, &Said)| if left_out >> test & 1 == 1 { Said::Nothing } else { *said };
                let said: Vec<Said> = said.iter().enumerate().map(keep).collect();
                !witness.candidates(&said).is_empty()
            };
            let named: BTreeSet<u32> = contradiction
                .left_out.iter().map(|set| set.iter().map(|test| 1 << test).sum()).collect();
            for set in &named {
                prop_assert!(without(*set), "{}", diagnoser.text());
            }
            if contradiction.is_smallest {
                let size = named.iter().next().unwrap().count_ones();
                let smallest: BTreeSet<u32> = (1..1_u32 << said.len())
                    .filter(|set| set.count_ones() <= size && without(*set)).collect();
                prop_assert!(smallest.is_superset(&named) && smallest.iter().all(|set| set.count_ones() == size));
                if contradiction.are_all {
                    prop_assert_eq!(smallest, named, "{}", diagnoser.text());
                }
            }
        }
    }

    #[test]
    fn testability_equals_that_of_single_faults(bytes in prop::collection::vec(any::<u8>(), 160)) {
        let (model, witness, _) = case(bytes);
        let report = testability(&model);
        let modes = witness.modes.len();
        let row = |mode: usize| -> Vec<bool> { (0..witness.tests.len()).map(|test| witness.fails(test, 1 << mode)).collect() };
        let detected: Vec<usize> = (0..modes).filter(|mode| row(*mode).contains(&true)).collect();
        prop_assert_eq!(&report.detected, &detected);
        prop_assert!((report.detection - detected.len() as f64 / modes as f64).abs() < 1e-12);
        let rate = |which: &[usize]| -> f64 { which.iter().map(|mode| witness.modes[*mode].probability).sum() };
        let all: Vec<usize> = (0..modes).collect();
        prop_assert!((report.detection_weighted - rate(&detected) / rate(&all)).abs() < 1e-12);
        let like = |mode: usize| detected.iter().filter(|other| row(**other) == row(mode)).count();
        for (size, share) in (1..).zip(report.isolation) {
            let isolated = detected.iter().filter(|mode| like(**mode) <= size).count();
            let expected = if detected.is_empty() { 0.0 } else { isolated as f64 / detected.len() as f64 };
            prop_assert!((share - expected).abs() < 1e-12);
        }
        for mode in &detected {
            let group: Vec<usize> = detected.iter().copied().filter(|other| row(*other) == row(*mode)).collect();
            prop_assert_eq!(group.len() > 1, report.ambiguity_groups.contains(&group));
        }
        let column = |test: usize| -> Vec<bool> { (0..modes).map(|mode| witness.fails(test, 1 << mode)).collect() };
        for test in 0..witness.tests.len() {
            let equal: Vec<usize> = (0..witness.tests.len()).filter(|other| column(*other) == column(test)).collect();
            let is_silent = !column(test).contains(&true);
            prop_assert_eq!(report.silent_tests.contains(&test), is_silent);
            prop_assert_eq!(report.equal_tests.contains(&equal), equal.len() > 1 && !is_silent);
        }
        // The smallest set of tests tells as many failure modes apart as all tests do.
        let kinds = |tests: &dyn Fn(usize) -> bool| {
            let seen = |mode: usize| -> Vec<bool> { row(mode).iter().enumerate().map(|(test, fails)| *fails && tests(test)).collect() };
            (0..modes).map(seen).chain([vec![false; witness.tests.len()]]).collect::<BTreeSet<_>>().len()
        };
        let full = kinds(&|_| true);
        prop_assert_eq!(kinds(&|test| report.test_set.tests.contains(&test)), full);
        let least = (0..1_u32 << witness.tests.len())
            .filter(|set| kinds(&|test| set >> test & 1 == 1) == full).map(u32::count_ones).min();
        prop_assert!(report.test_set.is_smallest);
        prop_assert_eq!(Some(report.test_set.tests.len() as u32), least);
    }
}
