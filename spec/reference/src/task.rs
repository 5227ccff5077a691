//! The interpreter's view of tasks.

use crate::program::{Condition, Span, Time};
use crate::value::{Bindings, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// The states of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum State {
    /// Waits for its preconditions.
    Pending,
    /// Waits for its resources.
    Enabled,
    /// Works.
    Ongoing,
    /// Lost a resource or was suspended.
    Interrupted,
    /// Has ended.
    Terminated,
}

impl State {
    /// Returns its name in PDL.
    pub fn word(self) -> &'static str {
        match self {
            State::Pending => "pending",
            State::Enabled => "enabled",
            State::Ongoing => "ongoing",
            State::Interrupted => "interrupted",
            State::Terminated => "terminated",
        }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// Origin of a task; procedure and step by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    Root,
    Step(usize, usize),
    Item(usize, usize),
    Handler(usize, usize),
}

/// Outcome of a task.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Outcome {
    Success(Value),
    Failure,
    Cut,
    Skipped,
    Exited,
    PreconditionFailed,
    InvariantViolated,
}

impl Outcome {
    pub(crate) fn text(&self) -> String {
        match self {
            Outcome::Success(value) => format!("success {value}"),
            Outcome::Failure => "failure".into(),
            Outcome::Cut => "cut".into(),
            Outcome::Skipped => "skipped".into(),
            Outcome::Exited => "exited".into(),
            Outcome::PreconditionFailed => "precondition failed".into(),
            Outcome::InvariantViolated => "invariant violated".into(),
        }
    }

    pub(crate) fn is_failure(&self) -> bool {
        matches!(self, Outcome::Failure | Outcome::PreconditionFailed | Outcome::InvariantViolated)
    }

    /// Returns true if `(word ?step)` holds.
    pub(crate) fn is(&self, word: &str) -> bool {
        match word {
            "succeeded" => matches!(self, Outcome::Success(_)),
            "failed" => self.is_failure(),
            "precondition-failed" => *self == Outcome::PreconditionFailed,
            "invariant-violated" => *self == Outcome::InvariantViolated,
            word => self.text() == word,
        }
    }
}

/// Words for how a task ended.
pub(crate) const OUTCOMES: &[&str] =
    &["succeeded", "failed", "cut", "skipped", "exited", "precondition-failed", "invariant-violated"];

/// Method for a goal.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Way {
    Procedure(usize),
    Primitive(usize),
    Items(Vec<Value>),
    /// The step's activity, or its `on-failure`, is built in.
    BuiltIn,
}

/// Decision for an enabled task.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Choice {
    pub(crate) way: Way,
    /// Bindings by the index of the method.
    pub(crate) bound: Bindings,
    /// Resource, amount.
    pub(crate) needs: Vec<(String, f64)>,
    pub(crate) interrupt_cost: f64,
    pub(crate) expected: Option<Span>,
    /// The task fails if it would have to wait for its resources.
    pub(crate) refuses: bool,
}

/// A clock: its instant, and a number that orders clocks with the same instant.
pub(crate) type Alarm = (Time, u64);

/// Present work of a task that has begun.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Work {
    Procedure {
        procedure: usize,
        context: Bindings,
        /// The task that each step's tag names.
        current: Vec<Option<usize>>,
        children: BTreeSet<usize>,
        /// Steps that have ended.
        ended: BTreeSet<usize>,
    },
    Primitive {
        primitive: usize,
        context: Bindings,
        locals: BTreeMap<String, Value>,
        duration: Option<Span>,
        worked: Span,
        /// None while it is interrupted.
        since: Option<Time>,
        end: Option<Alarm>,
        update: Option<Alarm>,
        update_left: Span,
    },
    Items(BTreeSet<usize>),
    Handling(usize),
    BuiltIn,
}

/// Position of a clause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Level {
    Step,
    Procedure,
}

/// Clauses, in the order in which they take effect at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Clause {
    ExitWhen,
    SkipWhen,
    EndWhen,
    RestartWhen,
    SuspendWhen,
    SuspendUntil,
    ResumeWhen,
    Waitfor,
}

