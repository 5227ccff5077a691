//! A run in short lines: `2s a ongoing`, `2s print ready`, `5s end`.
//!
//! Tasks are named by the tag of their step; a second task with the same tag is `a#2`. The end of a task that never started is not
//! reported unless it failed, and built-in activities are reported by their effect (`print`), not as tasks.

use apex_model::because::Because;
use apex_model::effect::{Decision, DecisionKind, Effect, Method};
use apex_model::event::Batch;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::Time;
use apex_runtime::ports::Observer;
use std::collections::{BTreeMap, BTreeSet};

/// Kinds of lines that are reported unless a page states others.
const DEFAULT_KINDS: &[&str] = &[
    "ongoing",
    "interrupted",
    "terminated",
    "print",
    "inform",
    "tell",
    "command",
    "withdraw",
    "trouble",
    "ask",
    "solve",
    "cancel",
    "note",
    "end",
];
/// Kinds that a page may request in addition.
const FURTHER_KINDS: &[&str] = &[
    "created",
    "pending",
    "enabled",
    "satisfied",
    "bound",
    "selected",
    "refused",
    "added",
    "builtin",
    "causes",
    "publish",
];

/// Observes a run and keeps the reports.
#[derive(Debug, Default)]
pub struct Teller {
    kinds: BTreeSet<String>,
    /// The names of the agents if there are several; each line begins with one.
    agents: Vec<String>,
    /// Knowledge of the tasks of the present agent; that of others is in `waiting`.
    known: Known,
    turn: usize,
    waiting: BTreeMap<usize, Known>,
    transitions: BTreeSet<(TaskState, TaskState)>,
    lines: Vec<String>,
}

/// Knowledge of one agent's tasks.
#[derive(Debug, Default)]
struct Known {
    names: BTreeMap<TaskId, String>,
    taken: BTreeMap<String, u32>,
    built_in: BTreeSet<TaskId>,
    started: BTreeSet<TaskId>,
}

impl Teller {
    /// Selects the kinds of reported lines; an empty list selects the default ones, `all` selects everything.
    ///
    /// # Errors
    /// Names a kind that does not exist.
    pub fn new(kinds: &[String]) -> Result<Teller, String> {
        let known = || DEFAULT_KINDS.iter().chain(FURTHER_KINDS);
        if let Some(stranger) = kinds.iter().find(|kind| !known().any(|known| known == kind)) {
            let known: Vec<&str> = known().copied().collect();
            return Err(format!("`show {stranger}`: no such kind; there are {}", known.join(" ")));
        }
        let chosen: BTreeSet<String> = match kinds {
            [] => DEFAULT_KINDS.iter().map(ToString::to_string).collect(),
            [only] if only == "causes" => DEFAULT_KINDS.iter().map(ToString::to_string).chain([only.clone()]).collect(),
            some => some.iter().cloned().collect(),
        };
        Ok(Teller { kinds: chosen, ..Teller::default() })
    }

    /// Lines begin with the agent's name from now on: `2s pilot: a ongoing`.
    pub fn name_agents(&mut self, names: Vec<String>) {
        self.agents = names;
    }

    /// Returns everything reported so far, one line each.
    pub fn text(&self) -> String {
        self.lines.iter().map(|line| format!("{line}\n")).collect()
    }

    /// Returns every change of state that occurred, reported or not.
    pub fn transitions(&self) -> &BTreeSet<(TaskState, TaskState)> {
        &self.transitions
    }

    /// Adds a separate line, for example about the end of the run.
    pub fn tell(&mut self, line: String) {
        self.lines.push(line);
    }

    fn say(&mut self, kind: &str, at: Time, words: &str, because: Option<&Because>) {
        if !self.kinds.contains(kind) {
            return;
        }
        let mut line = match self.agents.get(self.turn) {
            Some(agent) => format!("{at} {agent}: {words}"),
            None => format!("{at} {words}"),
        };
        if let Some(because) = because.filter(|_| self.kinds.contains("causes")) {
            line.push_str(" because ");
            line.push_str(&self.with_names(&because.cause.text()));
        }
        self.lines.push(line.replace('\n', "\\n"));
    }

    /// Replaces task numbers such as `T12` by names.
    fn with_names(&self, text: &str) -> String {
        let mut named = String::new();
        let mut word = String::new();
        for character in text.chars().chain([' ']) {
            if character.is_alphanumeric() {
                word.push(character);
                continue;
            }
            let number = word.strip_prefix('T').and_then(|digits| digits.parse().ok());
            named.push_str(number.and_then(|number| self.known.names.get(&TaskId(number))).unwrap_or(&word));
            named.push(character);
            word.clear();
        }
        named.trim_end().to_string()
    }

    fn name(&self, task: TaskId) -> String {
        self.known.names.get(&task).cloned().unwrap_or_else(|| task.to_string())
    }

