//! The record's tables, in one place. The server and the command line read the same tables with queries of their own;
//! a change here is a change of `docs/reference/flight-record.md` and, where old readers would err, of the version.

use crate::error::RecordError;
use rusqlite::{Connection, ErrorCode, OpenFlags};
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// `APEX` in ASCII: the mark of a flight record in SQLite's header.
pub const APPLICATION_ID: i64 = 0x4150_4558;
/// The version of the format that this program writes, and the latest that it reads.
pub const SCHEMA_VERSION: i64 = 5;

/// How long to wait for another program that holds the file.
const BUSY_PATIENCE: Duration = Duration::from_secs(2);
/// Where SQLite's header keeps the application id, big-endian.
const APPLICATION_ID_OFFSET: usize = 68;
const SQLITE_MARK: &[u8] = b"SQLite format 3\0";

const TABLES: &str = "
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT) WITHOUT ROWID;
CREATE TABLE source (position INTEGER PRIMARY KEY, name TEXT, role TEXT, body BLOB);
CREATE TABLE variable (id INTEGER PRIMARY KEY, name TEXT, body BLOB);
CREATE TABLE agent (id INTEGER PRIMARY KEY, name TEXT);
CREATE TABLE batch (id INTEGER PRIMARY KEY, t_ns INTEGER, events BLOB, agent INTEGER);
CREATE TABLE effect (id INTEGER PRIMARY KEY, batch INTEGER, t_ns INTEGER, kind TEXT, task INTEGER,
    from_state TEXT, to_state TEXT, outcome TEXT, subject TEXT, text TEXT, place TEXT, body BLOB, agent INTEGER);
CREATE TABLE task (id INTEGER, parent INTEGER, tag TEXT, goal TEXT, created_ns INTEGER,
    ended_ns INTEGER, outcome TEXT, method TEXT, place TEXT, agent INTEGER, PRIMARY KEY (id, agent)) WITHOUT ROWID;
CREATE TABLE note (id INTEGER PRIMARY KEY, batch INTEGER, t_ns INTEGER, text TEXT);
CREATE TABLE snapshot (batch INTEGER PRIMARY KEY, t_ns INTEGER, body BLOB, agent INTEGER);
CREATE TABLE problem (request INTEGER PRIMARY KEY, batch INTEGER, t_ns INTEGER, goal TEXT, solver TEXT, body TEXT,
    due_ns INTEGER, detail TEXT, plan TEXT, report BLOB);
CREATE TABLE situation (batch INTEGER PRIMARY KEY, t_ns INTEGER, body BLOB);
CREATE TABLE track (t_ns INTEGER PRIMARY KEY, latitude_deg REAL, longitude_deg REAL, altitude_m REAL,
    heading_deg REAL, roll_deg REAL, ground_speed_mps REAL, fuel_kg REAL);
CREATE TABLE target (id TEXT PRIMARY KEY, name TEXT, latitude_deg REAL, longitude_deg REAL, value REAL,
    geometry TEXT);
CREATE TABLE target_state (target TEXT, t_ns INTEGER, state TEXT, detail TEXT);
CREATE TABLE report (position INTEGER PRIMARY KEY, section TEXT, body TEXT);
CREATE INDEX batch_time ON batch (t_ns);
CREATE INDEX effect_batch ON effect (batch);
CREATE INDEX effect_task ON effect (task, id);
";

/// Makes an empty record at `path`, in place of an older record if there is one.
pub(super) fn create(path: &Path) -> Result<Connection, RecordError> {
    make_room(path)?;
    let fail = |error| write_error(path, "making its tables", error);
    let connection = Connection::open(path).map_err(fail)?;
    connection.busy_timeout(BUSY_PATIENCE).map_err(fail)?;
    // The marks go into the main file before the write-ahead log exists: readers that look at the header only see them.
    connection
        .execute_batch(&format!(
            "PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {SCHEMA_VERSION};
             BEGIN; {TABLES} COMMIT;
             PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL;"
        ))
        .map_err(fail)?;
    Ok(connection)
}

/// Removes an older record; refuses to touch anything else.
fn make_room(path: &Path) -> Result<(), RecordError> {
    match look(path)? {
        Found::Nothing => return Ok(()),
        Found::Record => {}
        Found::Other(found) => return Err(RecordError::NotARecord { path: path.to_path_buf(), found }),
    }
    refuse_when_written(path)?;
    for suffix in ["", "-wal", "-shm", "-journal"] {
        let name = sibling(path, suffix);
        if let Err(error) = fs::remove_file(&name)
            && error.kind() != std::io::ErrorKind::NotFound
        {
            let doing = "removing the older record".into();
            return Err(RecordError::Unwritable { path: name, doing, reason: error.to_string() });
        }
    }
    Ok(())
}

