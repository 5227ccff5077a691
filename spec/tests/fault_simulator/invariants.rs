//! The story of a flight, and the rules that it must keep.

use apex_executive::state::agent::Agent;
use apex_mission::verification::CheckResult;
use apex_model::effect::Effect;
use apex_model::event::{Batch, EventKind};
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::{Deliberator, Observer};
use apex_runtime::{EndReason, RunEnd};
use apex_spec::reasons::Asker;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Steps between two questions to all tasks: they are asked at each step in the first minutes, where most begins.
const ASKED_EVERY: u64 = 20;
const ASKED_ALWAYS: u64 = 500;
/// Messages by which tasks report that something is wrong.
const REPORTS: [&str; 22] = [
    "requirement-broken",
    "responding",
    "landing-early",
    "response-failed",
    "engine-out",
    "leak-found",
    "navigation-lost",
    "navigation-degraded",
    "reading-frozen",
    "icing-met",
    "rough-air",
    "storm-ahead",
    "violated",
    "lease-expired",
    "landing-because",
    "communication-lost",
    "contingency-route",
    "low-fuel",
    "skipped",
    "tour-failed",
    "survey-impossible",
    "camera-hot",
];

/// A flight as its steps tell it.
#[derive(Default)]
pub(crate) struct Story {
    pub(crate) steps: u64,
    /// Failures that began, by kind, with the instant of the first.
    pub(crate) faults: BTreeMap<String, f64>,
    /// Those messages with their instants.
    pub(crate) reported: Vec<(f64, String)>,
    asker: Asker,
    pub(crate) landed: bool,
    pub(crate) crashed: bool,
    pub(crate) exhausted: bool,
    airborne: bool,
    hasher: DefaultHasher,
}

impl Story {
    /// Digest of all batches and effects.
    pub(crate) fn digest(&self) -> u64 {
        self.hasher.finish()
    }

    pub(crate) fn outcome(&self) -> &'static str {
        match (self.crashed, self.landed && !self.airborne, self.airborne) {
            (true, ..) => "ended crashed",
            (_, true, _) => "ended landed",
            (_, _, true) => "ended in the air",
            _ => "never took off",
        }
    }
}

impl Observer for Story {
    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        self.steps += 1;
        format!("{batch:?}{effects:?}").hash(&mut self.hasher);
        let at_s = batch.now.seconds();
        for event in &batch.events {
            let EventKind::Occurrence(form) = &event.kind else { continue };
            let Some([Value::Symbol(head), rest @ ..]) = form.as_list() else { continue };
            match head.folded() {
                "truth-fault" => {
                    let kind = rest.first().map(Value::to_string).unwrap_or_default();
                    self.faults.entry(kind).or_insert(at_s);
                }
                "airborne" => (self.airborne, self.landed) = (true, false),
                "landed" => (self.airborne, self.landed) = (false, true),
                "crashed" => (self.airborne, self.crashed) = (false, true),
                "fuel-exhausted" => self.exhausted = true,
                _ => {}
            }
        }
        for effect in effects {
            let Effect::Inform { form, .. } = effect else { continue };
            if form.head().is_some_and(|head| REPORTS.iter().any(|word| head.is(word))) {
                self.reported.push((at_s, form.to_string()));
            }
        }
        Ok(())
    }

    fn inspect(&mut self, agent: &Agent, deliberator: &dyn Deliberator, now: Time) -> Result<(), String> {
        if self.steps < ASKED_ALWAYS || self.steps.is_multiple_of(ASKED_EVERY) {
            self.asker.inspect(agent, deliberator, now)?;
        }
        Ok(())
    }
}

/// The rules that a flight broke.
pub(crate) fn broken(story: &Story, end: &RunEnd, check: &CheckResult) -> Vec<String> {
    let mut rules = Vec::new();
    if let Some(first) = story.asker.missing().first() {
        rules.push(format!("a task is silent: {first} ({} in all)", story.asker.missing().len()));
    }
    if matches!(end.reason, EndReason::Quiescent | EndReason::Stopped) {
        rules.push(format!("it ended as {}", end.reason.text()));
    }
    let began = |kind: &str| story.faults.contains_key(kind);
    // Without engine or energy a landing may fail; with wrong readings a flight may meet the ground.
    let lost = ["engine", "leak", "navigation", "freeze", "silence", "bias", "acknowledgements"];
    // A command that is never acknowledged, or cannot be carried out, fails the task that waits for it.
    if let EndReason::Application(reason) = &end.reason
        && reason.contains("failed")
        && !lost.iter().any(|kind| began(kind))
    {
        rules.push(format!("at {:.0} s: {reason}", end.at.seconds()));
    }
    if story.crashed && !lost.iter().any(|kind| began(kind)) && !story.exhausted {
        rules.push(format!("it crashed without a failure: {:?}", story.faults));
    }
    if story.exhausted && !began("leak") && story.reported.is_empty() {
        rules.push("its energy ran out, and nothing was reported".to_string());
    }
    if (story.crashed || story.exhausted) && story.reported.is_empty() {
        rules.push(format!("it was lost, and no task reported it: {:?}", story.faults));
    }
    if check.violations() > 0 && check.said_broken.is_empty() && story.reported.is_empty() {
        rules.push(format!("requirements were violated, and no task reported it: {check}"));
    }
    rules
}
