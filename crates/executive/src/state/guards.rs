//! Tasks with an `invariant`, by the data that it reads.

use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Facts that a condition reads.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reads {
    /// Attributes of the state variables.
    pub attributes: BTreeSet<Symbol>,
    /// True if it reads states of tasks, task variables or functions: each change of these may concern it.
    pub more: bool,
}

/// Tasks that have begun and have an `invariant`, their step's or their procedure's.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Guards {
    tasks: BTreeMap<TaskId, Reads>,
    by_attribute: BTreeMap<Symbol, BTreeSet<TaskId>>,
    /// Tasks whose invariants read more than samples.
    restless: BTreeSet<TaskId>,
}

impl Guards {
    /// Notes that an invariant of the task reads these facts.
    pub fn insert(&mut self, task: TaskId, reads: Reads) {
        self.remove(task);
        for attribute in &reads.attributes {
            self.by_attribute.entry(attribute.clone()).or_default().insert(task);
        }
        if reads.more {
            self.restless.insert(task);
        }
        self.tasks.insert(task, reads);
    }

    /// Takes the task out.
    pub fn remove(&mut self, task: TaskId) {
        let Some(reads) = self.tasks.remove(&task) else { return };
        self.restless.remove(&task);
        for attribute in &reads.attributes {
            if let Some(tasks) = self.by_attribute.get_mut(attribute) {
                tasks.remove(&task);
                if tasks.is_empty() {
                    self.by_attribute.remove(attribute);
                }
            }
        }
    }

    /// Returns true if the task has an invariant that is judged.
    pub fn contains(&self, task: TaskId) -> bool {
        self.tasks.contains_key(&task)
    }

    /// Returns true if no task has an invariant.
    pub fn is_empty(&self) -> bool {
        self.tasks.is_empty()
    }

    /// Returns the tasks that a sample of this attribute concerns, in addition to [`Guards::restless`].
    pub fn concerned_by(&self, attribute: &Symbol) -> impl Iterator<Item = TaskId> + '_ {
        self.by_attribute.get(attribute).into_iter().flatten().copied()
    }

    /// Returns the tasks that any change may concern, in order of creation.
    pub fn restless(&self) -> impl Iterator<Item = TaskId> + '_ {
        self.restless.iter().copied()
    }

    /// Returns true if a change of the state of a task may concern an invariant.
    pub fn read_states(&self) -> bool {
        !self.restless.is_empty()
    }
}