fn sibling(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}

/// A running flight holds the write lock most of the time.
fn refuse_when_written(path: &Path) -> Result<(), RecordError> {
    let Ok(connection) = Connection::open(path) else { return Ok(()) };
    let locked =
        connection.busy_timeout(Duration::ZERO).and_then(|()| connection.execute_batch("BEGIN IMMEDIATE; ROLLBACK;"));
    match locked {
        Err(error) if error.sqlite_error_code() == Some(ErrorCode::DatabaseBusy) => {
            Err(RecordError::Busy { path: path.to_path_buf() })
        }
        Ok(()) | Err(_) => Ok(()),
    }
}

/// What stands at a path.
enum Found {
    Nothing,
    Record,
    Other(String),
}

fn look(path: &Path) -> Result<Found, RecordError> {
    let unreadable = |error: std::io::Error| RecordError::Unwritable {
        path: path.to_path_buf(),
        doing: "looking at what stands there".into(),
        reason: error.to_string(),
    };
    let mut file = match fs::File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Found::Nothing),
        Err(error) => return Err(unreadable(error)),
    };
    if file.metadata().map_err(unreadable)?.is_dir() {
        return Ok(Found::Other("it is a folder".into()));
    }
    let mut header = Vec::with_capacity(100);
    file.by_ref().take(100).read_to_end(&mut header).map_err(unreadable)?;
    let mark = header.get(APPLICATION_ID_OFFSET..APPLICATION_ID_OFFSET + 4);
    let id = mark.and_then(|bytes| <[u8; 4]>::try_from(bytes).ok()).map(|bytes| i64::from(u32::from_be_bytes(bytes)));
    Ok(match header.starts_with(SQLITE_MARK) {
        true if id == Some(APPLICATION_ID) => Found::Record,
        true => Found::Other("it is a database of something else".into()),
        false if header.is_empty() => Found::Record,
        false => Found::Other("it does not begin like one".into()),
    })
}

/// Opens the record at `path` for reading, after checking that it is one.
pub(super) fn open(path: &Path) -> Result<Connection, RecordError> {
    match look(path)? {
        Found::Nothing => return Err(RecordError::Missing { path: path.to_path_buf() }),
        Found::Record => {}
        Found::Other(found) => return Err(RecordError::NotARecord { path: path.to_path_buf(), found }),
    }
    let fail = |error| read_error(path, "its header", error);
    let connection =
        Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX)
            .map_err(fail)?;
    connection.busy_timeout(BUSY_PATIENCE).map_err(fail)?;
    let found: i64 = connection.query_row("PRAGMA user_version", [], |row| row.get(0)).map_err(fail)?;
    if found > SCHEMA_VERSION {
        return Err(RecordError::Newer { path: path.to_path_buf(), found, known: SCHEMA_VERSION });
    }
    if found < 1 {
        return Err(RecordError::NotARecord { path: path.to_path_buf(), found: "it is empty".into() });
    }
    if found < SCHEMA_VERSION {
        return Err(RecordError::Older { path: path.to_path_buf(), found, known: SCHEMA_VERSION });
    }
    Ok(connection)
}

/// The names of the agents in the record, in the order of their numbers.
///
/// # Errors
/// SQLite's own.
pub fn agents(connection: &Connection) -> rusqlite::Result<Vec<String>> {
    connection.prepare("SELECT name FROM agent ORDER BY id")?.query_map([], |row| row.get(0))?.collect()
}

/// Lets every later query on `connection` see one agent of several: the tables that belong to an agent are covered by
/// views of the same names. `main.batch` and the like still show everything.
///
/// # Errors
/// SQLite's own.
pub fn look_at_agent(connection: &Connection, agent: usize) -> rusqlite::Result<()> {
    for table in ["batch", "effect", "task", "snapshot"] {
        connection.execute_batch(&format!(
            "DROP VIEW IF EXISTS temp.{table}; CREATE TEMP VIEW {table} AS SELECT * FROM main.{table} WHERE agent = {agent};"
        ))?;
    }
    Ok(())
}

/// SQLite's trouble while writing, as a sentence.
pub(super) fn write_error(path: &Path, doing: &str, error: rusqlite::Error) -> RecordError {
    let (path, doing) = (path.to_path_buf(), doing.to_owned());
    match error.sqlite_error_code() {
        Some(ErrorCode::DiskFull) => RecordError::DiskFull { path, doing },
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => RecordError::Busy { path },
        _ => RecordError::Unwritable { path, doing, reason: error.to_string() },
    }
}

/// SQLite's trouble while reading, as a sentence.
pub(super) fn read_error(path: &Path, what: &str, error: rusqlite::Error) -> RecordError {
    RecordError::Damaged { path: path.to_path_buf(), what: format!("{what} cannot be read ({error})") }
}
