//! One instant being worked through: the agent, the instant, what is to be done next and what has been decided.
//!
//! The lists of work are empty before and after every instant, so they are no part of the agent. Services are
//! functions over this value; none keeps state of its own.

use crate::monitoring::Stimulus;
use crate::view::View;
use apex_model::agent::Agent;
use apex_model::because::{Because, Cause};
use apex_model::clause::{Clause, Level, MonitorId};
use apex_model::effect::{Decision, DecisionKind, Effect};
use apex_model::event::StateVariable;
use apex_model::evidence_list::EvidenceList;
use apex_model::library::Library;
use apex_model::monitor::Satisfaction;
use apex_model::procedure::{Procedure, Step};
use apex_model::resource::ResourceId;
use apex_model::source::Place;
use apex_model::task::{StepRef, Task, TaskId, TaskState};
use apex_model::time::Time;
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

/// The working value of one call of `step`.
pub(crate) struct Cycle<'a> {
    /// The agent.
    pub(crate) agent: &'a mut Agent,
    /// Its library, held beside it so that templates can be read while the agent changes.
    pub(crate) library: Arc<Library>,
    /// The instant.
    pub(crate) now: Time,
    /// What was decided, in order.
    pub(crate) effects: Vec<Effect>,
    /// What is to be done.
    pub(crate) work: Work,
}

/// What is to be done at this instant, by phase.
#[derive(Default)]
pub(crate) struct Work {
    /// Record: what the agent said to itself.
    pub(crate) said: Vec<Said>,
    /// Notice: what was recorded.
    pub(crate) stimuli: Vec<Stimulus>,
    /// Notice: monitors to be judged.
    pub(crate) touched: Vec<MonitorId>,
    /// Enable: clauses that came true.
    pub(crate) firings: Vec<Firing>,
    /// Enable: evidence for tasks about to be enabled.
    pub(crate) evidence: BTreeMap<TaskId, EvidenceList>,
    /// Enable: what freed a pending task last, where it was neither its waitfor nor the end of the step before it.
    pub(crate) freed: BTreeMap<TaskId, Cause>,
    /// Enable: pending tasks that may be free now.
    pub(crate) ready: Vec<TaskId>,
    /// Choose: tasks that were enabled.
    pub(crate) enabled: Vec<TaskId>,
    /// Contend: enabled and interrupted tasks that want to go on.
    pub(crate) claims: Vec<TaskId>,
    /// Contend: why tasks that were suspended go on, unless they have to wait for resources.
    pub(crate) resumed: BTreeMap<TaskId, Because>,
    /// Contend: resources whose users may change.
    pub(crate) dirty: BTreeSet<ResourceId>,
    /// Contend: an input of priorities changed; every contested resource is looked at.
    pub(crate) priorities_changed: bool,
    /// Contend: how often tasks lost resources at this instant.
    pub(crate) losses: BTreeMap<TaskId, u32>,
    /// Act: tasks that became ongoing.
    pub(crate) starting: Vec<TaskId>,
    /// Act, a round later: resumed tasks that may rather start over.
    pub(crate) resuming: BTreeSet<TaskId>,
    /// Tasks that ended and whose parents have not reacted.
    pub(crate) ended: VecDeque<TaskId>,
}

/// Something the agent said to itself.
pub(crate) enum Said {
    /// A message.
    Occurrence(Value),
    /// A sample.
    Measurement(StateVariable, Value),
}

/// A clause that came true.
pub(crate) struct Firing {
    /// The task.
    pub(crate) task: TaskId,
    /// Which clause.
    pub(crate) clause: Clause,
    /// Where it stands.
    pub(crate) level: Level,
    /// The monitor.
    pub(crate) monitor: MonitorId,
    /// How it came true.
    pub(crate) satisfaction: Satisfaction,
    /// The newest arrival that it answers, if it answers messages.
    pub(crate) answered: Option<u64>,
    /// Where the condition stands.
    pub(crate) place: Place,
}

impl Work {
    /// True when nothing is left to do at this instant.
    pub(crate) fn is_done(&self) -> bool {
        self.said.is_empty()
            && self.stimuli.is_empty()
            && self.touched.is_empty()
            && self.firings.is_empty()
            && self.ready.is_empty()
            && self.enabled.is_empty()
            && self.claims.is_empty()
            && self.dirty.is_empty()
            && !self.priorities_changed
            && self.starting.is_empty()
            && self.resuming.is_empty()
            && self.ended.is_empty()
    }
}

/// A list of tasks in order of creation, each once: the order in which steps are written.
pub(crate) fn in_order(list: &mut Vec<TaskId>) -> Vec<TaskId> {
    let mut taken = std::mem::take(list);
    taken.sort_unstable();
    taken.dedup();
    taken
}

impl Cycle<'_> {
    /// Writes a decision.
    pub(crate) fn decide(&mut self, task: Option<TaskId>, kind: DecisionKind, because: Because) {
        self.effects.push(Effect::Decided(Decision { task, kind, because }));
    }

    /// Writes a trouble: named, never silent.
    pub(crate) fn trouble(&mut self, task: Option<TaskId>, message: String, place: Option<Place>) {
        let because = Because::new(Cause::ExpressionFailed { message: message.clone() }, place);
        self.decide(task, DecisionKind::Trouble { message }, because);
    }

    /// Writes a trouble that no expression made.
    pub(crate) fn trouble_of(&mut self, task: Option<TaskId>, cause: Cause, place: Option<Place>) {
        let message = cause.text();
        self.decide(task, DecisionKind::Trouble { message }, Because::new(cause, place));
    }

    /// The view of `task` at `level`.
    pub(crate) fn view(&self, task: TaskId, level: Level) -> View<'_> {
        View { agent: self.agent, task, level, now: self.now }
    }

    /// The task, while it exists.
    pub(crate) fn task(&self, id: TaskId) -> Option<&Task> {
        self.agent.task(id)
    }

    /// The task's state; terminated when it is gone.
    pub(crate) fn state(&self, id: TaskId) -> TaskState {
        self.agent.task(id).map_or(TaskState::Terminated, |task| task.state)
    }

    /// The procedure with the step, and the step's number in it.
    pub(crate) fn template(&self, step: StepRef) -> Option<(Arc<Procedure>, usize)> {
        Some((self.agent.procedure(step.procedure)?.clone(), step.step as usize))
    }

    /// The step that `id` was made from, with the procedure that holds it.
    pub(crate) fn step_of(&self, id: TaskId) -> Option<StepHandle> {
        let (procedure, index) = self.template(self.task(id)?.step()?)?;
        Some(StepHandle { procedure, index })
    }

    /// Where `id` was written.
    pub(crate) fn place_of(&self, id: TaskId) -> Option<Place> {
        let step = self.task(id)?.step()?;
        self.agent.procedure(step.procedure)?.steps.get(step.step as usize).map(|step| step.place)
    }
}

/// Keeps a procedure alive while one of its steps is read.
pub(crate) struct StepHandle {
    procedure: Arc<Procedure>,
    index: usize,
}

impl StepHandle {
    /// The step.
    pub(crate) fn get(&self) -> Option<&Step> {
        self.procedure.steps.get(self.index)
    }
}
