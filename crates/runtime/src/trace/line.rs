//! One line of a trace. Keys and words are an interface: programs read them.

use crate::narrator::{Narrator, Told, cause_text};
use apex_model::effect::{DecisionKind, Effect};
use apex_model::event::{Event, EventKind, Message, SolverReport, StateVariable};
use apex_model::task::{TaskId, TaskState};
use apex_model::time::{NANOSECONDS_PER_SECOND, Time};
use apex_model::value::Value;
use std::fmt::Write as _;
use std::sync::Arc;

/// Columns that the instant takes in text, so that lines of one hour stand under each other.
const TIME_COLUMNS: usize = 12;

/// A line before it is written.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) at: Time,
    /// Whose line it is, where several agents run.
    pub(super) agent: Option<Arc<str>>,
    pub(super) kind: &'static str,
    pub(super) task: Option<TaskId>,
    pub(super) goal: Arc<str>,
    /// What the filter by object looks at besides the goal.
    pub(super) subject: String,
    pub(super) place: Option<String>,
    /// Keys between `goal` and `cause`, with JSON texts.
    fields: Vec<(&'static str, String)>,
    cause: String,
    /// The sentence of the text form, without task, cause and place.
    words: String,
}

impl Line {
    fn new(at: Time, kind: &'static str, subject: String, words: String) -> Line {
        let (fields, cause) = (Vec::new(), String::new());
        Line { at, agent: None, kind, task: None, goal: Arc::from(""), subject, place: None, fields, cause, words }
    }

    fn text_field(&mut self, key: &'static str, text: &str) -> &mut Line {
        self.fields.push((key, json_text(text)));
        self
    }

    fn field(&mut self, key: &'static str, json: String) -> &mut Line {
        self.fields.push((key, json));
        self
    }

