//! One line of a trace. Keys and words are an interface: programs read them.

use super::field::{FieldValue, LineFormatter};
use crate::effect_describer::{EffectDescriber, EffectRow, cause_text};
use crate::escaping;
use apex_model::effect::{Decision, DecisionKind, Effect};
use apex_model::event::{Event, EventKind, Message, SolverReport, StateVariable};
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;
use apex_model::value::Value;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::fmt::Write as _;
use std::io::{self, Write};
use std::sync::Arc;

/// Number of columns of the instant in text, so that lines within one hour are aligned.
const TIME_COLUMNS: usize = 12;

/// Kind of the line of a sample.
pub(super) const MEASUREMENT: &str = "measurement";

/// A line before it is written.
#[derive(Clone, Debug)]
pub(super) struct TraceLine {
    pub(super) at: Time,
    /// Agent of the line, if several agents run.
    pub(super) agent: Option<Arc<str>>,
    pub(super) kind: &'static str,
    pub(super) task: Option<TaskId>,
    pub(super) goal: Arc<str>,
    /// Text in which the filter by object searches, in addition to the goal.
    pub(super) subject: String,
    pub(super) place: Option<String>,
    /// Keys between `goal` and `cause`, with their values.
    fields: Vec<(&'static str, FieldValue)>,
    cause: String,
    /// The sentence of the text form, without task, cause and place.
    words: String,
}

impl TraceLine {
    fn new(at: Time, kind: &'static str, subject: String, words: String) -> TraceLine {
        let (fields, cause) = (Vec::new(), String::new());
        TraceLine { at, agent: None, kind, task: None, goal: Arc::from(""), subject, place: None, fields, cause, words }
    }

    fn text_field(&mut self, key: &'static str, text: &str) -> &mut TraceLine {
        self.field(key, FieldValue::Text(text.to_owned()))
    }

    fn field(&mut self, key: &'static str, value: impl Into<FieldValue>) -> &mut TraceLine {
        self.fields.push((key, value.into()));
        self
    }

    /// Returns the line of an input.
    pub(super) fn of_event(event: &Event) -> TraceLine {
        let at = event.at;
        let line = |kind, subject: String, words: String| TraceLine::new(at, kind, subject, words);
        match &event.kind {
            EventKind::Measurement(variable, value) => TraceLine::of_measurement(at, variable, value),
            EventKind::Occurrence(form) => TraceLine::of_occurrence(at, form),
            EventKind::Told(author, message) => {
                let mut line = match message {
                    Message::Occurrence(form) => TraceLine::of_occurrence(at, form),
                    Message::Measurement(variable, value) => TraceLine::of_measurement(at, variable, value),
                };
                let _ = write!(line.words, " from {author}");
                line.text_field("from_agent", author.printed());
                line
            }
            EventKind::Stop(reason) => {
                let mut line = line("stop", String::new(), format!("the application ends: {reason}"));
                line.text_field("reason", reason);
                line
            }
            EventKind::CommandAcknowledged(command, result) => {
                let name = format!("command {}", command.0);
                let words = match result {
                    Ok(_) => format!("{name} acknowledged"),
                    Err(reason) => format!("{name} failed: {reason}"),
                };
                let mut line = line("acknowledged", name, words);
                line.field("command", command.0);
                match result {
                    Ok(value) => line.field("value", value),
                    Err(reason) => line.text_field("error", reason),
                };
                line
            }
            EventKind::CommandProgressed(command, progress) => {
                let name = format!("command {}", command.0);
                let words = format!("{name} is {}", progress.word());
                let mut line = line("acknowledged", name, words);
                line.field("command", command.0).text_field("progress", progress.word());
                line
            }
            EventKind::SolverReported(request, report) => {
                let mut line = line("solver", format!("request {}", request.0), String::new());
                line.field("request", request.0);
                match report {
                    SolverReport::Plan(plan) => {
                        line.words = format!("{} answers request {}: {}", plan.solver, request.0, plan.summary);
                        line.text_field("solver", plan.solver.printed()).text_field("summary", &plan.summary);
                    }
                    SolverReport::Failed(reason) => {
                        line.words = format!("request {} failed: {reason}", request.0);
                        line.text_field("error", reason);
                    }
                }
                line
            }
            EventKind::OperatorAnswered(question, value) => {
                let name = format!("question {}", question.0);
                let mut line = line("answer", name.clone(), format!("operator answers {name}: {value}"));
                line.field("question", question.0).field("value", value);
                line
            }
            EventKind::Woken => line("wake", String::new(), "wake".into()),
        }
    }

