//! A store that compares: what a replay records again must equal the stored record, row by row.
//!
//! This confirms every column of every derived table, in addition to the effects: words, shapes, track, states of targets, variables,
//! snapshots. Rows that no step derives (facts, sources, notes, the report) are covered by the seals alone.

use super::difference::RowDifference;
use super::reader::RecordReader;
use super::store::{RowStore, SqlValue};
use super::tables::{ALL, TABLES, Table};
use super::writer::{Recorder, TRACK_OF};
use crate::error::RecordError;
use apex_model::library::Library;
use apex_model::time::Time;
use rusqlite::types::Value;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// Number of rows read at one time.
const PAGE_ROWS: usize = 256;
/// Maximum number of characters of a cell that are shown.
const SHOWN_MAX: usize = 300;

/// Tables that a replay can derive again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Derivable {
    /// Situations, states of targets and planning problems: only with the record's mission.
    pub(crate) mission: bool,
    /// True if situations are compared: only for builds with their layout.
    pub(crate) situations: bool,
    /// True if snapshots of agents are compared: only for builds with their layout.
    pub(crate) snapshots: bool,
}

impl Derivable {
    fn has(self, table: Table) -> bool {
        match table {
            Table::Agent | Table::Variable | Table::Batch | Table::Word | Table::Shape | Table::Effects => true,
            Table::Track | Table::Answer => true,
            Table::TargetState | Table::Problem => self.mission,
            Table::Snapshot => self.snapshots,
            Table::Situation => self.mission && self.situations,
            Table::Meta | Table::Source | Table::Note | Table::Target | Table::Report => false,
        }
    }
}

/// Returns a recorder that stores nothing and compares everything with the rows of `reader`.
pub(crate) fn recorder(
    reader: &RecordReader,
    library: &Library,
    derivable: Derivable,
) -> Result<Recorder, RecordError> {
    let vehicle = reader.meta(TRACK_OF)?;
    let last = "SELECT max(id) FROM main.batch";
    let last =
        reader.connection.query_row(last, [], |row| row.get(0)).map_err(|error| reader.damaged("the steps", error));
    let twin = Twin {
        cut_off: if reader.is_complete()? { None } else { last? },
        batch: 0,
        reader: reader.of_agent(reader.agent)?,
        path: reader.path().to_path_buf(),
        derivable,
        pages: std::array::from_fn(|_| Page { next_key: i64::MIN, rows: VecDeque::new() }),
        counts: [0; TABLES],
        difference: None,
    };
    Recorder::with_store(Box::new(twin), library, vehicle.as_deref())
}

/// Compares the rows that it receives with the stored ones.
struct Twin {
    /// Number of the last step of a record that was cut off.
    cut_off: Option<i64>,
    /// Number of the present step.
    batch: i64,
    reader: RecordReader,
    path: PathBuf,
    derivable: Derivable,
    pages: [Page; TABLES],
    counts: [u64; TABLES],
    difference: Option<RowDifference>,
}

/// Stored rows of a table that are still to be compared.
struct Page {
    next_key: i64,
    rows: VecDeque<Vec<Value>>,
}

impl Twin {
    /// Returns the next stored row of a table.
    fn next(&mut self, table: Table) -> Result<Option<Vec<Value>>, RecordError> {
        let Some(page) = self.pages.get_mut(table.index()) else { return Ok(None) };
        if page.rows.is_empty() {
            let broken = |error| self.reader.damaged(table.name(), error);
            let sql = format!(
                "SELECT * FROM main.{0} WHERE {1} > ?1 ORDER BY {1} LIMIT {PAGE_ROWS}",
                table.name(),
                table.column(0)
            );
            let mut statement = self.reader.connection.prepare_cached(&sql).map_err(broken)?;
            let columns = statement.column_count();
            let mut rows = statement.query([page.next_key]).map_err(broken)?;
            while let Some(row) = rows.next().map_err(broken)? {
                page.next_key = row.get(0).map_err(broken)?;
                let cells = (0..columns).map(|column| row.get::<_, Value>(column)).collect::<Result<_, _>>();
                page.rows.push_back(cells.map_err(broken)?);
            }
        }
        Ok(page.rows.pop_front())
    }

