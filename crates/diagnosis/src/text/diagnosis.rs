//! A diagnosis as text and JSON.

use super::{mode_names, test_names};
use crate::diagnoser::{Candidate, Diagnoser, Diagnosis, Health};
use crate::evidence::Outcome;
use crate::hitting::SearchEnd;
use crate::limits::{CANDIDATES_MAX, NODES_MAX};
use crate::model::Model;
use serde_json::{Value, json};
use std::fmt::Write;

/// Candidates are printed until they hold this share of the prior odds.
const SHARE_PRINTED: f64 = 0.99;
/// Maximum number of candidates that are printed.
const PRINTED_MAX: usize = 10;

impl Diagnoser {
    /// Returns the diagnosis as text.
    pub fn text(&self) -> String {
        let (model, diagnosis) = (self.model().as_ref(), self.diagnosis());
        let of = |wanted: Outcome| {
            let outcomes = self.outcomes().iter().enumerate();
            outcomes.filter(move |(_, outcome)| **outcome == wanted).map(|(test, _)| test)
        };
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}: {} of {} tests passed", model.name, of(Outcome::Passed).count(), model.tests.len());
        for (word, outcome) in [("failed", Outcome::Failed), ("intermittent", Outcome::Intermittent)] {
            if of(outcome).next().is_some() {
                let _ = writeln!(text, "  {word:<12} {}", test_names(model, of(outcome)));
            }
        }
        for health in [Health::Bad, Health::Suspect, Health::Unknown] {
            let modes = diagnosis.modes.iter().enumerate().filter(|(_, known)| **known == health).map(|(mode, _)| mode);
            let _ = writeln!(text, "  {:<12} {}", health.word(), mode_names(model, modes));
        }
        self.add_candidates(model, diagnosis, &mut text);
        add_contradiction(model, diagnosis, &mut text);
        text
    }

    fn add_candidates(&self, model: &Model, diagnosis: &Diagnosis, text: &mut String) {
        if diagnosis.groups.is_empty() {
            if diagnosis.contradiction.is_none() {
                let _ = writeln!(text, "  no failure needs an explanation");
            }
            return;
        }
        let candidates = diagnosis.candidates(CANDIDATES_MAX);
        let _ = writeln!(text, "candidates (share of the prior odds of those found)");
        let mut shown = 0.0;
        let mut count = 0;
        for candidate in candidates.iter().take(PRINTED_MAX) {
            let names = mode_names(model, candidate.modes.iter());
            let _ = writeln!(text, "  {:.3}  {{{names}}}", candidate.share);
            shown += candidate.share;
            count += 1;
            if shown >= SHARE_PRINTED {
                break;
            }
        }
        if count < candidates.len() {
            let _ = writeln!(text, "  {:.3}  {} others", (1.0 - shown).max(0.0), candidates.len() - count);
        }
        if let Some(note) = note(diagnosis.end()) {
            let _ = writeln!(text, "  {note}");
        }
    }

    /// Returns the diagnosis as JSON.
    pub fn json(&self) -> Value {
        let (model, diagnosis) = (self.model().as_ref(), self.diagnosis());
        let named = |names: &mut dyn Iterator<Item = &str>, healths: &[Health]| -> Value {
            names.zip(healths).map(|(name, health)| (name.to_string(), json!(health.word()))).collect()
        };
        let tests = |tests: &[usize]| tests.iter().map(|test| model.test_name(*test)).collect::<Vec<_>>();
        let candidate = |candidate: &Candidate| {
            let modes: Vec<&str> = candidate.modes.iter().map(|mode| model.mode_name(mode)).collect();
            json!({ "failure_modes": modes, "share": candidate.share })
        };
        let contradiction = diagnosis.contradiction.as_ref().map(|contradiction| {
            json!({
                "unexplained": tests(&contradiction.unexplained),
                "left_out": contradiction.left_out.iter().map(|set| tests(set)).collect::<Vec<_>>(),
                "is_smallest": contradiction.is_smallest,
                "are_all": contradiction.are_all,
            })
        });
        json!({
            "model": model.name,
            "failure_modes": named(&mut model.modes.iter().map(|mode| mode.name.as_str()), &diagnosis.modes),
            "components": named(&mut model.components.iter().map(|one| one.name.as_str()), &diagnosis.components),
            "candidates": diagnosis.candidates(CANDIDATES_MAX).iter().map(candidate).collect::<Vec<_>>(),
            "search": match diagnosis.end() {
                SearchEnd::All => "all",
                SearchEnd::Likeliest => "likeliest",
                SearchEnd::NodeLimit => "node-limit",
            },
            "contradiction": contradiction,
        })
    }
}

fn note(end: SearchEnd) -> Option<String> {
    match end {
        SearchEnd::All => None,
        SearchEnd::Likeliest => {
            Some(format!("note: the {CANDIDATES_MAX} likeliest of each group; there may be others, none likelier"))
        }
        SearchEnd::NodeLimit => Some(format!(
            "note: the search ended at its limit of {NODES_MAX} partial sets in a group: there may be likelier candidates"
        )),
    }
}

fn add_contradiction(model: &Model, diagnosis: &Diagnosis, text: &mut String) {
    let Some(contradiction) = &diagnosis.contradiction else { return };
    let unexplained = test_names(model, contradiction.unexplained.iter().copied());
    let _ = writeln!(text, "contradiction: no failure explains {unexplained} together with the tests that passed");
    let sets: Vec<String> =
        contradiction.left_out.iter().map(|set| format!("{{{}}}", test_names(model, set.iter().copied()))).collect();
    let smallest = if contradiction.is_smallest { "smallest sets of tests" } else { "sets of tests" };
    let others = if contradiction.are_all { "" } else { ", perhaps others" };
    let _ = writeln!(text, "  {smallest} without which the rest is consistent: {}{others}", sets.join(" or "));

    let _ = writeln!(text, "  one of them is wrong, or the model lacks a dependency");
}
