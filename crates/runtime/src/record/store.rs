//! The file under the recorder: rows in grouped transactions, each of which ends with a seal, and what to do when a write
//! fails.

use super::checkpoints::Checkpoints;
use super::closing;
use super::difference::RowDifference;
use super::schema::{self, write_error};
use super::seal::{Link, Sealer};
use super::tables::{TABLES, Table};
use crate::error::RecordError;
use crate::limits::{GROUP_BATCHES_MAX, GROUP_MILLISECONDS_MAX};
use apex_model::time::Time;
use rusqlite::types::{ToSqlOutput, ValueRef};
use rusqlite::{Connection, params, params_from_iter};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Bytes of one page of the file: SQLite's default, with which the file is made.
const PAGE_BYTES: u64 = 4096;

/// A cell of a row, as SQLite stores it.
pub(super) type Cell<'c> = ValueRef<'c>;

/// A text, or nothing.
pub(super) fn text(text: Option<&str>) -> Cell<'_> {
    text.map_or(ValueRef::Null, |text| ValueRef::Text(text.as_bytes()))
}

/// A whole number, or nothing.
pub(super) fn whole<'c>(number: Option<i64>) -> Cell<'c> {
    number.map_or(ValueRef::Null, ValueRef::Integer)
}

/// A real number, or nothing.
pub(super) fn real<'c>(number: Option<f64>) -> Cell<'c> {
    number.map_or(ValueRef::Null, ValueRef::Real)
}

/// Destination of the recorder's rows: they are stored, or compared with stored ones.
pub(super) trait RowStore: Send {
    /// Appends a row. Tables whose rows are numbered get their first column here. `doing` is for the message if it fails.
    fn insert(&mut self, doing: &str, table: Table, cells: &[Cell<'_>]) -> Result<(), RecordError>;

    /// The instant that is being stored, for messages and seals.
    fn set_now(&mut self, now: Time);

    /// Counts a whole step; commits if the group is large or old enough.
    fn end_step(&mut self) -> Result<(), RecordError>;

    /// Commits the open group, if there is one.
    fn commit(&mut self) -> Result<(), RecordError>;

    /// Closes the file: one file without companions, sealed as a whole.
    fn close(&mut self) -> Result<(), RecordError>;

    /// Something that cannot be turned into bytes; nothing is stored after it.
    fn unstorable(&mut self, what: &str, reason: String) -> RecordError;

    /// The file.
    fn path(&self) -> &Path;

    /// The first row that differs from the stored one; for stores that compare.
    fn difference(&self) -> Option<&RowDifference> {
        None
    }
}

/// Durability of a committed group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Durability {
    /// Survives the end of the program, however it comes. A power cut may take the last groups, never the order.
    #[default]
    Program,
    /// Survives a power cut as well: each commit waits for the disk.
    Power,
}

impl Durability {
    fn pragma(self) -> &'static str {
        match self {
            Durability::Program => "PRAGMA synchronous = NORMAL",
            Durability::Power => "PRAGMA synchronous = FULL",
        }
    }
}

/// An open record file.
pub(super) struct Store {
    path: PathBuf,
    /// None after it was closed.
    connection: Option<Connection>,
    /// Copies what is committed into the main file from time to time.
    checkpoints: Option<Checkpoints>,
    group: Option<Group>,
    sealer: Sealer,
    link: Link,
    counts: [u64; TABLES],
    inserts: [String; TABLES],
    /// A write failed; nothing is written after it.
    broken: bool,
    now: Time,
}

/// An open transaction.
struct Group {
    began: Instant,
    batches: u32,
}

impl Store {
    pub(super) fn create(path: &Path, bytes_max: Option<u64>, durability: Durability) -> Result<Store, RecordError> {
        let connection = schema::create(path)?;
        connection.execute_batch(durability.pragma()).map_err(|error| write_error(path, "opening it", error))?;
        if let Some(bytes) = bytes_max {
            let pages = (bytes / PAGE_BYTES).clamp(1, u64::from(u32::MAX - 1));
            connection
                .query_row(&format!("PRAGMA max_page_count = {pages}"), [], |_| Ok(()))
                .map_err(|error| write_error(path, "setting its largest size", error))?;
        }
        connection.set_prepared_statement_cache_capacity(2 * TABLES);
        Ok(Store {
            path: path.to_path_buf(),
            connection: Some(connection),
            checkpoints: Checkpoints::begin(path),
            group: None,
            sealer: Sealer::default(),
            link: Link::default(),
            counts: [0; TABLES],
            inserts: super::tables::ALL.map(Table::insert),
            broken: false,
            now: Time::ZERO,
        })
    }

