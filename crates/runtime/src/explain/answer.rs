//! What an explanation is: plain data, which becomes JSON as it stands (`docs/reference/explanations.md`). Texts are made
//! from it in `text.rs`, so that both say the same.

use super::{Link, Moment};
use apex_executive::explanation::ReasonKind;
use serde::Serialize;

/// The version of the JSON form. A new member is no new version; one that changes or goes is.
pub const EXPLANATION_VERSION: u32 = 1;

/// What every answer says first.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct About {
    /// [`EXPLANATION_VERSION`].
    pub version: u32,
    /// `why` or `why-not`.
    pub question: &'static str,
    /// What kind of thing was asked about: `task`, `resource`, `command`, `target`, `step`, `procedure`.
    pub kind: &'static str,
    /// What was asked about, as the asker wrote it.
    pub asked: String,
    /// The agent.
    pub agent: String,
    /// The instant of the question, in seconds of mission time.
    pub t: f64,
}

/// An answer to `why`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(untagged)]
pub enum Answer {
    /// About a task.
    Task(Box<Why>),
    /// About a resource.
    Resource(Box<ResourceAnswer>),
    /// About a command.
    Command(Box<CommandAnswer>),
}

impl Answer {
    /// Where several agents ran a task is named with its agent.
    pub(super) fn of_crew(mut self) -> Answer {
        if let Answer::Task(why) = &mut self {
            why.task = format!("{}/{}", why.about.agent, why.task);
        }
        self
    }
}

/// Who has a resource, and why; who wants it too.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ResourceAnswer {
    /// What every answer says first.
    #[serde(flatten)]
    pub about: About,
    /// Its name.
    pub resource: String,
    /// How much of it there is, with its unit.
    pub total: String,
    /// Who holds it then.
    pub holders: Vec<Holder>,
    /// Who waits for it then.
    pub waiting: Vec<Holder>,
}

/// A task that holds a resource, or waits for it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Holder {
    /// The task, `T4`.
    pub task: String,
    /// Its goal.
    pub goal: String,
    /// How much it holds; none for who waits.
    pub amount: Option<String>,
    /// Its priority then.
    pub priority: f64,
    /// What it adds to that where it defends.
    pub interrupt_cost: f64,
    /// How it got it, or why it was refused.
    pub because: Option<Link>,
    /// What it waits for at the instant of the question, who waits: for this resource, who has it and why it stays so.
    pub waits_for: Vec<Unmet>,
}

/// Why a command was sent.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct CommandAnswer {
    /// What every answer says first.
    #[serde(flatten)]
    pub about: About,
    /// Its form.
    pub form: String,
    /// Why, back to a sample, a message or a sentence of the program.
    pub because: Link,
}

/// A procedure, primitive or solver that could have served a goal.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Choice {
    /// `procedure file.pdl:3:1`
    pub method: String,
    /// Its index.
    pub index: String,
    /// It matches the goal.
    pub matches: bool,
    /// Why it is first, why it comes later, or why it does not match.
    pub because: String,
}

/// An answer to `why-not`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct WhyNot {
    /// What every answer says first.
    #[serde(flatten)]
    pub about: About,
    /// The answer in a sentence.
    pub answer: String,
    /// For what was never created: from what was asked about up to the first that exists.
    pub missing: Vec<Missing>,
    /// The task that all waits for, or that was asked about.
    pub task: Option<Box<Why>>,
    /// What became of the target, if one was asked about.
    pub target: Vec<TargetMoment>,
    /// What else may have been meant.
    pub others: Vec<String>,
}

/// Something that does not exist yet.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Missing {
    /// Its step's tag, or `root`.
    pub step: String,
    /// Its activity, as it is written.
    pub activity: String,
    /// The procedure that the step belongs to: its index.
    pub procedure: String,
    /// Where the step stands.
    pub place: String,
    /// The text of that line.
    pub source: Option<String>,
    /// What is missing, in a sentence.
    pub because: String,
}

/// What became of a target.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct TargetMoment {
    /// When, in seconds of mission time.
    pub t: f64,
    /// `planned`, `observing`, `observed`, `skipped`.
    pub state: String,
    /// Why, as text.
    pub detail: String,
}

/// The explanation of a task.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Why {
    /// What every answer says first.
    #[serde(flatten)]
    pub about: About,
    /// The task, `T12`.
    pub task: String,
    /// Its step's tag.
    pub tag: String,
    /// Its goal, as known then.
    pub goal: String,
    /// Its state then.
    pub state: String,
    /// Since when, in seconds of mission time.
    pub since: f64,
    /// `success`, `failure` or `cut`, if it has ended.
    pub outcome: Option<String>,
    /// Its priority then, without interrupt cost; none when it has ended.
    pub priority: Option<f64>,
    /// Resources that it holds then.
    pub holds: Vec<String>,
    /// How it is pursued, `procedure file.pdl:3:1`, if that was decided.
    pub method: Option<String>,
    /// `file:line:column` of its step.
    pub place: Option<String>,
    /// Why it came to its state, back to a sample, a message or a sentence of the program.
    pub because: Option<Link>,
    /// What else could have pursued its goal, and why it does not; the chosen one is the first that matches.
    pub choices: Vec<Choice>,
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
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Unmet {
    /// What kind of thing.
    #[cfg_attr(test, ts(type = "string"))]
    pub kind: ReasonKind,
    /// The part of the condition as PDL text, or the reason as text.
    pub what: String,
    /// What is known about it then; empty where `what` says it all.
    pub now: String,
    /// Since when, in seconds of mission time, where that is known.
    pub since: Option<f64>,
    /// When it comes true by time alone, in seconds of mission time, if nothing changes before.
    pub until: Option<f64>,
    /// How far the newest sample is from the threshold, with its unit.
    pub distance: Option<String>,
    /// The task concerned, `T4`, if another one is.
    pub task: Option<String>,
    /// Where it stands in PDL.
    pub place: Option<String>,
}

/// A lost conflict.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
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
    /// Both for operators: `5 against 0 + interrupt cost 0.1`.
    pub strengths: String,
}

/// A living subtask.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Subtask {
    /// The task, `T13`.
    pub task: String,
    /// Its goal.
    pub goal: String,
    /// Its state.
    pub state: String,
}
