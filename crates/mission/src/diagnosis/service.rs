//! The diagnosis service: outcomes of tests come in as measurements and messages, diagnoses go out as measurements and messages.
//!
//! Runs: in the fold of the situation, after each step that has an outcome. What it reports enters the next batch and is recorded like all
//! inputs, so that PDL watches it and replay derives the same. In: `(test-outcome TEST)` with `passed`, `failed`, `intermittent` or
//! `unknown`, and the messages `(test-passed TEST)`, `(test-failed TEST)`, `(test-intermittent TEST)`, `(test-unknown TEST)`. Out:
//! `(test-state TEST)`, `(health COMPONENT)`, `(candidates MODEL)`, and the messages `(diagnosed COMPONENT HEALTH FAILED-TESTS)`,
//! `(test-doubted TEST AGE)` and `(tests-contradict UNEXPLAINED TESTS)`. Bound: that of [`Diagnoser`] for each batch, O(tests + components)
//! otherwise.

use crate::text::plain_duration;
use apex_diagnosis::{Contradiction, Diagnoser, Health, Model, Outcome};
use apex_model::effect::Effect;
use apex_model::event::{Batch, EventKind, StateVariable};
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_runtime::ports::Input;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Candidates that are published, the likeliest first.
const PUBLISHED_MAX: usize = 5;

/// State of the service: the outcomes, from which everything else follows, and the published part of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DiagnosisService {
    outcomes: Vec<Outcome>,
    /// Of each pass the instant of its newest report, of each failure its beginning.
    instants: Vec<Time>,
    published: Option<Published>,
    #[serde(skip)]
    kept: DiagnoserCache,
}

/// Last published values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Published {
    outcomes: Vec<Outcome>,
    components: Vec<Health>,
    candidates: Value,
    doubted: Vec<usize>,
    /// Unexplained tests, and the set of tests that contradict them.
    contradiction: Option<(Vec<usize>, Vec<usize>)>,
}

/// The diagnoser of these reports; created again after a snapshot is restored.
#[derive(Clone, Debug, Default)]
struct DiagnoserCache(Option<Diagnoser>);

impl PartialEq for DiagnoserCache {
    /// Returns true: the diagnoser follows from the reports, so it does not distinguish two services.
    fn eq(&self, _: &DiagnoserCache) -> bool {
        true
    }
}

/// Report of the service after a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reported {
    /// Inputs for the next batch.
    pub inputs: Vec<Input>,
    /// Lines for the report.
    pub notes: Vec<String>,
}

impl DiagnosisService {
    /// Returns the reported outcome of each test with its instant in ns, as [`Diagnoser::report_all`] takes them; none before the first
    /// step.
    pub fn reports(&self) -> impl Iterator<Item = (usize, Outcome, i64)> {
        let reports = self.outcomes.iter().zip(&self.instants).enumerate();
        reports.map(|(test, (outcome, at))| (test, *outcome, at.0))
    }

    /// Observes a step: the messages of its batch, then those that the agent sends.
    pub fn observe(&mut self, model: &Arc<Model>, batch: &Batch, effects: &[Effect]) -> Reported {
        let mut reported = Reported::default();
        self.outcomes.resize(model.tests.len(), Outcome::Unknown);
        self.instants.resize(model.tests.len(), Time::ZERO);
        let of_agent = effects.iter().filter_map(|effect| match effect {
            Effect::Inform { form, .. } => Some((batch.now, message(form)?)),
            _ => None,
        });
        let of_batch = batch.events.iter().filter_map(|event| Some((event.at, said(&event.kind)?)));
        let mut is_new = self.published.is_none();
        for (at, (name, outcome)) in of_batch.chain(of_agent) {
            match (model.test(&name), outcome) {
                (Some(test), Ok(outcome)) => {
                    self.take(test, outcome, at);
                    is_new = true;
                }
                (None, _) => reported.notes.push(format!("model `{}` has no test `{name}`", model.name)),
                (_, Err(word)) => reported.notes.push(format!("`{word}` is not an outcome of test `{name}`")),
            }
        }
        if !is_new {
            return reported;
        }
        let mut diagnoser = self.kept.0.take().unwrap_or_else(|| Diagnoser::new(Arc::clone(model)));
        diagnoser.report_all(self.reports());
        let next = Published::of(&diagnoser);
        let before = self.published.replace(next.clone());
        DiagnosisChanges { diagnoser: &diagnoser, now: batch.now, before: before.as_ref(), next: &next }
            .report(&mut reported);
        self.kept.0 = Some(diagnoser);
        reported
    }

    /// Takes a report. A failure that is reported again keeps its beginning.
    fn take(&mut self, test: usize, outcome: Outcome, at: Time) {
        if let Some((known, instant)) = self.outcomes.get_mut(test).zip(self.instants.get_mut(test)) {
            if !(known.is_failure() && outcome.is_failure()) {
                *instant = at;
            }
            *known = outcome;
        }
    }
}

