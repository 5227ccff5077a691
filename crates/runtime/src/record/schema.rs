//! Creates the file of a record and removes an older one at its path. A change of the tables (`tables.rs`) also changes
//! `docs/reference/flight-record.md` and, if older readers would misread the file, the version.

use super::tables::SCHEMA;
use crate::error::RecordError;
use rusqlite::{Connection, ErrorCode};
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Bytes of one page of the file: SQLite's default, with which the file is created.
pub(super) const PAGE_BYTES: u64 = 4096;

/// `APEX` in ASCII: the mark of a flight record in SQLite's header.
pub const APPLICATION_ID: i64 = 0x4150_4558;
/// The format version that this program writes, and the only one that it reads.
pub const SCHEMA_VERSION: i64 = 7;
/// The version of the format that is converted.
pub(super) const CONVERTIBLE_VERSION: i64 = 6;

/// Time to wait for another program that holds the file.
pub(super) const BUSY_PATIENCE: Duration = Duration::from_secs(2);
/// Offset of the application id in SQLite's header, big-endian.
const APPLICATION_ID_OFFSET: usize = 68;
const SQLITE_MARK: &[u8] = b"SQLite format 3\0";

/// Creates an empty record at `path`, in place of an older record if there is one.
pub(super) fn create(path: &Path) -> Result<Connection, RecordError> {
    make_room(path)?;
    let fail = |error| write_error(path, "making its tables", error);
    let connection = Connection::open(path).map_err(fail)?;
    match make_tables(&connection) {
        Ok(()) => Ok(connection),
        Err(error) => {
            // A file without tables, as on a full disk, is not a record.
            drop(connection);
            remove(path);
            Err(fail(error))
        }
    }
}

fn make_tables(connection: &Connection) -> rusqlite::Result<()> {
    connection.busy_timeout(BUSY_PATIENCE)?;
    let tables: Vec<&str> = SCHEMA.iter().map(|(_, _, sql)| *sql).collect();
    // The marks are written into the main file before the write-ahead log exists, for readers that read only the header. A program killed
    // here leaves no rollback journal; nothing is recorded yet.
    connection.execute_batch(&format!(
        "PRAGMA journal_mode = MEMORY;
         PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {SCHEMA_VERSION};
         BEGIN; {}; COMMIT;
         PRAGMA journal_mode = WAL;",
        tables.join("; ")
    ))
}

/// Removes an older record; refuses to remove any other file.
fn make_room(path: &Path) -> Result<(), RecordError> {
    match look(path)? {
        FileState::Nothing => return Ok(()),
        FileState::Record => {}
        FileState::Other(found) => return Err(RecordError::NotARecord { path: path.to_path_buf(), found }),
    }
    refuse_when_written(path)?;
    for suffix in ["", "-wal", "-shm", "-journal", ".sig"] {
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

/// Returns the name of a file that SQLite keeps next to the record.
pub(super) fn sibling(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}

/// Refuses a record of a running flight, which holds the write lock most of the time.
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

/// Kind of file at a path.
pub(super) enum FileState {
    Nothing,
    Record,
    Other(String),
}

/// Reads the header of the file at `path`.
pub(super) fn look(path: &Path) -> Result<FileState, RecordError> {
    let unreadable = |error: std::io::Error| RecordError::Unwritable {
        path: path.to_path_buf(),
        doing: "inspecting the existing file".into(),
        reason: error.to_string(),
    };
    let mut file = match fs::File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(FileState::Nothing),
        Err(error) => return Err(unreadable(error)),
    };
    if file.metadata().map_err(unreadable)?.is_dir() {
        return Ok(FileState::Other("it is a folder".into()));
    }
    let mut header = Vec::with_capacity(100);
    file.by_ref().take(100).read_to_end(&mut header).map_err(unreadable)?;
    let mark = header.get(APPLICATION_ID_OFFSET..APPLICATION_ID_OFFSET + 4);
    let id = mark.and_then(|bytes| <[u8; 4]>::try_from(bytes).ok()).map(|bytes| i64::from(u32::from_be_bytes(bytes)));
    Ok(match header.starts_with(SQLITE_MARK) {
        true if id == Some(APPLICATION_ID) => FileState::Record,
        true => FileState::Other("it is an SQLite database of another program".into()),
        false if header.is_empty() => FileState::Record,
        false => FileState::Other("its first bytes are not those of a record".into()),
    })
}

/// Returns true if the file at `path` begins as a flight record does. An empty file, or one that cannot be read, does not.
pub fn is_record(path: &Path) -> bool {
    let has_bytes = fs::metadata(path).is_ok_and(|metadata| metadata.is_file() && metadata.len() > 0);
    has_bytes && matches!(look(path), Ok(FileState::Record))
}

/// Sets the largest size of the file.
pub(super) fn limit_bytes(connection: &Connection, path: &Path, bytes: u64) -> Result<(), RecordError> {
    let pages = (bytes / PAGE_BYTES).clamp(1, u64::from(u32::MAX - 1));
    connection
        .query_row(&format!("PRAGMA max_page_count = {pages}"), [], |_| Ok(()))
        .map_err(|error| write_error(path, "setting its largest size", error))
}

/// Removes a new record that holds no rows.
pub(super) fn remove(path: &Path) {
    for suffix in ["", "-wal", "-shm"] {
        let _ = std::fs::remove_file(sibling(path, suffix));
    }
}

/// Returns the names of the agents in the record, in the order of their numbers.
///
/// # Errors
/// SQLite's own.
pub fn agents(connection: &Connection) -> rusqlite::Result<Vec<String>> {
    connection.prepare("SELECT name FROM agent ORDER BY id")?.query_map([], |row| row.get(0))?.collect()
}

/// Restricts every later query on `connection` to one agent of several: views hide the tables that belong to an agent under the same
/// names. `main.batch` and the like still contain everything.
///
/// # Errors
/// SQLite's own.
pub fn look_at_agent(connection: &Connection, agent: usize) -> rusqlite::Result<()> {
    for table in ["batch", "snapshot"] {
        connection.execute_batch(&format!(
            "DROP VIEW IF EXISTS temp.{table}; CREATE TEMP VIEW {table} AS SELECT * FROM main.{table} WHERE agent = {agent};"
        ))?;
    }
    Ok(())
}

/// Converts an SQLite error while writing.
pub(super) fn write_error(path: &Path, doing: &str, error: rusqlite::Error) -> RecordError {
    let (path, doing) = (path.to_path_buf(), doing.to_owned());
    match error.sqlite_error_code() {
        Some(ErrorCode::DiskFull) => RecordError::DiskFull { path, doing },
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => RecordError::Busy { path },
        _ => RecordError::Unwritable { path, doing, reason: error.to_string() },
    }
}

/// Converts an SQLite error while reading.
pub(super) fn read_error(path: &Path, what: &str, error: rusqlite::Error) -> RecordError {
    RecordError::Damaged { path: path.to_path_buf(), what: format!("{what} cannot be read ({error})") }
}
