//! Evaluation context of a session's conditions: its histories, the tasks that were reported to it, the bound variables.

use crate::expression::EvalContext;
use crate::state::bindings::Bindings;
use crate::state::histories::history::Histories;
use crate::state::variable_index::VariableIndex;
use apex_model::agent_limits::Limits;
use apex_model::host::HostFunctions;
use apex_model::library::Library;
use apex_model::symbol::Symbol;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A task whose states were reported to the session.
#[derive(Clone, Debug)]
pub(super) struct KnownTask {
    pub(super) state: TaskState,
    pub(super) since: Time,
    /// Instant at which the task became ongoing; before that, the instant of its first report.
    pub(super) started_at: Time,
    /// Time for which the task had been ongoing before `since`.
    pub(super) worked: Duration,
}

impl KnownTask {
    /// Enters `state` at `at`.
    pub(super) fn enter(&mut self, state: TaskState, at: Time) {
        if self.state == TaskState::Ongoing {
            self.worked = self.worked + (at - self.since);
        } else if state == TaskState::Ongoing && self.worked == Duration::ZERO {
            self.started_at = at;
        }
        self.state = state;
        self.since = at;
    }
}

/// The world of a session, apart from its monitors.
#[derive(Clone, Debug)]
pub(super) struct SessionState {
    pub(super) library: Arc<Library>,
    pub(super) index: Arc<VariableIndex>,
    pub(super) host: HostFunctions,
    pub(super) name: Symbol,
    pub(super) histories: Histories,
    pub(super) tasks: BTreeMap<TaskId, KnownTask>,
    pub(super) variables: Bindings,
    pub(super) now: Time,
    pub(super) limits: Limits,
}

impl EvalContext for SessionState {
    fn variable(&self, name: &Symbol) -> Option<Value> {
        self.variables.get(name).cloned()
    }

    fn now(&self) -> Time {
        self.now
    }

    fn this_task(&self) -> Option<TaskId> {
        None
    }

    fn agent_name(&self) -> &Symbol {
        &self.name
    }

    fn task_start(&self, task: TaskId) -> Option<Time> {
        self.tasks.get(&task).map(|task| task.started_at)
    }

    fn task_end(&self, task: TaskId) -> Option<Time> {
        self.tasks.get(&task).filter(|task| task.state == TaskState::Terminated).map(|task| task.since)
    }

    fn task_state(&self, task: TaskId) -> Option<TaskState> {
        self.tasks.get(&task).map(|task| task.state)
    }

    fn task_time_ongoing(&self, task: TaskId) -> Option<Duration> {
        let task = self.tasks.get(&task)?;
        let now = if task.state == TaskState::Ongoing { self.now - task.since } else { Duration::ZERO };
        Some(task.worked + now)
    }

    fn histories(&self) -> &Histories {
        &self.histories
    }

    fn library(&self) -> &Library {
        &self.library
    }

    fn host(&self) -> &HostFunctions {
        &self.host
    }

    fn limits(&self) -> &Limits {
        &self.limits
    }
}