/// Returns the name of the test that an event reports, with its outcome, or with the word that is not an outcome; `None` for other events.
fn said(kind: &EventKind) -> Option<(String, Result<Outcome, String>)> {
    match kind {
        EventKind::Measurement(variable, value) if variable.attribute.is("test-outcome") => {
            let word = name(value);
            Some((name(&variable.object), Outcome::of_word(&word).ok_or(word)))
        }
        EventKind::Occurrence(form) => message(form),
        _ => None,
    }
}

/// Reads a message `(test-OUTCOME TEST)`; `None` for other messages.
fn message(form: &Value) -> Option<(String, Result<Outcome, String>)> {
    let [Value::Symbol(word), test] = form.as_list()? else { return None };
    let outcome = Outcome::of_word(word.folded().strip_prefix("test-")?)?;
    Some((name(test), Ok(outcome)))
}

fn name(value: &Value) -> String {
    value.as_symbol().map_or_else(|| value.to_string(), |name| name.folded().to_string())
}

impl Published {
    fn of(diagnoser: &Diagnoser) -> Published {
        let (model, diagnosis) = (diagnoser.model(), diagnoser.diagnosis());
        let set =
            |modes: &apex_diagnosis::Bits| Value::list(modes.iter().map(|mode| Value::symbol(model.mode_name(mode))));
        let candidates = diagnosis.candidates(PUBLISHED_MAX);
        let named =
            |found: &Contradiction| (found.unexplained.clone(), found.left_out.first().cloned().unwrap_or_default());
        Published {
            outcomes: diagnoser.outcomes().to_vec(),
            components: diagnosis.components.clone(),
            candidates: Value::list(candidates.iter().map(|candidate| set(&candidate.modes))),
            doubted: diagnosis.doubts.iter().map(|doubt| doubt.test).collect(),
            contradiction: diagnosis.contradiction.as_ref().map(named),
        }
    }
}

/// The difference of two diagnoses.
struct DiagnosisChanges<'a> {
    diagnoser: &'a Diagnoser,
    now: Time,
    before: Option<&'a Published>,
    next: &'a Published,
}

