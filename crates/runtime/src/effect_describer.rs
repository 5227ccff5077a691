//! Describes effects as rows of text. Record, trace and explanations print the same text.
//!
//! A describer remembers the goal of each task and the sources of plans, so that every line can name its task and its place in PDL.

use crate::limits::ENDED_GOALS_MAX;
use crate::method_detail::MethodDetail;
use apex_model::because::Because;
use apex_model::effect::{Decision, DecisionKind, Effect, Method, SolveRequestId};
use apex_model::event::{Batch, EventKind, SolverReport};
use apex_model::library::Library;
use apex_model::source::{Place, SourceFile};
use apex_model::symbol::Symbol;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::value::Value;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

/// An effect as text, for readers of a record and lines of a trace.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectRow {
    /// The kind, as in the record.
    pub kind: &'static str,
    /// The task it is about.
    pub task: Option<TaskId>,
    /// That task's goal as known now; empty without a task.
    pub goal: Arc<str>,
    /// The task's parent, for `created`.
    pub parent: Option<TaskId>,
    /// The step's tag, for `created`.
    pub tag: Option<String>,
    /// State before, for `transition`.
    pub from: Option<TaskState>,
    /// State after, for `transition`.
    pub to: Option<TaskState>,
    /// A word of `apex_model::task::OUTCOME_WORDS`, for the transition to terminated.
    pub outcome: Option<&'static str>,
    /// The task's value, for a successful end with a value.
    pub value: Option<Value>,
    /// The goal, form or variable.
    pub subject: String,
    /// The cause (or the message) as text, without the place.
    pub text: String,
    /// `file:line:column`.
    pub place: Option<String>,
    /// The method, for `selected`.
    pub(crate) method: Option<MethodDetail>,
}

/// The goal of a task.
#[derive(Clone, Debug)]
struct TaskGoal {
    text: Arc<str>,
    /// The number of the instance's end; `None` while the task lives.
    end: Option<u64>,
}

/// Describes the effects of one agent, which must come in order and completely.
#[derive(Clone, Debug)]
pub struct EffectDescriber {
    /// The library of the run; only its sources are used and extended.
    library: Library,
    goals: BTreeMap<TaskId, TaskGoal>,
    /// Tasks that have ended, oldest first, each with the number of its end.
    ended: VecDeque<(TaskId, u64)>,
    ends: u64,
    plans: BTreeMap<SolveRequestId, SourceFile>,
}

impl EffectDescriber {
    /// Returns a describer for a run of `library`, from the run's first step on.
    pub fn new(library: &Library) -> EffectDescriber {
        let library = Library { sources: library.sources.clone(), ..Library::default() };
        EffectDescriber { library, goals: BTreeMap::new(), ended: VecDeque::new(), ends: 0, plans: BTreeMap::new() }
    }

    /// Returns a describer of single effects, whose places refer to `sources`, which include those of plans.
    pub(crate) fn of_sources(sources: Vec<SourceFile>) -> EffectDescriber {
        EffectDescriber::new(&Library { sources, ..Library::default() })
    }

    /// Sets the goal of `task`, for a caller that knows it.
    pub(crate) fn remember(&mut self, task: TaskId, goal: Arc<str>) {
        self.goals.insert(task, TaskGoal { text: goal, end: None });
    }

    /// Returns a place as text, `file.pdl:14:3`, also for places inside of plans.
    pub fn place(&self, place: Place) -> String {
        self.library.describe_place(place)
    }

    /// Returns the goal of `task` as known now.
    pub fn goal(&self, task: TaskId) -> Arc<str> {
        self.goals.get(&task).map(|goal| Arc::clone(&goal.text)).unwrap_or_default()
    }

    /// Processes the step's inputs, which must precede its effects, because plans bring sources.
    pub fn hear(&mut self, batch: &Batch) {
        for event in &batch.events {
            if let EventKind::SolverReported(request, SolverReport::Plan(plan)) = &event.kind {
                self.plans.insert(*request, plan.source.clone());
            }
        }
    }

    /// Describes one effect. All effects must be passed, in order.
    pub fn tell(&mut self, effect: &Effect) -> EffectRow {
        match effect {
            Effect::Decided(decision) => self.decided(decision),
            Effect::Command { command, task, form, because } => {
                let mut told = self.said("command", Some(*task), form.to_string(), format!("command {}", command.0));
                told.place = because.place.map(|place| self.place(place));
                told
            }
            Effect::WithdrawCommand { command, reason } => {
                self.said("withdraw", None, format!("command {}", command.0), reason.clone())
            }
            Effect::Solve(request) => {
                let budget = request.budget.map_or_else(String::new, |budget| format!(", budget {budget}"));
                let text = format!("request {} to {}{budget}", request.request.0, request.solver);
                self.said("solve", Some(request.task), request.goal.to_string(), text)
            }
            Effect::CancelSolve(request) => self.said(
                "cancel-solve",
                None,
                format!("request {}", request.0),
                "no task waits for it any longer".into(),
            ),
            Effect::Inform { task, form } => self.said("inform", Some(*task), form.to_string(), String::new()),
            Effect::Publish { task, variable, value, because } => {
                let mut told = self.said("publish", Some(*task), format!("{variable} = {value}"), cause_text(because));
                told.place = because.place.map(|place| self.place(place));
                told
            }
            Effect::Print { task, text } => self.said("print", Some(*task), String::new(), text.clone()),
            Effect::Ask { question, task, text, options, by, default } => {
                let options: Vec<String> = options.iter().map(Value::to_string).collect();
                let by = by.map_or_else(String::new, |by| match default {
                    Some(default) => format!("; {default} is taken at {by}"),
                    None => format!("; it fails at {by}"),
                });
                let words = format!("question {}; options: {}{by}", question.0, options.join(", "));
                self.said("ask", Some(*task), text.clone(), words)
            }
            Effect::WithdrawQuestion { question, reason } => {
                self.said("withdraw-question", None, format!("question {}", question.0), reason.clone())
            }
            Effect::Tell { task, to, message } => {
                let names: Vec<&str> = to.iter().map(Symbol::printed).collect();
                self.said("tell", Some(*task), message.to_string(), format!("to {}", names.join(", ")))
            }
            Effect::AgentEnded { reason } => self.said("agent-ended", None, String::new(), reason.clone()),
            Effect::EndApplication { reason } => self.said("end-application", None, String::new(), reason.clone()),
        }
    }

