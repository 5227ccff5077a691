//! View of a run in progress for operators, computed from its steps: open questions, planning, updates of targets.

use apex_executive::state::agent::Agent;
use apex_model::effect::{Effect, SolveRequest, SolveRequestId};
use apex_model::event::{Batch, EventKind};
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::{Deliberator, Observer, SolverAnswer};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// State of a run according to its steps; shared by its observer and the door.
#[derive(Clone, Default)]
pub(crate) struct Seen(Arc<Mutex<KeptLines>>);

#[derive(Default)]
struct KeptLines {
    state: SeenState,
    planning: BTreeMap<SolveRequestId, (String, Instant)>,
}

/// State of a run in the form of the API.
#[derive(Clone, Debug, Default, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct SeenState {
    #[serde(skip)]
    pub(crate) now_ns: i64,
    /// Open questions, oldest first.
    pub(crate) questions: Vec<OpenQuestion>,
    /// The request on which planners work; mission time stops meanwhile.
    pub(crate) planning: Option<Planning>,
    /// True once the run has ended.
    #[serde(skip)]
    pub(crate) is_over: bool,
    /// Targets that messages have announced (true) or declared gone (false).
    #[serde(skip)]
    pub(crate) news: BTreeMap<String, bool>,
}

/// A question that waits for an answer.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct OpenQuestion {
    pub(crate) agent: String,
    pub(crate) question: u64,
    text: String,
    /// The choices as printed; empty if any answer is accepted.
    options: Vec<String>,
    /// Answer taken at the deadline; `None` fails the task.
    default: Option<String>,
    asked_ns: i64,
    /// The deadline.
    by_ns: Option<i64>,
    #[serde(skip)]
    pub(crate) choices: Vec<Value>,
}

/// A planner at work.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct Planning {
    /// The goal of the requested plan.
    goal: String,
    /// Wall time since the request, in seconds.
    since_s: f64,
}

impl Seen {
    fn kept(&self) -> MutexGuard<'_, KeptLines> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the state until now.
    pub(crate) fn state(&self) -> SeenState {
        let kept = self.kept();
        let planning = kept.planning.values().next();
        let planning =
            planning.map(|(goal, since)| Planning { goal: goal.clone(), since_s: since.elapsed().as_secs_f64() });
        SeenState { planning, ..kept.state.clone() }
    }
}

/// Observes a run for its [`crate::FlightDoor`].
pub struct FlightWatch {
    seen: Seen,
    /// Questions of the last observed step; the name of the agent is added at its inspection.
    asked: Vec<OpenQuestion>,
}

impl FlightWatch {
    pub(crate) fn new(seen: Seen) -> FlightWatch {
        FlightWatch { seen, asked: Vec::new() }
    }
}

impl Drop for FlightWatch {
    fn drop(&mut self) {
        self.seen.kept().state.is_over = true;
    }
}

impl Observer for FlightWatch {
    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        let mut kept = self.seen.kept();
        kept.state.now_ns = batch.now.0;
        for event in &batch.events {
            let EventKind::Occurrence(form) = &event.kind else { continue };
            match form.as_list() {
                Some([Value::Symbol(head), id, ..]) if head.folded() == "new-target" => {
                    kept.state.news.insert(id.to_string(), true);
                }
                Some([Value::Symbol(head), id, ..]) if head.folded() == "target-gone" => {
                    kept.state.news.insert(id.to_string(), false);
                }
                _ => {}
            }
        }
        for effect in effects {
            let Effect::Ask { question, text, options, by, default, .. } = effect else { continue };
            self.asked.push(OpenQuestion {
                agent: String::new(),
                question: question.0,
                text: text.clone(),
                options: options.iter().map(Value::to_string).collect(),
                default: default.as_ref().map(Value::to_string),
                asked_ns: batch.now.0,
                by_ns: by.map(|by| by.0),
                choices: options.clone(),
            });
        }
        Ok(())
    }

    fn inspect(&mut self, agent: &Agent, _: &dyn Deliberator, _: Time) -> Result<(), String> {
        let name = agent.name.printed();
        let mut kept = self.seen.kept();
        for question in self.asked.drain(..) {
            kept.state.questions.push(OpenQuestion { agent: name.to_string(), ..question });
        }
        let open = |question: u64| agent.questions.keys().any(|each| each.0 == question);
        kept.state.questions.retain(|each| Symbol::new(&each.agent) != agent.name || open(each.question));
        Ok(())
    }

    fn posed(&mut self, request: &SolveRequest, _: Time, _: &str) -> Result<(), String> {
        self.seen.kept().planning.insert(request.request, (request.goal.to_string(), Instant::now()));
        Ok(())
    }

    fn answered(&mut self, request: SolveRequestId, _: Time, _: &SolverAnswer) -> Result<(), String> {
        self.seen.kept().planning.remove(&request);
        Ok(())
    }
}
