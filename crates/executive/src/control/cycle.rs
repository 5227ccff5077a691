//! Work of an instant (TC)
//! What: holds the state of one instant while it is processed: the agent, the instant, the pending work, the decisions so far.
//! Runs: with every phase of a step.
//! Reads: Agent, Library.
//! Writes: lists of work, Decision. The lists are empty before and after every instant, so they do not belong to the agent.
//! Bound: O(1) per entry.
//! PDL: none.
//! Paper: section III, the stages of a step.

use crate::expression::declared_unit;
use crate::expression::view::View;
use crate::monitoring::stimulus::Stimulus;
use crate::state::agent::Agent;
use crate::state::clause::{Clause, Level, MonitorId};
use crate::state::index::LibraryIndex;
use crate::state::monitor_set::MonitorIds;
use crate::state::monitors::monitor::Satisfaction;
use crate::state::probing::ProbingId;
use crate::state::resource_id::ResourceId;
use crate::state::step_clauses::StepClauses;
use crate::state::task::{Origin, ProcedureRef, Task};
use apex_model::because::{Because, Cause};
use apex_model::effect::{Decision, DecisionKind, Effect};
use apex_model::event::StateVariable;
use apex_model::evidence_list::EvidenceList;
use apex_model::library::Library;
use apex_model::procedure::{Procedure, Step};
use apex_model::source::Place;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;
use apex_model::value::Value;
use smallvec::SmallVec;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

/// Working state of one call of `step`.
pub(crate) struct Cycle<'a> {
    /// The agent.
    pub(crate) agent: &'a mut Agent,
    /// Its library, held next to it so that templates can be read while the agent changes.
    pub(crate) library: &'a Library,
    /// Index of the library.
    pub(crate) index: &'a LibraryIndex,
    /// The instant.
    pub(crate) now: Time,
    /// The number of the first task that this step makes.
    pub(crate) first_task: u64,
    /// Decisions, in order.
    pub(crate) effects: Vec<Effect>,
    /// Pending work.
    pub(crate) work: Work,
}

/// Capacity reserved for the effects of a small step, so that the list does not grow in pieces; small enough for an allocator's free
/// lists.
const EFFECTS_EXPECTED: usize = 1_024 / size_of::<Effect>();

/// A list of tasks to check; usually short.
pub(crate) type TaskList = SmallVec<[TaskId; 4]>;

/// Pending work at this instant, by phase. Most instants affect few tasks, so the lists are short.
#[derive(Default)]
pub(crate) struct Work {
    /// Record: messages and samples of the agent to itself.
    pub(crate) said: Vec<SelfMessage>,
    /// Notice: recorded samples and messages.
    pub(crate) stimuli: SmallVec<[Stimulus; 1]>,
    /// Record: number of samples that deriving once more from the stimuli would record, if it changed nothing else.
    pub(crate) repetition: Option<u64>,
    /// Notice: monitors to be judged.
    pub(crate) touched: MonitorIds,
    /// Enable: clauses that became true.
    pub(crate) firings: SmallVec<[Firing; 1]>,
    /// Enable: evidence for tasks that are about to be enabled.
    pub(crate) evidence: SmallVec<[(TaskId, EvidenceList); 1]>,
    /// Enable: the last cause that freed a pending task, other than its waitfor and the end of the preceding step.
    pub(crate) freed: BTreeMap<TaskId, Cause>,
    /// Enable: pending tasks that may be free now.
    pub(crate) ready: TaskList,
    /// Choose: tasks that were enabled.
    pub(crate) enabled: TaskList,
    /// Contend: enabled and interrupted tasks that claim to continue.
    pub(crate) claims: TaskList,
    /// Contend: causes for which suspended tasks continue, unless they must wait for resources.
    pub(crate) resumed: BTreeMap<TaskId, Because>,
    /// At rest: claims that were refused, which may have closed a circle of waits.
    pub(crate) refused: TaskList,
    /// Contend: resources whose users may change.
    pub(crate) dirty: BTreeSet<ResourceId>,
    /// Contend: true if an input of priorities changed; every contested resource is then arbitrated.
    pub(crate) priorities_changed: bool,
    /// Contend: tasks stopped or continue, so that tasks below them may have other priorities; every contested resource is arbitrated, and
    /// every turn is computed again.
    pub(crate) inheritance_changed: bool,
    /// Act: tasks that became ongoing.
    pub(crate) starting: TaskList,
    /// Act, a round later: resumed tasks that may start over instead.
    pub(crate) resuming: BTreeSet<TaskId>,
    /// At rest: probings that begin or end a probe when no other work remains at this instant.
    pub(crate) probings: SmallVec<[ProbingId; 1]>,
    /// Notice: true if states of tasks changed that invariants read.
    pub(crate) states_changed: bool,
    /// Enable: tasks whose invariants may no longer hold.
    pub(crate) doubtful: BTreeSet<TaskId>,
    /// Tasks that ended and whose parents have not reacted.
    pub(crate) ended: VecDeque<TaskId>,
    /// Tasks that exceeded the memory budget, with the place of the binding.
    pub(crate) over_budget: SmallVec<[(TaskId, Place); 1]>,
    /// Changes to the number of living tasks in this round.
    pub(crate) balance: Balance,
}

