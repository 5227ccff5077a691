//! Connections to the file of a record, or to a copy of it, before its rows are checked.

use super::file_seal::{self, FileSeal};
use super::identity::check_log;
use super::schema::{self, BUSY_PATIENCE, CONVERTIBLE_VERSION, FileState, SCHEMA_VERSION, read_error, sibling};
use crate::error::RecordError;
use rusqlite::config::DbConfig;
use rusqlite::{Connection, ErrorCode, OpenFlags};
use std::fs::{self, File};
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Connects to the record at `path`, or to a copy of it, without a check of its rows: for checks and recovery.
pub(super) fn connect(path: &Path) -> Result<Connected, RecordError> {
    connect_to(path, SCHEMA_VERSION)
}

/// A connection, the seal of its file, and the copy that is read in place of the record.
type Connected = (Connection, FileSeal, Option<Arc<Copied>>);

/// As [`connect`], to a record of this version of the format.
pub(super) fn connect_to(path: &Path, version: i64) -> Result<Connected, RecordError> {
    match schema::look(path)? {
        FileState::Nothing => return Err(RecordError::Missing { path: path.to_path_buf() }),
        FileState::Record => {}
        FileState::Other(found) => return Err(RecordError::NotARecord { path: path.to_path_buf(), found }),
    }
    let is_there = |suffix| fs::metadata(sibling(path, suffix)).is_ok_and(|found| found.len() > 0);
    let (log, journal) = (is_there("-wal"), is_there("-journal"));
    let seal = if log || journal { FileSeal::None } else { check_file(path)? };
    let mut copy = None;
    let connection = match (seal, log || journal) {
        (FileSeal::Intact, _) => immutable(path),
        (_, false) => plain(path, path).or_else(|_| immutable(path)).or_else(|error| extended(path, &mut copy, error)),
        // The contents of a log or journal can only be read where SQLite can create files next to it.
        (_, true) if journal => copied(path, &mut copy),
        (_, true) => plain(path, path).or_else(|_| copied(path, &mut copy)),
    }?;
    if log && let Ok(file) = immutable(path) {
        check_log(&connection, &file, path)?;
    }
    check_version(&connection, path, version)?;
    Ok((connection, seal, copy))
}

fn check_file(path: &Path) -> Result<FileSeal, RecordError> {
    let checked = File::open(path).and_then(|mut file| file_seal::check(&mut file));
    checked.map_err(|error| RecordError::Damaged {
        path: path.to_path_buf(),
        what: format!("it cannot be read ({error})"),
    })
}

/// Compares the version of the format that the file states with `known`.
pub(super) fn check_version(connection: &Connection, path: &Path, known: i64) -> Result<(), RecordError> {
    let fail = |error| read_error(path, "its header", error);
    let found: i64 = connection.query_row("PRAGMA user_version", [], |row| row.get(0)).map_err(fail)?;
    let path = path.to_path_buf();
    match found {
        _ if found == known => Ok(()),
        _ if found > known => Err(RecordError::Newer { path, found, known }),
        _ if found < 1 => Err(RecordError::NotARecord {
            path,
            found: "it is empty, as the file of a flight that was killed at once".into(),
        }),
        CONVERTIBLE_VERSION => Err(RecordError::Convertible { path, found, known }),
        _ => Err(RecordError::Older { path, found, known }),
    }
}

/// Returns a connection that shares the file with a program that writes it. `path` is for messages.
pub(super) fn plain(place: &Path, path: &Path) -> Result<Connection, RecordError> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    defended(Connection::open_with_flags(place, flags), path)
}

/// Returns a connection to a file that no program changes: it needs no locks and no files next to it.
pub(super) fn immutable(path: &Path) -> Result<Connection, RecordError> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX | OpenFlags::SQLITE_OPEN_URI;
    let mut name = String::from("file:");
    for byte in path.as_os_str().as_encoded_bytes() {
        match byte {
            b'/' | b'.' | b'-' | b'_' | b'0'..=b'9' | b'A'..=b'Z' | b'a'..=b'z' => name.push(char::from(*byte)),
            other => name.push_str(&format!("%{other:02X}")),
        }
    }
    name.push_str("?immutable=1");
    defended(Connection::open_with_flags(name, flags), path)
}

/// Returns a connection to a copy in the folder for temporary files, where SQLite can complete an interrupted write.
fn copied(path: &Path, copy: &mut Option<Arc<Copied>>) -> Result<Connection, RecordError> {
    let made = Copied::make(path).map_err(|error| RecordError::Damaged {
        path: path.to_path_buf(),
        what: format!("its writing was cut off, and it cannot be copied to be read ({error})"),
    })?;
    let made = copy.insert(Arc::new(made));
    // Opening the copy for writing rolls back a half-written transaction.
    let fail = |error| read_error(path, "its header", error);
    let writable = Connection::open(&made.record).map_err(fail)?;
    let _: i64 = writable.query_row("PRAGMA user_version", [], |row| row.get(0)).map_err(fail)?;
    let connection = plain(&made.record, path);
    drop(writable);
    connection
}

