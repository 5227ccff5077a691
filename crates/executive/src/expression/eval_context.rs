//! Evaluation context: everything that an expression can read, namely variables of the task, time, tasks, histories, library.

use crate::state::bindings::Bindings;
use crate::state::histories::history::Histories;
use apex_model::agent_limits::Limits;
use apex_model::event::StateVariable;
use apex_model::host::HostFunctions;
use apex_model::library::Library;
use apex_model::symbol::Symbol;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// The data of its agent that a task can read. Task control implements it; tests implement a small version.
pub(crate) trait EvalContext {
    /// Returns the value of the pattern variable `name` (without `?`); step tags are `Value::Task`.
    fn variable(&self, name: &Symbol) -> Option<Value>;
    /// Returns the value of a primitive's `locals` variable, outside of [`super::run`].
    fn local(&self, name: &Symbol) -> Option<Value> {
        let _ = name;
        None
    }
    /// Returns the instant of this step.
    fn now(&self) -> Time;
    /// Returns the value of `+this-task+`.
    fn this_task(&self) -> Option<TaskId>;
    /// Returns the value of `+self+`.
    fn agent_name(&self) -> &Symbol;
    /// Returns the instant at which the task became ongoing; before that, the instant of its creation.
    fn task_start(&self, task: TaskId) -> Option<Time>;
    /// Returns the instant at which the task ended; `None` while it lives.
    fn task_end(&self, task: TaskId) -> Option<Time>;
    /// Returns the task's state; `None` for a task that is not known.
    fn task_state(&self, task: TaskId) -> Option<TaskState>;
    /// Returns the words of the outcome of a task that has ended and is not known to be repeated; `None` while it lives.
    fn task_outcome(&self, task: TaskId) -> Option<&'static [&'static str]> {
        let _ = task;
        None
    }
    /// Returns `+tot+`: the time for which the task has been ongoing, without interruptions.
    fn task_time_ongoing(&self, task: TaskId) -> Option<Duration>;
    /// Returns the histories of measurements and messages.
    fn histories(&self) -> &Histories;
    /// Returns the value of `variable` that the agent published at this instant and that the history does not hold yet.
    fn published(&self, variable: &StateVariable) -> Option<Value> {
        let _ = variable;
        None
    }
    /// Returns the checked library.
    fn library(&self) -> &Library;
    /// Returns the registered host functions.
    fn host(&self) -> &HostFunctions;
    /// Returns the agent's limits.
    fn limits(&self) -> &Limits;
}

/// An evaluation context with additional variables, which hide those of equal name: bindings of a pattern, a task's own bindings.
pub(crate) struct WithBindings<'a> {
    /// The context that answers everything else.
    pub(crate) below: &'a dyn EvalContext,
    /// The additional variables.
    pub(crate) bindings: &'a Bindings,
}

impl EvalContext for WithBindings<'_> {
    fn variable(&self, name: &Symbol) -> Option<Value> {
        self.bindings.get(name).cloned().or_else(|| self.below.variable(name))
    }
    fn local(&self, name: &Symbol) -> Option<Value> {
        self.below.local(name)
    }
    fn now(&self) -> Time {
        self.below.now()
    }
    fn this_task(&self) -> Option<TaskId> {
        self.below.this_task()
    }
    fn agent_name(&self) -> &Symbol {
        self.below.agent_name()
    }
    fn task_start(&self, task: TaskId) -> Option<Time> {
        self.below.task_start(task)
    }
    fn task_end(&self, task: TaskId) -> Option<Time> {
        self.below.task_end(task)
    }
    fn task_state(&self, task: TaskId) -> Option<TaskState> {
        self.below.task_state(task)
    }
    fn task_outcome(&self, task: TaskId) -> Option<&'static [&'static str]> {
        self.below.task_outcome(task)
    }
    fn task_time_ongoing(&self, task: TaskId) -> Option<Duration> {
        self.below.task_time_ongoing(task)
    }
    fn histories(&self) -> &Histories {
        self.below.histories()
    }
    fn published(&self, variable: &StateVariable) -> Option<Value> {
        self.below.published(variable)
    }
    fn library(&self) -> &Library {
        self.below.library()
    }
    fn host(&self) -> &HostFunctions {
        self.below.host()
    }
    fn limits(&self) -> &Limits {
        self.below.limits()
    }
}