/// Ends and beginnings of tasks in a round.
#[derive(Default)]
pub(crate) struct Balance {
    /// True if tasks ended.
    pub(crate) ends: bool,
    /// True if a task was repeated or restarted.
    pub(crate) again: bool,
    /// The number of the next task when the round began.
    next_task: u64,
}

/// A message or sample that the agent sends to itself.
pub(crate) enum SelfMessage {
    /// A message.
    Occurrence(Value),
    /// A sample.
    Measurement(StateVariable, Value),
}

/// A clause that became true.
pub(crate) struct Firing {
    /// The task.
    pub(crate) task: TaskId,
    /// Clause.
    pub(crate) clause: Clause,
    /// Level of the clause: the task's step, or the procedure that the task executes.
    pub(crate) level: Level,
    /// The monitor.
    pub(crate) monitor: MonitorId,
    /// Result that satisfied it.
    pub(crate) satisfaction: Satisfaction,
    /// The newest arrival that it answers, if it answers messages.
    pub(crate) answered: Option<u64>,
    /// Position of the condition in the PDL text.
    pub(crate) place: Place,
}

impl Work {
    /// Returns true if tasks ended in the finished round and none was created, repeated or restarted: the number of such rounds is
    /// limited by the number of tasks. Begins the next round.
    pub(crate) fn made_progress(&mut self, next_task: u64) -> bool {
        let Balance { ends, again, next_task: before } = std::mem::take(&mut self.balance);
        self.balance.next_task = next_task;
        ends && !again && before == next_task
    }

    /// Clears the remaining work, so that the lists are empty at the next instant.
    pub(crate) fn end_instant(&mut self) {
        if self.is_done() {
            self.evidence.clear();
            // Clearing an empty tree has a cost, and this function runs at every instant.
            if !self.freed.is_empty() || !self.resumed.is_empty() || !self.resuming.is_empty() {
                self.freed.clear();
                self.resumed.clear();
                self.resuming.clear();
            }
        } else {
            *self = Work::default();
        }
    }

    /// Returns true if no work remains at this instant.
    pub(crate) fn is_done(&self) -> bool {
        self.stimuli.is_empty() && self.has_only_stimuli()
    }

    /// Returns true if the only remaining work is to begin and end probes.
    pub(crate) fn has_only_probings(&self) -> bool {
        self.stimuli.is_empty() && self.has_no_more_than_stimuli_and_probings()
    }

    /// Returns true if the only remaining work is to notice what was recorded.
    pub(crate) fn has_only_stimuli(&self) -> bool {
        self.probings.is_empty() && self.has_no_more_than_stimuli_and_probings()
    }

    fn has_no_more_than_stimuli_and_probings(&self) -> bool {
        self.said.is_empty()
            && self.touched.is_empty()
            && self.firings.is_empty()
            && self.ready.is_empty()
            && self.enabled.is_empty()
            && self.claims.is_empty()
            && self.dirty.is_empty()
            && !self.states_changed
            && !self.priorities_changed
            && !self.inheritance_changed
            && self.starting.is_empty()
            && self.resuming.is_empty()
            && self.ended.is_empty()
    }
}

/// Takes the tasks out of `list` in order of creation, each once: the order in which steps are written.
pub(crate) fn in_order(list: &mut TaskList) -> TaskList {
    if list.is_empty() {
        return TaskList::new();
    }
    let mut taken = std::mem::take(list);
    taken.sort_unstable();
    taken.dedup();
    taken
}

impl<'a> Cycle<'a> {
    /// Publishes a sample of the agent itself that no form published.
    pub(crate) fn publish_own(&mut self, id: TaskId, (variable, value): (StateVariable, Value), because: Because) {
        let effect = Effect::Publish { task: id, variable: variable.clone(), value: value.clone(), because };
        self.effects.push(effect);
        self.say_sample(variable, value);
    }

