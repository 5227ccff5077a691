//! The log: everything that went out, with its causes.

use super::effect_index::EffectSearch;
use super::index::task_number;
use super::{RecordView, for_reading, for_writing, last_effect};
use crate::error::RecordError;
use rusqlite::types::Value;
use rusqlite::{Row, params_from_iter};
use serde::Serialize;
use std::time::{Duration, Instant};

/// Maximum number of rows of an answer, unless the query states one.
const LIMIT_DEFAULT: usize = 200;
/// Maximum number of rows of any answer.
const LIMIT_MAX: usize = 5_000;

/// Effects that one statement of a search reads.
const JOINED_EFFECTS_MAX: i64 = 4_096;
/// Time that a query spends on an index that is behind.
const EVENTS_BUDGET: Duration = Duration::from_millis(30);

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
        let mut events = match query.task {
            // SQLite has an index of the effects of a task.
            Some(_) => self.selected(query, (i64::MIN, i64::MAX), limit + 1)?,
            None => self.found(query, limit + 1)?,
        };
        let more = events.len() > limit;
        events.truncate(limit);
        events.reverse();
        Ok(Events { events, more })
    }

    fn selected(&self, query: &EventsQuery, range: (i64, i64), count: usize) -> Result<Vec<EventRow>, RecordError> {
        let (sql, values) = select(query, range, count);
        self.query("the effects", |connection| {
            connection.prepare_cached(&sql)?.query_map(params_from_iter(values), EventRow::read)?.collect()
        })
    }

    /// The newest effects that a query selects, at most `count`: those that the index does not have yet, then the blocks that
    /// may hold what is wanted.
    fn found(&self, query: &EventsQuery, count: usize) -> Result<Vec<EventRow>, RecordError> {
        self.index_effects(EVENTS_BUDGET)?;
        let wanted = EffectSearch {
            from_ns: query.from_ns.unwrap_or(i64::MIN),
            to_ns: query.to_ns.unwrap_or(i64::MAX),
            kinds: &query.kinds,
            find: query.find.as_deref().filter(|find| !find.is_empty()),
        };
        let (seen, ranges) = {
            let index = for_reading(&self.indexes.effects);
            (index.seen(), joined(index.blocks(&wanted)))
        };
        let mut events = self.selected(query, (seen + 1, i64::MAX), count)?;
        for range in ranges {
            if events.len() >= count {
                break;
            }
            events.extend(self.selected(query, range, count - events.len())?);
        }
        Ok(events)
    }

    /// Reads effects into the index of the log, for about `budget`; what is not in it is searched row by row. True if all are in.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn index_effects(&self, budget: Duration) -> Result<bool, RecordError> {
        self.reader.check_growth()?;
        let (began, connection) = (Instant::now(), &self.reader.connection);
        let damaged = |error| self.reader.damaged("the effects", error);
        let last = last_effect(connection).map_err(damaged)?;
        while for_reading(&self.indexes.effects).seen() < last {
            if began.elapsed() > budget {
                return Ok(false);
            }
            for_writing(&self.indexes.effects).refresh(connection, last).map_err(damaged)?;
        }
        Ok(true)
    }
}

/// Joins ranges that follow one another, downwards, up to a bound.
fn joined(ranges: impl Iterator<Item = (i64, i64)>) -> Vec<(i64, i64)> {
    let mut all: Vec<(i64, i64)> = Vec::new();
    for (first, last) in ranges {
        match all.last_mut() {
            Some(above) if above.0 == last + 1 && above.1 - first < JOINED_EFFECTS_MAX => above.0 = first,
            _ => all.push((first, last)),
        }
    }
    all
}

/// The statement of a query among effects `first..=last`, and its values; it selects at most `count` rows, the newest first.
fn select(query: &EventsQuery, (first, last): (i64, i64), count: usize) -> (String, Vec<Value>) {
    let mut sql = format!("SELECT {COLUMNS} FROM effect WHERE id BETWEEN ? AND ? AND t_ns BETWEEN ? AND ?");
    let mut values: Vec<Value> = vec![
        first.into(),
        last.into(),
        query.from_ns.unwrap_or(i64::MIN).into(),
        query.to_ns.unwrap_or(i64::MAX).into(),
    ];
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
    sql.push_str(&format!(" ORDER BY id DESC LIMIT {count}"));
    (sql, values)
}