    /// Returns true for the rows that are written last in a step, in the last step of a record that was cut off: a step is committed before
    /// its commands leave and before a planner works, and these rows follow.
    fn may_lack(&self, table: Table) -> bool {
        self.cut_off == Some(self.batch) && matches!(table, Table::TargetState | Table::Snapshot | Table::Situation)
    }

    fn differ(&mut self, table: Table, column: &'static str, recorded: Option<String>, replayed: Option<String>) {
        let number = self.counts.get(table.index()).copied().unwrap_or(0);
        let row = format!("{} {number}", table.row_word());
        self.difference.get_or_insert(RowDifference { row, column, recorded, replayed });
    }
}

impl RowStore for Twin {
    fn insert(&mut self, _: &str, table: Table, cells: &[SqlValue<'_>]) -> Result<(), RecordError> {
        if !self.derivable.has(table) || self.difference.is_some() {
            return Ok(());
        }
        if let Some(count) = self.counts.get_mut(table.index()) {
            *count += 1;
        }
        if let (Table::Batch, Some(SqlValue::Integer(number))) = (table, cells.first()) {
            self.batch = *number;
        }
        let Some(stored) = self.next(table)? else {
            if self.may_lack(table) {
                return Ok(());
            }
            let made: Vec<String> =
                cells.iter().map(|cell| shown(&Value::try_from(*cell).unwrap_or(Value::Null))).collect();
            self.differ(table, "", None, Some(made.join(", ")));
            return Ok(());
        };
        let numbered = usize::from(table.is_numbered());
        for (index, (stored, made)) in stored.iter().skip(numbered).zip(cells).enumerate() {
            let made = as_stored(*made);
            if *stored != made {
                self.differ(table, table.column(index + numbered), Some(shown(stored)), Some(shown(&made)));
                return Ok(());
            }
        }
        Ok(())
    }

    fn set_now(&mut self, _: Time) {}

    fn end_step(&mut self) -> Result<(), RecordError> {
        Ok(())
    }

    fn commit(&mut self) -> Result<(), RecordError> {
        Ok(())
    }

    /// Reports the first stored row that the replay did not make, if no difference was found before.
    fn close(&mut self) -> Result<(), RecordError> {
        for table in ALL {
            if self.difference.is_none()
                && self.derivable.has(table)
                && let Some(stored) = self.next(table)?
            {
                if let Some(count) = self.counts.get_mut(table.index()) {
                    *count += 1;
                }
                let cells: Vec<String> = stored.iter().map(shown).collect();
                self.differ(table, "", Some(cells.join(", ")), None);
            }
        }
        Ok(())
    }

    fn unstorable(&mut self, what: &str, reason: String) -> RecordError {
        RecordError::Unwritable { path: self.path.clone(), doing: format!("turning {what} into bytes"), reason }
    }

    fn path(&self) -> &Path {
        &self.path
    }

    fn difference(&self) -> Option<&RowDifference> {
        self.difference.as_ref()
    }
}

/// Returns a cell in the form in which SQLite returns it.
fn as_stored(cell: SqlValue<'_>) -> Value {
    match Value::try_from(cell) {
        Ok(Value::Real(real)) if real.is_nan() => Value::Null,
        Ok(Value::Real(0.0)) => Value::Real(0.0),
        Ok(value) => value,
        Err(_) => Value::Null,
    }
}

/// Returns a cell as text in one line.
fn shown(cell: &Value) -> String {
    let text = match cell {
        Value::Null => return "nothing".into(),
        Value::Integer(number) => return number.to_string(),
        Value::Real(real) => return real.to_string(),
        Value::Blob(bytes) => return format!("{} bytes", bytes.len()),
        Value::Text(text) => text,
    };
    let mut shown: String = text.chars().take(SHOWN_MAX).collect();
    if shown.len() < text.len() {
        shown.push_str("..");
    }
    shown
}