    /// Records a sample that the agent publishes: expressions see it from now on, conditions from the next round.
    pub(crate) fn say_sample(&mut self, variable: StateVariable, value: Value) {
        if let Ok(held) = declared_unit::in_declared_unit(self.library, &variable, value.clone()) {
            self.agent.published.push((variable.clone(), held));
        }
        self.work.said.push(SelfMessage::Measurement(variable, value));
    }

    /// Writes a decision.
    pub(crate) fn decide(&mut self, task: Option<TaskId>, kind: DecisionKind, because: Because) {
        if self.effects.capacity() == 0 {
            self.effects.reserve(EFFECTS_EXPECTED);
        }
        self.effects.push(Effect::Decided(Decision { task, kind, because }));
    }

    /// Reports an error by its message.
    pub(crate) fn trouble(&mut self, task: Option<TaskId>, message: String, place: Option<Place>) {
        let because = Because::new(Cause::ExpressionFailed { message: message.clone() }, place);
        self.decide(task, DecisionKind::Trouble { message }, because);
    }

    /// Reports an error with its cause, if no expression caused it.
    pub(crate) fn trouble_of(&mut self, task: Option<TaskId>, cause: Cause, place: Option<Place>) {
        let message = cause.text();
        self.decide(task, DecisionKind::Trouble { message }, Because::new(cause, place));
    }

    /// Returns the view of `task` at `level`.
    pub(crate) fn view(&self, task: TaskId, level: Level) -> View<'_> {
        View { agent: self.agent, task, level, now: self.now }
    }

    /// Returns the task, while it exists.
    pub(crate) fn task(&self, id: TaskId) -> Option<&Task> {
        self.agent.task(id)
    }

    /// Returns the task's state; terminated when it is gone.
    pub(crate) fn state(&self, id: TaskId) -> TaskState {
        self.agent.task(id).map_or(TaskState::Terminated, |task| task.state)
    }

    /// Returns true if the task's step has one of these kinds of clauses.
    #[inline]
    pub(crate) fn has(&self, id: TaskId, kinds: StepClauses) -> bool {
        self.agent.task(id).is_some_and(|task| task.clauses.has(kinds))
    }

    /// Returns the step that `id` was made from, in a handle that keeps its procedure alive.
    pub(crate) fn step_of(&self, id: TaskId) -> Option<StepHandle<'a>> {
        let step = self.task(id)?.step()?;
        let index = step.step as usize;
        match step.procedure {
            ProcedureRef::Stored(number) => {
                let procedure: &'a Procedure = self.library.procedures.get(number as usize)?;
                procedure.steps.get(index).map(StepHandle::Stored)
            }
            ProcedureRef::Generated(_) => {
                Some(StepHandle::Generated(self.agent.procedure(step.procedure)?.clone(), index))
            }
        }
    }

    /// Returns true if the task's step repeats, so that the end of an instance may not be the end of the step.
    pub(crate) fn may_repeat(&self, id: TaskId) -> bool {
        let Some(task) = self.task(id).filter(|task| task.clauses.has(StepClauses::REPETITION)) else { return false };
        let repeats = |handle: &StepHandle<'_>| handle.get().is_some_and(|step| step.repeating.is_some());
        matches!(task.origin, Origin::Step(_)) && self.step_of(id).as_ref().is_some_and(repeats)
    }

    /// Returns the position in the PDL text from which `id` was made.
    pub(crate) fn place_of(&self, id: TaskId) -> Option<Place> {
        let task = self.task(id)?;
        if let Origin::Probe(probing) = task.origin {
            return self.agent.probings.get(&probing).map(|probing| probing.place);
        }
        let step = task.step()?;
        self.agent.procedure(step.procedure)?.steps.get(step.step as usize).map(|step| step.place)
    }
}

/// A step that can be read while the agent changes.
pub(crate) enum StepHandle<'a> {
    /// Of the library.
    Stored(&'a Step),
    /// Of a generated procedure, which the handle keeps alive.
    Generated(Arc<Procedure>, usize),
}

impl StepHandle<'_> {
    /// Returns the step.
    pub(crate) fn get(&self) -> Option<&Step> {
        match self {
            StepHandle::Stored(step) => Some(step),
            StepHandle::Generated(procedure, index) => procedure.steps.get(*index),
        }
    }
}