impl DiagnosisChanges<'_> {
    fn report(&self, reported: &mut Reported) {
        for (index, (test, outcome)) in self.diagnoser.model().tests.iter().zip(&self.next.outcomes).enumerate() {
            if self.before.and_then(|before| before.outcomes.get(index)) != Some(outcome) {
                let word =
                    Outcome::WORDS.iter().find(|(_, known)| known == outcome).map_or("unknown", |(word, _)| word);
                self.measure("test-state", &test.name, Value::symbol(word), reported);
            }
        }
        for (index, (component, health)) in
            self.diagnoser.model().components.iter().zip(&self.next.components).enumerate()
        {
            let before = self.before.and_then(|before| before.components.get(index));
            if before == Some(health) {
                continue;
            }
            self.measure("health", &component.name, Value::symbol(health.word()), reported);
            let is_fault = |health: Health| matches!(health, Health::Bad | Health::Suspect);
            if is_fault(*health) || before.copied().is_some_and(is_fault) {
                let tests = self.names(&self.failed());
                let form =
                    [Value::symbol("diagnosed"), Value::symbol(&component.name), Value::symbol(health.word()), tests];
                self.say(form.to_vec(), reported);
                let tests: Vec<&str> =
                    self.failed().into_iter().map(|test| self.diagnoser.model().test_name(test)).collect();
                let failed = if tests.is_empty() { "no test".to_string() } else { tests.join(", ") };
                reported.notes.push(format!("{} is {health}; failed: {failed}", component.name));
            }
        }
        if self.before.is_none_or(|before| before.candidates != self.next.candidates) {
            self.measure("candidates", &self.diagnoser.model().symbol(), self.next.candidates.clone(), reported);
        }
        self.report_doubts(reported);
        if let Some((unexplained, left_out)) = &self.next.contradiction
            && self.before.is_none_or(|before| before.contradiction != self.next.contradiction)
        {
            let form = [Value::symbol("tests-contradict"), self.names(unexplained), self.names(left_out)];
            self.say(form.to_vec(), reported);
            let left_out: Vec<String> = left_out.iter().map(|test| self.aged(*test)).collect();
            reported.notes.push(format!("tests contradict each other; consistent without {}", left_out.join(", ")));
        }
    }

    /// Reports the passes that are doubted from now on.
    fn report_doubts(&self, reported: &mut Reported) {
        let model = self.diagnoser.model();
        for doubt in &self.diagnoser.diagnosis().doubts {
            if self.before.is_some_and(|before| before.doubted.contains(&doubt.test)) {
                continue;
            }
            let (test, failed) = (model.test_name(doubt.test), model.test_name(doubt.failed));
            let age = Duration(doubt.age_ns);
            let form = [Value::symbol("test-doubted"), Value::symbol(test), Value::Duration(age)];
            self.say(form.to_vec(), reported);
            let age = plain_duration(age);
            reported.notes.push(format!("{test} is doubted: it passed {age} before {failed} failed"));
        }
    }

    /// Returns the name of a test with its outcome and the age of it.
    fn aged(&self, test: usize) -> String {
        let name = self.diagnoser.model().test_name(test);
        let outcome = self.next.outcomes.get(test).copied().unwrap_or_default();
        let word = if outcome.is_failure() { "failed" } else { "passed" };
        let age = Duration(self.now.0.saturating_sub(self.diagnoser.instant_ns(test)));
        match age.0 > 0 {
            true => format!("{name} ({word} {} ago)", plain_duration(age)),
            false => format!("{name} ({word} now)"),
        }
    }

    fn failed(&self) -> Vec<usize> {
        let failed = |outcome: &Outcome| matches!(outcome, Outcome::Failed | Outcome::Intermittent);
        let outcomes = self.next.outcomes.iter().enumerate();
        outcomes.filter(|(_, outcome)| failed(outcome)).map(|(test, _)| test).collect()
    }

    fn names(&self, tests: &[usize]) -> Value {
        Value::list(tests.iter().map(|test| Value::symbol(self.diagnoser.model().test_name(*test))))
    }

    fn measure(&self, attribute: &str, object: &str, value: Value, reported: &mut Reported) {
        let variable = StateVariable::new(Symbol::new(attribute), Value::symbol(object));
        reported.inputs.push(Input::new(self.now, EventKind::Measurement(variable, value)));
    }

    fn say(&self, items: Vec<Value>, reported: &mut Reported) {
        reported.inputs.push(Input::new(self.now, EventKind::Occurrence(Value::list(items))));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;
    use apex_model::event::Event;

    fn model() -> Arc<Model> {
        let text = include_str!("../../../../library/diagnosis/observation-uav.json");
        Arc::new(Model::parse("observation-uav.json", text).unwrap())
    }

    fn batch(forms: &[&str]) -> Batch {
        let read = |form: &&str| EventKind::Occurrence(apex_pdl::read_value(form).unwrap());
        let event = |kind| Event { sequence: 0, at: Time::ZERO, kind };
        Batch { now: Time::ZERO, events: forms.iter().map(read).map(event).collect() }
    }

    fn shown(reported: &Reported) -> Vec<String> {
        let text = |input: &Input| match &input.kind {
            EventKind::Measurement(variable, value) => format!("{variable} = {value}"),
            EventKind::Occurrence(form) => form.to_string(),
            other => format!("{other:?}"),
        };
        reported.inputs.iter().map(text).collect()
    }

    #[test]
    fn everything_is_published_once_and_then_what_changes() {
        let (model, mut service) = (model(), DiagnosisService::default());
        assert_eq!(service.observe(&model, &batch(&[]), &[]).inputs.len(), 25 + 17 + 1);
        assert_eq!(service.observe(&model, &batch(&[]), &[]), Reported::default());
        let passed = ["(test-passed payload-voltage)", "(test-passed computer-heartbeat)", "(test-passed sharpness)"];
        service.observe(&model, &batch(&passed), &[]);
        let reported = service.observe(&model, &batch(&["(test-failed radio-rssi)"]), &[]);
        let shown = shown(&reported);
        assert!(shown.contains(&"(health antenna-cable) = suspect".to_string()), "{shown:?}");
        assert!(
            shown.contains(
                &"(candidates observation-uav) = ((radio-modem) (antenna-cable) (radio-antenna))".to_string()
            )
        );
    }

    #[test]
    fn what_the_agent_says_of_a_test_counts_as_what_it_hears() {
        let (model, mut heard, mut said) = (model(), DiagnosisService::default(), DiagnosisService::default());
        let inform = Effect::Inform {
            form: apex_pdl::read_value("(test-failed imu-self-test)").unwrap(),
            task: apex_model::task::TaskId(1),
        };
        let by_effect = said.observe(&model, &batch(&[]), &[inform]);
        assert_eq!(by_effect, heard.observe(&model, &batch(&["(test-failed imu-self-test)"]), &[]));
        assert!(shown(&by_effect).contains(&"(health imu) = bad".to_string()));
    }

    #[test]
    fn a_restored_service_continues_as_before() {
        let (model, mut service) = (model(), DiagnosisService::default());
        service.observe(&model, &batch(&["(test-failed gps-fix)"]), &[]);
        let bytes = postcard::to_stdvec(&service).unwrap();
        let mut restored: DiagnosisService = postcard::from_bytes(&bytes).unwrap();
        assert_eq!(restored, service);
        let next = batch(&["(test-passed gps-fix)"]);
        assert_eq!(restored.observe(&model, &next, &[]), service.observe(&model, &next, &[]));
    }

    #[test]
    fn an_unknown_test_is_noted() {
        let reported = DiagnosisService::default().observe(&model(), &batch(&["(test-failed nonsense)"]), &[]);
        assert_eq!(reported.notes, ["model `observation-uav` has no test `nonsense`"]);
    }
}