impl Clause {
    pub(crate) fn word(self) -> &'static str {
        match self {
            Clause::ExitWhen => "exit-when",
            Clause::SkipWhen => "skip-when",
            Clause::EndWhen => "end-when",
            Clause::RestartWhen => "restart-when",
            Clause::SuspendWhen => "suspend-when",
            Clause::SuspendUntil => "until",
            Clause::ResumeWhen => "resume-when",
            Clause::Waitfor => "waitfor",
        }
    }
}

/// Window of evidence: from the instant `start` on, this included, and only arrivals after the arrival `after`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    pub(crate) start: Time,
    pub(crate) after: Option<u64>,
}

/// A clause that is being watched.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Watch {
    /// Number in order of creation.
    pub(crate) number: u64,
    pub(crate) clause: Clause,
    pub(crate) level: Level,
    pub(crate) condition: Condition,
    pub(crate) window: Window,
    /// Number of state changes before its creation.
    pub(crate) made: usize,
    /// Instant of the task's creation, from which earlier facts are known to it.
    pub(crate) made_at: Time,
    /// True if ends and states of tasks count even if they were reached before.
    pub(crate) standing: bool,
    /// The clause must be checked at once, not only in the next round.
    pub(crate) at_once: bool,
}

/// A task.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Task {
    pub(crate) parent: Option<usize>,
    pub(crate) origin: Origin,
    pub(crate) state: State,
    pub(crate) created_at: Time,
    /// Instant of the task's first creation, unaffected by restarts.
    pub(crate) first_created: Time,
    pub(crate) started_at: Option<Time>,
    pub(crate) suspended: bool,
    /// Its own variables.
    pub(crate) bound: Bindings,
    /// The newest arrival that the task has answered.
    pub(crate) answered: Option<u64>,
    pub(crate) waits_for_step_before: bool,
    pub(crate) waits_for_result: bool,
    pub(crate) waits_for_condition: bool,
    pub(crate) waits_for_interval: Option<Alarm>,
    pub(crate) watches: Vec<Watch>,
    pub(crate) choice: Option<Choice>,
    pub(crate) work: Option<Work>,
    /// Amounts of resources that the task holds for its steps.
    pub(crate) held: Vec<(String, f64)>,
    pub(crate) outcome: Option<Outcome>,
    pub(crate) ended_before: Option<Time>,
    pub(crate) repeats_no_more: bool,
    pub(crate) known: BTreeSet<String>,
    /// Messages that arrived while the repeated step was busy and that no task has answered; `None` while none are kept.
    pub(crate) missed: Option<BTreeSet<u64>>,
    /// Its parent has taken note of its end.
    pub(crate) over: bool,
    /// Number of state changes before the tag of the step began to name the task.
    pub(crate) tagged: usize,
    /// No clause can refer to the task any longer.
    pub(crate) forgotten: bool,
}

impl Task {
    pub(crate) fn new(parent: Option<usize>, origin: Origin, now: Time) -> Task {
        Task {
            parent,
            origin,
            state: State::Pending,
            created_at: now,
            first_created: now,
            started_at: None,
            suspended: false,
            bound: Bindings::new(),
            answered: None,
            waits_for_step_before: false,
            waits_for_result: false,
            waits_for_condition: false,
            waits_for_interval: None,
            watches: Vec::new(),
            choice: None,
            work: None,
            held: Vec::new(),
            outcome: None,
            ended_before: None,
            repeats_no_more: false,
            known: BTreeSet::new(),
            missed: None,
            over: false,
            tagged: 0,
            forgotten: false,
        }
    }

    /// Returns true if nothing prevents its enablement.
    pub(crate) fn is_free(&self) -> bool {
        self.state == State::Pending
            && !self.waits_for_step_before
            && !self.waits_for_result
            && !self.waits_for_condition
            && self.waits_for_interval.is_none()
    }

    /// Returns all amounts that the task must hold to be ongoing.
    pub(crate) fn needs(&self) -> Vec<(String, f64)> {
        let mut needs = self.choice.as_ref().map(|choice| choice.needs.clone()).unwrap_or_default();
        self.held.iter().for_each(|(name, amount)| add(&mut needs, name, *amount));
        needs
    }
}

/// Adds a need; two needs of one resource are combined into their sum.
pub(crate) fn add(needs: &mut Vec<(String, f64)>, name: &str, amount: f64) {
    match needs.iter_mut().find(|(other, _)| other == name) {
        Some((_, sum)) => *sum += amount,
        None => needs.push((name.to_string(), amount)),
    }
}
