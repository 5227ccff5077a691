//! Causes. Every decision carries one; a transition cannot be written without it.
//!
//! Texts of causes are made only here, so that the trace, `apex why`, Sherpa and Python use the same words.

use crate::estimate::{Aggregate, Estimate};
use crate::event::StateVariable;
use crate::evidence_list::EvidenceList;
use crate::library::Library;
use crate::source::Place;
use crate::task::TaskId;
use crate::time::Time;
use crate::value::Value;
use serde::{Deserialize, Serialize};

pub use crate::cause::Cause;

/// Cause of a decision, and the line of PDL that led to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Because {
    /// The cause.
    pub cause: Cause,
    /// The clause of PDL that caused it.
    pub place: Option<Place>,
    /// Evidence: samples, events, ends of tasks.
    pub evidence: EvidenceList,
}

/// A fact that a decision rests on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Evidence {
    /// A sample.
    Sample {
        /// The state variable, `(roll-angle aircraft-1)`; of a task's state `(state T1)`.
        variable: StateVariable,
        /// Its value.
        value: Value,
        /// Instant.
        at: Time,
    },
    /// A message.
    Event {
        /// Its form.
        form: Value,
        /// Instant.
        at: Time,
        /// Its arrival number, because equal messages may arrive at one instant.
        sequence: u64,
    },
    /// A task's state.
    TaskState {
        /// The task.
        task: TaskId,
        /// The state's word; `resumed` is the change from interrupted to ongoing.
        state: Value,
        /// Instant.
        at: Time,
    },
    /// The end of a task.
    TaskEnd {
        /// The task.
        task: TaskId,
        /// Instant.
        at: Time,
    },
    /// An episode over a run of samples.
    Run {
        /// The state variable.
        variable: StateVariable,
        /// First sample's time.
        start: Time,
        /// Last sample's time.
        end: Time,
        /// Number of samples.
        samples: u64,
    },
    /// An instant that was waited for.
    Instant {
        /// For a delay, the beginning of the wait.
        since: Option<Time>,
        /// The instant.
        at: Time,
    },
    /// An expression that was true.
    Function {
        /// The expression, as PDL text.
        what: String,
        /// Its value.
        value: Value,
        /// Instant.
        at: Time,
    },
    /// Something that did not happen.
    Absence {
        /// The condition, as PDL text.
        what: String,
        /// Instant up to which it was not true.
        at: Time,
    },
    /// A value that an estimator gives.
    Estimate(Box<Estimate>),
    /// A statistic or a trend.
    Aggregate(Box<Aggregate>),
}

/// Share of a resource that a task was granted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// The resource.
    pub resource: Value,
    /// Amount with its unit; `None` is all of the resource.
    pub amount: Option<Value>,
}

/// One wait of a circle of tasks that wait for each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CircleLink {
    /// The waiting task.
    pub task: TaskId,
    /// The resource that it waits for.
    pub resource: Value,
    /// The holder: a task above the one that waits next.
    pub holder: TaskId,
}

/// Rules of conflict resolution (`pdl.md`, Conflicts).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ConflictRule {
    /// Lower rank among siblings.
    Rank,
    /// Higher priority.
    Priority,
    /// Equal: the holder keeps the resource.
    Incumbent,
    /// Equal: work that was interrupted continues before other work begins.
    Begun,
    /// Equal newcomers: written order.
    WrittenOrder,
    /// Equal newcomers: created earlier.
    CreationOrder,
    /// Not enough units are left.
    Capacity,
    /// Higher priority, inherited from a task that the winner precedes by rank.
    GoesBefore {
        /// That task.
        whom: TaskId,
    },
}

/// Rule that chooses among several equally specific matches, by what is true of the chosen one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum EqualsRule {
    /// It is a plan made in flight, which was requested for use.
    MadeInFlight,
    /// It is a procedure, and the others are primitives.
    Procedure,
    /// It comes first in the library.
    FirstInLibrary,
}

/// Strength of a task in a conflict: its priority or rank, and its interrupt cost if it defends its resources.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Strength {
    /// Priority, or rank where ranks decide.
    pub priority: f64,
    /// Interrupt cost; 0 for a task that does not hold the resource, and in comparisons by rank.
    pub interrupt_cost: f64,
}

impl Strength {
    /// Returns the strength of a task that claims.
    pub fn claiming(priority: f64) -> Strength {
        Strength { priority, interrupt_cost: 0.0 }
    }

    /// Returns the value that is compared.
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
    /// Returns a cause with a place and no evidence.
    pub fn new(cause: Cause, place: Option<Place>) -> Because {
        Because { cause, place, evidence: EvidenceList::default() }
    }

    /// Returns the cause as text after "because", with evidence and place, as in the trace.
    pub fn text(&self, library: &Library) -> String {
        self.text_at(&|place| library.describe_place(place))
    }

    /// Returns the same text, with places described by `describe`.
    pub fn text_at(&self, describe: &dyn Fn(Place) -> String) -> String {
        let mut text = self.cause.text();
        for (index, evidence) in self.evidence.iter().enumerate() {
            text.push_str(if index == 0 { ": " } else { ", " });
            text.push_str(&evidence.text());
        }
        if let Some(place) = self.place {
            text.push_str("; from ");
            text.push_str(&describe(place));
        }
        text
    }
}

impl Evidence {
    /// Returns the fact as text, for a sample `(roll-angle aircraft-1) = 7.2deg at 12.5s`.
    pub fn text(&self) -> String {
        match self {
            Evidence::Sample { variable, value, at } => format!("{variable} = {value} at {at}"),
            Evidence::Event { form, at, .. } => format!("{form} at {at}"),
            Evidence::TaskState { task, state, at } => format!("(state {task}) = {state} at {at}"),
            Evidence::TaskEnd { task, at } => format!("{task} ended at {at}"),
            Evidence::Run { variable, start, end, samples } => {
                let noun = if *samples == 1 { "sample" } else { "samples" };
                format!("{variable} from {start} to {end}, {samples} {noun}")
            }
            Evidence::Instant { since: Some(since), at } => format!("{} after {since}, at {at}", *at - *since),
            Evidence::Instant { since: None, at } => format!("it is {at}"),
            Evidence::Function { what, value, at } => format!("{what} is {value} at {at}"),
            Evidence::Absence { what, at } => format!("no {what} up to {at}"),
            Evidence::Estimate(estimate) => estimate.text(),
            Evidence::Aggregate(aggregate) => aggregate.text(),
        }
    }
}

impl Share {
    /// Returns the share as text: `camera-1`, or `2 of downlink`.
    pub fn text(&self) -> String {
        match &self.amount {
            None => self.resource.to_string(),
            Some(amount) => format!("{amount} of {}", self.resource),
        }
    }
}
