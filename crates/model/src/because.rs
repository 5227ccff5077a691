//! Causes. Every decision carries one; a transition cannot be written without it.
//!
//! Texts are made here and nowhere else, so that the trace, `apex why`, Sherpa and Python say the same words.

use crate::effect::{CommandId, SolveRequestId};
use crate::library::Library;
use crate::source::Place;
use crate::symbol::Symbol;
use crate::task::TaskId;
use crate::time::{Duration, Time};
use crate::value::Value;
use serde::{Deserialize, Serialize};

/// Why something was decided, and by which line of PDL.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Because {
    /// The cause.
    pub cause: Cause,
    /// The clause of PDL that made it so.
    pub place: Option<Place>,
    /// What was seen: samples, events, ends of tasks.
    pub evidence: Vec<Evidence>,
}

/// A fact that a decision rests on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Evidence {
    /// A sample.
    Sample {
        /// The state variable as text, `(roll-angle aircraft-1)`.
        variable: String,
        /// Its value.
        value: Value,
        /// When.
        at: Time,
    },
    /// A message.
    Event {
        /// Its form.
        form: Value,
        /// When.
        at: Time,
    },
    /// The end of a task.
    TaskEnd {
        /// The task.
        task: TaskId,
        /// When.
        at: Time,
    },
    /// An episode over a run of samples.
    Run {
        /// The state variable as text.
        variable: String,
        /// First sample's time.
        start: Time,
        /// Last sample's time.
        end: Time,
        /// How many samples.
        samples: u64,
    },
}

/// Causes of decisions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Cause {
    /// The agent started with this goal.
    InitialTask,
    /// The parent's controller made this subtask.
    ParentStarted {
        /// The parent.
        parent: TaskId,
    },
    /// There is nothing to wait for.
    NoPreconditions,
    /// The preconditions hold.
    PreconditionsSatisfied,
    /// A clause's condition holds (`end-when`, `restart-when`, `suspend-when`, ..).
    ConditionSatisfied {
        /// The clause's name.
        clause: String,
    },
    /// All resources are free, or none is needed.
    ResourcesGranted {
        /// Their names.
        resources: Vec<Value>,
    },
    /// A conflict over a resource was lost.
    Outranked {
        /// The winner.
        by: TaskId,
        /// The resource.
        resource: Value,
        /// The rule that decided.
        rule: ConflictRule,
        /// What the winner brought.
        winner: Strength,
        /// What the loser brought.
        loser: Strength,
    },
    /// The resource can never give what is needed: it has less, or less of it is left.
    ResourceExhausted {
        /// The resource.
        resource: Value,
        /// The amount needed, with its unit.
        needed: Value,
        /// What there is, with its unit.
        left: Value,
    },
    /// An ancestor was interrupted with its whole subtree, or resumed, or starts over.
    AncestorChanged {
        /// The ancestor.
        ancestor: TaskId,
    },
    /// A built-in activity of another task did it: `terminate`, `suspend`, `resume`, `reset`.
    Activity {
        /// The task that did it.
        by: TaskId,
        /// The activity's name.
        activity: String,
    },
    /// All steps have ended.
    StepsEnded,
    /// A primitive was complete at once.
    CompletedAtOnce,
    /// A primitive's `(complete)` form.
    CompletedByForm,
    /// A primitive's duration is over.
    DurationElapsed {
        /// The time worked, without suspensions.
        duration: Duration,
    },
    /// The vehicle acknowledged the command.
    CommandAcknowledged {
        /// The command.
        command: CommandId,
    },
    /// The vehicle refused or lost the command.
    CommandFailed {
        /// The command.
        command: CommandId,
        /// The vehicle's reason.
        reason: String,
    },
    /// All tasks made by `forall` have ended, or the list was empty.
    ItemsEnded {
        /// How many items.
        items: u64,
    },
    /// The parent ended.
    ParentEnded {
        /// The parent.
        parent: TaskId,
    },
    /// A child failed and nothing handles it.
    ChildFailed {
        /// The child.
        child: TaskId,
    },
    /// The failure of this task is handled by another goal.
    FailureHandled {
        /// The task that handles it.
        by: TaskId,
    },
    /// The step repeats or responds again.
    Repetition,
    /// Nothing in the library and no solver serves the goal.
    NoMethod {
        /// The goal.
        goal: Value,
    },
    /// A solver failed to plan for the goal.
    SolverFailed {
        /// The request.
        request: SolveRequestId,
        /// The solver's reason.
        reason: String,
    },
    /// No procedure or primitive matched, and a solver serves the goal.
    NoProcedureMatched,
    /// The most specific match.
    MostSpecific {
        /// How many matched.
        candidates: u64,
    },
    /// A solver's plan arrived.
    PlanArrived {
        /// The request.
        request: SolveRequestId,
        /// The solver.
        solver: Symbol,
    },
    /// A `select`, `=>` or pattern bound a variable.
    Binding {
        /// The clause's name.
        clause: String,
    },
    /// An expression could not be evaluated.
    ExpressionFailed {
        /// What went wrong.
        message: String,
    },
    /// A limit of the executive was reached.
    LimitReached {
        /// The limit's name in `limits.rs`.
        limit: String,
        /// Its value.
        value: u64,
    },
    /// The operator did not answer in time, or answered.
    Operator {
        /// What happened.
        what: String,
    },
    /// `(end-application)`, or the end of the root task.
    ApplicationEnded,
}

