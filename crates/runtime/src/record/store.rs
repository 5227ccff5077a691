//! The file under the recorder: prepared statements in grouped transactions, and what to do when a write fails.

use super::schema::{self, write_error};
use crate::error::RecordError;
use crate::limits::{GROUP_BATCHES_MAX, GROUP_MILLISECONDS_MAX};
use apex_model::time::Time;
use rusqlite::{Connection, Params};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Bytes of one page of the file: SQLite's default, with which the file is made.
const PAGE_BYTES: u64 = 4096;

/// An open record file.
pub(super) struct Store {
    path: PathBuf,
    connection: Connection,
    group: Option<Group>,
    /// A write failed; nothing is written after it.
    broken: bool,
    /// The instant that is being stored, for messages.
    pub(super) now: Time,
}

/// An open transaction.
struct Group {
    began: Instant,
    batches: u32,
}

impl Store {
    pub(super) fn create(path: &Path, bytes_max: Option<u64>) -> Result<Store, RecordError> {
        let connection = schema::create(path)?;
        if let Some(bytes) = bytes_max {
            let pages = (bytes / PAGE_BYTES).clamp(1, u64::from(u32::MAX - 1));
            connection
                .query_row(&format!("PRAGMA max_page_count = {pages}"), [], |_| Ok(()))
                .map_err(|error| write_error(path, "setting its largest size", error))?;
        }
        Ok(Store { path: path.to_path_buf(), connection, group: None, broken: false, now: Time::ZERO })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Executes one statement inside of the open group. `doing` is for the message when it fails.
    pub(super) fn write(&mut self, doing: &str, sql: &str, params: impl Params) -> Result<(), RecordError> {
        if self.broken {
            return Err(self.unwritable(doing, "an earlier write failed".into()));
        }
        let done = self.open_group().and_then(|()| self.connection.prepare_cached(sql)?.execute(params));
        done.map(|_| ()).map_err(|error| self.give_up(doing, error))
    }

    fn open_group(&mut self) -> rusqlite::Result<()> {
        if self.group.is_none() {
            self.connection.prepare_cached("BEGIN IMMEDIATE")?.execute([])?;
            self.group = Some(Group { began: Instant::now(), batches: 0 });
        }
        Ok(())
    }

    /// Counts a whole step; commits when the group is large or old enough.
    pub(super) fn end_step(&mut self) -> Result<(), RecordError> {
        let Some(group) = &mut self.group else { return Ok(()) };
        group.batches += 1;
        let due = group.batches >= GROUP_BATCHES_MAX || group.began.elapsed().as_millis() >= GROUP_MILLISECONDS_MAX;
        if due { self.commit() } else { Ok(()) }
    }

    /// Commits the open group, if there is one.
    pub(super) fn commit(&mut self) -> Result<(), RecordError> {
        if self.group.take().is_none() || self.broken {
            return Ok(());
        }
        let done = self.connection.prepare_cached("COMMIT").and_then(|mut statement| statement.execute([]));
        done.map(|_| ()).map_err(|error| self.give_up("committing", error))
    }

    /// One file without companions travels better. A reader that looks on now prevents it, and that is no fault.
    pub(super) fn fold(&mut self) {
        let _ = self.connection.execute_batch("PRAGMA wal_checkpoint(TRUNCATE); PRAGMA journal_mode = DELETE;");
    }

    /// Keeps what was committed and writes no more: half a step in the record would be worse than its end.
    fn give_up(&mut self, doing: &str, error: rusqlite::Error) -> RecordError {
        self.abandon_group();
        write_error(&self.path, &format!("{doing} at {}", self.now), error)
    }

    fn abandon_group(&mut self) {
        self.broken = true;
        self.group = None;
        if !self.connection.is_autocommit() {
            let _ = self.connection.execute_batch("ROLLBACK");
        }
    }

    /// Something that cannot be turned into bytes.
    pub(super) fn unstorable(&mut self, what: &str, error: impl std::fmt::Display) -> RecordError {
        self.abandon_group();
        self.unwritable(&format!("turning {what} into bytes"), error.to_string())
    }

    fn unwritable(&self, doing: &str, reason: String) -> RecordError {
        RecordError::Unwritable { path: self.path.clone(), doing: format!("{doing} at {}", self.now), reason }
    }
}

impl Drop for Store {
    /// What was observed stays, also when nobody finished the record; it then says that it is incomplete.
    fn drop(&mut self) {
        let _ = self.commit();
    }
}
