//! The states of all tasks over time, kept in memory and grown with the record.
//!
//! Bound: each effect row is read once; memory is one small entry per state change.

use super::state::StateWord;
use apex_model::task::TaskState;
use rusqlite::{Connection, Row};
use std::collections::BTreeMap;

/// A task and what became known of it when, oldest first. Parent, tag and place are those of its creation.
#[derive(Clone, Debug, Default)]
pub(super) struct IndexedTask {
    pub(super) parent: Option<u64>,
    pub(super) tag: String,
    pub(super) place: Option<String>,
    pub(super) created_ns: i64,
    pub(super) changes: Vec<Change>,
    /// Its goal: as created, then with the bindings of each selection that changed it.
    goals: Vec<(i64, Box<str>)>,
    /// The method of each selection; none from a new start of the step until it is selected again.
    methods: Vec<(i64, Option<Box<str>>)>,
}

/// From `at_ns` on the task is in `state`.
#[derive(Clone, Debug)]
pub(super) struct Change {
    pub(super) at_ns: i64,
    pub(super) state: StateWord,
    /// Outcome, if it has ended. A step that repeats leaves the ended state again.
    pub(super) outcome: Option<Box<str>>,
}

/// All tasks by number.
#[derive(Default)]
pub(super) struct TaskIndex {
    seen_effect: i64,
    /// Number of the last effect that was read or skipped.
    read_to: i64,
    seen_task: i64,
    tasks: BTreeMap<u64, IndexedTask>,
}

/// Reads a task's number; SQLite knows signed numbers only.
pub(super) fn task_number(row: &Row<'_>, column: usize) -> Result<Option<u64>, rusqlite::Error> {
    Ok(row.get::<_, Option<i64>>(column)?.map(i64::cast_unsigned))
}

/// A stretch of time in one state; the last one of a task that has not ended is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub(super) state: StateWord,
    pub(super) from_ns: i64,
    pub(super) to_ns: i64,
}

impl TaskIndex {
    /// All tasks by number.
    pub(super) fn tasks(&self) -> &BTreeMap<u64, IndexedTask> {
        &self.tasks
    }

    /// One task.
    pub(super) fn get(&self, id: u64) -> Option<&IndexedTask> {
        self.tasks.get(&id)
    }

    /// Returns the number of the last effect that was read or skipped.
    pub(super) fn read_to(&self) -> i64 {
        self.read_to
    }

    /// Reads the rows that were written since the last call, up to effect `last`.
    pub(super) fn refresh(&mut self, connection: &Connection, last: i64) -> Result<(), rusqlite::Error> {
        self.read_tasks(connection)?;
        let mut statement = connection.prepare_cached(
            "SELECT id, t_ns, kind, task, to_state, outcome, subject, method FROM effect WHERE id > ?1 \
             AND id <= ?2 AND task IS NOT NULL AND kind IN ('created', 'transition', 'selected') ORDER BY id",
        )?;
        let mut rows = statement.query([self.seen_effect.max(self.read_to), last])?;
        while let Some(row) = rows.next()? {
            let (at_ns, kind): (i64, String) = (row.get(1)?, row.get(2)?);
            let Some(id) = task_number(row, 3)? else { continue };
            let task = self.tasks.entry(id).or_default();
            match kind.as_str() {
                "created" => {
                    task.created_ns = at_ns;
                    task.changes.push(Change { at_ns, state: StateWord(TaskState::Pending), outcome: None });
                    task.set_goal(at_ns, row.get::<_, Option<String>>(6)?.unwrap_or_default());
                }
                "transition" => {
                    let outcome = row.get::<_, Option<Box<str>>>(5)?.filter(|word| !word.is_empty());
                    task.change(Change { at_ns, state: row.get(4)?, outcome });
                }
                _ => {
                    task.set_goal(at_ns, row.get::<_, Option<String>>(6)?.unwrap_or_default());
                    let method = row.get::<_, Option<Box<str>>>(7)?.filter(|method| !method.is_empty());
                    task.methods.push((at_ns, method));
                }
            }
            self.seen_effect = row.get(0)?;
        }
        self.read_to = self.read_to.max(last);
        Ok(())
    }

    /// Reads what new tasks were created with; what they select later is among the effects.
    fn read_tasks(&mut self, connection: &Connection) -> Result<(), rusqlite::Error> {
        let sql = "SELECT position, id, parent, tag, place FROM task WHERE position > ?1 ORDER BY position";
        let mut statement = connection.prepare_cached(sql)?;
        let mut rows = statement.query([self.seen_task])?;
        while let Some(row) = rows.next()? {
            let Some(id) = task_number(row, 1)? else { continue };
            let task = self.tasks.entry(id).or_default();
            task.parent = task_number(row, 2)?;
            task.tag = row.get::<_, Option<String>>(3)?.unwrap_or_default();
            task.place = row.get::<_, Option<String>>(4)?.filter(|place| !place.is_empty());
            self.seen_task = row.get(0)?;
        }
        Ok(())
    }
}