    /// The line of an input.
    pub(super) fn of_event(event: &Event) -> Line {
        let at = event.at;
        let line = |kind, subject: String, words: String| Line::new(at, kind, subject, words);
        match &event.kind {
            EventKind::Measurement(variable, value) => Line::of_measurement(at, variable, value),
            EventKind::Occurrence(form) => Line::of_occurrence(at, form),
            EventKind::Told(author, message) => {
                let mut line = match message {
                    Message::Occurrence(form) => Line::of_occurrence(at, form),
                    Message::Measurement(variable, value) => Line::of_measurement(at, variable, value),
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
                line.field("command", command.0.to_string());
                match result {
                    Ok(value) => line.field("value", json_value(value)),
                    Err(reason) => line.text_field("error", reason),
                };
                line
            }
            EventKind::SolverReported(request, report) => {
                let mut line = line("solver", format!("request {}", request.0), String::new());
                line.field("request", request.0.to_string());
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
                line.field("question", question.0.to_string()).field("value", json_value(value));
                line
            }
            EventKind::Woken => line("wake", String::new(), "wake".into()),
        }
    }

    fn of_measurement(at: Time, variable: &StateVariable, value: &Value) -> Line {
        let name = variable.to_string();
        let mut line = Line::new(at, "measurement", name.clone(), format!("{name} = {value}"));
        line.text_field("variable", &name).field("value", json_value(value));
        line
    }

    fn of_occurrence(at: Time, form: &Value) -> Line {
        let form = form.to_string();
        let mut line = Line::new(at, "event", form.clone(), format!("event {form}"));
        line.text_field("form", &form);
        line
    }

    /// The line of something that the shell decided.
    pub(super) fn of_note(at: Time, text: &str) -> Line {
        let mut line = Line::new(at, "note", String::new(), format!("note: {text}"));
        line.text_field("text", text);
        line
    }

    /// The line of an effect of the step at `now`.
    pub(super) fn of_effect(now: Time, effect: &Effect, told: &Told, narrator: &Narrator) -> Line {
        let mut line = Line::new(now, told.kind, told.subject.clone(), String::new());
        line.task = told.task;
        line.goal = Arc::clone(&told.goal);
        line.place.clone_from(&told.place);
        match effect {
            Effect::Decided(decision) => {
                line.cause.clone_from(&told.text);
                line.decided(&decision.kind, told, narrator);
            }
            Effect::Command { command, because, .. } => {
                line.cause = cause_text(because);
                line.words = format!("command {} {}", command.0, told.subject);
                line.field("command", command.0.to_string()).text_field("form", &told.subject);
            }
            Effect::WithdrawCommand { command, reason } => {
                line.words = format!("command {} withdrawn: {reason}", command.0);
                line.field("command", command.0.to_string()).text_field("reason", reason);
            }
            Effect::Solve(request) => {
                line.words = format!("asks for a plan: {}", told.text);
                line.field("request", request.request.0.to_string()).text_field("solver", request.solver.printed());
                if let Some(budget) = request.budget {
                    line.field("budget_s", seconds_text(Time(budget.0)));
                }
            }
            Effect::CancelSolve(request) => {
                line.words = format!("request {} cancelled", request.0);
                line.field("request", request.0.to_string());
            }
            Effect::Inform { .. } => {
                line.kind = "event";
                line.words = format!("informs {}", told.subject);
                line.text_field("form", &told.subject);
            }
            Effect::Print { text, .. } => {
                line.words = format!("prints {text}");
                line.text_field("text", text);
            }
            Effect::Ask { question, options, by, default, .. } => {
                line.words = format!("asks {:?} ({})", told.subject, told.text);
                line.field("question", question.0.to_string()).text_field("text", &told.subject);
                let options: Vec<String> = options.iter().map(json_value).collect();
                line.field("options", format!("[{}]", options.join(",")));
                if let Some(by) = by {
                    line.field("by", seconds_text(*by));
                }
                if let Some(default) = default {
                    line.field("default", json_value(default));
                }
            }
            Effect::WithdrawQuestion { question, reason } => {
                line.words = format!("question {} withdrawn: {reason}", question.0);
                line.field("question", question.0.to_string()).text_field("reason", reason);
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

    fn decided(&mut self, kind: &DecisionKind, told: &Told, narrator: &Narrator) {
        match kind {
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
                    self.field("value", json_value(value));
                }
            }
            DecisionKind::Satisfied { clause, interval } => {
                self.words = format!("{clause} satisfied");
                self.text_field("clause", clause);
                self.field("start", seconds_text(interval.0)).field("end", seconds_text(interval.1));
            }
            DecisionKind::Bound { variable, value } => {
                self.words.clone_from(&told.subject);
                self.text_field("variable", &format!("?{variable}")).field("value", json_value(value));
            }
            DecisionKind::Selected { method, .. } => {
                let method = narrator.method(method);
                self.words = format!("selected {method}");
                self.cause = told.text.strip_prefix(&format!("{method} because ")).unwrap_or(&told.text).to_owned();
                self.text_field("method", &method);
            }
            DecisionKind::Refused { winner, .. } => {
                self.words = format!("refused {}", told.subject);
                self.text_field("resource", &told.subject).text_field("winner", &winner.to_string());
            }
            DecisionKind::ProcedureAdded { request, summary, .. } => {
                self.kind = "plan";
                self.words = format!("plan added: {summary}");
                self.field("request", request.0.to_string()).text_field("summary", summary);
            }
            DecisionKind::Trouble { message } => {
                self.words = format!("trouble: {message}");
                self.text_field("message", message);
            }
        }
    }

    /// `{"t":1.5,"kind":"transition","task":"T3","goal":"..",..,"cause":"..","place":".."}`
    pub(super) fn json(&self) -> String {
        let mut json = format!("{{\"t\":{},\"kind\":\"{}\"", seconds_text(self.at), self.kind);
        let mut put = |key: &str, value: &str| {
            let _ = write!(json, ",\"{key}\":{value}");
        };
        if let Some(agent) = &self.agent {
            put("agent", &json_text(agent));
        }
        if let Some(task) = self.task {
            put("task", &json_text(&task.to_string()));
            put("goal", &json_text(&self.goal));
        }
        self.fields.iter().for_each(|(key, value)| put(key, value));
        if !self.cause.is_empty() {
            put("cause", &json_text(&self.cause));
        }
        if let Some(place) = &self.place {
            put("place", &json_text(place));
        }
        json.push('}');
        json
    }

    /// `       12.5s  T3 (power-up camera-1): enabled -> ongoing because it was granted camera-1; from file.pdl:14:3`
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
        if !self.cause.is_empty() {
            let _ = write!(text, " because {}", self.cause);
        }
        if let Some(place) = &self.place {
            let _ = write!(text, "; from {place}");
        }
        text.replace('\r', "").replace('\n', "\\n")
    }
}

/// Seconds as the shortest exact decimal: `1.5`, `0.3`, `-2`, never `0.30000000000000004`.
pub fn seconds_text(time: Time) -> String {
    let total = time.0.unsigned_abs();
    let second = NANOSECONDS_PER_SECOND.unsigned_abs();
    let sign = if time.0 < 0 { "-" } else { "" };
    let digits = format!("{:09}", total % second);
    match digits.trim_end_matches('0') {
        "" => format!("{sign}{}", total / second),
        fraction => format!("{sign}{}.{fraction}", total / second),
    }
}

fn json_text(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// A number for a plain number, PDL text in a string for everything else.
fn json_value(value: &Value) -> String {
    match value {
        Value::Integer(integer) => integer.to_string(),
        Value::Real(real) if real.is_finite() => format!("{real:?}"),
        Value::Text(text) => json_text(text),
        other => json_text(&other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_exact_and_short() {
        let cases =
            [(300_000_000, "0.3"), (1_500_000_000, "1.5"), (-2_000_000_000, "-2"), (1, "0.000000001"), (0, "0")];
        for (nanoseconds, text) in cases {
            assert_eq!(seconds_text(Time(nanoseconds)), text);
        }
    }

    #[test]
    fn values_are_json_whatever_they_hold() {
        assert_eq!(json_value(&Value::Real(f64::NAN)), "\"NaN\"");
        assert_eq!(json_value(&Value::Real(1e300)), "1e300");
        assert_eq!(json_value(&Value::text("say \"hi\"\n")), r#""say \"hi\"\n""#);
        assert_eq!(json_value(&Value::list([Value::Integer(1), Value::symbol("A")])), "\"(1 A)\"");
    }
}
