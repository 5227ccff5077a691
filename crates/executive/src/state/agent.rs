//! The agent: all state that can influence behaviour, in one value that can be cloned, compared and stored.

use crate::state::clause::{ClauseMonitor, MonitorId};
use crate::state::controller::OpenCommand;
use crate::state::guards::Guards;
use crate::state::histories::history::Histories;
use crate::state::index::{Heads, IndexCandidate, LibraryIndex, ProcedureIndex};
use crate::state::interests::Interests;
use crate::state::listening::Listening;
use crate::state::memory_count::MemoryCount;
use crate::state::probing::{Probing, ProbingId};
use crate::state::resource::ResourceTable;
use crate::state::step_clauses::StepClauses;
use crate::state::table::Table;
use crate::state::task::{Origin, ProcedureRef, Task};
use crate::state::wake::{Wake, WakeQueue};
use apex_model::agent_limits::Limits;
use apex_model::effect::{CommandId, QuestionId, SolveRequestId};
use apex_model::event::StateVariable;
use apex_model::host::HostFunctions;
use apex_model::library::Library;
use apex_model::procedure::Procedure;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::time::Time;
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// An agent. A snapshot is its serialised form; library and host functions are put back by [`Agent::attach`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Agent {
    /// The checked library; not part of a snapshot.
    #[serde(skip)]
    pub library: Arc<Library>,
    /// Registered host functions; not part of a snapshot.
    #[serde(skip)]
    pub host: HostFunctions,
    /// Derived from the library; not part of a snapshot.
    #[serde(skip)]
    pub index: Arc<LibraryIndex>,
    /// Generated procedures by the first word of their goal; derived from `generated`.
    #[serde(skip)]
    pub generated_heads: Heads,
    /// `+self+`.
    pub name: Symbol,
    /// The goal of the root task.
    pub initial_task: Value,
    /// Bundles that the agent uses; empty means all.
    pub bundles: Vec<Symbol>,
    /// Its workload, 1 to 9, in the formula of urgency and importance.
    pub workload: f64,
    /// Its limits.
    #[serde(default)]
    pub limits: Limits,
    /// The instant of the last step.
    pub now: Time,
    /// True when the first step was taken.
    pub started: bool,
    /// Reason for the end of the application, if it has ended.
    pub finished: Option<String>,
    /// Tasks that live or that a clause may still refer to.
    pub tasks: Table<Task>,
    /// Monitors of living tasks.
    pub watches: Table<ClauseMonitor>,
    /// Monitors by the stimuli that they must receive.
    pub interests: Interests,
    /// Histories of measurements and messages.
    pub histories: Histories,
    /// Holders of resources.
    pub resources: ResourceTable,
    /// Procedures made from plans.
    pub generated: Table<Generated>,
    /// Commands without an answer.
    pub commands: BTreeMap<CommandId, OpenCommand>,
    /// Solver requests without an answer, with the tasks that wait.
    pub requests: BTreeMap<SolveRequestId, TaskId>,
    /// Questions without an answer, with the tasks that wait.
    pub questions: BTreeMap<QuestionId, TaskId>,
    /// Probings of conditions with `:probing`, while tasks wait for these conditions.
    #[serde(default, with = "crate::state::pairs")]
    pub probings: BTreeMap<ProbingId, Probing>,
    /// Scheduled wakes.
    pub wakes: WakeQueue,
    /// Claimants whose priority can change without a change of a task, because it rises or reads histories.
    pub unsteady: BTreeSet<TaskId>,
    /// Circles of tasks that wait for each other's resources, as reported.
    #[serde(default)]
    pub circles: Vec<BTreeSet<TaskId>>,
    /// Messages that wait for repeating steps.
    #[serde(default)]
    pub listening: Listening,
    /// Tasks that have begun and have an `invariant`, their step's or their procedure's.
    #[serde(default)]
    pub guards: Guards,
    /// The newest instant at which messages or samples came from outside, and how many did.
    #[serde(default)]
    pub burst: (Time, u64),
    /// Values published in this round, recorded in the next one; empty between instants.
    #[serde(skip)]
    pub published: Vec<(StateVariable, Value)>,
    /// Counters: the next number of each kind.
    pub next: Counters,
    /// Bytes of large values and samples.
    #[serde(default)]
    pub memory: MemoryCount,
    /// Number of suspended tasks; derived from the tasks, not part of a snapshot.
    #[serde(skip)]
    pub suspended: u64,
}

/// The next number of each kind; none is ever used twice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// Tasks.
    pub task: u64,
    /// Monitors.
    pub monitor: u64,
    /// Commands.
    pub command: u64,
    /// Solver requests.
    pub request: u64,
    /// Questions.
    pub question: u64,
    /// Generated procedures.
    pub generated: u64,
    /// Number of samples and messages that have arrived, the agent's own included.
    pub arrival: u64,
    /// Number of messages and samples that have arrived from outside.
    #[serde(default)]
    pub outside: u64,
}

