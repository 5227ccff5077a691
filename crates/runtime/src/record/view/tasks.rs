//! The task tree at an instant.

use super::RecordView;
use super::goals::{IndexedGoal, TargetNames};
use super::index::{IndexedTask, TaskIndex};
use super::state::StateWord;
use crate::error::RecordError;
use crate::method_detail::MethodDetail;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Default maximum number of selected tasks: more than an operator reads, and few enough to draw during a flight.
const LIMIT_DEFAULT: usize = 1_000;
/// Maximum number of selected tasks of any answer.
const LIMIT_MAX: usize = 20_000;
/// Maximum number of children that are listed with a task.
const CHILDREN_MAX: usize = 100;

/// A query of the task tree.
#[derive(Clone, Debug, Default)]
pub struct TasksQuery {
    /// Mission time in nanoseconds; default: the record's end.
    pub at_ns: Option<i64>,
    /// True leaves out tasks that have ended.
    pub alive_only: bool,
    /// Only tasks whose number (`T12`), tag or goal contains this text, in any case.
    pub find: Option<String>,
    /// A task that is selected in any case.
    pub with: Option<u64>,
    /// Maximum number of selected tasks; default 1,000, at most 20,000.
    pub limit: Option<usize>,
}

/// The task tree at an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Tasks {
    /// Mission time in nanoseconds.
    pub at_ns: i64,
    /// The selected tasks with all their ancestors, by number, so that parents come before their children.
    pub tasks: Vec<Task>,
    /// Number of tasks in each state at that time.
    pub counts: BTreeMap<StateWord, usize>,
    /// Number of matching tasks that the limit leaves out.
    pub left_out: usize,
}

/// A task at an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Task {
    /// Its number: 12 for `T12`.
    pub id: u64,
    /// Its parent's number.
    pub parent: Option<u64>,
    /// Its step's tag.
    pub tag: String,
    /// Its goal as known at that time.
    pub goal: String,
    /// Identifiers of the targets that the goal names.
    pub targets: Vec<String>,
    /// True if it only sends a message or asks a question.
    pub is_message: bool,
    /// Its state.
    pub state: StateWord,
    /// A word of `apex_model::task::OUTCOME_WORDS`, if it has ended.
    pub outcome: Option<String>,
    /// Mission time in nanoseconds at which the state began.
    pub since_ns: i64,
    /// Mission time in nanoseconds of its creation.
    pub created_ns: i64,
    /// `procedure file.pdl:3:1`, if a method was selected by the instant.
    pub method: Option<String>,
    /// `file:line:column` of that method; null for a built-in activity and a solver.
    pub method_place: Option<String>,
    /// `file:line:column` of its step.
    pub place: Option<String>,
}

/// Result of a look-up of one task at an instant.
#[derive(Clone, Debug, PartialEq)]
pub enum TaskLookup {
    /// The task, and its children by number.
    Found {
        /// The task.
        task: Box<Task>,
        /// Its children.
        children: Vec<Task>,
    },
    /// The task is created later.
    NotYet {
        /// Mission time in nanoseconds of its creation.
        created_ns: i64,
    },
    /// The record does not contain the task.
    Unknown,
}

impl Task {
    /// Returns the task at `at_ns`; `None` before its creation.
    fn at(id: u64, task: &IndexedTask, targets: &TargetNames, at_ns: i64) -> Option<Task> {
        let now = task.state_at(at_ns)?;
        let goal = task.known_goal(at_ns);
        let method = task.method_at(at_ns);
        Some(Task {
            id,
            parent: task.parent,
            tag: task.tag.clone(),
            goal: task.goal_at(at_ns).to_owned(),
            targets: goal.map(|goal| goal.targets(targets)).unwrap_or_default(),
            is_message: goal.is_some_and(IndexedGoal::is_message),
            state: now.state,
            outcome: now.outcome.word().map(str::to_owned),
            since_ns: now.at_ns,
            created_ns: task.created_ns,
            method: method.map(MethodDetail::to_string),
            method_place: method.and_then(|method| method.place.clone()),
            place: task.place.clone(),
        })
    }
}

impl RecordView {
    /// Returns the task tree. At the limit, tasks that have not ended are kept first, then those that changed last.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn tasks(&mut self, query: &TasksQuery) -> Result<Tasks, RecordError> {
        let end_ns = self.reader.span()?.map_or(0, |(_, end)| end.0);
        let at_ns = query.at_ns.unwrap_or(end_ns);
        let limit = query.limit.unwrap_or(LIMIT_DEFAULT).clamp(1, LIMIT_MAX);
        let find = query.find.as_deref().map(str::to_lowercase).filter(|text| !text.is_empty());
        let targets = self.target_names()?;
        let index = self.tasks_index()?;
        let mut counts = BTreeMap::new();
        let mut wanted = Vec::new();
        for (&id, task) in index.tasks() {
            let Some(now) = task.state_at(at_ns) else { continue };
            *counts.entry(now.state).or_insert(0) += 1;
            let ended = !now.state.is_alive();
            let kept =
                !(query.alive_only && ended) && find.as_ref().is_none_or(|find| matches((id, task), at_ns, find));
            let first = query.with == Some(id);
            if kept || first {
                wanted.push((!first, ended, std::cmp::Reverse(now.at_ns), id));
            }
        }
        wanted.sort_unstable();
        let left_out = wanted.len().saturating_sub(limit);
        let chosen = with_ancestors(&index, wanted.into_iter().take(limit).map(|(.., id)| id));
        let tasks = chosen.into_iter().filter_map(|id| Task::at(id, index.get(id)?, &targets, at_ns)).collect();
        Ok(Tasks { at_ns, tasks, counts, left_out })
    }

    /// Returns task `id` at mission time `at_ns` (nanoseconds) and its children then, at most 100.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn task(&mut self, id: u64, at_ns: i64) -> Result<TaskLookup, RecordError> {
        let targets = self.target_names()?;
        let index = self.tasks_index()?;
        let Some(task) = index.get(id) else { return Ok(TaskLookup::Unknown) };
        let Some(row) = Task::at(id, task, &targets, at_ns) else {
            return Ok(TaskLookup::NotYet { created_ns: task.created_ns });
        };
        let children = index
            .tasks()
            .range(id..)
            .filter(|(_, child)| child.parent == Some(id))
            .filter_map(|(&id, child)| Task::at(id, child, &targets, at_ns))
            .take(CHILDREN_MAX)
            .collect();
        Ok(TaskLookup::Found { task: Box::new(row), children })
    }
}

fn matches((id, task): (u64, &IndexedTask), at_ns: i64, find: &str) -> bool {
    task.goal_at(at_ns).to_lowercase().contains(find)
        || task.tag.to_lowercase().contains(find)
        || format!("t{id}") == *find
}

fn with_ancestors(index: &TaskIndex, ids: impl Iterator<Item = u64>) -> BTreeSet<u64> {
    let mut chosen = BTreeSet::new();
    for id in ids {
        let mut next = Some(id);
        // A task is selected with all its ancestors, so the ascent ends at the first ancestor that is selected already.
        while let Some(id) = next.filter(|&id| chosen.insert(id)) {
            next = index.get(id).and_then(|task| task.parent);
        }
    }
    chosen
}
