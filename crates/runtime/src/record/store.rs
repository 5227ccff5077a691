//! The file of the recorder: rows in grouped transactions, each of which ends with a seal. A write that fails before the flight has begun
//! is an error; during a flight the newest steps stay in memory until the disk accepts them.

use super::checkpoints::Checkpoints;
use super::closing;
use super::difference::RowDifference;
use super::disk_news::{DiskNews, RecordingLoss, reason_of};
use super::kept_rows::KeptRows;
use super::schema::{self, limit_bytes, write_error};
use super::seal::{ChainPosition, Sealer};
use super::segments::{self, SegmentPlaces};
use super::signature::{self, SigningKey};
use super::tables::{TABLES, Table};
use crate::error::RecordError;
use crate::limits::{GROUP_BATCHES_MAX, GROUP_MILLISECONDS_MAX, RECORDING_RETRY_INTERVAL};
use apex_model::time::Time;
use rusqlite::types::{ToSqlOutput, ValueRef};
use rusqlite::{Connection, params, params_from_iter};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A cell of a row, as SQLite stores it.
pub(super) type SqlValue<'c> = ValueRef<'c>;

/// Returns a text, or nothing.
pub(super) fn text(text: Option<&str>) -> SqlValue<'_> {
    text.map_or(ValueRef::Null, |text| ValueRef::Text(text.as_bytes()))
}

/// Returns a real number, or nothing.
pub(super) fn real<'c>(number: Option<f64>) -> SqlValue<'c> {
    number.map_or(ValueRef::Null, ValueRef::Real)
}

/// Destination of the recorder's rows: stores them, or compares them with stored ones.
pub(super) trait RowStore: Send {
    /// Appends a row. Tables with numbered rows get their first column here. `doing` describes the action in the error message.
    fn insert(&mut self, doing: &'static str, table: Table, cells: &[SqlValue<'_>]) -> Result<(), RecordError>;

    /// Sets the instant that is being stored, for messages and seals.
    fn set_now(&mut self, now: Time);

    /// Counts a whole step; commits if the group is large or old enough.
    fn end_step(&mut self) -> Result<(), RecordError>;

    /// Commits the open group, if there is one.
    fn commit(&mut self) -> Result<(), RecordError>;

    /// Closes the file: one file without companions, sealed as a whole.
    fn close(&mut self) -> Result<(), RecordError>;

    /// Returns the error for a value that cannot be converted to bytes; nothing is stored afterwards.
    fn unstorable(&mut self, what: &str, reason: String) -> RecordError;

    /// Returns the file.
    fn path(&self) -> &Path;

    /// Changes the largest size of the file.
    fn set_bytes_max(&mut self, _: u64) -> Result<(), RecordError> {
        Ok(())
    }

    /// Signs the file when it is closed.
    fn sign_with(&mut self, _: SigningKey) {}

    /// From now on reports failed writes as messages ([`RowStore::take_news`]) instead of errors.
    fn outlive_the_disk(&mut self) {}

    /// Takes the next message about the disk.
    fn take_news(&mut self) -> Option<DiskNews> {
        None
    }

    /// Returns the first row that differs from the stored one; `None` for stores that cannot be compared.
    fn difference(&self) -> Option<&RowDifference> {
        None
    }
}

/// Durability of a committed group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Durability {
    /// Survives the end of the program, however it ends. A power cut may lose the last groups, but never their order.
    #[default]
    Program,
    /// Survives a power cut as well: each commit waits for the disk.
    Power,
}

impl Durability {
    pub(super) fn pragma(self) -> &'static str {
        match self {
            Durability::Program => "PRAGMA synchronous = NORMAL",
            Durability::Power => "PRAGMA synchronous = FULL",
        }
    }
}

/// An open record file.
pub(super) struct Store {
    pub(super) path: PathBuf,
    /// `None` after the file was closed.
    pub(super) connection: Option<Connection>,
    /// Copies committed rows into the main file from time to time.
    pub(super) checkpoints: Option<Checkpoints>,
    pub(super) group: Option<OpenTransaction>,
    pub(super) sealer: Sealer,
    /// The last committed group.
    pub(super) link: ChainPosition,
    /// Number of the last committed step.
    pub(super) committed_batch: i64,
    /// Instant of that step; `None` before the first.
    pub(super) committed_at: Option<Time>,
    pub(super) counts: [u64; TABLES],
    inserts: [String; TABLES],
    /// True after a failed write; nothing is written afterwards.
    broken: bool,
    now: Time,
    /// Rows that are not committed.
    pub(super) kept: KeptRows,
    outlives_disk: bool,
    /// A write has failed during the flight.
    pub(super) loss: Option<RecordingLoss>,
    pub(super) news: Vec<DiskNews>,
    pub(super) durability: Durability,
    pub(super) places: SegmentPlaces,
    signing_key: Option<SigningKey>,
}

