//! The timeline: lanes of task states over time.
//!
//! A lane holds the tasks that one step of one procedure made (same parent lane, same tag), so that a step that
//! repeats for hours stays one lane. Tasks of a lane that overlap lie in rows below each other.

use super::RecordView;
use super::index::{IndexedTask, Interval, TaskIndex};
use super::state::StateWord;
use crate::error::RecordError;
use apex_model::task::TaskState;
use serde::Serialize;
use std::collections::BTreeMap;

/// Maximum number of lanes of an answer, unless the query states one.
const LANES_DEFAULT: usize = 40;
/// Maximum number of lanes of any answer.
const LANES_MAX: usize = 400;
/// Maximum number of rows of a lane: more tasks at once than this cannot be distinguished in a picture.
const ROWS_MAX: usize = 8;
/// Maximum number of intervals of a lane: about one for every second pixel of a wide screen.
const INTERVALS_MAX: usize = 800;

/// A query of the timeline.
#[derive(Clone, Debug, Default)]
pub struct TimelineQuery {
    /// Start of the window in nanoseconds of mission time; default: the record's start.
    pub from_ns: Option<i64>,
    /// End of the window in nanoseconds of mission time; default: the record's end.
    pub to_ns: Option<i64>,
    /// Maximum number of lanes; default 40, at most 400.
    pub lanes: Option<usize>,
}

/// Lanes of task states over time.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Timeline {
    /// Start of the window, nanoseconds of mission time.
    pub from_ns: i64,
    /// End of the window, nanoseconds of mission time.
    pub to_ns: i64,
    /// In the order of the task tree: a lane comes before the lanes below it.
    pub lanes: Vec<Lane>,
    /// Number of lanes that the limit leaves out; their tasks were active for less time.
    pub left_out: usize,
}

/// The tasks of one step.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Lane {
    /// The step's tag.
    pub tag: String,
    /// The goal of the first task.
    pub goal: String,
    /// Nesting in the tree of all lanes; a root has 0.
    pub depth: usize,
    /// Number of tasks.
    pub tasks: usize,
    /// Nanoseconds in which its tasks were enabled, ongoing or interrupted.
    pub active_ns: i64,
    /// Bars that do not overlap, row by row.
    pub rows: Vec<Vec<Bar>>,
    /// Number of intervals that the limits of a lane leave out.
    pub left_out: usize,
}

/// A stretch of time that a task spent in one state.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Bar {
    /// The task's number.
    pub task: u64,
    /// Its state.
    pub state: StateWord,
    /// Start, nanoseconds of mission time.
    pub from_ns: i64,
    /// End, nanoseconds of mission time.
    pub to_ns: i64,
}

/// The tasks of one lane while lanes are gathered.
struct Group {
    depth: usize,
    children: Vec<usize>,
    tasks: Vec<u64>,
    active_ns: i64,
}

impl RecordView {
    /// The timeline. If the limit applies, the lanes that were active longest are kept.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn timeline(&mut self, query: &TimelineQuery) -> Result<Timeline, RecordError> {
        let from_ns = query.from_ns.map_or_else(|| self.first_ns(), Ok)?;
        let to_ns = query.to_ns.map_or_else(|| self.growth().map(|growth| growth.end_ns), Ok)?;
        let limit = query.lanes.unwrap_or(LANES_DEFAULT).clamp(1, LANES_MAX);
        Ok(draw(self.tasks_index()?, (from_ns, to_ns), limit))
    }
}

fn draw(index: &TaskIndex, (from_ns, to_ns): (i64, i64), limit: usize) -> Timeline {
    let (groups, roots) = gather(index, from_ns, to_ns);
    let mut ranked: Vec<usize> =
        (0..groups.len()).filter(|&at| groups.get(at).is_some_and(|group| !group.tasks.is_empty())).collect();
    ranked.sort_by_key(|&at| (groups.get(at).map_or(0, |group| -group.active_ns), at));
    let left_out = ranked.len().saturating_sub(limit);
    ranked.truncate(limit);
    let lanes = in_tree_order(&groups, &roots)
        .into_iter()
        .filter(|at| ranked.contains(at))
        .filter_map(|at| groups.get(at).and_then(|group| lane(index, group, from_ns, to_ns)))
        .collect();
    Timeline { from_ns, to_ns, lanes, left_out }
}

