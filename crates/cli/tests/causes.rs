//! Every cause of the shipped missions' flights follows from their records alone.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a page or flight that cannot be read is a failed test"
)]

mod common;

use apex_model::library::Library;
use apex_pdl::{HostSignature, Requirement, SourceText};
use apex_runtime::record::RecordReader;
use apex_spec::rederive::mutation::{Spoiling, spoiled};
use apex_spec::rederive::{Step, because_of, complaints};
use common::Desk;
use std::path::Path;

/// Flies a shipped mission until an instant. Where a budget of planning is given with a smaller one, the smaller one is used: the causes
/// do not depend on the quality of plans.
fn flown(name: &str, until: &str, budgets: Option<(&str, &str)>) -> (Library, Vec<Step>) {
    let desk = Desk::with_mission(name);
    if let Some((shipped, small)) = budgets {
        desk.change("m/mission.pdl", shipped, small);
    }
    let arguments = ["fly", "m", "--until", until, "--record", "flight.apex", "--no-progress"];
    desk.apex(&arguments).well();
    let reader = RecordReader::open(&desk.path("flight.apex")).unwrap();
    let steps = reader.steps().unwrap().map(|step| {
        let step = step.unwrap();
        let effects = step.effects.iter().map(|effect| effect.effect().unwrap()).collect();
        Step { batch: step.batch, effects }
    });
    let steps = steps.collect();
    (library(&reader), steps)
}

fn library(reader: &RecordReader) -> Library {
    let sources = reader.pdl_sources().unwrap();
    let text = |source: &apex_model::source::SourceFile| SourceText {
        name: source.name.to_string(),
        text: source.text.to_string(),
    };
    let host: Vec<HostSignature> =
        apex_geo::functions::host_signatures().into_iter().map(HostSignature::pure).collect();
    let mut resolve = |requirement: Requirement| {
        let wanted = match requirement {
            Requirement::File { name, .. } => name,
            Requirement::Library(name) => format!("{name}.pdl"),
        };
        let found = sources.iter().find(|source| Path::new(&*source.name).ends_with(&wanted));
        found.map(text).ok_or_else(|| wanted.into())
    };
    let options = apex_pdl::CheckOptions { fragment: false, host: &host, resolve: &mut resolve };
    apex_pdl::check(vec![text(&sources[0])], options).library
}

fn follows(name: &str, until: &str, budgets: Option<(&str, &str)>, causes_min: usize) {
    let (library, steps) = flown(name, until, budgets);
    let causes = steps.iter().flat_map(|step| &step.effects).filter_map(because_of).count();
    assert!(causes >= causes_min, "{causes} causes");
    let told: Vec<String> = complaints(&library, &steps)
        .into_iter()
        .map(|complaint| {
            let at = &steps[complaint.step];
            format!("{}: {} ({}): {:?}", at.batch.now, complaint.what, complaint.kind, at.effects[complaint.effect])
        })
        .collect();
    assert!(told.is_empty(), "{} of {causes} causes do not follow:\n{}", told.len(), told.join("\n"));
}

#[test]
fn causes_of_first_picture_follow_from_its_record() {
    follows("first-picture", "15min", None, 100);
}

#[test]
fn causes_of_structure_watch_follow_from_its_record() {
    follows("structure-watch", "1h", Some((":budget 500ms", ":budget 50ms")), 300);
}

#[test]
fn causes_of_western_states_follow_from_its_record() {
    follows("western-states", "24h", Some((":budget 3s", ":budget 300ms")), 2000);
}

#[test]
fn a_spoiled_cause_of_a_flight_is_noticed() {
    let (library, steps) = flown("first-picture", "15min", None);
    let (mut tried, mut missed) = (0, Vec::new());
    let all =
        steps.iter().enumerate().flat_map(|(step, each)| (0..each.effects.len()).map(move |effect| (step, effect)));
    for at in all.collect::<Vec<_>>().into_iter().step_by(5) {
        for how in [Spoiling::Swap, Spoiling::Shift] {
            let Some(wrong) = spoiled(&steps, at, how) else { continue };
            tried += 1;
            if complaints(&library, &wrong).is_empty() {
                missed.push((how, steps[at.0].effects[at.1].clone()));
            }
        }
    }
    assert!(tried > 30 && missed.is_empty(), "{} of {tried} are missed: {missed:?}", missed.len());
}
