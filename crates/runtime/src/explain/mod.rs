//! Why: explains one task of a recorded flight at an instant: how it came to its state, what it waits for and since
//! when, who took its resource, why it ended.

mod crew;
mod find;
mod history;

pub use crew::why_of_any;
pub use find::find_task;
pub use history::Moment;

use crate::error::RecordError;
use crate::record::{LoadProgram, RecordReader, TaskRow};
use apex_executive::Agent;
use apex_executive::explanation::{self, Reason, ReasonKind};
use apex_model::event::Batch;
use apex_model::task::TaskId;
use apex_model::time::Time;
use history::History;
use serde::Serialize;
use std::fmt;

/// The explanation of a task.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Why {
    /// The task, `T12`.
    pub task: String,
    /// Its step's tag.
    pub tag: String,
    /// Its goal, as known then.
    pub goal: String,
    /// The instant of the question, in seconds of mission time.
    pub t: f64,
    /// Its state then.
    pub state: String,
    /// How it is pursued, `procedure file.pdl:3:1`, if that was decided.
    pub method: Option<String>,
    /// `file:line:column` of its step.
    pub place: Option<String>,
    /// What happened to it, oldest first.
    pub history: Vec<Moment>,
    /// What it waits for then; empty when it waits for nothing.
    pub waiting: Vec<Unmet>,
    /// Who has its resource, when it lost a conflict and has not won since.
    pub blocked: Option<Blocked>,
    /// Its subtasks that live then.
    pub subtasks: Vec<Subtask>,
}

/// One thing that must still come true.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unmet {
    /// What kind of thing.
    pub kind: ReasonKind,
    /// The part of the condition as PDL text, or the reason in words.
    pub what: String,
    /// What is known about it then; empty where `what` says it all.
    pub now: String,
    /// Since when, in seconds of mission time, where that is known.
    pub since: Option<f64>,
    /// The task concerned, `T4`, if another one is.
    pub task: Option<String>,
    /// Where it stands in PDL.
    pub place: Option<String>,
}

/// A lost conflict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Blocked {
    /// The winner, `T4`.
    pub by: String,
    /// The winner's goal.
    pub goal: String,
    /// The resource.
    pub resource: String,
    /// Since when, in seconds of mission time.
    pub since: f64,
    /// The winner's priority or rank, with its interrupt cost where it defended.
    pub winner_priority: f64,
    /// The loser's.
    pub loser_priority: f64,
    /// The part of the winner's priority that is its interrupt cost.
    pub winner_cost: f64,
    /// The part of the loser's.
    pub loser_cost: f64,
    /// Both for people: `5 against 0 + interrupt cost 0.1`.
    pub strengths: String,
}

/// A living subtask.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Subtask {
    /// The task, `T13`.
    pub task: String,
    /// Its goal.
    pub goal: String,
    /// Its state.
    pub state: String,
}

/// Explains the task called `name` (`T12`, `12`, or words of its goal or tag) as it was at `at`, or at the end of the
/// record where that comes first.
///
/// # Errors
/// [`RecordError::Question`] with candidates for an ambiguous or unknown name; others when the record cannot be read
/// or its mission not loaded.
pub fn why(reader: &RecordReader, name: &str, at: Time, load: LoadProgram<'_>) -> Result<Why, RecordError> {
    let Some((_, end)) = reader.span()? else {
        return Err(RecordError::Question("Nothing happened yet: the record holds no steps.".into()));
    };
    let at = at.min(end);
    let tasks = reader.tasks()?;
    let row = find_task(&tasks, name, at)?;
    let history = History::read(reader, row.id, at)?;
    let subtasks = subtasks(reader, &tasks, row.id, at)?;
    let waiting = if history.waits() { waiting(reader, row.id, at, load)? } else { Vec::new() };
    let blocked = history.blocked.map(|blocked| {
        let winner = tasks.iter().find(|task| task.id == blocked.by);
        Blocked {
            by: blocked.by.to_string(),
            goal: winner.map(|winner| winner.goal.clone()).unwrap_or_default(),
            resource: blocked.resource,
            since: blocked.since.seconds(),
            winner_priority: blocked.winner.total(),
            loser_priority: blocked.loser.total(),
            winner_cost: blocked.winner.interrupt_cost,
            loser_cost: blocked.loser.interrupt_cost,
            strengths: format!("{} against {}", blocked.winner, blocked.loser),
        }
    });
    Ok(Why {
        task: row.id.to_string(),
        tag: row.tag.clone(),
        goal: history.goal.unwrap_or_else(|| row.goal.clone()),
        t: at.seconds(),
        state: history.state,
        method: history.method,
        place: row.place.clone(),
        history: history.moments,
        waiting,
        blocked,
        subtasks,
    })
}

