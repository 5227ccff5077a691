//! One flight record, opened for reading only, whether it is finished or another program still writes it.

use crate::answer::{Answer, ApiError};
use crate::index::TaskIndex;
use rusqlite::{Connection, OpenFlags, OptionalExtension};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// `APEX` in ASCII: the mark of a flight record in SQLite's header.
const APPLICATION_ID: i64 = 0x4150_4558;
/// The schema that this program reads.
const SCHEMA_VERSION: i64 = 4;
/// How long to wait for a writer that holds the file.
const BUSY_PATIENCE: Duration = Duration::from_secs(2);

/// Why a file cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// There is no such file.
    #[error("there is no flight record at {}; `apex fly MISSION` writes one", .0.display())]
    Missing(PathBuf),
    /// SQLite cannot read it.
    #[error("{} cannot be read as a flight record: {source}; is it a file that `apex fly` wrote?", .path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What SQLite said.
        source: rusqlite::Error,
    },
    /// It is a database of something else.
    #[error("{} is a database, but not a flight record; give a `*.apex` file that `apex fly` wrote", .0.display())]
    Foreign(PathBuf),
    /// It was written by another version of the schema.
    #[error("{} has record version {found}, and this program reads version {SCHEMA_VERSION}; use the Apex that wrote it", .path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: i64,
    },
}

/// A record and what was already read of it; shared by all requests.
pub(crate) struct Record {
    reader: Mutex<Reader>,
}

/// One connection with its task index.
pub(crate) struct Reader {
    /// The file's path.
    pub(crate) path: PathBuf,
    /// The read-only connection.
    pub(crate) connection: Connection,
    /// The states of all tasks over time, brought up to date before each use.
    pub(crate) index: TaskIndex,
}

impl Record {
    /// Opens the record at `path`, to look at agent number `agent`.
    pub(crate) fn open(path: &Path, agent: usize) -> Result<Record, RecordError> {
        if !path.is_file() {
            return Err(RecordError::Missing(path.to_path_buf()));
        }
        let unreadable = |source| RecordError::Unreadable { path: path.to_path_buf(), source };
        let connection = connect(path).map_err(unreadable)?;
        if pragma(&connection, "application_id").map_err(unreadable)? != APPLICATION_ID {
            return Err(RecordError::Foreign(path.to_path_buf()));
        }
        let found = pragma(&connection, "user_version").map_err(unreadable)?;
        if found != SCHEMA_VERSION {
            return Err(RecordError::Version { path: path.to_path_buf(), found });
        }
        look_at_agent(&connection, agent).map_err(unreadable)?;
        let reader = Reader { path: path.to_path_buf(), connection, index: TaskIndex::default() };
        Ok(Record { reader: Mutex::new(reader) })
    }

    /// Reads with the shared connection; blocks while another request reads.
    pub(crate) fn read<T>(&self, query: impl FnOnce(&mut Reader) -> Answer<T>) -> Answer<T> {
        // A query that panicked has written nothing: the connection is as good as before.
        let mut reader = self.reader.lock().unwrap_or_else(PoisonError::into_inner);
        query(&mut reader)
    }
}

impl Reader {
    /// The task index, up to date with the record.
    pub(crate) fn tasks(&mut self) -> Result<&TaskIndex, ApiError> {
        self.index.refresh(&self.connection)?;
        Ok(&self.index)
    }

    /// One value of table `meta`.
    pub(crate) fn meta(&self, key: &str) -> Result<Option<String>, rusqlite::Error> {
        self.connection
            .prepare_cached("SELECT value FROM meta WHERE key = ?1")?
            .query_row([key], |row| row.get(0))
            .optional()
    }
}

fn connect(path: &Path) -> Result<Connection, rusqlite::Error> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX | OpenFlags::SQLITE_OPEN_URI;
    let connection = Connection::open_with_flags(path, flags)?;
    connection.busy_timeout(BUSY_PATIENCE)?;
    match pragma(&connection, "user_version") {
        Ok(_) => Ok(connection),
        // A finished record on a read-only medium has no place for WAL's side files; nobody writes there either.
        Err(error) if error.sqlite_error_code() == Some(rusqlite::ErrorCode::CannotOpen) => {
            Connection::open_with_flags(immutable_uri(path), flags)
        }
        Err(error) => Err(error),
    }
}

/// Where several agents ran, covers the tables that belong to an agent by views of the same names.
fn look_at_agent(connection: &Connection, agent: usize) -> Result<(), rusqlite::Error> {
    let agents: i64 = connection.query_row("SELECT count(*) FROM agent", [], |row| row.get(0))?;
    for table in ["batch", "effect", "task", "snapshot"].iter().filter(|_| agents > 1) {
        let sql = format!("CREATE TEMP VIEW {table} AS SELECT * FROM main.{table} WHERE agent = {agent}");
        connection.execute_batch(&sql)?;
    }
    Ok(())
}

fn pragma(connection: &Connection, name: &str) -> Result<i64, rusqlite::Error> {
    connection.query_row(&format!("PRAGMA {name}"), [], |row| row.get(0))
}

fn immutable_uri(path: &Path) -> String {
    let mut uri = String::from("file:");
    for byte in path.to_string_lossy().bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'-' | b'_' => uri.push(char::from(byte)),
            other => uri.push_str(&format!("%{other:02X}")),
        }
    }
    uri.push_str("?immutable=1");
    uri
}
