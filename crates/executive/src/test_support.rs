//! Small evaluation context for tests.

use crate::expression::EvalContext;
use crate::state::bindings::Bindings;
use crate::state::histories::history::Histories;
use apex_model::agent_limits::{Limits, UNLOWERED};
use apex_model::host::HostFunctions;
use apex_model::library::Library;
use apex_model::symbol::Symbol;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeMap;

/// State of a task for tests.
#[derive(Clone, Debug)]
pub(crate) struct TestTask {
    pub(crate) start: Time,
    pub(crate) end: Option<Time>,
    pub(crate) state: TaskState,
}

impl Default for TestTask {
    fn default() -> TestTask {
        TestTask { start: Time::ZERO, end: None, state: TaskState::Pending }
    }
}

/// Everything an expression may see, as plain fields. `+this-task+` is T1, `+self+` is pilot.
pub(crate) struct TestView {
    pub(crate) variables: Bindings,
    pub(crate) now: Time,
    pub(crate) name: Symbol,
    pub(crate) tasks: BTreeMap<TaskId, TestTask>,
    pub(crate) histories: Histories,
    pub(crate) library: Library,
    pub(crate) host: HostFunctions,
}

impl Default for TestView {
    fn default() -> TestView {
        TestView {
            variables: Bindings::new(),
            now: Time::ZERO,
            name: Symbol::new("pilot"),
            tasks: BTreeMap::new(),
            histories: Histories::default(),
            library: Library::default(),
            host: HostFunctions::default(),
        }
    }
}

impl EvalContext for TestView {
    fn variable(&self, name: &Symbol) -> Option<Value> {
        self.variables.get(name).cloned()
    }
    fn now(&self) -> Time {
        self.now
    }
    fn this_task(&self) -> Option<TaskId> {
        Some(TaskId(1))
    }
    fn agent_name(&self) -> &Symbol {
        &self.name
    }
    fn task_start(&self, task: TaskId) -> Option<Time> {
        self.tasks.get(&task).map(|task| task.start)
    }
    fn task_end(&self, task: TaskId) -> Option<Time> {
        self.tasks.get(&task).and_then(|task| task.end)
    }
    fn task_state(&self, task: TaskId) -> Option<TaskState> {
        self.tasks.get(&task).map(|task| task.state)
    }
    fn task_time_ongoing(&self, task: TaskId) -> Option<Duration> {
        self.tasks.get(&task).map(|task| self.now - task.start)
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
        UNLOWERED
    }
}
