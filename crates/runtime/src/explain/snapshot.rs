//! A record at the instant of a question: its tasks, and the agent restored to that instant.

use super::answer::{About, EXPLANATION_VERSION};
use super::log::Log;
use crate::error::RecordError;
use crate::record::view::decisions::Decisions;
use crate::record::{LoadProgram, RecordReader, TaskRow};
use apex_executive::{Agent, explanation};
use apex_model::event::Batch;
use apex_model::source::{Place, SourceFile};
use apex_model::task::TaskId;
use apex_model::time::Time;

/// Longer goals are cut where they are only mentioned.
const GOAL_CHARACTERS_MAX: usize = 60;
/// Sign in place of a cut part.
const CUT_SIGN: &str = " ..)";

/// Question to a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Question {
    /// A task, resource, command, target, step, procedure, in the asker's words.
    pub what: String,
    /// The instant; the end of the record if the instant is later.
    pub at: Time,
    /// Greatest depth of a chain of causes.
    pub depth: usize,
}

impl Question {
    /// Returns a question about `what` at `at` with the default depth.
    pub fn new(what: &str, at: Time) -> Question {
        Question { what: what.into(), at, depth: crate::limits::EXPLANATION_DEPTH_DEFAULT }
    }
}

/// A record at an instant.
pub(super) struct RecordSnapshot<'a> {
    pub(super) reader: &'a RecordReader,
    pub(super) at: Time,
    pub(super) depth: usize,
    pub(super) tasks: Vec<TaskRow>,
    pub(super) name: String,
    /// The restored agent; `None` if it was not requested.
    agent: Option<Result<Box<Agent>, RecordError>>,
}

impl<'a> RecordSnapshot<'a> {
    /// Returns the snapshot for `question`; without `load` the agent is not restored.
    pub(super) fn set(
        reader: &'a RecordReader,
        question: &Question,
        load: Option<LoadProgram<'_>>,
    ) -> Result<RecordSnapshot<'a>, RecordError> {
        let at = instant_of(reader, question.at)?;
        let agent = load.map(|load| restored(reader, at, load));
        let name = match &agent {
            Some(Ok(agent)) => agent.name.to_string(),
            Some(Err(_)) | None => reader.meta("agent")?.unwrap_or_default(),
        };
        Ok(RecordSnapshot { reader, at, depth: question.depth.max(1), tasks: reader.tasks()?, name, agent })
    }

    /// Returns the restored agent; `None` if it was not requested.
    ///
    /// # Errors
    /// Why it cannot be restored.
    pub(super) fn into_agent(self) -> Result<Option<Box<Agent>>, RecordError> {
        self.agent.transpose()
    }

    /// Returns the restored agent; `None` if it was not requested, or this version of Apex cannot restore it.
    pub(super) fn agent(&self) -> Option<&Agent> {
        self.agent.as_ref()?.as_deref().ok()
    }

    /// Returns true if the agent was requested: chains of causes are followed only then.
    pub(super) fn restores(&self) -> bool {
        self.agent.is_some()
    }

    /// Returns the head of an answer.
    pub(super) fn about(&self, question: &'static str, kind: &'static str, asked: &str) -> About {
        let t = self.at.seconds();
        About { version: EXPLANATION_VERSION, question, kind, asked: asked.trim().into(), agent: self.name.clone(), t }
    }

    /// Returns the record's decisions up to the instant.
    pub(super) fn decisions(&self) -> Decisions<'a> {
        Decisions { reader: self.reader, until: self.at }
    }

    /// Returns the reader for chains of causes: decisions, samples, and the lines of the program and of plans.
    pub(super) fn log(&self) -> Result<Log<'a>, RecordError> {
        let plans = self.agent().into_iter().flat_map(|agent| agent.generated.iter());
        let mut sources: Vec<SourceFile> = plans.map(|(_, plan)| plan.source.clone()).collect();
        sources.extend(self.reader.pdl_sources()?);
        Ok(Log { decisions: self.decisions(), sources })
    }

    /// Returns the goal of a task as known at the instant, or as last known if the task no longer exists. Long goals are cut.
    pub(super) fn goal(&self, task: TaskId) -> String {
        let goal = self.whole_goal(task);
        // The omitted part must be longer than the sign in its place.
        let is_long = goal.char_indices().nth(GOAL_CHARACTERS_MAX + CUT_SIGN.len()).is_some();
        match goal.char_indices().nth(GOAL_CHARACTERS_MAX).filter(|_| is_long) {
            Some((end, _)) => format!("{}{CUT_SIGN}", goal.get(..end).unwrap_or_default().trim_end()),
            None => goal,
        }
    }

    /// Returns the goal of a task as [`RecordSnapshot::goal`] does, but never cut.
    pub(super) fn whole_goal(&self, task: TaskId) -> String {
        let living =
            self.agent().and_then(|agent| explanation::describe_task(agent, task)).map(|view| view.goal.to_string());
        living.or_else(|| self.row(task).map(|row| row.goal.clone())).unwrap_or_default()
    }

    /// Returns the task's row.
    pub(super) fn row(&self, task: TaskId) -> Option<&TaskRow> {
        let found = self.tasks.binary_search_by_key(&task, |row| row.id);
        found.ok().and_then(|index| self.tasks.get(index))
    }
}

/// Returns the instant of a question; the end of the record if the instant is later.
///
/// # Errors
/// Nothing was decided by then.
pub(super) fn instant_of(reader: &RecordReader, at: Time) -> Result<Time, RecordError> {
    let Some((start, end)) = reader.span()? else {
        return Err(RecordError::Question("Nothing happened yet: the record holds no steps.".into()));
    };
    let at = at.min(end);
    if at < start {
        return Err(RecordError::Question(format!("The flight begins at {start}; nothing was decided by {at}.")));
    }
    Ok(at)
}

/// Returns the agent restored to `at`.
///
/// # Errors
/// Why it cannot be restored.
pub(super) fn restored(reader: &RecordReader, at: Time, load: LoadProgram<'_>) -> Result<Box<Agent>, RecordError> {
    let mut agent = Box::new(reader.restore(at, load)?);
    // Nothing happens between the last step and `at`, but silences grow: "no sample for 4 s".
    apex_executive::step(&mut agent, &Batch { now: at, events: Vec::new() });
    Ok(agent)
}

/// Returns a place as `file.pdl:14:3`, also for places in plans: their files are numbered after those of the library.
pub(super) fn place_text(agent: &Agent, place: Place) -> String {
    agent.describe_place(place)
}
