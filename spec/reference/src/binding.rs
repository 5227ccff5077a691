//! Variables: the tasks that see each variable, and the tasks that change it.

use crate::agent::{Agent, Change};
use crate::task::{Level, State, Work};
use crate::value::Value;

impl Agent<'_> {
    /// Returns the value that the clauses of `task` at `level` see under this name.
    pub(crate) fn variable(&self, task: usize, level: Level, name: &str) -> Option<Value> {
        match level {
            Level::Procedure => self.inner(task, name),
            Level::Step => self.outer(task, name),
        }
    }

    /// Returns a variable of the task's own procedure or primitive.
    fn inner(&self, task: usize, name: &str) -> Option<Value> {
        let task = &self.tasks[task];
        match &task.work {
            Some(Work::Procedure { .. }) => self.in_procedure(task.work.as_ref()?, name),
            Some(Work::Primitive { context, locals, .. }) => locals.get(name).or_else(|| context.get(name)).cloned(),
            _ => task.choice.as_ref()?.bound.get(name).cloned(),
        }
    }

    fn in_procedure(&self, work: &Work, name: &str) -> Option<Value> {
        let Work::Procedure { procedure, context, current, .. } = work else { return None };
        if let Some(value) = context.get(name) {
            return Some(value.clone());
        }
        let tags = self.steps(*procedure);
        let step = tags.iter().position(|step| step.tag == name)?;
        current[step].map(Value::Task)
    }

    /// Returns a variable of the task itself, or of the procedure that its step belongs to.
    fn outer(&self, task: usize, name: &str) -> Option<Value> {
        if let Some(value) = self.tasks[task].bound.get(name) {
            return Some(value.clone());
        }
        let parent = self.tasks[task].parent?;
        match self.tasks[parent].work.as_ref()? {
            work @ Work::Procedure { .. } => self.in_procedure(work, name),
            Work::Items(_) | Work::Handling(_) => self.outer(parent, name),
            Work::Primitive { .. } | Work::BuiltIn => None,
        }
    }

    /// Returns the owner of the variable.
    pub(crate) fn owner(&self, task: usize, level: Level, name: &str) -> Option<usize> {
        if level == Level::Procedure || self.tasks[task].bound.contains_key(name) {
            return Some(task);
        }
        let parent = self.tasks[task].parent?;
        match self.tasks[parent].work.as_ref()? {
            Work::Procedure { .. } => Some(parent),
            _ => self.owner(parent, Level::Step, name),
        }
    }

    /// Stores the value of a variable before a change.
    fn note_change(&mut self, task: usize, name: &str, before: Option<Value>) {
        if let Some(before) = before {
            let (number, noticed) = (self.next_serial(), self.noticed);
            self.changes.push(Change { task, name: name.to_string(), before, number, noticed });
        }
    }

    /// Returns the nearest task above that runs a procedure.
    pub(crate) fn procedure_above(&self, task: usize) -> Option<usize> {
        let parent = self.tasks[task].parent?;
        match self.tasks[parent].work {
            Some(Work::Procedure { .. }) => Some(parent),
            _ => self.procedure_above(parent),
        }
    }

    /// Sets a variable of the procedure or primitive that `task` runs, and lets steps that wait for it continue.
    pub(crate) fn bind_result(&mut self, task: usize, name: &str, value: Value) {
        let before = match &mut self.tasks[task].work {
            Some(Work::Procedure { context, .. } | Work::Primitive { context, .. }) => {
                context.insert(name.to_string(), value)
            }
            _ => return,
        };
        self.note_change(task, name, before);
        let Some(Work::Procedure { current, .. }) = &self.tasks[task].work else { return };
        for child in current.clone().into_iter().flatten() {
            let waits = self.tasks[child].waits_for_result && self.tasks[child].state == State::Pending;
            if waits && self.awaited(child).is_none() {
                self.tasks[child].waits_for_result = false;
                self.changed = true;
            }
        }
    }

    /// `(setq ?x value)`: the variable changes where it is defined; a new one is defined in the task.
    pub(crate) fn assign(&mut self, task: usize, level: Level, name: &str, value: Value) {
        let runs = matches!(self.tasks[task].work, Some(Work::Procedure { .. } | Work::Primitive { .. }));
        if level == Level::Procedure && runs {
            self.bind_result(task, name, value);
        } else if self.tasks[task].bound.contains_key(name) {
            self.tasks[task].bound.insert(name.to_string(), value);
        } else if let Some(above) = self.procedure_above(task) {
            self.bind_result(above, name, value);
        } else {
            self.tasks[task].bound.insert(name.to_string(), value);
        }
    }
}
