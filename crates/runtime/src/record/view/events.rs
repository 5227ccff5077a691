//! The log: everything that went out, with its causes.

use super::RecordView;
use super::index::task_number;
use crate::error::RecordError;
use rusqlite::types::Value;
use rusqlite::{Row, params_from_iter};
use serde::Serialize;

/// Maximum number of rows of an answer, unless the query states one.
const LIMIT_DEFAULT: usize = 200;
/// Maximum number of rows of any answer.
const LIMIT_MAX: usize = 5_000;

/// A query of the log.
#[derive(Clone, Debug, Default)]
pub struct EventsQuery {
    /// Earliest mission time in nanoseconds; default: the record's start.
    pub from_ns: Option<i64>,
    /// Latest mission time in nanoseconds; default: the record's end.
    pub to_ns: Option<i64>,
    /// Kinds of effects; empty selects all.
    pub kinds: Vec<String>,
    /// Only effects of this task.
    pub task: Option<u64>,
    /// Only effects whose subject or text contains this, in any case.
    pub find: Option<String>,
    /// Maximum number of rows; default 200, at most 5,000.
    pub limit: Option<usize>,
}

/// The last effects of the time asked for, oldest first.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Events {
    /// The effects.
    pub events: Vec<EventRow>,
    /// True if older effects of that time are left out.
    pub more: bool,
}

/// An effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct EventRow {
    /// Its number in the record, from 1.
    pub id: i64,
    /// Mission time in nanoseconds.
    pub t_ns: i64,
    /// `transition`, `command`, `solve`, ..: `docs/reference/flight-record.md` lists them.
    pub kind: String,
    /// The task's number, if it is about one.
    pub task: Option<u64>,
    /// State before, for `transition`.
    pub from_state: Option<String>,
    /// State after, for `transition`.
    pub to_state: Option<String>,
    /// `success`, `failure` or `cut`, for the transition to `terminated`.
    pub outcome: Option<String>,
    /// The goal, form or variable.
    pub subject: Option<String>,
    /// The cause, or what was said, without the place.
    pub text: Option<String>,
    /// `file:line:column` of the clause of PDL.
    pub place: Option<String>,
}

const COLUMNS: &str = "id, t_ns, kind, task, from_state, to_state, outcome, subject, text, place";

impl EventRow {
    /// Reads a row of [`COLUMNS`].
    fn read(row: &Row<'_>) -> rusqlite::Result<EventRow> {
        let text =
            |column: usize| row.get::<_, Option<String>>(column).map(|text| text.filter(|text| !text.is_empty()));
        Ok(EventRow {
            id: row.get(0)?,
            t_ns: row.get(1)?,
            kind: row.get(2)?,
            task: task_number(row, 3)?,
            from_state: text(4)?,
            to_state: text(5)?,
            outcome: text(6)?,
            subject: text(7)?,
            text: text(8)?,
            place: text(9)?,
        })
    }
}

impl RecordView {
    /// The effects that a query selects.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn events(&self, query: &EventsQuery) -> Result<Events, RecordError> {
        let limit = query.limit.unwrap_or(LIMIT_DEFAULT).clamp(1, LIMIT_MAX);
        let (sql, values) = select(query, limit);
        let mut events: Vec<EventRow> = self.query("the effects", |connection| {
            connection.prepare_cached(&sql)?.query_map(params_from_iter(values), EventRow::read)?.collect()
        })?;
        let more = events.len() > limit;
        events.truncate(limit);
        events.reverse();
        Ok(Events { events, more })
    }
}

/// The statement of a query and its values; it selects one row more than `limit`.
fn select(query: &EventsQuery, limit: usize) -> (String, Vec<Value>) {
    let mut sql = format!("SELECT {COLUMNS} FROM effect WHERE t_ns BETWEEN ? AND ?");
    let mut values: Vec<Value> = vec![query.from_ns.unwrap_or(i64::MIN).into(), query.to_ns.unwrap_or(i64::MAX).into()];
    if !query.kinds.is_empty() {
        sql.push_str(&format!(" AND kind IN ({})", vec!["?"; query.kinds.len()].join(", ")));
        values.extend(query.kinds.iter().map(|kind| Value::from(kind.clone())));
    }
    if let Some(task) = query.task {
        sql.push_str(" AND task = ?");
        values.push(task.cast_signed().into());
    }
    if let Some(find) = query.find.as_deref().filter(|find| !find.is_empty()) {
        sql.push_str(" AND (instr(lower(subject), lower(?)) > 0 OR instr(lower(text), lower(?)) > 0)");
        values.extend([Value::from(find.to_owned()), Value::from(find.to_owned())]);
    }
    sql.push_str(&format!(" ORDER BY id DESC LIMIT {}", limit.saturating_add(1)));
    (sql, values)
}