    fn of_measurement(at: Time, variable: &StateVariable, value: &Value) -> TraceLine {
        let (name, text) = (variable.to_string(), value.to_string());
        let words = format!("{name} = {text}");
        let mut line = TraceLine::new(at, MEASUREMENT, name.clone(), words);
        line.field("variable", FieldValue::Text(name)).field("value", FieldValue::of(value, text));
        line
    }

    fn of_occurrence(at: Time, form: &Value) -> TraceLine {
        let form = form.to_string();
        let mut line = TraceLine::new(at, "event", form.clone(), format!("event {form}"));
        line.text_field("form", &form);
        line
    }

    /// Returns the line of a decision of the runtime.
    pub(super) fn of_note(at: Time, text: &str) -> TraceLine {
        let mut line = TraceLine::new(at, "note", String::new(), format!("note: {text}"));
        line.text_field("text", text);
        line
    }

    /// Returns the line of an effect of the step at `now`.
    pub(super) fn of_effect(now: Time, effect: &Effect, told: &EffectRow, describer: &EffectDescriber) -> TraceLine {
        let mut line = TraceLine::new(now, told.kind, told.subject.clone(), String::new());
        line.task = told.task;
        line.goal = Arc::clone(&told.goal);
        line.place.clone_from(&told.place);
        match effect {
            Effect::Decided(decision) => {
                line.cause.clone_from(&told.text);
                line.decided(decision, told, describer);
            }
            Effect::Command { command, because, .. } => {
                line.cause = cause_text(because);
                line.words = format!("command {} {}", command.0, told.subject);
                line.field("command", command.0).text_field("form", &told.subject);
            }
            Effect::WithdrawCommand { command, reason } => {
                line.words = format!("command {} withdrawn: {reason}", command.0);
                line.field("command", command.0).text_field("reason", reason);
            }
            Effect::Solve(request) => {
                line.words = format!("asks for a plan: {}", told.text);
                line.field("request", request.request.0).text_field("solver", request.solver.printed());
                if let Some(budget) = request.budget {
                    line.field("budget_s", Time(budget.0));
                }
            }
            Effect::CancelSolve(request) => {
                line.words = format!("request {} cancelled", request.0);
                line.field("request", request.0);
            }
            Effect::Inform { .. } => {
                line.kind = "event";
                line.words = format!("informs {}", told.subject);
                line.text_field("form", &told.subject);
            }
            Effect::Publish { variable, value, because, .. } => {
                line.cause = cause_text(because);
                line.words = format!("publishes {}", told.subject);
                line.text_field("variable", &variable.to_string()).field("value", value);
            }
            Effect::Print { text, .. } => {
                line.words = format!("prints {text}");
                line.text_field("text", text);
            }
            Effect::Ask { .. } => line.asked(effect, told),
            Effect::WithdrawQuestion { question, reason } => {
                line.words = format!("question {} withdrawn: {reason}", question.0);
                line.field("question", question.0).text_field("reason", reason);
            }
            Effect::Tell { to, message, .. } => {
                let names: Vec<String> = to.iter().map(ToString::to_string).collect();
                line.words = format!("tells {}: {message}", names.join(", "));
                line.text_field("to", &names.join(" ")).text_field("message", &message.to_string());
            }
            Effect::AgentEnded { reason } => {
                line.words = format!("the agent is done: {reason}");
                line.text_field("reason", reason);
            }
            Effect::EndApplication { reason } => {
                line.kind = "end";
                line.words = format!("end: {reason}");
                line.text_field("reason", reason);
            }
        }
        line
    }

    /// Adds the members of a question to the operator.
    fn asked(&mut self, effect: &Effect, told: &EffectRow) {
        let Effect::Ask { question, options, by, default, .. } = effect else { return };
        self.words = format!("asks {:?} ({})", told.subject, told.text);
        self.field("question", question.0).text_field("text", &told.subject);
        self.field("options", FieldValue::List(options.iter().map(FieldValue::from).collect()));
        if let Some(by) = by {
            self.field("by", *by);
        }
        if let Some(default) = default {
            self.field("default", default);
        }
    }