/// Groups all tasks into lanes; tasks outside the window shape the tree but do not show.
fn gather(index: &TaskIndex, from_ns: i64, to_ns: i64) -> (Vec<Group>, Vec<usize>) {
    let mut groups: Vec<Group> = Vec::new();
    let mut roots = Vec::new();
    let mut lane_of_task: BTreeMap<u64, usize> = BTreeMap::new();
    let mut lane_of_key: BTreeMap<(Option<usize>, &str), usize> = BTreeMap::new();
    for (&id, task) in index.tasks() {
        let parent = task.parent.and_then(|parent| lane_of_task.get(&parent).copied());
        let at = *lane_of_key.entry((parent, task.tag.as_str())).or_insert(groups.len());
        if at == groups.len() {
            let above = parent.and_then(|parent| groups.get_mut(parent));
            let depth = above.as_ref().map_or(0, |above| above.depth + 1);
            above.map_or(&mut roots, |above| &mut above.children).push(at);
            groups.push(Group { depth, children: Vec::new(), tasks: Vec::new(), active_ns: 0 });
        }
        lane_of_task.insert(id, at);
        let Some(group) = groups.get_mut(at) else { continue };
        if task.intervals(from_ns, to_ns).next().is_some() {
            group.tasks.push(id);
            group.active_ns +=
                task.intervals(from_ns, to_ns).filter(|bar| bar.state.0 != TaskState::Pending).map(length).sum::<i64>();
        }
    }
    (groups, roots)
}

fn length(interval: Interval) -> i64 {
    interval.to_ns.saturating_sub(interval.from_ns)
}

fn in_tree_order(groups: &[Group], roots: &[usize]) -> Vec<usize> {
    let mut order = Vec::with_capacity(groups.len());
    let mut open: Vec<usize> = roots.iter().rev().copied().collect();
    while let Some(at) = open.pop() {
        order.push(at);
        open.extend(groups.get(at).into_iter().flat_map(|group| group.children.iter().rev()));
    }
    order
}

fn lane(index: &TaskIndex, group: &Group, from_ns: i64, to_ns: i64) -> Option<Lane> {
    let first = index.get(*group.tasks.first()?)?;
    let mut rows: Vec<(i64, Vec<Bar>)> = Vec::new();
    let mut left_out = 0;
    let mut room = INTERVALS_MAX;
    for &id in &group.tasks {
        let bars = bars(id, index.get(id)?, from_ns, to_ns);
        let (Some(start), Some(end)) = (bars.first().map(|bar| bar.from_ns), bars.last().map(|bar| bar.to_ns)) else {
            continue;
        };
        let free = rows.iter().position(|(busy_until, _)| *busy_until <= start);
        if bars.len() > room || (free.is_none() && rows.len() == ROWS_MAX) {
            left_out += bars.len();
            continue;
        }
        room -= bars.len();
        match free.and_then(|at| rows.get_mut(at)) {
            Some((busy_until, row)) => {
                *busy_until = end;
                row.extend(bars);
            }
            None => rows.push((end, bars)),
        }
    }
    Some(Lane {
        tag: first.tag.clone(),
        goal: first.goal.clone(),
        depth: group.depth,
        tasks: group.tasks.len(),
        active_ns: group.active_ns,
        rows: rows.into_iter().map(|(_, row)| row).collect(),
        left_out,
    })
}

/// A task's bars; instants of waiting are dropped, an instant of work is kept as a mark.
fn bars(id: u64, task: &IndexedTask, from_ns: i64, to_ns: i64) -> Vec<Bar> {
    task.intervals(from_ns, to_ns)
        .filter(|interval| length(*interval) > 0 || interval.state.0 == TaskState::Ongoing)
        .map(|interval| Bar { task: id, state: interval.state, from_ns: interval.from_ns, to_ns: interval.to_ns })
        .collect()
}
