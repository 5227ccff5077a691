//! Failures, interruptions and faults: the entries of the trouble rail. (english: allow)

use super::RecordView;
use super::index::task_number;
use crate::error::RecordError;
use rusqlite::Connection;
use serde::Serialize;

/// Kind of the effects that report faults.
const FAULT: &str = "trouble"; // english: allow
/// Maximum number of entries of an answer; the latest are kept.
const TROUBLES_MAX: usize = 500;

/// Failures, interruptions and faults up to an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Troubles {
    /// By time.
    pub troubles: Vec<Trouble>,
    /// Number of older entries that the limit leaves out.
    pub left_out: usize,
}

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

impl RecordView {
    /// The entries up to mission time `at_ns` (nanoseconds; none means the record's end).
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn troubles(&mut self, at_ns: Option<i64>) -> Result<Troubles, RecordError> {
        let mission = self.mission(at_ns)?;
        let targets = self.targets(at_ns)?.targets;
        let until = at_ns.unwrap_or(i64::MAX);
        let mut troubles = self.query("the effects", |connection| read(connection, until))?;
        for target in targets {
            let mut before = None;
            for change in target.history {
                if change.state == "skipped" && before.as_deref() != Some("skipped") {
                    troubles.push(Trouble {
                        t_ns: change.t_ns,
                        kind: TroubleKind::LeftOut,
                        subject: target.name.clone(),
                        cause: change.detail.unwrap_or_default(),
                        task: None,
                        target: Some(target.id.clone()),
                    });
                }
                before = Some(change.state);
            }
        }
        if let Some(ending) = mission.ending.filter(|ending| ending.failed) {
            let (subject, t_ns) = ("the flight".to_owned(), mission.growth.end_ns);
            let kind = TroubleKind::Ended;
            troubles.push(Trouble { t_ns, kind, subject, cause: ending.reason, task: None, target: None });
        }
        // Stable: what the executive did at one instant keeps its order.
        troubles.sort_by_key(|trouble| trouble.t_ns);
        let left_out = troubles.len().saturating_sub(TROUBLES_MAX);
        troubles.drain(..left_out);
        Ok(Troubles { troubles, left_out })
    }
}

/// Failures, interruptions and faults. Of the tasks that one decision interrupts at an instant, the first is kept.
fn read(connection: &Connection, until: i64) -> rusqlite::Result<Vec<Trouble>> {
    let sql = "SELECT t_ns, kind, task, to_state, subject, text FROM effect WHERE t_ns <= ?1 AND (kind = ?2 \
               OR (kind = 'transition' AND (outcome = 'failure' OR to_state = 'interrupted'))) ORDER BY id";
    let mut statement = connection.prepare_cached(sql)?;
    let mut rows = statement.query((until, FAULT))?;
    let mut troubles: Vec<Trouble> = Vec::new();
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
        let is_same = |last: &Trouble| {
            kind == TroubleKind::Interrupted
                && (last.t_ns, last.kind, &last.cause) == (trouble.t_ns, kind, &trouble.cause)
        };
        if !troubles.last().is_some_and(is_same) {
            troubles.push(trouble);
        }
    }
    Ok(troubles)
}
