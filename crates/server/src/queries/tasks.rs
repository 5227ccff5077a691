//! `/api/tasks`: the task tree as it was at an instant.

use crate::answer::Answer;
use crate::index::{State, Task, TaskIndex};
use crate::record::Reader;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Tasks in one answer unless asked otherwise; more than a person reads, few enough to draw while time runs.
const LIMIT_DEFAULT: usize = 1_000;
/// Tasks in one answer at most.
const LIMIT_MAX: usize = 20_000;

/// Parameters.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TasksQuery {
    at: Option<i64>,
    /// False leaves out tasks that have ended.
    ended: Option<bool>,
    /// A text to find in number, tag or goal.
    find: Option<String>,
    /// A task to give in any case, with all above it.
    with: Option<u64>,
    limit: Option<usize>,
}

/// The answer.
#[derive(Debug, Serialize)]
pub(crate) struct Tasks {
    at_ns: i64,
    /// By number, so that parents come before their children.
    tasks: Vec<TaskRow>,
    /// How many tasks are in each state at that time, in all.
    counts: BTreeMap<State, usize>,
    /// Tasks that would belong here but for the limit.
    left_out: usize,
}

/// One task at an instant.
#[derive(Debug, Serialize)]
pub(crate) struct TaskRow {
    pub(crate) id: u64,
    pub(crate) parent: Option<u64>,
    pub(crate) tag: String,
    pub(crate) goal: String,
    pub(crate) state: State,
    /// How it ended; only when it has.
    pub(crate) outcome: Option<String>,
    pub(crate) since_ns: i64,
    pub(crate) created_ns: i64,
    pub(crate) method: Option<String>,
    pub(crate) place: Option<String>,
}

impl TaskRow {
    /// The task at `at_ns`; none when it was not there yet.
    pub(crate) fn at(id: u64, task: &Task, at_ns: i64) -> Option<TaskRow> {
        let now = task.state_at(at_ns)?;
        Some(TaskRow {
            id,
            parent: task.parent,
            tag: task.tag.clone(),
            goal: task.goal.clone(),
            state: now.state,
            outcome: now.outcome.as_deref().map(str::to_owned),
            since_ns: now.at_ns,
            created_ns: task.created_ns,
            method: task.method.clone(),
            place: task.place.clone(),
        })
    }
}

/// Answers `/api/tasks`. Where the limit bites, tasks that have not ended come first, then those that changed last.
pub(crate) fn tasks(reader: &mut Reader, query: &TasksQuery) -> Answer<Tasks> {
    let at_ns = query.at.unwrap_or(i64::MAX);
    let limit = query.limit.unwrap_or(LIMIT_DEFAULT).clamp(1, LIMIT_MAX);
    let find = query.find.as_deref().map(str::to_lowercase).filter(|text| !text.is_empty());
    let index = reader.tasks()?;
    let mut counts = BTreeMap::new();
    let mut wanted = Vec::new();
    for (&id, task) in index.tasks() {
        let Some(now) = task.state_at(at_ns) else { continue };
        *counts.entry(now.state).or_insert(0) += 1;
        let ended = now.state == State::Terminated;
        let kept = (query.ended.unwrap_or(true) || !ended) && find.as_ref().is_none_or(|find| matches(id, task, find));
        if kept || query.with == Some(id) {
            let first = query.with == Some(id);
            wanted.push((!first, ended, std::cmp::Reverse(now.at_ns), id));
        }
    }
    wanted.sort_unstable();
    let left_out = wanted.len().saturating_sub(limit);
    let chosen = with_ancestors(index, wanted.into_iter().take(limit).map(|(.., id)| id));
    let tasks = chosen.into_iter().filter_map(|id| TaskRow::at(id, index.get(id)?, at_ns)).collect();
    Ok(Tasks { at_ns, tasks, counts, left_out })
}

fn matches(id: u64, task: &Task, find: &str) -> bool {
    task.goal.to_lowercase().contains(find) || task.tag.to_lowercase().contains(find) || format!("t{id}") == *find
}

fn with_ancestors(index: &TaskIndex, ids: impl Iterator<Item = u64>) -> BTreeSet<u64> {
    let mut chosen = BTreeSet::new();
    for id in ids {
        let mut next = Some(id);
        // A task is chosen with all above it, so the climb ends at the first one that is there already.
        while let Some(id) = next.filter(|&id| chosen.insert(id)) {
            next = index.get(id).and_then(|task| task.parent);
        }
    }
    chosen
}
