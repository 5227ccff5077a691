//! Explanations of a recorded flight: why a task is in its state, why it holds a resource, why a command was sent; and
//! why something did not happen: a task not created, started, resumed, chosen or granted, a target not visited.
//!
//! [`Explainer`] answers with typed values (`answer.rs`, `link.rs`, `moment.rs`, `cause.rs`). Their JSON form is described
//! in `docs/reference/explanations.md`; text is printed from the same values (`text.rs`).

mod absence;
mod answer;
mod cause;
mod cause_parts;
mod chain;
mod crew;
mod find;
mod history;
mod link;
mod log;
mod moment;
mod monitors;
mod phrase;
mod snapshot;
mod target;
mod task;
mod text;
mod things;
mod why;
mod why_not;

pub use crate::limits::EXPLANATION_DEPTH_DEFAULT as DEPTH_DEFAULT;
pub use crate::method_detail::MethodDetail;
pub use answer::{
    About, Answer, Blocked, Choice, CommandAnswer, EXPLANATION_VERSION, Holder, Missing, ResourceAnswer, Subtask,
    TargetMoment, Unmet, Why, WhyNot,
};
pub use cause::{CauseDetail, CausePart, Observation, PartValue};
pub use find::{TaskSearchError, find_task};
pub use link::Link;
pub use moment::Moment;
pub use monitors::{Binding, MonitoredCondition, Monitors, TaskMonitor};
pub use snapshot::Question;
pub use task::TaskExplanation;

use crate::error::RecordError;
use crate::record::{LoadProgram, RecordReader};
use apex_model::task::TaskId;
use apex_model::time::Time;
use snapshot::RecordSnapshot;

/// Answers questions about a recorded flight. Every answer is a typed value; text and JSON are printed from it.
#[derive(Clone, Copy)]
pub struct Explainer<'a> {
    reader: &'a RecordReader,
    load: Option<LoadProgram<'a>>,
}

impl<'a> Explainer<'a> {
    /// Returns an explainer that restores the agent at the instant of each question; `load` checks the recorded sources again.
    pub fn new(reader: &'a RecordReader, load: LoadProgram<'a>) -> Explainer<'a> {
        Explainer { reader, load: Some(load) }
    }

    /// Returns an explainer that reads only the record's decisions and restores no agent. It is fast; its answers lack what only the
    /// agent knows (open conditions, priorities, choices) and chains of causes.
    pub fn of_decisions(reader: &'a RecordReader) -> Explainer<'a> {
        Explainer { reader, load: None }
    }

    /// Explains a task; if there is none with this name a resource (`camera-1`), then a command (`command 7`, or words of its form).
    ///
    /// # Errors
    /// [`RecordError::Question`] with candidates for an ambiguous or unknown name; others if the record cannot be read
    /// or its mission not loaded.
    pub fn why(&self, question: &Question) -> Result<Answer, RecordError> {
        match crew::addressed(self.reader, question)? {
            Some((reader, question)) => self.on(&reader).why_one(&question).map(Answer::of_crew),
            None => self.why_one(question),
        }
    }

    /// Explains why something has not happened: a task by number, tag or goal, a step or goal of the program, a procedure by its place, a
    /// resource, a target.
    ///
    /// # Errors
    /// [`RecordError::Question`] with suggestions if nothing has this name; others as [`Explainer::why`].
    pub fn why_not(&self, question: &Question) -> Result<WhyNot, RecordError> {
        match crew::addressed(self.reader, question)? {
            Some((reader, question)) => why_not::answer(self.on(&reader).snapshot(&question)?, &question.what),
            None => why_not::answer(self.snapshot(question)?, &question.what),
        }
    }

    /// Explains task `id` at `at`, or at the end of the record if that is earlier.
    ///
    /// # Errors
    /// Like [`Explainer::why`].
    pub fn task(&self, id: TaskId, at: Time) -> Result<Why, RecordError> {
        let question = Question::new(&id.to_string(), at);
        let snapshot = self.snapshot(&question)?;
        let id = find_task(&snapshot.tasks, &question.what, snapshot.at)?.id;
        why::of_task(snapshot, id, "why", &question.what)
    }

    /// Returns an explainer with the same options for another reader.
    fn on<'b>(&self, reader: &'b RecordReader) -> Explainer<'b>
    where
        'a: 'b,
    {
        Explainer { reader, load: self.load }
    }

    fn snapshot(&self, question: &Question) -> Result<RecordSnapshot<'a>, RecordError> {
        RecordSnapshot::set(self.reader, question, self.load)
    }

    /// Answers from the record of a single agent.
    fn why_one(&self, question: &Question) -> Result<Answer, RecordError> {
        let snapshot = self.snapshot(question)?;
        let name = find::without_agent(&question.what, &snapshot.name)?;
        let tagged =
            snapshot.tasks.iter().any(|row| row.created <= snapshot.at && row.tag.eq_ignore_ascii_case(name.trim()));
        if !tagged && let Some(answer) = things::of_resource(&snapshot, name, "why")? {
            return Ok(Answer::Resource(Box::new(answer.answer)));
        }
        match find_task(&snapshot.tasks, name, snapshot.at).map(|row| row.id) {
            Ok(id) => why::of_task(snapshot, id, "why", &question.what).map(|why| Answer::Task(Box::new(why))),
            // The tag of a step refers to its tasks, never to a command that contains the same word.
            Err(error) if tagged => Err(find::of_no_agent(error.into_text(), name, &snapshot.name)),
            Err(error) => match things::of_command(&snapshot, name)? {
                Some(answer) => Ok(Answer::Command(Box::new(answer))),
                None => Err(find::of_no_agent(error.into_text(), name, &snapshot.name)),
            },
        }
    }
}