/// Returns a connection to a copy of a file that lacks its end, such as an interrupted download. SQLite refuses a file that is shorter than
/// its header states, so the copy has empty pages in place of the missing ones; tables are read up to the first of them. Returns `error` if
/// the file is not too short.
fn extended(path: &Path, copy: &mut Option<Arc<Copied>>, error: RecordError) -> Result<Connection, RecordError> {
    let Ok(Some(length)) = length_before_cut(path) else { return Err(error) };
    let made = Copied::make(path).and_then(|made| {
        File::options().write(true).open(&made.record)?.set_len(length)?;
        Ok(made)
    });
    let made = made.map_err(|error| RecordError::Damaged {
        path: path.to_path_buf(),
        what: format!("its end is missing, and it cannot be copied to be read ({error})"),
    })?;
    immutable(&copy.insert(Arc::new(made)).record)
}

/// Returns the length in bytes that the header of a database states, if the file is shorter; `None` if it is not, or if the header does not
/// state it. Source: "Database File Format" of SQLite, sections 1.3.2 and 1.3.7.
fn length_before_cut(path: &Path) -> std::io::Result<Option<u64>> {
    let mut file = File::open(path)?;
    let mut header = [0; 100];
    file.read_exact(&mut header)?;
    let number = |at: usize| header.get(at..at + 4).and_then(|bytes| bytes.try_into().ok()).map(u32::from_be_bytes);
    let (change, pages, of_change) = (number(24), number(28), number(92));
    let page_bytes = match u16::from_be_bytes([header[16], header[17]]) {
        1 => 65_536,
        bytes => u64::from(bytes),
    };
    let length = u64::from(pages.filter(|_| change == of_change).unwrap_or(0)) * page_bytes;
    Ok(Some(length).filter(|length| file.metadata().is_ok_and(|found| found.len() < *length)))
}

/// Prevents a connection from executing code of the file, such as triggers.
fn defended(connection: rusqlite::Result<Connection>, path: &Path) -> Result<Connection, RecordError> {
    let prepared = || -> rusqlite::Result<Connection> {
        let connection = connection?;
        connection.busy_timeout(BUSY_PATIENCE)?;
        connection.set_db_config(DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true)?;
        connection.execute_batch("PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON; PRAGMA mmap_size = 0;")?;
        // The first read shows whether the file can be read in its place.
        let _: i64 = connection.query_row("PRAGMA schema_version", [], |row| row.get(0))?;
        Ok(connection)
    };
    prepared().map_err(|error| match error.sqlite_error_code() {
        Some(ErrorCode::DatabaseBusy) => RecordError::Busy { path: path.to_path_buf() },
        _ => read_error(path, "its header", error),
    })
}

/// Files of a record in a separate folder, which is removed when no reader uses it any longer.
#[derive(Debug)]
pub(super) struct Copied {
    folder: PathBuf,
    pub(super) record: PathBuf,
}

/// Number of the next folder of this program.
static COPIES: AtomicU64 = AtomicU64::new(0);
/// Number from which on an existing folder is an error.
const FOLDERS_MAX: u64 = 1_000_000;

impl Copied {
    /// Creates an empty folder and returns the path of the copy in it.
    pub(super) fn folder() -> std::io::Result<Copied> {
        Copied::folder_in(&std::env::temp_dir())
    }

    /// As [`Copied::folder`], in `place`.
    pub(super) fn folder_in(place: &Path) -> std::io::Result<Copied> {
        let folder = loop {
            let number = COPIES.fetch_add(1, Ordering::Relaxed);
            let folder = place.join(format!("apex-record-{}-{number}", std::process::id()));
            match fs::create_dir(&folder) {
                Ok(()) => break folder,
                // It belongs to another program, or to one that was killed: in containers, process numbers repeat.
                Err(error) if error.kind() == ErrorKind::AlreadyExists && number < FOLDERS_MAX => {}
                Err(error) => return Err(error),
            }
        };
        Ok(Copied { record: folder.join("copy.apex"), folder })
    }

    fn make(path: &Path) -> std::io::Result<Copied> {
        let copied = Copied::folder()?;
        // The copies must not inherit the permissions of the originals.
        let copy = |from: &Path, to: &Path| std::io::copy(&mut File::open(from)?, &mut File::create(to)?).map(|_| ());
        copy(path, &copied.record)?;
        for suffix in ["-wal", "-journal"] {
            let from = sibling(path, suffix);
            if from.exists() {
                copy(&from, &sibling(&copied.record, suffix))?;
            }
        }
        Ok(copied)
    }
}

impl Drop for Copied {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_that_a_killed_program_left_are_passed_over() {
        let place = tempfile::TempDir::new().unwrap();
        let next = COPIES.load(Ordering::Relaxed);
        for number in next..next + 100 {
            fs::create_dir(place.path().join(format!("apex-record-{}-{number}", std::process::id()))).unwrap();
        }
        let copied = Copied::folder_in(place.path()).unwrap();
        assert!(copied.folder.is_dir() && !copied.record.exists());
        assert!(Copied::folder_in(&place.path().join("nowhere")).is_err());
    }
}