/// An open transaction.
pub(super) struct OpenTransaction {
    began: Instant,
    batches: u32,
}

impl Store {
    pub(super) fn create(
        path: &Path,
        places: SegmentPlaces,
        durability: Durability,
        kept_bytes_max: usize,
    ) -> Result<Store, RecordError> {
        segments::outlive_file_size_limits();
        let connection = schema::create(path)?;
        connection.execute_batch(durability.pragma()).map_err(|error| write_error(path, "opening it", error))?;
        if let Some(bytes) = places.bytes_max {
            limit_bytes(&connection, path, bytes)?;
        }
        connection.set_prepared_statement_cache_capacity(2 * TABLES);
        Ok(Store {
            path: path.to_path_buf(),
            connection: Some(connection),
            checkpoints: Checkpoints::begin(path),
            group: None,
            sealer: Sealer::default(),
            link: ChainPosition::default(),
            committed_batch: 0,
            committed_at: None,
            counts: [0; TABLES],
            inserts: super::tables::ALL.map(Table::insert),
            broken: false,
            now: Time::ZERO,
            kept: KeptRows::new(kept_bytes_max),
            outlives_disk: false,
            loss: None,
            news: Vec::new(),
            durability,
            places,
            signing_key: None,
        })
    }

    fn open_group(&mut self) -> rusqlite::Result<()> {
        if self.group.is_none() {
            let connection = self.connection.as_ref().ok_or(rusqlite::Error::InvalidQuery)?;
            connection.prepare_cached("BEGIN IMMEDIATE")?.execute([])?;
            self.group = Some(OpenTransaction { began: Instant::now(), batches: 0 });
        }
        Ok(())
    }

    /// Writes a row into the open group.
    pub(super) fn store<'c>(
        &mut self,
        table: Table,
        row: impl Iterator<Item = SqlValue<'c>> + Clone,
    ) -> rusqlite::Result<()> {
        self.open_group()?;
        let index = table.index();
        let (Some(connection), Some(sql)) = (&self.connection, self.inserts.get(index)) else {
            return Err(rusqlite::Error::InvalidQuery);
        };
        connection.prepare_cached(sql)?.execute(params_from_iter(row.clone().map(ToSqlOutput::Borrowed)))?;
        self.sealer.row(index, row);
        Ok(())
    }

    fn seal_and_commit(&mut self) -> rusqlite::Result<()> {
        let batch = self.counts.get(Table::Batch.index()).copied().unwrap_or(0).cast_signed();
        self.seal_and_commit_as((batch, self.now))
    }

    /// Commits the open group with a seal that says that this step is its last.
    pub(super) fn seal_and_commit_as(&mut self, (batch, now): (i64, Time)) -> rusqlite::Result<()> {
        let Some(connection) = &self.connection else { return Ok(()) };
        let mut link = self.link;
        if !self.sealer.is_empty() {
            let seal = self.sealer.seal(self.link, now.0, batch);
            let sql = "INSERT INTO seal VALUES (?1, ?2, ?3, ?4, ?5)";
            let row = params![seal.id, seal.t_ns, seal.batch, seal.count_bytes(), seal.chain];
            connection.prepare_cached(sql)?.execute(row)?;
            link = seal.link();
        }
        connection.prepare_cached("COMMIT")?.execute([])?;
        // A group whose commit fails is not part of the chain.
        if batch > self.committed_batch {
            self.committed_at = Some(now);
        }
        (self.link, self.committed_batch) = (link, batch);
        Ok(())
    }

    /// Handles a failed write. During a flight its steps stay in memory; before the flight nothing more is written, because half a step
    /// in the record would be worse than its end.
    fn failed(&mut self, doing: &str, error: rusqlite::Error) -> Result<(), RecordError> {
        let error = write_error(&self.path, &format!("{doing} at {}", self.now), error);
        self.abandon_group();
        if !self.outlives_disk {
            self.broken = true;
            return Err(error);
        }
        if self.loss.is_none() {
            let reason = reason_of(&error);
            self.news.push(DiskNews::Lost(reason.clone()));
            self.loss = Some(RecordingLoss::new(self.now, reason));
        }
        Ok(())
    }

    pub(super) fn next_position<'c>(&mut self, table: Table) -> Option<SqlValue<'c>> {
        let count = self.counts.get_mut(table.index())?;
        *count += 1;
        table.is_numbered().then_some(ValueRef::Integer(count.cast_signed()))
    }

    pub(super) fn abandon_group(&mut self) {
        self.group = None;
        self.sealer.clear();
        if let Some(connection) = self.connection.as_ref().filter(|connection| !connection.is_autocommit()) {
            let _ = connection.execute_batch("ROLLBACK");
        }
    }

    fn unwritable(&self, doing: &str, reason: String) -> RecordError {
        RecordError::Unwritable { path: self.path.clone(), doing: format!("{doing} at {}", self.now), reason }
    }
}

