//! Explanations of a recorded flight: why a task is as it is, why a resource belongs to somebody, why a command was
//! sent; and why something is not: not created, not started, not chosen, not granted, not visited.
//!
//! An answer is plain data (`answer.rs`); its JSON form is described in `docs/reference/explanations.md`, its text is made
//! from the same data (`text.rs`).

mod absence;
mod answer;
mod chain;
mod crew;
mod find;
mod history;
mod link;
mod log;
mod phrase;
mod scene;
mod target;
mod text;
mod things;
mod why;
mod why_not;

pub use crate::limits::EXPLANATION_DEPTH_DEFAULT as DEPTH_DEFAULT;
pub use answer::{
    About, Answer, Blocked, Choice, CommandAnswer, EXPLANATION_VERSION, Holder, Missing, ResourceAnswer, Subtask,
    TargetMoment, Unmet, Why, WhyNot,
};
pub use crew::why_of_any;
pub use find::find_task;
pub use history::Moment;
pub use link::Link;
pub use scene::Question;

use crate::error::RecordError;
use crate::record::{LoadProgram, RecordReader};
use apex_model::time::Time;
use scene::Scene;

/// Explains the task called `name` (`T12`, `12`, or words of its goal or tag) as it was at `at`, or at the end of the
/// record where that comes first.
///
/// # Errors
/// [`RecordError::Question`] with candidates for an ambiguous or unknown name; others when the record cannot be read
/// or its mission not loaded.
pub fn why(reader: &RecordReader, name: &str, at: Time, load: LoadProgram<'_>) -> Result<Why, RecordError> {
    let question = Question::new(name, at);
    let scene = Scene::set(reader, &question, load)?;
    let id = find_task(&scene.tasks, find::without_agent(name, &scene.name)?, scene.at)?.id;
    why::of_task(scene, id, "why", name)
}

/// Explains a task, else a resource (`camera-1`), else a command (`command 7`, or words of its form).
///
/// # Errors
/// As [`why`].
pub fn ask(reader: &RecordReader, question: &Question, load: LoadProgram<'_>) -> Result<Answer, RecordError> {
    if let Some((reader, question)) = crew::addressed(reader, question)? {
        return ask_one(&reader, &question, load).map(|answer| answer.of_crew());
    }
    ask_one(reader, question, load)
}

/// Asks the record of one agent.
fn ask_one(reader: &RecordReader, question: &Question, load: LoadProgram<'_>) -> Result<Answer, RecordError> {
    let scene = Scene::set(reader, question, load)?;
    let name = find::without_agent(&question.what, &scene.name)?;
    let tagged = scene.tasks.iter().any(|row| row.created <= scene.at && row.tag.eq_ignore_ascii_case(name.trim()));
    if !tagged && let Some(answer) = things::of_resource(&scene, name, "why")? {
        return Ok(Answer::Resource(Box::new(answer)));
    }
    match find_task(&scene.tasks, name, scene.at).map(|row| row.id) {
        Ok(id) => why::of_task(scene, id, "why", &question.what).map(|why| Answer::Task(Box::new(why))),
        // A step's tag means its tasks, never a command with the same word in it.
        Err(error) if tagged => Err(find::of_no_agent(error, name, &scene.name)),
        Err(error) => match things::of_command(&scene, name)? {
            Some(answer) => Ok(Answer::Command(Box::new(answer))),
            None => Err(find::of_no_agent(error, name, &scene.name)),
        },
    }
}

/// Explains why something is not: a task by number, tag or goal, a step or a goal of the program, a procedure by its
/// place, a resource, a target.
///
/// # Errors
/// [`RecordError::Question`] with what may have been meant when nothing has this name; others as [`why`].
pub fn why_not(reader: &RecordReader, question: &Question, load: LoadProgram<'_>) -> Result<WhyNot, RecordError> {
    if let Some((reader, question)) = crew::addressed(reader, question)? {
        return why_not::answer(Scene::set(&reader, &question, load)?, &question.what);
    }
    let scene = Scene::set(reader, question, load)?;
    why_not::answer(scene, &question.what)
}