/// Rules of conflict resolution (`pdl.md` section 9).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ConflictRule {
    /// Lower rank among siblings.
    Rank,
    /// Higher priority.
    Priority,
    /// Equal: who has it keeps it.
    Incumbent,
    /// Equal newcomers: written order.
    WrittenOrder,
    /// Equal newcomers: created earlier.
    CreationOrder,
    /// Not enough units are left.
    Capacity,
}

/// What a task brings to a conflict: its priority (or rank), and its interrupt cost where it defends what it holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Strength {
    /// Priority, or rank where ranks decide.
    pub priority: f64,
    /// Interrupt cost; 0 for who does not hold the resource, and where ranks decide.
    pub interrupt_cost: f64,
}

impl Strength {
    /// Of a task that claims.
    pub fn claiming(priority: f64) -> Strength {
        Strength { priority, interrupt_cost: 0.0 }
    }

    /// What is compared.
    pub fn total(self) -> f64 {
        self.priority + self.interrupt_cost
    }
}

impl std::fmt::Display for Strength {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.interrupt_cost {
            0.0 => write!(f, "{}", self.priority),
            cost => write!(f, "{} + interrupt cost {cost}", self.priority),
        }
    }
}

impl Because {
    /// A cause with a place and no evidence.
    pub fn new(cause: Cause, place: Option<Place>) -> Because {
        Because { cause, place, evidence: Vec::new() }
    }

    /// The cause as a sentence fragment after "because", with evidence and place: what the trace prints.
    pub fn text(&self, library: &Library) -> String {
        let mut text = self.cause.text();
        for (index, evidence) in self.evidence.iter().enumerate() {
            text.push_str(if index == 0 { ": " } else { ", " });
            text.push_str(&evidence.text());
        }
        if let Some(place) = self.place {
            text.push_str("; from ");
            text.push_str(&library.describe_place(place));
        }
        text
    }
}

impl Evidence {
    /// `(roll-angle aircraft-1) = 7.2deg at 12.5s`
    pub fn text(&self) -> String {
        match self {
            Evidence::Sample { variable, value, at } => format!("{variable} = {value} at {at}"),
            Evidence::Event { form, at } => format!("{form} at {at}"),
            Evidence::TaskEnd { task, at } => format!("{task} ended at {at}"),
            Evidence::Run { variable, start, end, samples } => {
                format!("{variable} from {start} to {end}, {samples} samples")
            }
        }
    }
}

