//! The story of a flight, collected from its steps.

use apex_executive::state::agent::Agent;
use apex_model::effect::Effect;
use apex_model::event::{Batch, EventKind};
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::{Deliberator, Observer};
use apex_spec::reasons::Asker;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

/// Steps between two checks of all tasks. In one flight of [`ASKED_FLIGHTS`] they are checked at each of the first steps, in which most
/// tasks begin: the answers of all tasks take longer than the rest of a step.
const ASKED_EVERY: u64 = 20;
const ASKED_ALWAYS: u64 = 500;
/// See [`ASKED_EVERY`].
pub(crate) const ASKED_FLIGHTS: u64 = 5;
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

/// A failure of the vehicle: its kind, its subject, and its beginning and end.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FaultSpan {
    pub(crate) kind: String,
    pub(crate) of: String,
    pub(crate) from_s: f64,
    pub(crate) until_s: f64,
}

/// A flight, collected from its steps.
#[derive(Default)]
pub(crate) struct Story {
    /// The mission's folder, which is part of place names in messages and differs for each flight.
    folder: String,
    /// Number of the first steps at each of which all tasks are checked.
    asked_always: u64,
    pub(crate) steps: u64,
    /// Failures in the order in which they began.
    pub(crate) faults: Vec<FaultSpan>,
    /// Messages of [`REPORTS`] with their instants.
    pub(crate) reported: Vec<(f64, String)>,
    pub(crate) asker: Asker,
    pub(crate) landed: bool,
    pub(crate) crashed: bool,
    pub(crate) exhausted: bool,
    pub(crate) airborne: bool,
    /// Instants of the first crash and of the end of its energy.
    pub(crate) lost_s: Option<f64>,
    /// Of batches and effects; `None` for a flight whose digest is not compared, because their text takes an eighth of its time.
    hasher: Option<DefaultHasher>,
}

impl Story {
    /// Returns the story of the flight of `seed` in the mission in `folder`, with or without a digest.
    pub(crate) fn of(folder: &Path, seed: u64, has_digest: bool) -> Story {
        let hasher = has_digest.then(DefaultHasher::new);
        let asked_always = if seed.is_multiple_of(ASKED_FLIGHTS) { ASKED_ALWAYS } else { 0 };
        Story { folder: folder.display().to_string(), asked_always, hasher, ..Story::default() }
    }

    /// Digest of all batches and effects; `None` if it was not requested.
    pub(crate) fn digest(&self) -> Option<u64> {
        self.hasher.as_ref().map(DefaultHasher::finish)
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
        if let Some(hasher) = &mut self.hasher {
            format!("{batch:?}{effects:?}").replace(&self.folder, "").hash(hasher);
        }
        let at_s = batch.now.seconds();
        for event in &batch.events {
            let EventKind::Occurrence(form) = &event.kind else { continue };
            let Some([Value::Symbol(head), rest @ ..]) = form.as_list() else { continue };
            match head.folded() {
                "truth-fault" => {
                    let (kind, of) = (word(rest.first()), word(rest.get(1)));
                    self.faults.push(FaultSpan { kind, of, from_s: at_s, until_s: f64::INFINITY });
                }
                "truth-fault-over" => {
                    let (kind, of) = (word(rest.first()), word(rest.get(1)));
                    let open = self.faults.iter_mut().rev().find(|span| span.kind == kind && span.of == of);
                    open.into_iter().for_each(|span| span.until_s = at_s);
                }
                "airborne" => (self.airborne, self.landed) = (true, false),
                "landed" => (self.airborne, self.landed) = (false, true),
                "crashed" => {
                    (self.airborne, self.crashed) = (false, true);
                    self.lost_s.get_or_insert(at_s);
                }
                "fuel-exhausted" => {
                    self.exhausted = true;
                    self.lost_s.get_or_insert(at_s);
                }
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
        if self.steps < self.asked_always || self.steps.is_multiple_of(ASKED_EVERY) {
            self.asker.inspect(agent, deliberator, now)?;
        }
        Ok(())
    }
}

fn word(value: Option<&Value>) -> String {
    value.map(Value::to_string).unwrap_or_default()
}
