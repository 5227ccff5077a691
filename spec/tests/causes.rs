//! Every cause on every page has a kind and follows from the record alone, and falsified causes are noticed.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a page or flight that cannot be read is a failed test"
)]

use apex_model::because::{Because, Evidence};
use apex_model::effect::Effect;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_spec::rederive::mutation::{Spoiling, spoiled};
use apex_spec::rederive::{Collector, Step, because_of, complaints};
use apex_spec::scenario::Scenario;
use apex_spec::{page, scenario, verdict};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Number of falsified causes tried for each kind and way.
const TRIES_MAX: usize = 3;
/// Longer records are not falsified, because each trial derives the whole record again.
const EFFECTS_MAX: usize = 400;

/// Returns the records of all pages, with their libraries.
fn records() -> Vec<(String, Arc<apex_model::library::Library>, Vec<Step>)> {
    let mut all = Vec::new();
    for path in page::files() {
        let text = std::fs::read_to_string(&path).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let runs = verdict::scenarios(&text).into_iter().filter(|(block, _)| block.kind == "trace");
        for (block, scenario) in runs {
            for (library, steps) in record(&scenario) {
                all.push((format!("{name}:{}", block.line), library, steps));
            }
        }
    }
    all
}

fn record(scenario: &Scenario) -> Vec<(Arc<apex_model::library::Library>, Vec<Step>)> {
    let Ok(program) = scenario::program(&scenario.pdl) else { return Vec::new() };
    let mut collector = Collector::default();
    scenario::run_observed(scenario, &program, &mut [&mut collector]).unwrap().ok();
    collector.steps.into_values().map(|steps| (Arc::clone(&program.0), steps)).collect()
}

#[test]
fn every_cause_on_the_pages_follows_from_the_record() {
    let records = records();
    let mut told = Vec::new();
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for (name, library, steps) in &records {
        for because in steps.iter().flat_map(|step| &step.effects).filter_map(because_of) {
            *kinds.entry(because.cause.kind()).or_default() += 1;
            assert!(!because.cause.text().is_empty(), "a cause without words: {:?}", because.cause);
        }
        for complaint in complaints(library, steps) {
            let effect = &steps[complaint.step].effects[complaint.effect];
            told.push(format!("{name}: {} ({}): {effect:?}", complaint.what, complaint.kind));
        }
    }
    assert!(told.is_empty(), "{} causes do not follow:\n{}", told.len(), told[..told.len().min(25)].join("\n"));
    assert!(kinds.len() > 40, "the pages show few kinds of causes: {kinds:?}");
    assert!(!kinds.contains_key("executive-fault"));
}

#[test]
fn a_spoiled_cause_is_noticed_whatever_its_kind() {
    let mut tried: BTreeMap<(&str, Spoiling), (usize, usize)> = BTreeMap::new();
    for (_, library, steps) in records() {
        if steps.iter().map(|step| step.effects.len()).sum::<usize>() > EFFECTS_MAX {
            continue;
        }
        for (number, step) in steps.iter().enumerate() {
            for (index, effect) in step.effects.iter().enumerate() {
                let Some(because) = because_of(effect) else { continue };
                for how in [Spoiling::Swap, Spoiling::Shift] {
                    let count = tried.entry((because.cause.kind(), how)).or_default();
                    if count.0 >= TRIES_MAX {
                        continue;
                    }
                    let Some(wrong) = spoiled(&steps, (number, index), how) else { continue };
                    count.0 += 1;
                    count.1 += usize::from(!complaints(&library, &wrong).is_empty());
                }
            }
        }
    }
    tried.retain(|_, (tries, _)| *tries > 0);
    let blind: Vec<_> = tried.iter().filter(|(_, (tries, noticed))| noticed < tries).collect();
    let kinds = tried.len();
    assert!(blind.is_empty(), "{} of {kinds} ways of spoiling are not always noticed: {blind:?}", blind.len());
}

/// Two conditions that hold together, against thresholds that are computed.
const COMPUTED: &str = "
(defconstant least (* 2 3))
(procedure (index (do-domain)) (step w (watch 10)))
(procedure (index (watch ?high))
  (step a (print done) (waitfor (level tank > (* 2 ?high)) (pressure tank > least))))
";
const MEASURED: &str = r#"{"t": 1, "measurement": "(level tank)", "value": 15}
{"t": 2, "measurement": "(level tank)", "value": 25}
{"t": 3, "measurement": "(pressure tank)", "value": 5}
{"t": 4, "measurement": "(pressure tank)", "value": 9}"#;

#[test]
fn samples_are_held_against_computed_thresholds_of_several_conditions() {
    let scenario = Scenario { pdl: COMPUTED.into(), inputs: MEASURED.into(), ..Scenario::default() };
    let (library, steps) = record(&scenario).pop().unwrap();
    assert_eq!(complaints(&library, &steps), []);
    let samples =
        |because: &Because| because.evidence.iter().filter(|each| matches!(each, Evidence::Sample { .. })).count();
    let mut tried = 0;
    for (number, step) in steps.iter().enumerate() {
        for (index, because) in step.effects.iter().enumerate().filter_map(|(at, each)| Some((at, because_of(each)?))) {
            for spoil in 0..samples(because) {
                // The previous sample, which was also measured but does not meet the threshold.
                let mut wrong = steps.clone();
                let Effect::Decided(decision) = &mut wrong[number].effects[index] else { continue };
                let mut count = 0;
                decision.because.evidence = because
                    .evidence
                    .iter()
                    .cloned()
                    .map(|mut each| {
                        if let Evidence::Sample { value, at, .. } = &mut each {
                            if count == spoil {
                                let (earlier, low) = if *at == Time::from_seconds(2.0) { (1.0, 15) } else { (3.0, 5) };
                                (*at, *value) = (Time::from_seconds(earlier), Value::Integer(low));
                            }
                            count += 1;
                        }
                        each
                    })
                    .collect();
                tried += 1;
                assert!(!complaints(&library, &wrong).is_empty(), "{:?}", wrong[number].effects[index]);
            }
        }
    }
    assert!(tried >= 2, "{tried}");
}

#[test]
fn the_reference_lists_every_kind_of_cause_and_no_other() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let source = std::fs::read_to_string(format!("{root}/crates/model/src/cause.rs")).unwrap();
    let reference = std::fs::read_to_string(format!("{root}/docs/reference/trace.md")).unwrap();
    let variant = |line: &str| {
        let name =
            line.strip_prefix("    ").filter(|name| name.starts_with(|first: char| first.is_ascii_uppercase()))?;
        let name = name.trim_end_matches([',', ' ', '{']);
        let mut kind = String::new();
        for character in name.chars() {
            if character.is_ascii_uppercase() && !kind.is_empty() {
                kind.push('-');
            }
            kind.push(character.to_ascii_lowercase());
        }
        Some(kind)
    };
    let known: Vec<String> = source.lines().filter_map(variant).collect();
    let section = reference.split("## Causes").nth(1).and_then(|rest| rest.split("\n## ").next()).unwrap_or_default();
    let listed: Vec<&str> = section.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next()).collect();
    assert!(known.len() > 50, "{known:?}");
    assert_eq!(known, listed);
}