/// A procedure made from a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Generated {
    /// The procedure; its index is the goal for which it was planned.
    pub procedure: Arc<Procedure>,
    /// Derived from the procedure; not part of a snapshot.
    #[serde(skip)]
    pub index: Arc<ProcedureIndex>,
    /// The plan as PDL text.
    pub source: apex_model::source::SourceFile,
    /// True if it is begun again when it ends.
    pub repeat: bool,
    /// True while it serves new tasks; a newer plan for the same goal ends that.
    pub current: bool,
    /// Number of controllers that run it.
    pub users: u32,
}

impl Default for Agent {
    fn default() -> Agent {
        Agent {
            library: Arc::default(),
            host: HostFunctions::default(),
            index: Arc::default(),
            generated_heads: Heads::default(),
            name: Symbol::new("agent"),
            initial_task: Value::list([Value::symbol("do-domain")]),
            bundles: Vec::new(),
            workload: apex_model::library::DEFAULT_WORKLOAD,
            limits: Limits::default(),
            now: Time::BEGINNING,
            started: false,
            finished: None,
            tasks: Table::default(),
            watches: Table::default(),
            interests: Interests::default(),
            histories: Histories::default(),
            resources: ResourceTable::default(),
            generated: Table::default(),
            commands: BTreeMap::new(),
            requests: BTreeMap::new(),
            questions: BTreeMap::new(),
            probings: BTreeMap::new(),
            wakes: WakeQueue::default(),
            unsteady: BTreeSet::new(),
            circles: Vec::new(),
            listening: Listening::default(),
            guards: Guards::default(),
            burst: (Time::BEGINNING, 0),
            next: Counters::default(),
            published: Vec::new(),
            memory: MemoryCount::default(),
            suspended: 0,
        }
    }
}

impl Agent {
    /// Puts library and host functions back into an agent read from a snapshot.
    pub fn attach(&mut self, library: Arc<Library>, host: HostFunctions) {
        self.index = Arc::new(LibraryIndex::new(&library, &self.bundles));
        self.library = library;
        self.host = host;
        let numbers: Vec<u64> = self.generated.iter().map(|(number, _)| number).collect();
        let mut heads = Heads::default();
        for number in numbers {
            if let Some(generated) = self.generated.get_mut(number) {
                generated.index = Arc::new(ProcedureIndex::new(&generated.procedure));
                if generated.current {
                    heads.insert(&generated.procedure.index, IndexCandidate::Generated(number));
                }
            }
        }
        self.generated_heads = heads;
        self.derive_clauses();
        self.suspended = self.tasks.iter().filter(|(_, task)| task.suspended).count() as u64;
    }

    fn derive_clauses(&mut self) {
        let origins: Vec<(u64, Origin)> = self.tasks.iter().map(|(number, task)| (number, task.origin)).collect();
        for (number, origin) in origins {
            let clauses = self.clauses_of(origin);
            if let Some(task) = self.tasks.get_mut(number) {
                task.clauses = clauses;
            }
        }
    }

    /// Returns the clauses of the step from which a task is made; empty if there is no step.
    pub fn clauses_of(&self, origin: Origin) -> StepClauses {
        let (Origin::Step(step) | Origin::Item(step) | Origin::OnFailure(step)) = origin else {
            return StepClauses::NONE;
        };
        let index = self.procedure_index(step.procedure).and_then(|index| index.steps.get(step.step as usize));
        index.map_or(StepClauses::UNKNOWN, |index| index.clauses)
    }

    /// Returns the instant of the next step if nothing happens before, with its reason.
    pub fn next_wake(&self) -> Option<(Time, String)> {
        let at = self.next_wake_at()?;
        let wake = self.wakes.first().filter(|_| self.started);
        Some((at, wake.map_or_else(|| "the agent has not begun".into(), |(_, wake)| self.describe_wake(wake))))
    }

    /// Returns the instant of the next step if nothing happens before.
    pub fn next_wake_at(&self) -> Option<Time> {
        match (&self.finished, self.started) {
            (Some(_), _) => None,
            (None, false) => Some(Time::ZERO),
            (None, true) => self.wakes.first().map(|(key, _)| key.at),
        }
    }

    /// Returns the growth of limits on one instant at `now`: each message from outside may cause as much work as one alone. Messages among
    /// tasks and agents do not count.
    pub(crate) fn outside_messages_at(&self, now: Time) -> u64 {
        if self.burst.0 == now { self.burst.1.max(1) } else { 1 }
    }