/// The last entry that is not later than `at_ns`.
fn last_known<T>(known: &[(i64, T)], at_ns: i64) -> Option<&T> {
    let later = known.partition_point(|(since_ns, _)| *since_ns <= at_ns);
    later.checked_sub(1).and_then(|last| known.get(last)).map(|(_, value)| value)
}

impl IndexedTask {
    fn set_goal(&mut self, at_ns: i64, goal: String) {
        if self.goals.last().is_none_or(|(_, known)| **known != *goal) {
            self.goals.push((at_ns, goal.into_boxed_str()));
        }
    }

    fn change(&mut self, change: Change) {
        // A step that starts again forgets how its last instance was pursued.
        if change.state.0 == TaskState::Pending && self.methods.last().is_some_and(|(_, method)| method.is_some()) {
            self.methods.push((change.at_ns, None));
        }
        self.changes.push(change);
    }

    /// Its goal as known at `at_ns`; empty before its creation.
    pub(super) fn goal_at(&self, at_ns: i64) -> &str {
        last_known(&self.goals, at_ns).map_or("", |goal| goal)
    }

    /// The method selected by `at_ns`.
    pub(super) fn method_at(&self, at_ns: i64) -> Option<&str> {
        last_known(&self.methods, at_ns)?.as_deref()
    }

    /// The state at `at_ns`, with the time it began; none before the task was created.
    pub(super) fn state_at(&self, at_ns: i64) -> Option<&Change> {
        let later = self.changes.partition_point(|change| change.at_ns <= at_ns);
        later.checked_sub(1).and_then(|last| self.changes.get(last))
    }

    /// The stretches in each state but the last (ended), cut to `from_ns..=to_ns`.
    pub(super) fn intervals(&self, from_ns: i64, to_ns: i64) -> impl Iterator<Item = Interval> + '_ {
        let ends = self.changes.iter().skip(1).map(|next| next.at_ns).chain(std::iter::once(i64::MAX));
        self.changes.iter().zip(ends).filter_map(move |(change, end)| {
            let interval = Interval { state: change.state, from_ns: change.at_ns.max(from_ns), to_ns: end.min(to_ns) };
            (change.state.is_alive() && interval.from_ns <= interval.to_ns).then_some(interval)
        })
    }

    /// The intervals that a picture shows: an instant of waiting is none, an instant of work is one.
    pub(super) fn drawn(&self, from_ns: i64, to_ns: i64) -> impl Iterator<Item = Interval> + '_ {
        let is_drawn = |interval: &Interval| interval.length_ns() > 0 || interval.state.0 == TaskState::Ongoing;
        self.intervals(from_ns, to_ns).filter(is_drawn)
    }
}

impl Interval {
    /// Its length in nanoseconds.
    pub(super) fn length_ns(self) -> i64 {
        self.to_ns.saturating_sub(self.from_ns)
    }
}

#[cfg(test)]
impl TaskIndex {
    /// Adds a task with these changes of its state.
    pub(super) fn insert(&mut self, id: u64, parent: Option<u64>, tag: &str, changes: &[(i64, TaskState)]) {
        let mut task = IndexedTask {
            parent,
            tag: tag.into(),
            created_ns: changes.first().map_or(0, |(at_ns, _)| *at_ns),
            ..IndexedTask::default()
        };
        for &(at_ns, state) in changes {
            task.change(Change { at_ns, state: StateWord(state), outcome: None });
        }
        self.tasks.insert(id, task);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn task(changes: &[(i64, TaskState)]) -> IndexedTask {
        let changes =
            changes.iter().map(|&(at_ns, state)| Change { at_ns, state: StateWord(state), outcome: None }).collect();
        IndexedTask { changes, ..IndexedTask::default() }
    }

    #[test]
    fn the_last_change_of_an_instant_counts() {
        let task = task(&[(5, TaskState::Pending), (5, TaskState::Enabled), (9, TaskState::Ongoing)]);
        assert!(task.state_at(4).is_none());
        assert_eq!(task.state_at(5).unwrap().state, StateWord(TaskState::Enabled));
        assert_eq!(task.state_at(8).unwrap().state, StateWord(TaskState::Enabled));
        assert_eq!(task.state_at(9).unwrap().state, StateWord(TaskState::Ongoing));
    }

    #[test]
    fn intervals_are_cut_to_the_window_and_leave_the_ended_state_out() {
        let task = task(&[(0, TaskState::Pending), (10, TaskState::Ongoing), (30, TaskState::Terminated)]);
        let seen: Vec<Interval> = task.intervals(5, 20).collect();
        assert_eq!(
            seen,
            [
                Interval { state: StateWord(TaskState::Pending), from_ns: 5, to_ns: 10 },
                Interval { state: StateWord(TaskState::Ongoing), from_ns: 10, to_ns: 20 },
            ]
        );
    }
}
