//! Tasks: commitments to act under conditions to realise a policy (paper, section III).

use crate::state::bindings::Bindings;
use crate::state::clause::MonitorId;
use crate::state::controller::{Controller, Selection};
use crate::state::probing::ProbingId;
use crate::state::resource::Need;
use crate::state::resource_id::ResourceId;
use crate::state::step_clauses::StepClauses;
use crate::state::wake::WakeKey;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;
use std::collections::BTreeSet;

/// Reference to a procedure: to a stored one by its index in the library, to a generated one by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum ProcedureRef {
    /// Index into [`apex_model::library::Library::procedures`].
    Stored(u32),
    /// Number in [`crate::state::agent::Agent::generated`].
    Generated(u64),
}

/// Reference to a step of a procedure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct StepRef {
    /// The procedure.
    pub procedure: ProcedureRef,
    /// Index of the step.
    pub step: u32,
}

/// The template that a task was made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Origin {
    /// The agent's initial task.
    Initial,
    /// A step of its parent's procedure.
    Step(StepRef),
    /// One item of the `forall` of its parent's step.
    Item(StepRef),
    /// The `on-failure` activity of its parent's step.
    OnFailure(StepRef),
    /// Work of its parent until a plan arrives: the solver declaration's index.
    Meanwhile(u32),
    /// A probe for a condition with `:probing`.
    Probe(ProbingId),
}

/// A task. Small, because a hundred thousand may wait; rarely used fields are boxed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Its number.
    pub id: TaskId,
    /// Task whose controller made it; `None` for the root.
    pub parent: Option<TaskId>,
    /// Origin.
    pub origin: Origin,
    /// Its state.
    pub state: TaskState,
    /// Nesting: the root has 0.
    pub depth: u32,
    /// Unsatisfied preconditions, such as its `waitfor`, its predecessor in a sequence or its least interval.
    pub held_back: HeldBack,
    /// True if a clause or an activity has suspended it: it claims no resources until it is resumed. Only the agent changes this, because
    /// it counts the suspended tasks.
    pub suspended: bool,
    /// Creation of this instance, or the instant at which the task became pending again.
    pub created_at: Time,
    /// Instant of the last change of its state.
    pub since: Time,
    /// Instant at which it first became ongoing.
    pub started_at: Option<Time>,
    /// Messages and samples up to this arrival number are answered: they cannot satisfy this instance.
    pub after_sequence: Option<u64>,
    /// Its own variables: `waitfor` bindings, `select`, the item of a `forall`.
    pub bindings: Bindings,
    /// Its monitors, in order of making.
    pub monitors: SmallVec<[MonitorId; 2]>,
    /// Method for its goal; `None` while pending.
    pub selection: Option<Box<Selection>>,
    /// Controller; `None` before the task is ongoing.
    pub controller: Option<Box<Controller>>,
    /// Outcome; `None` while it lives.
    pub outcome: Option<Outcome>,
    /// Clauses of its step; derived from the step, not part of a snapshot.
    #[serde(skip)]
    pub clauses: StepClauses,
    /// Data that few tasks need.
    pub extras: Option<Box<Extras>>,
}

/// Preconditions of a task, each true while it holds the task back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HeldBack {
    /// True if a preceding step of the sequence has not ended.
    pub by_predecessor: bool,
    /// True if its waitfor is not satisfied.
    pub by_condition: bool,
    /// True if `:with-min-interval` has not passed.
    pub by_interval: bool,
    /// True if it uses the result of another step that does not exist yet.
    pub by_result: bool,
    /// True if its waitfor uses a result that does not exist yet: the waitfor then has no monitor.
    pub by_unknown: bool,
}

impl HeldBack {
    /// Returns what still holds back a task that begins again: only its turn in a sequence.
    pub fn of_turn(self) -> HeldBack {
        HeldBack { by_predecessor: self.by_predecessor, ..HeldBack::default() }
    }

    /// Returns true when nothing holds the task back.
    pub fn is_free(self) -> bool {
        !(self.by_predecessor || self.by_condition || self.by_interval || self.by_result || self.by_unknown)
    }
}

/// Rarely used parts of a task.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extras {
    /// The accumulated time ongoing before the present stretch.
    pub worked: Duration,
    /// Resources held for it by `(hold-resource ..)`.
    pub held: Vec<Need>,
    /// Numbers of its open log policies.
    pub logs: Vec<u64>,
    /// End of the instance before, for recovery and least intervals.
    pub ended_before: Option<Time>,
    /// First creation, if it has started over since: its deadline stays.
    pub first_created: Option<Time>,
    /// Number of instances that started at `instant`, to stop loops that take no time.
    pub instances: u32,
    /// The instant of `instances`.
    pub instant: Time,
    /// Instant from which `instants` counts.
    #[serde(default)]
    pub counted_since: Time,
    /// Number of instants within a second at which instances began although nothing had arrived from outside.
    #[serde(default)]
    pub instants: u32,
    /// Number of inputs from outside that had arrived when an instance last began.
    #[serde(default)]
    pub outside: u64,
    /// Combinations of `:for-new` variables already answered.
    pub answered: BTreeSet<Vec<Value>>,
    /// True if the step does not repeat any longer, because a clause or an activity has ended the step.
    pub repeats_no_more: bool,
    /// The least interval's wake.
    pub wake: Option<WakeKey>,
    /// The resource that it was refused at the last arbitration of all claimants, and the winner.
    pub refused: Option<(ResourceId, TaskId)>,
    /// True if its waiting has been reported: once for each claim, not at every arbitration.
    pub refusal_told: bool,
    /// The wake at which its rising priority may win.
    pub crossing: Option<WakeKey>,
}

impl Task {
    /// Returns the rarely used parts, made when missing.
    pub fn extras_mut(&mut self) -> &mut Extras {
        self.extras.get_or_insert_default()
    }

    /// Returns the step from which the task was made; `None` if it was made otherwise.
    pub fn step(&self) -> Option<StepRef> {
        match self.origin {
            Origin::Step(step) | Origin::Item(step) | Origin::OnFailure(step) => Some(step),
            Origin::Initial | Origin::Meanwhile(_) | Origin::Probe(_) => None,
        }
    }

    /// Returns true if there are tasks below it.
    pub fn has_children(&self) -> bool {
        self.controller.as_ref().is_some_and(|controller| controller.has_children())
    }

    /// Returns true when it has ended.
    pub fn is_terminated(&self) -> bool {
        self.state == TaskState::Terminated
    }
}
