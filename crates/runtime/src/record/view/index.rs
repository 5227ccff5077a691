//! The states of all tasks over time, kept in memory and grown with the record.
//!
//! Bound: each effect row is read once; memory is one small entry per state change.

use super::state::StateWord;
use apex_model::task::TaskState;
use rusqlite::{Connection, Row};
use std::collections::BTreeMap;

/// A task and the changes of its state, oldest first.
#[derive(Clone, Debug, Default)]
pub(super) struct IndexedTask {
    pub(super) parent: Option<u64>,
    pub(super) tag: String,
    pub(super) goal: String,
    pub(super) method: Option<String>,
    pub(super) place: Option<String>,
    pub(super) created_ns: i64,
    pub(super) changes: Vec<Change>,
}

/// From `at_ns` on the task is in `state`.
#[derive(Clone, Debug)]
pub(super) struct Change {
    pub(super) at_ns: i64,
    pub(super) state: StateWord,
    /// How it ended, when it did. A step that repeats leaves the ended state again.
    pub(super) outcome: Option<Box<str>>,
}

/// All tasks by number.
#[derive(Default)]
pub(super) struct TaskIndex {
    seen_effect: i64,
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

    /// Reads the rows that were written since the last call.
    pub(super) fn refresh(&mut self, connection: &Connection) -> Result<(), rusqlite::Error> {
        self.read_tasks(connection)?;
        let mut statement = connection.prepare_cached(
            "SELECT id, t_ns, kind, task, to_state, outcome, subject, method FROM effect WHERE id > ?1 \
             AND task IS NOT NULL AND kind IN ('created', 'transition', 'selected') ORDER BY id",
        )?;
        let mut rows = statement.query([self.seen_effect])?;
        while let Some(row) = rows.next()? {
            let (at_ns, kind): (i64, String) = (row.get(1)?, row.get(2)?);
            let Some(id) = task_number(row, 3)? else { continue };
            let task = self.tasks.entry(id).or_default();
            match kind.as_str() {
                "created" => {
                    task.created_ns = at_ns;
                    task.changes.push(Change { at_ns, state: StateWord(TaskState::Pending), outcome: None });
                }
                "transition" => {
                    let outcome = row.get::<_, Option<Box<str>>>(5)?.filter(|word| !word.is_empty());
                    task.changes.push(Change { at_ns, state: row.get(4)?, outcome });
                }
                _ => {
                    task.goal = row.get::<_, Option<String>>(6)?.unwrap_or_default();
                    task.method = row.get::<_, Option<String>>(7)?.filter(|method| !method.is_empty());
                }
            }
            self.seen_effect = row.get(0)?;
        }
        Ok(())
    }

    /// Reads what new tasks were created with; what they select later is among the effects.
    fn read_tasks(&mut self, connection: &Connection) -> Result<(), rusqlite::Error> {
        let sql = "SELECT position, id, parent, tag, goal, place FROM task WHERE position > ?1 ORDER BY position";
        let mut statement = connection.prepare_cached(sql)?;
        let mut rows = statement.query([self.seen_task])?;
        while let Some(row) = rows.next()? {
            let Some(id) = task_number(row, 1)? else { continue };
            let task = self.tasks.entry(id).or_default();
            task.parent = task_number(row, 2)?;
            task.tag = row.get::<_, Option<String>>(3)?.unwrap_or_default();
            task.goal = row.get::<_, Option<String>>(4)?.unwrap_or_default();
            task.place = row.get::<_, Option<String>>(5)?.filter(|place| !place.is_empty());
            self.seen_task = row.get(0)?;
        }
        Ok(())
    }
}

impl IndexedTask {
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