    fn open_group(&mut self) -> rusqlite::Result<()> {
        if self.group.is_none() {
            let connection = self.connection.as_ref().ok_or(rusqlite::Error::InvalidQuery)?;
            connection.prepare_cached("BEGIN IMMEDIATE")?.execute([])?;
            self.group = Some(Group { began: Instant::now(), batches: 0 });
        }
        Ok(())
    }

    fn store(&mut self, table: Table, cells: &[Cell<'_>]) -> rusqlite::Result<()> {
        self.open_group()?;
        let index = table.index();
        let (Some(connection), Some(sql), Some(count)) =
            (&self.connection, self.inserts.get(index), self.counts.get_mut(index))
        else {
            return Err(rusqlite::Error::InvalidQuery);
        };
        *count += 1;
        let position = table.is_numbered().then_some(ValueRef::Integer(count.cast_signed()));
        let row = || position.into_iter().chain(cells.iter().copied());
        connection.prepare_cached(sql)?.execute(params_from_iter(row().map(ToSqlOutput::Borrowed)))?;
        self.sealer.row(index, row());
        Ok(())
    }

    fn seal_and_commit(&mut self) -> rusqlite::Result<()> {
        let Some(connection) = &self.connection else { return Ok(()) };
        if !self.sealer.is_empty() {
            let batch = self.counts.get(Table::Batch.index()).copied().unwrap_or(0).cast_signed();
            let seal = self.sealer.seal(self.link, self.now.0, batch);
            let sql = "INSERT INTO seal VALUES (?1, ?2, ?3, ?4, ?5)";
            let row = params![seal.id, seal.t_ns, seal.batch, seal.count_bytes(), seal.chain];
            connection.prepare_cached(sql)?.execute(row)?;
            self.link = seal.link();
        }
        connection.prepare_cached("COMMIT")?.execute([]).map(|_| ())
    }

    /// Keeps what was committed and writes no more: half a step in the record would be worse than its end.
    fn give_up(&mut self, doing: &str, error: rusqlite::Error) -> RecordError {
        self.abandon_group();
        write_error(&self.path, &format!("{doing} at {}", self.now), error)
    }

    fn abandon_group(&mut self) {
        self.broken = true;
        self.group = None;
        if let Some(connection) = self.connection.as_ref().filter(|connection| !connection.is_autocommit()) {
            let _ = connection.execute_batch("ROLLBACK");
        }
    }

    fn unwritable(&self, doing: &str, reason: String) -> RecordError {
        RecordError::Unwritable { path: self.path.clone(), doing: format!("{doing} at {}", self.now), reason }
    }
}

impl RowStore for Store {
    fn insert(&mut self, doing: &str, table: Table, cells: &[Cell<'_>]) -> Result<(), RecordError> {
        if self.broken {
            return Err(self.unwritable(doing, "an earlier write failed".into()));
        }
        self.store(table, cells).map_err(|error| self.give_up(doing, error))
    }

    fn set_now(&mut self, now: Time) {
        self.now = now;
    }

    fn end_step(&mut self) -> Result<(), RecordError> {
        let Some(group) = &mut self.group else { return Ok(()) };
        group.batches += 1;
        let due = group.batches >= GROUP_BATCHES_MAX || group.began.elapsed().as_millis() >= GROUP_MILLISECONDS_MAX;
        if due { self.commit() } else { Ok(()) }
    }

    fn commit(&mut self) -> Result<(), RecordError> {
        if self.group.take().is_none() || self.broken {
            return Ok(());
        }
        self.seal_and_commit().map_err(|error| self.give_up("committing", error))
    }

    fn close(&mut self) -> Result<(), RecordError> {
        self.commit()?;
        self.checkpoints = None;
        let Some(connection) = self.connection.take() else { return Ok(()) };
        closing::close(connection, &self.path)
    }

    fn unstorable(&mut self, what: &str, reason: String) -> RecordError {
        self.abandon_group();
        self.unwritable(&format!("turning {what} into bytes"), reason)
    }

    fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Store {
    /// Keeps the stored steps, also if the record was never finished; it then states that it is incomplete.
    fn drop(&mut self) {
        let _ = self.commit();
    }
}
