//! The data of its agent that a task can read: the context of the expressions and conditions of its clauses.

use crate::expression::EvalContext;
use crate::state::agent::Agent;
use crate::state::clause::Level;
use crate::state::controller::{Controller, MethodBinding, ProcedureController};
use crate::state::histories::history::Histories;
use crate::state::task::Task;
use apex_model::agent_limits::Limits;
use apex_model::event::StateVariable;
use apex_model::host::HostFunctions;
use apex_model::library::Library;
use apex_model::symbol::Symbol;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Evaluation context of the clauses of `task` at `level` at `now`.
pub(crate) struct View<'a> {
    /// The agent.
    pub(crate) agent: &'a Agent,
    /// The task.
    pub(crate) task: TaskId,
    /// At the level of the step, expressions see the variables of the surrounding procedure; at the level of the procedure, those of the
    /// task's own controller.
    pub(crate) level: Level,
    /// The instant of the evaluation: now, or a later one while a crossing of priorities is computed.
    pub(crate) now: Time,
}

/// Returns a variable of a procedure instance: from its context, otherwise the task of the step with that tag.
fn in_procedure(agent: &Agent, controller: &ProcedureController, name: &Symbol) -> Option<Value> {
    if let Some(value) = controller.context.get(name) {
        return Some(value.clone());
    }
    let step = agent.procedure_index(controller.procedure)?.tags.get(name)?;
    controller.current.get(*step as usize).copied().flatten().map(Value::Task)
}

impl View<'_> {
    /// Returns a variable of the task's own procedure or primitive, chosen or running.
    fn inner(&self, task: &Task, name: &Symbol) -> Option<Value> {
        match task.controller.as_deref() {
            Some(Controller::Procedure(controller)) => in_procedure(self.agent, controller, name),
            Some(Controller::Primitive(controller)) => controller.context.get(name).cloned(),
            _ => match &task.selection.as_ref()?.way {
                MethodBinding::Procedure(_, bindings) | MethodBinding::Primitive(_, bindings) => {
                    bindings.get(name).cloned()
                }
                MethodBinding::Items(_)
                | MethodBinding::BuiltIn(_)
                | MethodBinding::Terminate
                | MethodBinding::Solver(_) => None,
            },
        }
    }

    /// Returns a variable of the task itself, or of the controllers above it up to its procedure.
    fn outer(&self, task: &Task, name: &Symbol) -> Option<Value> {
        let mut task = task;
        loop {
            if let Some(value) = task.bindings.get(name) {
                return Some(value.clone());
            }
            let parent = self.agent.task(task.parent?)?;
            match parent.controller.as_deref()? {
                Controller::Procedure(controller) => return in_procedure(self.agent, controller, name),
                Controller::Items(_) | Controller::Planning(_) | Controller::Handling(_) => task = parent,
                Controller::Primitive(_) | Controller::Question(_) | Controller::BuiltIn => return None,
            }
        }
    }
}

impl EvalContext for View<'_> {
    fn variable(&self, name: &Symbol) -> Option<Value> {
        let task = self.agent.task(self.task)?;
        match self.level {
            Level::Procedure => self.inner(task, name),
            Level::Step => self.outer(task, name),
        }
    }

    fn local(&self, name: &Symbol) -> Option<Value> {
        match self.agent.task(self.task)?.controller.as_deref() {
            Some(Controller::Primitive(controller)) => controller.locals.get(name).cloned(),
            _ => None,
        }
    }

    fn now(&self) -> Time {
        self.now
    }

    fn this_task(&self) -> Option<TaskId> {
        Some(self.task)
    }

    fn limits(&self) -> &Limits {
        &self.agent.limits
    }

    fn agent_name(&self) -> &Symbol {
        &self.agent.name
    }

    fn task_start(&self, task: TaskId) -> Option<Time> {
        self.agent.task(task).map(|task| task.started_at.unwrap_or(task.created_at))
    }

    fn task_end(&self, task: TaskId) -> Option<Time> {
        self.agent.task(task).filter(|task| task.is_terminated()).map(|task| task.since)
    }

    fn task_state(&self, task: TaskId) -> Option<TaskState> {
        self.agent.task(task).map(|task| task.state)
    }

    fn task_outcome(&self, task: TaskId) -> Option<&'static [&'static str]> {
        let task = self.agent.task(task).filter(|task| task.is_terminated())?;
        task.outcome.as_ref().map(Outcome::states)
    }

    fn task_time_ongoing(&self, task: TaskId) -> Option<Duration> {
        let task = self.agent.task(task)?;
        let before = task.extras.as_ref().map_or(Duration::ZERO, |extras| extras.worked);
        Some(if task.state == TaskState::Ongoing { before + (self.now - task.since) } else { before })
    }

    fn histories(&self) -> &Histories {
        &self.agent.histories
    }

    fn published(&self, variable: &StateVariable) -> Option<Value> {
        let published = self.agent.published.iter().rev();
        published.filter(|(of, _)| of == variable).map(|(_, value)| value.clone()).next()
    }

    fn library(&self) -> &Library {
        &self.agent.library
    }

    fn host(&self) -> &HostFunctions {
        &self.agent.host
    }
}