/// What the restored agent says about the task.
fn waiting(reader: &RecordReader, task: TaskId, at: Time, load: LoadProgram<'_>) -> Result<Vec<Unmet>, RecordError> {
    let mut agent = reader.restore(at, load)?;
    // Nothing happens between the last step and `at`, but silences grow: "no sample for 4 s".
    apex_executive::step(&mut agent, &Batch { now: at, events: Vec::new() });
    let reasons = explanation::waiting(&agent, task);
    Ok(reasons.into_iter().map(|reason| unmet(&agent, reason)).collect())
}

fn unmet(agent: &Agent, reason: Reason) -> Unmet {
    Unmet {
        kind: reason.kind,
        what: reason.text,
        now: reason.now.unwrap_or_default(),
        since: reason.since.map(Time::seconds),
        task: reason.task.map(|task| task.to_string()),
        place: reason.place.map(|place| agent.describe_place(place)),
    }
}

fn subtasks(reader: &RecordReader, tasks: &[TaskRow], parent: TaskId, at: Time) -> Result<Vec<Subtask>, RecordError> {
    let mut subtasks = Vec::new();
    for task in tasks.iter().filter(|task| task.parent == Some(parent) && task.created <= at) {
        let state = history::state_at(reader, task.id, at)?;
        if state != "terminated" {
            subtasks.push(Subtask { task: task.id.to_string(), goal: task.goal.clone(), state });
        }
    }
    Ok(subtasks)
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at = Time::from_seconds(self.t);
        writeln!(f, "{} {} is {} at {at}.", self.task, self.goal, self.state)?;
        if let Some(place) = &self.place {
            writeln!(f, "It is the step `{}` at {place}.", self.tag)?;
        }
        if let Some(method) = &self.method {
            writeln!(f, "It is pursued by {method}.")?;
        }
        writeln!(f, "\nWhat happened to it:")?;
        self.history.iter().try_for_each(|moment| writeln!(f, "{moment}"))?;
        if !self.waiting.is_empty() {
            writeln!(f, "\nWhat it waits for:")?;
            for unmet in &self.waiting {
                write!(f, "  {}", unmet.what)?;
                if !unmet.now.is_empty() {
                    write!(f, ": {}", unmet.now)?;
                }
                if let Some(since) = unmet.since {
                    write!(f, ", since {}", Time::from_seconds(since))?;
                }
                writeln!(f, "{}", unmet.place.as_ref().map_or_else(String::new, |place| format!("; from {place}")))?;
            }
        }
        if let Some(Blocked { by, goal, resource, since, strengths, .. }) = &self.blocked {
            let since = Time::from_seconds(*since);
            writeln!(f, "\nIt lost {resource} to {by} {goal} at {since} ({strengths}).")?;
        }
        if !self.subtasks.is_empty() {
            writeln!(f, "\nIts subtasks:")?;
            self.subtasks
                .iter()
                .try_for_each(|Subtask { task, goal, state }| writeln!(f, "  {task} {goal}: {state}"))?;
        }
        Ok(())
    }
}