    /// Returns true after `EndApplication`: the agent takes no further steps.
    pub fn is_finished(&self) -> bool {
        self.finished.is_some()
    }

    /// Returns the task with this number, while a clause may still refer to it.
    #[inline]
    pub fn task(&self, id: TaskId) -> Option<&Task> {
        self.tasks.get(id.0)
    }

    /// Returns the task with this number, mutably.
    #[inline]
    pub fn task_mut(&mut self, id: TaskId) -> Option<&mut Task> {
        self.tasks.get_mut(id.0)
    }

    /// Suspends the task, or ends its suspension. Returns false if nothing changes or the task does not exist.
    pub fn set_suspended(&mut self, id: TaskId, suspended: bool) -> bool {
        let Some(task) = self.tasks.get_mut(id.0).filter(|task| task.suspended != suspended) else { return false };
        task.suspended = suspended;
        self.suspended = if suspended { self.suspended + 1 } else { self.suspended.saturating_sub(1) };
        true
    }

    /// Returns the procedure that `reference` names.
    #[inline]
    pub fn procedure(&self, reference: ProcedureRef) -> Option<&Arc<Procedure>> {
        match reference {
            ProcedureRef::Stored(index) => self.library.procedures.get(index as usize),
            ProcedureRef::Generated(number) => self.generated.get(number).map(|generated| &generated.procedure),
        }
    }

    /// Returns the index of the procedure that `reference` names.
    #[inline]
    pub fn procedure_index(&self, reference: ProcedureRef) -> Option<&Arc<ProcedureIndex>> {
        match reference {
            ProcedureRef::Stored(index) => self.index.procedures.get(index as usize),
            ProcedureRef::Generated(number) => self.generated.get(number).map(|generated| &generated.index),
        }
    }

    /// Returns a place as text, `file.pdl:14:3`, also for places inside of plans: their files are numbered after those of the library.
    pub fn describe_place(&self, place: Place) -> String {
        let number = u64::from(place.file).checked_sub(self.library.sources.len() as u64);
        match number.and_then(|number| self.generated.get(number)) {
            Some(generated) => format!("{}:{}:{}", generated.source.name, place.line, place.column),
            None => self.library.describe_place(place),
        }
    }

    /// Returns the tag of the step that a task was made from.
    pub fn tag(&self, task: &Task) -> Symbol {
        let step = task.step().and_then(|step| {
            let procedure = self.procedure(step.procedure)?;
            procedure.steps.get(step.step as usize).map(|step| step.tag.clone())
        });
        step.unwrap_or_else(|| {
            Symbol::new(match task.origin {
                Origin::Probe(_) => "probe",
                _ if task.parent.is_some() => "meanwhile",
                _ => "root",
            })
        })
    }

    /// Returns the probings for the condition of `monitor`, in written order.
    pub fn probings_of(&self, monitor: MonitorId) -> impl Iterator<Item = (ProbingId, &Probing)> {
        let of = |part| ProbingId { monitor, part };
        self.probings.range(of(0)..=of(u32::MAX)).map(|(id, probing)| (*id, probing))
    }

    fn describe_wake(&self, wake: Wake) -> String {
        let name = |task: TaskId| match self.task(task) {
            Some(found) => format!("{task} ({})", self.tag(found)),
            None => task.to_string(),
        };
        match wake {
            Wake::Duration(task) => format!("the duration of {} ends", name(task)),
            Wake::Update(task) => format!("{} updates", name(task)),
            Wake::MinimumInterval(task) => format!("the minimum interval of {} is over", name(task)),
            Wake::Probing(monitor) => match self.watches.get(monitor.0) {
                Some(watch) => {
                    format!(
                        "{} probes for its {}, or the time limit of its probing ends",
                        name(watch.task),
                        watch.clause.word()
                    )
                }
                None => "a probe is due".into(),
            },
            Wake::PriorityCrossing(task) => format!("the rising priority of {} may win a conflict", name(task)),
            Wake::CommandTimeout(command) => match self.commands.get(&command) {
                Some(open) => format!("command {} of {} times out", command.0, name(open.task)),
                None => format!("command {} times out", command.0),
            },
            Wake::Question(question) => format!("the operator's time for question {} is over", question.0),
            Wake::SolveTimeout(request) => match self.requests.get(&request) {
                Some(task) => format!("the request {} of {} to a solver times out", request.0, name(*task)),
                None => format!("the request {} to a solver times out", request.0),
            },
            Wake::Monitor(monitor) => match self.watches.get(monitor.0) {
                Some(watch) => format!("{} of {} may become true", watch.clause.word(), name(watch.task)),
                None => "a condition may become true".into(),
            },
        }
    }
}
