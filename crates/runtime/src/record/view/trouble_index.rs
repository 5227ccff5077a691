//! An index of failures, interruptions and faults, shared by all views of a record and grown with it. (english: allow)

use super::index::task_number;
use rusqlite::Connection;
use serde::Serialize;

/// Kind of the effects that report faults.
const FAULT: &str = "trouble"; // english: allow

/// Something that went wrong.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Trouble {
    /// Mission time in nanoseconds.
    pub t_ns: i64,
    /// Kind of the entry.
    pub kind: TroubleKind,
    /// The goal, target or message that it is about.
    pub subject: String,
    /// Cause.
    pub cause: String,
    /// The task's number, if it is about one.
    pub task: Option<u64>,
    /// The target's identifier, if it is about one.
    pub target: Option<String>,
}

/// Kind of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "kebab-case")]
pub enum TroubleKind {
    /// A task failed.
    Failed,
    /// Work was interrupted by a more important task.
    Interrupted,
    /// The executive met a fault: an error in an expression, a limit, a stray answer.
    Fault,
    /// A target that was planned or new is in no plan.
    LeftOut,
    /// The flight ended in failure.
    Ended,
}

/// Failures, interruptions and faults, kept in memory and grown with the record. Bound: each effect is read once.
#[derive(Default)]
pub(super) struct TroubleIndex {
    read_to: i64,
    /// By time.
    entries: Vec<Trouble>,
}

impl TroubleIndex {
    /// Returns the number of the last effect that was read.
    pub(super) fn read_to(&self) -> i64 {
        self.read_to
    }

    /// Returns the entries up to an instant.
    pub(super) fn until(&self, until: i64) -> &[Trouble] {
        let end = self.entries.partition_point(|entry| entry.t_ns <= until);
        self.entries.get(..end).unwrap_or_default()
    }

    /// Reads effects up to `last`. Of the tasks that one decision interrupts at an instant, the first is kept.
    pub(super) fn refresh(&mut self, connection: &Connection, last: i64) -> rusqlite::Result<()> {
        let sql = "SELECT t_ns, kind, task, to_state, subject, text FROM effect WHERE id > ?1 AND id <= ?2 AND (kind = ?3 \
                   OR (kind = 'transition' AND (outcome = 'failure' OR to_state = 'interrupted'))) ORDER BY id";
        let mut statement = connection.prepare_cached(sql)?;
        let mut rows = statement.query((self.read_to, last, FAULT))?;
        while let Some(row) = rows.next()? {
            let word: String = row.get(1)?;
            let state: Option<String> = row.get(3)?;
            let kind = match (word.as_str(), state.as_deref()) {
                (FAULT, _) => TroubleKind::Fault,
                (_, Some("interrupted")) => TroubleKind::Interrupted,
                _ => TroubleKind::Failed,
            };
            let trouble = Trouble {
                t_ns: row.get(0)?,
                kind,
                subject: row.get::<_, Option<String>>(4)?.unwrap_or_default(),
                cause: row.get::<_, Option<String>>(5)?.unwrap_or_default(),
                task: task_number(row, 2)?,
                target: None,
            };
            let is_same = |before: &Trouble| {
                kind == TroubleKind::Interrupted
                    && (before.t_ns, before.kind, &before.cause) == (trouble.t_ns, kind, &trouble.cause)
            };
            if !self.entries.last().is_some_and(is_same) {
                self.entries.push(trouble);
            }
        }
        self.read_to = self.read_to.max(last);
        Ok(())
    }
}
