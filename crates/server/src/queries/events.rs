//! `/api/events`: the log of everything that went out, with its causes.

use crate::answer::Answer;
use crate::index::task_number;
use crate::record::Reader;
use rusqlite::types::Value;
use rusqlite::{Row, params_from_iter};
use serde::{Deserialize, Serialize};

/// Rows in one answer unless asked otherwise.
const LIMIT_DEFAULT: usize = 200;
/// Rows in one answer at most.
const LIMIT_MAX: usize = 5_000;

/// Parameters.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EventsQuery {
    from: Option<i64>,
    to: Option<i64>,
    /// Kinds of effects, by comma.
    kind: Option<String>,
    task: Option<i64>,
    /// A text to find in subject or text.
    find: Option<String>,
    limit: Option<usize>,
}

/// The answer: the last rows of the time asked for, oldest first.
#[derive(Debug, Serialize)]
pub(crate) struct Events {
    events: Vec<EventRow>,
    /// True when older rows of that time were left out.
    more: bool,
}

/// One effect.
#[derive(Debug, Serialize)]
pub(crate) struct EventRow {
    pub(crate) id: i64,
    pub(crate) t_ns: i64,
    pub(crate) kind: String,
    pub(crate) task: Option<u64>,
    pub(crate) from_state: Option<String>,
    pub(crate) to_state: Option<String>,
    pub(crate) outcome: Option<String>,
    pub(crate) subject: Option<String>,
    pub(crate) text: Option<String>,
    pub(crate) place: Option<String>,
}

/// The columns that [`EventRow::read`] reads, in its order.
pub(crate) const COLUMNS: &str = "id, t_ns, kind, task, from_state, to_state, outcome, subject, text, place";

impl EventRow {
    /// Reads a row of [`COLUMNS`].
    pub(crate) fn read(row: &Row<'_>) -> Result<EventRow, rusqlite::Error> {
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

/// Answers `/api/events`.
pub(crate) fn events(reader: &Reader, query: &EventsQuery) -> Answer<Events> {
    let limit = query.limit.unwrap_or(LIMIT_DEFAULT).clamp(1, LIMIT_MAX);
    let mut sql = format!("SELECT {COLUMNS} FROM effect WHERE t_ns BETWEEN ? AND ?");
    let mut values: Vec<Value> = vec![query.from.unwrap_or(i64::MIN).into(), query.to.unwrap_or(i64::MAX).into()];
    if let Some(kinds) = query.kind.as_deref().filter(|kinds| !kinds.is_empty()) {
        let kinds: Vec<Value> = kinds.split(',').map(|kind| Value::from(kind.trim().to_owned())).collect();
        sql.push_str(&format!(" AND kind IN ({})", vec!["?"; kinds.len()].join(", ")));
        values.extend(kinds);
    }
    if let Some(task) = query.task {
        sql.push_str(" AND task = ?");
        values.push(task.into());
    }
    if let Some(find) = query.find.as_deref().filter(|find| !find.is_empty()) {
        sql.push_str(" AND (instr(lower(subject), lower(?)) > 0 OR instr(lower(text), lower(?)) > 0)");
        values.extend([Value::from(find.to_owned()), Value::from(find.to_owned())]);
    }
    sql.push_str(&format!(" ORDER BY id DESC LIMIT {}", limit.saturating_add(1)));
    let mut statement = reader.connection.prepare_cached(&sql)?;
    let rows = statement.query_map(params_from_iter(values), EventRow::read)?;
    let mut events: Vec<EventRow> = rows.collect::<Result<_, _>>()?;
    let more = events.len() > limit;
    events.truncate(limit);
    events.reverse();
    Ok(Events { events, more })
}
