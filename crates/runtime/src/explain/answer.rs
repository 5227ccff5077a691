//! Explanations as plain data, serialised to JSON without change (`docs/reference/explanations.md`). `text.rs` prints text from the same
//! data, so that both agree.

use super::{Link, Moment};
use apex_executive::explanation::ReasonKind;
use serde::Serialize;

/// The version of the JSON form. It increases when a member changes or is removed, not when one is added.
pub const EXPLANATION_VERSION: u32 = 1;

/// Head of every answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct About {
    /// [`EXPLANATION_VERSION`].
    pub version: u32,
    /// `why` or `why-not`.
    pub question: &'static str,
    /// Kind of the subject: `task`, `resource`, `command`, `target`, `step`, `procedure`.
    pub kind: &'static str,
    /// The subject, as written in the question.
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
    /// Adds the names of agents to tasks if several agents ran.
    pub(super) fn of_crew(mut self) -> Answer {
        if let Answer::Task(why) = &mut self {
            why.task = format!("{}/{}", why.about.agent, why.task);
        }
        self
    }
}

/// Holders of a resource and its claimants, with reasons.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ResourceAnswer {
    /// Head.
    #[serde(flatten)]
    pub about: About,
    /// Its name.
    pub resource: String,
    /// Total amount, with its unit.
    pub total: String,
    /// Holders at that instant.
    pub holders: Vec<Holder>,
    /// Waiting tasks at that instant.
    pub waiting: Vec<Holder>,
}

/// A task that holds a resource or waits for it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Holder {
    /// The task, `T4`.
    pub task: String,
    /// Its goal.
    pub goal: String,
    /// Held amount; `None` for a waiting task.
    pub amount: Option<String>,
    /// Its priority then.
    pub priority: f64,
    /// Added to its priority when it defends the resource.
    pub interrupt_cost: f64,
    /// Reason of the grant or of the refusal.
    pub because: Option<Link>,
    /// For a waiting task: the requirements at the instant of the question, with the holders of this resource and the reasons. Empty for
    /// a holder.
    pub waits_for: Vec<Unmet>,
}

/// Reason for which a command was sent.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct CommandAnswer {
    /// Head.
    #[serde(flatten)]
    pub about: About,
    /// Its form.
    pub form: String,
    /// Cause, back to a sample, a message or a form of the program.
    pub because: Link,
}

/// A procedure, primitive or solver that could have served a goal.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Choice {
    /// `procedure file.pdl:3:1`
    pub method: String,
    /// `file:line:column` of a procedure or primitive.
    pub place: Option<String>,
    /// Its index.
    pub index: String,
    /// True if it matches the goal.
    pub matches: bool,
    /// Reason for its order: first, later, or not matching.
    pub because: String,
}

/// An answer to `why-not`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct WhyNot {
    /// Head.
    #[serde(flatten)]
    pub about: About,
    /// The answer in one line.
    pub answer: String,
    /// For a step without a task: the missing steps, from the subject of the question up to the first existing task.
    pub missing: Vec<Missing>,
    /// The task for which all of them wait, or the subject of the question.
    pub task: Option<Box<Why>>,
    /// History of the target, if the question concerns one.
    pub target: Vec<TargetMoment>,
    /// Other possible meanings of the question.
    pub others: Vec<String>,
}

/// A step, procedure or goal for which no task exists yet.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Missing {
    /// Its step's tag, or `root`.
    pub step: String,
    /// Its activity as written.
    pub activity: String,
    /// The procedure that the step belongs to: its index.
    pub procedure: String,
    /// Position of the step in the PDL text.
    pub place: String,
    /// The text of that line.
    pub source: Option<String>,
    /// Missing requirement, human-readable.
    pub because: String,
}

/// Moment in the history of a target.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct TargetMoment {
    /// Instant, in seconds of mission time.
    pub t: f64,
    /// `planned`, `observing`, `observed`, `skipped`.
    pub state: String,
    /// Reason, as text.
    pub detail: String,
}

/// The explanation of a task.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Why {
    /// Head.
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
    /// A word of `apex_model::task::OUTCOME_WORDS`, if it has ended.
    pub outcome: Option<String>,
    /// Its priority at the instant, without interrupt cost; `None` if it has ended.
    pub priority: Option<f64>,
    /// Resources that it holds then.
    pub holds: Vec<String>,
    /// Method, `procedure file.pdl:3:1`, if it was selected.
    pub method: Option<String>,
    /// `file:line:column` of its step.
    pub place: Option<String>,
    /// Cause of its state, back to a sample, a message or a form of the program.
    pub because: Option<Link>,
    /// Methods for its goal with the reasons of their order; the chosen one is the first that matches.
    pub choices: Vec<Choice>,
    /// History, oldest first.
    pub history: Vec<Moment>,
    /// Open requirements at the instant; empty if the task does not wait.
    pub waiting: Vec<Unmet>,
    /// Holder of the resource over which the task lost its last conflict; `None` if it has won since.
    pub blocked: Option<Blocked>,
    /// Its subtasks that live then.
    pub subtasks: Vec<Subtask>,
}

/// One open requirement.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Unmet {
    /// Kind.
    #[cfg_attr(test, ts(type = "string"))]
    pub kind: ReasonKind,
    /// The part of the condition as PDL text, or the reason as text.
    pub what: String,
    /// Present state; empty if `what` is complete.
    pub now: String,
    /// True for a part of a condition about which no sample or message has arrived.
    pub unobserved: bool,
    /// Since when, in seconds of mission time, where that is known.
    pub since: Option<f64>,
    /// Instant at which it is met by time alone, if nothing changes before, in seconds of mission time.
    pub until: Option<f64>,
    /// Distance of the newest sample from the threshold, with its unit.
    pub distance: Option<String>,
    /// The other task concerned, `T4`; `None` if it concerns no other task.
    pub task: Option<String>,
    /// Its number, 4 for `T4`.
    pub task_number: Option<u64>,
    /// Position in the PDL text.
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
    /// The loser's priority or rank.
    pub loser_priority: f64,
    /// The part of the winner's priority that is its interrupt cost.
    pub winner_cost: f64,
    /// The part of the loser's priority that is its interrupt cost.
    pub loser_cost: f64,
    /// Both strengths as text for operators: `5 against 0 + interrupt cost 0.1`.
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