impl Cause {
    /// The cause in words.
    pub fn text(&self) -> String {
        match self {
            Cause::InitialTask => "it is the agent's initial task".into(),
            Cause::ParentStarted { parent } => format!("{parent} started and has this step"),
            Cause::NoPreconditions => "there is nothing to wait for".into(),
            Cause::PreconditionsSatisfied => "its preconditions hold".into(),
            Cause::ConditionSatisfied { clause } => format!("the condition of {clause} holds"),
            Cause::ResourcesGranted { resources } if resources.is_empty() => "it needs no resources".into(),
            Cause::ResourcesGranted { resources } => format!("it was granted {}", words(resources)),
            Cause::Outranked { by, resource, rule, winner, loser } => {
                outranked_text(*by, resource, *rule, *winner, *loser)
            }
            Cause::ResourceExhausted { resource, needed, left } => {
                format!("{resource} can never give the {needed} that it needs: there is {left}")
            }
            Cause::AncestorChanged { ancestor } => format!("{ancestor} above it changed"),
            Cause::Activity { by, activity } => format!("{by} did ({activity})"),
            Cause::StepsEnded => "all of its steps have ended".into(),
            Cause::CompletedAtOnce => "its primitive takes no time".into(),
            Cause::CompletedByForm => "its primitive said (complete)".into(),
            Cause::DurationElapsed { duration } => format!("its duration of {duration} is over"),
            Cause::CommandAcknowledged { command } => format!("the vehicle finished command {}", command.0),
            Cause::CommandFailed { command, reason } => format!("command {} failed: {reason}", command.0),
            Cause::ItemsEnded { items: 0 } => "its forall list is empty".into(),
            Cause::ItemsEnded { items } => format!("all {items} items of its forall have ended"),
            Cause::ParentEnded { parent } => format!("{parent} above it ended"),
            Cause::ChildFailed { child } => format!("its subtask {child} failed and nothing handles that"),
            Cause::FailureHandled { by } => format!("{by} handles its failure"),
            Cause::Repetition => "its step repeats".into(),
            Cause::NoMethod { goal } => format!("no procedure, primitive or solver serves {goal}"),
            Cause::SolverFailed { request, reason } => format!("solver request {} failed: {reason}", request.0),
            Cause::NoProcedureMatched => "no procedure or primitive matches, and a solver serves the goal".into(),
            Cause::MostSpecific { candidates: 1 } => "it is the only match".into(),
            Cause::MostSpecific { candidates } => format!("it is the most specific of {candidates} matches"),
            Cause::PlanArrived { request, solver } => format!("{solver} answered request {}", request.0),
            Cause::Binding { clause } => format!("{clause} gave it"),
            Cause::ExpressionFailed { message } => format!("an expression failed: {message}"),
            Cause::LimitReached { limit, value } => format!("the limit {limit} = {value} was reached"),
            Cause::Operator { what } => what.clone(),
            Cause::ApplicationEnded => "the application ended".into(),
        }
    }
}

fn words(values: &[Value]) -> String {
    values.iter().map(Value::to_string).collect::<Vec<_>>().join(", ")
}

fn outranked_text(by: TaskId, resource: &Value, rule: ConflictRule, winner: Strength, loser: Strength) -> String {
    match rule {
        ConflictRule::Rank => format!("{by} comes first on {resource} (rank {winner} before {loser})"),
        ConflictRule::Priority => format!("{by} outranks it on {resource} (priority {winner} > {loser})"),
        ConflictRule::Incumbent => format!("{by} holds {resource} and defends it (priority {winner} against {loser})"),
        ConflictRule::WrittenOrder => format!("{by} is written first and takes {resource} (both priority {winner})"),
        ConflictRule::CreationOrder => format!("{by} is older and takes {resource} (both priority {winner})"),
        ConflictRule::Capacity => format!("not enough of {resource} is left, {by} has it"),
    }
}