impl RowStore for Store {
    fn insert(&mut self, doing: &'static str, table: Table, cells: &[SqlValue<'_>]) -> Result<(), RecordError> {
        if self.broken {
            return Err(self.unwritable(doing, "an earlier write failed".into()));
        }
        let position = self.next_position(table);
        let row = position.into_iter().chain(cells.iter().copied());
        self.kept.row(table, row.clone());
        if self.loss.is_some() {
            return Ok(());
        }
        self.store(table, row).or_else(|error| self.failed(doing, error))
    }

    fn set_now(&mut self, now: Time) {
        self.now = now;
    }

    fn end_step(&mut self) -> Result<(), RecordError> {
        self.kept.end_step(self.loss.is_some());
        if self.loss.is_some() {
            return self.commit();
        }
        let Some(group) = &mut self.group else { return Ok(()) };
        group.batches += 1;
        let due = group.batches >= GROUP_BATCHES_MAX || group.began.elapsed().as_millis() >= GROUP_MILLISECONDS_MAX;
        if due { self.commit() } else { Ok(()) }
    }

    fn commit(&mut self) -> Result<(), RecordError> {
        if self.loss.as_ref().is_some_and(|loss| loss.tried.elapsed() >= RECORDING_RETRY_INTERVAL) {
            self.resume(false);
        }
        if self.loss.is_some() || self.group.take().is_none() || self.broken {
            return Ok(());
        }
        match self.seal_and_commit() {
            Ok(()) => {
                self.kept.clear();
                Ok(())
            }
            Err(error) => self.failed("committing", error),
        }
    }

    fn outlive_the_disk(&mut self) {
        self.outlives_disk = true;
    }

    fn sign_with(&mut self, key: SigningKey) {
        self.signing_key = Some(key);
    }

    fn set_bytes_max(&mut self, bytes: u64) -> Result<(), RecordError> {
        self.places.bytes_max = Some(bytes);
        self.connection.as_ref().map_or(Ok(()), |connection| limit_bytes(connection, &self.path, bytes))
    }

    fn take_news(&mut self) -> Option<DiskNews> {
        (!self.news.is_empty()).then(|| self.news.remove(0))
    }

    fn close(&mut self) -> Result<(), RecordError> {
        self.commit()?;
        if self.loss.is_some() {
            self.resume(true);
        }
        if let Some(RecordingLoss { since, reason, .. }) = &self.loss {
            let (path, since, reason) = (self.path.clone(), *since, reason.clone());
            return Err(RecordError::Lost { path, since, held: self.committed_at, reason, steps: self.kept.steps() });
        }
        self.checkpoints = None;
        let Some(connection) = self.connection.take() else { return Ok(()) };
        closing::close(connection, &self.path)?;
        let Some(key) = self.signing_key.take() else { return Ok(()) };
        signature::sign(&self.path, &key).map_err(|error| self.unwritable("signing it", error.to_string()))
    }

    fn unstorable(&mut self, what: &str, reason: String) -> RecordError {
        self.abandon_group();
        self.broken = true;
        self.unwritable(&format!("turning {what} into bytes"), reason)
    }

    fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Store {
    /// Keeps the stored steps even if the record was never finished; it then states that it is incomplete.
    fn drop(&mut self) {
        let _ = self.commit();
    }
}