    fn said(&self, kind: &'static str, task: Option<TaskId>, subject: String, text: String) -> EffectRow {
        let goal = task.map(|task| self.goal(task)).unwrap_or_default();
        EffectRow {
            kind,
            task,
            goal,
            parent: None,
            tag: None,
            from: None,
            to: None,
            outcome: None,
            value: None,
            subject,
            text,
            place: None,
            method: None,
        }
    }

    fn decided(&mut self, decision: &Decision) -> EffectRow {
        let because = &decision.because;
        let mut told = self.said("trouble", decision.task, String::new(), cause_text(because));
        let mut place = because.place;
        match &decision.kind {
            DecisionKind::Created { parent, tag, goal, place: step } => {
                place = step.or(place);
                told.kind = "created";
                (told.parent, told.tag) = (*parent, Some(tag.to_string()));
                self.set_goal(&mut told, goal);
            }
            DecisionKind::Transition { from, to, outcome } => {
                told.kind = "transition";
                told.subject = told.goal.to_string();
                (told.from, told.to) = (Some(*from), Some(*to));
                if let Some(task) = decision.task {
                    self.end_or_revive(task, *to);
                }
                told.outcome = outcome.as_ref().map(outcome_word);
                told.value = outcome.as_ref().and_then(outcome_value);
            }
            DecisionKind::Satisfied { clause, interval } => {
                told.kind = "satisfied";
                told.subject = clause.to_string();
                told.text = format!("{} in [{}, {}]", told.text, interval.0, interval.1);
            }
            DecisionKind::Bound { variable, value } => {
                told.kind = "bound";
                told.subject = format!("?{variable} = {value}");
                told.value = Some(value.clone());
            }
            DecisionKind::Selected { method, goal, .. } => {
                told.kind = "selected";
                let method = self.method(method);
                told.text = format!("{method} because {}", told.text);
                told.method = Some(method);
                self.set_goal(&mut told, goal);
            }
            DecisionKind::Refused { resource, .. } => {
                told.kind = "refused";
                told.subject = resource.to_string();
            }
            DecisionKind::ProcedureAdded { request, summary, .. } => {
                told.kind = "procedure-added";
                told.subject.clone_from(summary);
                self.library.sources.extend(self.plans.remove(request));
            }
            DecisionKind::Trouble { message } => told.subject.clone_from(message),
        }
        told.place = place.map(|place| self.place(place));
        told
    }

    fn set_goal(&mut self, told: &mut EffectRow, goal: &Value) {
        told.subject = goal.to_string();
        told.goal = Arc::from(&*told.subject);
        if let Some(task) = told.task {
            self.goals.insert(task, TaskGoal { text: Arc::clone(&told.goal), end: None });
        }
    }

    /// Drops the goals of tasks that ended long ago, so that memory is bounded by the number of living tasks. A task may begin again
    /// after its end.
    fn end_or_revive(&mut self, task: TaskId, to: TaskState) {
        let Some(goal) = self.goals.get_mut(&task) else { return };
        goal.end = None;
        if to != TaskState::Terminated {
            return;
        }
        self.ends += 1;
        goal.end = Some(self.ends);
        self.ended.push_back((task, self.ends));
        while self.ended.len() > ENDED_GOALS_MAX {
            let Some((task, end)) = self.ended.pop_front() else { return };
            if self.goals.get(&task).is_some_and(|goal| goal.end == Some(end)) {
                self.goals.remove(&task);
            }
        }
    }

    /// Returns the method with its place.
    pub(crate) fn method(&self, method: &Method) -> MethodDetail {
        MethodDetail::of(method, |place| self.place(place))
    }
}

/// Returns the cause with its evidence, without the place, which has a separate column.
pub fn cause_text(because: &Because) -> String {
    let mut text = because.cause.text();
    for (index, evidence) in because.evidence.iter().enumerate() {
        text.push_str(if index == 0 { ": " } else { ", " });
        text.push_str(&evidence.text());
    }
    text
}

/// Returns `success`, `failure`, `cut`, `skipped`, `exited`, `precondition failed` or `invariant violated`.
pub fn outcome_word(outcome: &Outcome) -> &'static str {
    outcome.word()
}

fn outcome_value(outcome: &Outcome) -> Option<Value> {
    match outcome {
        Outcome::Success(value) if value.is_true() => Some(value.clone()),
        _ => None,
    }
}