    fn decided(&mut self, decision: &Decision, told: &EffectRow, describer: &EffectDescriber) {
        match &decision.kind {
            DecisionKind::Created { parent, .. } => {
                self.words = "created".into();
                let tag = told.tag.as_deref().unwrap_or_default();
                if let Some(parent) = parent {
                    self.text_field("parent", &parent.to_string());
                }
                self.text_field("tag", tag).text_field("state", TaskState::Pending.word());
            }
            DecisionKind::Transition { from, to, .. } => {
                self.words = format!("{from} -> {to}");
                self.text_field("from", from.word()).text_field("state", to.word());
                if let Some(outcome) = told.outcome {
                    let _ = write!(self.words, " ({outcome})");
                    self.text_field("outcome", outcome);
                }
                if let Some(value) = &told.value {
                    let _ = write!(self.words, " with {value}");
                    self.field("value", value);
                }
            }
            DecisionKind::Satisfied { clause, interval } => {
                self.words = format!("{clause} satisfied");
                self.text_field("clause", clause);
                self.field("start", interval.0).field("end", interval.1);
            }
            DecisionKind::Bound { variable, value } => {
                self.words.clone_from(&told.subject);
                self.text_field("variable", &format!("?{variable}")).field("value", value);
            }
            DecisionKind::Selected { method, .. } => {
                let method = describer.method(method).to_string();
                self.words = format!("selected {method}");
                self.cause = cause_text(&decision.because);
                self.text_field("method", &method);
            }
            DecisionKind::Refused { winner, .. } => {
                self.words = format!("refused {}", told.subject);
                self.text_field("resource", &told.subject).text_field("winner", &winner.to_string());
            }
            DecisionKind::ProcedureAdded { request, summary, .. } => {
                self.kind = "plan";
                self.words = format!("plan added: {summary}");
                self.field("request", request.0).text_field("summary", summary);
            }
            DecisionKind::Trouble { message } => {
                // The cause of most of them is the message itself, which is then stated once.
                let told = if self.cause.ends_with(message.as_str()) { &self.cause } else { message };
                self.words = format!("trouble: {told}"); // english: allow
                self.text_field("message", message);
            }
        }
    }

    /// Writes `{"t":1.5,"kind":"transition","task":"T3","goal":"..",..,"cause":"..","place":".."}`
    ///
    /// # Errors
    /// The output's own.
    pub(super) fn write_json(&self, out: &mut impl Write) -> io::Result<()> {
        let mut serializer = serde_json::Serializer::with_formatter(out, LineFormatter);
        self.serialize(&mut serializer).map_err(io::Error::from)
    }

    /// Returns `       12.5s  T3 (power-up camera-1): enabled -> ongoing because it was granted camera-1; from file.pdl:14:3`
    pub(super) fn text(&self) -> String {
        let mut text = format!("{:>TIME_COLUMNS$}  ", self.at.to_string());
        match (&self.agent, self.task) {
            (Some(agent), Some(task)) => {
                let _ = write!(text, "{agent}/{task} {}: ", self.goal);
            }
            (Some(agent), None) => {
                let _ = write!(text, "{agent}: ");
            }
            (None, Some(task)) => {
                let _ = write!(text, "{task} {}: ", self.goal);
            }
            (None, None) => {}
        }
        text.push_str(&self.words);
        if !self.cause.is_empty() && !self.words.ends_with(&self.cause) {
            let _ = write!(text, " because {}", self.cause);
        }
        if let Some(place) = &self.place {
            let _ = write!(text, "; from {place}");
        }
        escaping::one_line(&text.replace('\r', ""))
    }
}

impl Serialize for TraceLine {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("t", &FieldValue::Seconds(self.at))?;
        map.serialize_entry("kind", self.kind)?;
        if let Some(agent) = &self.agent {
            map.serialize_entry("agent", &**agent)?;
        }
        if let Some(task) = self.task {
            map.serialize_entry("task", &task.to_string())?;
            map.serialize_entry("goal", &*self.goal)?;
        }
        for (key, value) in &self.fields {
            map.serialize_entry(key, value)?;
        }
        if !self.cause.is_empty() {
            map.serialize_entry("cause", &self.cause)?;
        }
        if let Some(place) = &self.place {
            map.serialize_entry("place", place)?;
        }
        map.end()
    }
}