    fn decided(&mut self, at: Time, decision: &Decision) {
        let because = Some(&decision.because);
        let name = decision.task.map_or_else(|| "agent".to_string(), |task| self.name(task));
        match &decision.kind {
            DecisionKind::Created { parent, tag, goal, .. } => {
                self.created(at, decision, *parent, tag.printed(), &goal.to_string())
            }
            DecisionKind::Transition { from, to, outcome } => {
                self.transitions.insert((*from, *to));
                self.moved(at, decision, *to, outcome.as_ref());
            }
            DecisionKind::Satisfied { clause, interval } => {
                let words = format!("{name} {clause} satisfied [{}, {}]", interval.0, interval.1);
                self.say("satisfied", at, &words, None);
            }
            DecisionKind::Bound { variable, value } => {
                let words = self.with_names(&format!("{name} ?{variable} = {value}"));
                self.say("bound", at, &words, because);
            }
            DecisionKind::Selected { method, goal, .. } => {
                if let (Some(task), Method::BuiltIn) = (decision.task, method) {
                    self.known.built_in.insert(task);
                }
                let by = match method {
                    Method::Procedure(place) => format!("the procedure in line {}", place.line),
                    Method::Primitive(place) => format!("the primitive in line {}", place.line),
                    Method::BuiltIn => return,
                    Method::Solver(solver) => format!("the solver {solver}"),
                };
                self.say("selected", at, &format!("{name} {goal} by {by}"), because);
            }
            DecisionKind::Refused { resource, winner } => {
                let words = format!("{name} waits for {resource}, {} has it", self.name(*winner));
                self.say("refused", at, &words, because);
            }
            DecisionKind::ProcedureAdded { summary, .. } => {
                self.say("added", at, &format!("procedure {summary}"), because)
            }
            DecisionKind::Trouble { message } => {
                let words = self.with_names(&format!("{name} trouble: {message}")); // english: allow
                self.say("trouble", at, &words, None);
            }
        }
    }

    fn created(&mut self, at: Time, decision: &Decision, parent: Option<TaskId>, tag: &str, goal: &str) {
        let Some(task) = decision.task else { return };
        let base = if parent.is_none() { "root" } else { tag };
        let count = self.known.taken.entry(base.to_string()).or_insert(0);
        *count += 1;
        let name = if *count == 1 { base.to_string() } else { format!("{base}#{count}") };
        self.known.names.insert(task, name.clone());
        self.say("created", at, &format!("{name} created {goal}"), Some(&decision.because));
    }

    fn moved(&mut self, at: Time, decision: &Decision, to: TaskState, outcome: Option<&Outcome>) {
        let Some(task) = decision.task else { return };
        if to == TaskState::Ongoing {
            self.known.started.insert(task);
        }
        let failed = outcome.is_some_and(|outcome| outcome.is_failure() || matches!(outcome, Outcome::Skipped));
        let never_started = to == TaskState::Terminated && !self.known.started.contains(&task);
        let hidden = self.known.built_in.contains(&task) && !self.kinds.contains("builtin");
        if !failed && (hidden || never_started) {
            return;
        }
        let words = match outcome {
            Some(Outcome::Success(value)) if !value.is_true() => "terminated".to_string(),
            Some(Outcome::Success(value)) => self.with_names(&format!("terminated >> {value}")),
            Some(Outcome::Failure) => "failed".to_string(),
            Some(other) => other.word().to_string(),
            None => to.word().to_string(),
        };
        self.say(to.word(), at, &format!("{} {words}", self.name(task)), Some(&decision.because));
    }
}

impl Observer for Teller {
    fn turn(&mut self, agent: usize) -> Result<(), String> {
        if agent != self.turn {
            let known = self.waiting.remove(&agent).unwrap_or_default();
            self.waiting.insert(self.turn, std::mem::replace(&mut self.known, known));
            self.turn = agent;
        }
        Ok(())
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        let at = batch.now;
        for effect in effects {
            match effect {
                Effect::Decided(decision) => self.decided(at, decision),
                Effect::Command { form, .. } => self.say("command", at, &format!("command {form}"), None),
                Effect::WithdrawCommand { .. } => self.say("withdraw", at, "withdraw", None),
                Effect::Solve(request) => {
                    self.say("solve", at, &format!("solve {} by {}", request.goal, request.solver), None)
                }
                Effect::CancelSolve(_) => self.say("cancel", at, "cancel solve", None),
                Effect::Inform { form, .. } => self.say("inform", at, &format!("inform {form}"), None),
                Effect::Publish { variable, value, because, .. } => {
                    self.say("publish", at, &format!("publish {variable} = {value}"), Some(because));
                }
                Effect::Print { text, .. } => self.say("print", at, &format!("print {text}"), None),
                Effect::Ask { text, .. } => self.say("ask", at, &format!("ask {text}"), None),
                Effect::WithdrawQuestion { question, .. } => {
                    self.say("withdraw", at, &format!("withdraw question {}", question.0), None);
                }
                Effect::Tell { to, message, .. } => {
                    let names: Vec<&str> = to.iter().map(|name| name.printed()).collect();
                    self.say("tell", at, &format!("tell {} {message}", names.join(" ")), None);
                }
                Effect::AgentEnded { .. } => self.say("end", at, "end", None),
                Effect::EndApplication { .. } => {}
            }
        }
        Ok(())
    }

    fn note(&mut self, at: Time, text: &str) -> Result<(), String> {
        if self.kinds.contains("note") {
            self.lines.push(format!("{at} note: {text}"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_kinds_are_named() {
        let error = Teller::new(&["prints".to_string()]).err().unwrap_or_default();
        assert!(error.contains("prints"), "{error}");
    }

    #[test]
    fn task_numbers_become_names() {
        let mut teller = Teller::default();
        teller.known.names.insert(TaskId(12), "orient".into());
        assert_eq!(teller.with_names("T12 outranks T1 on (camera T12)"), "orient outranks T1 on (camera orient)");
    }
}
