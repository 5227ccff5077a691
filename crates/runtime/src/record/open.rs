//! Opening a record for reading: it is compared with its seals before it is used.
//!
//! A closed record is checked as a whole file; any other by the hash chain of its groups, its schema and its indexes. A record
//! whose folder cannot be written, and one that was cut off, is read where it stands or from a copy in the folder for
//! temporary files. Bound: the file is read once.

use super::check::{self, CheckProgress, Damage, NoVisitor};
use super::file_seal::{self, FileSeal};
use super::schema::{self, BUSY_PATIENCE, CONVERTIBLE_VERSION, FileState, SCHEMA_VERSION, read_error, sibling};
use crate::error::RecordError;
use rusqlite::config::DbConfig;
use rusqlite::{Connection, ErrorCode, OpenFlags};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;

/// Reason to trust the rows of an open record.
#[derive(Clone, Debug)]
pub(super) enum Trust {
    /// The file is as it was sealed, with this length and time of its last change.
    File(Stamp),
    /// The groups up to here fit their seals; the seal of the file is missing or broken.
    Groups(CheckProgress, FileSeal),
}

/// Length and time of the last change of a file.
pub(super) type Stamp = (u64, Option<SystemTime>);

/// An open record.
pub(super) struct Opened {
    pub(super) connection: Connection,
    pub(super) trust: Trust,
    /// The copy that is read in place of the record itself.
    pub(super) copy: Option<Arc<Copied>>,
}

/// Opens the record at `path` and checks it.
pub(super) fn open(path: &Path) -> Result<Opened, RecordError> {
    let (connection, seal, copy) = connect(path)?;
    let damaged = |what| RecordError::Damaged { path: path.to_path_buf(), what };
    check::check_schema(&connection).map_err(damaged)?;
    let trust = match seal {
        FileSeal::Intact => Trust::File(stamp(path)),
        FileSeal::None | FileSeal::Broken => {
            let mut position = CheckProgress::default();
            check::check_groups(&connection, &mut position, &mut NoVisitor)
                .map_err(|damage| damaged(damage.to_string()))?;
            check::check_indexes(&connection).map_err(damaged)?;
            Trust::Groups(position, seal)
        }
    };
    Ok(Opened { connection, trust, copy })
}

/// Opens a record again that was checked a moment ago.
pub(super) fn open_again(path: &Path, before: (&Trust, Option<&Arc<Copied>>)) -> Result<Opened, RecordError> {
    let (trust, copy) = before;
    match trust {
        Trust::File(stamped) if *stamped != stamp(path) => open(path),
        Trust::File(_) => {
            let connection = immutable(path)?;
            Ok(Opened { connection, trust: trust.clone(), copy: None })
        }
        Trust::Groups(..) => {
            let place = copy.map_or(path, |copy| &copy.record);
            let connection = plain(place, path).or_else(|_| immutable(place))?;
            check::check_schema(&connection).map_err(|what| RecordError::Damaged { path: path.to_path_buf(), what })?;
            Ok(Opened { connection, trust: trust.clone(), copy: copy.cloned() })
        }
    }
}

/// Checks the groups that were added after `position` to a record that grows.
pub(super) fn follow(connection: &Connection, position: &mut CheckProgress) -> Result<(), Damage> {
    let last = connection.prepare_cached("SELECT max(id) FROM main.seal");
    let last = last.and_then(|mut statement| statement.query_row([], |row| row.get::<_, Option<i64>>(0)));
    if last.is_ok_and(|last| last.unwrap_or(0) == position.link.id) {
        return Ok(());
    }
    check::check_groups(connection, position, &mut NoVisitor)
}

/// Connects to the record at `path`, or to a copy of it, without a check: for checks and recovery.
pub(super) fn connect(path: &Path) -> Result<Connected, RecordError> {
    connect_to(path, SCHEMA_VERSION)
}

/// A connection, the seal of its file, and the copy that is read in place of the record.
type Connected = (Connection, FileSeal, Option<Arc<Copied>>);

/// Like [`connect`], to a record of this version of the format.
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
        (_, false) => plain(path, path).or_else(|_| immutable(path)),
        // What a log or journal holds can only be had where files can be made next to it.
        (_, true) if journal => copied(path, &mut copy),
        (_, true) => plain(path, path).or_else(|_| copied(path, &mut copy)),
    }?;
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

fn check_version(connection: &Connection, path: &Path, known: i64) -> Result<(), RecordError> {
    let fail = |error| read_error(path, "its header", error);
    let found: i64 = connection.query_row("PRAGMA user_version", [], |row| row.get(0)).map_err(fail)?;
    let path = path.to_path_buf();
    match found {
        _ if found == known => Ok(()),
        _ if found > known => Err(RecordError::Newer { path, found, known }),
        _ if found < 1 => Err(RecordError::NotARecord { path, found: "it is empty".into() }),
        CONVERTIBLE_VERSION => Err(RecordError::Convertible { path, found, known }),
        _ => Err(RecordError::Older { path, found, known }),
    }
}

/// Returns a connection that shares the file with a program that writes it. `path` is for messages.
fn plain(place: &Path, path: &Path) -> Result<Connection, RecordError> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    defended(Connection::open_with_flags(place, flags), path)
}

/// Returns a connection to a file that nothing changes: it needs no locks and no files next to it.
fn immutable(path: &Path) -> Result<Connection, RecordError> {
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

/// Returns a connection to a copy in the folder for temporary files, where SQLite can finish what was cut off.
fn copied(path: &Path, copy: &mut Option<Arc<Copied>>) -> Result<Connection, RecordError> {
    let made = Copied::make(path).map_err(|error| RecordError::Damaged {
        path: path.to_path_buf(),
        what: format!("its writing was cut off, and it cannot be copied to be read ({error})"),
    })?;
    let made = copy.insert(Arc::new(made));
    // Opening it for writing rolls back what was half written.
    let fail = |error| read_error(path, "its header", error);
    let writable = Connection::open(&made.record).map_err(fail)?;
    let _: i64 = writable.query_row("PRAGMA user_version", [], |row| row.get(0)).map_err(fail)?;
    let connection = plain(&made.record, path);
    drop(writable);
    connection
}

/// Lets a connection run nothing that a file says.
fn defended(connection: rusqlite::Result<Connection>, path: &Path) -> Result<Connection, RecordError> {
    let prepared = || -> rusqlite::Result<Connection> {
        let connection = connection?;
        connection.busy_timeout(BUSY_PATIENCE)?;
        connection.set_db_config(DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true)?;
        connection.execute_batch("PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON; PRAGMA mmap_size = 0;")?;
        // The first read shows whether the file can be read here.
        let _: i64 = connection.query_row("PRAGMA schema_version", [], |row| row.get(0))?;
        Ok(connection)
    };
    prepared().map_err(|error| match error.sqlite_error_code() {
        Some(ErrorCode::DatabaseBusy) => RecordError::Busy { path: path.to_path_buf() },
        _ => read_error(path, "its header", error),
    })
}

pub(super) fn stamp(path: &Path) -> Stamp {
    fs::metadata(path).map_or((0, None), |found| (found.len(), found.modified().ok()))
}

/// Files of a record in a separate folder, which is removed when nothing reads them any longer.
#[derive(Debug)]
pub(super) struct Copied {
    folder: PathBuf,
    pub(super) record: PathBuf,
}

/// Number of the next folder of this program.
static COPIES: AtomicU64 = AtomicU64::new(0);

impl Copied {
    fn make(path: &Path) -> std::io::Result<Copied> {
        let number = COPIES.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("apex-record-{}-{number}", std::process::id()));
        // A folder that exists already belongs to another program.
        fs::create_dir(&folder)?;
        let copied = Copied { record: folder.join("copy.apex"), folder };
        // The permissions of the originals are not those of the copies.
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

/// Result of a check of a whole record.
#[derive(Clone, Debug)]
pub struct Integrity {
    /// Whether the file is as it was sealed.
    pub file: FileSeal,
    /// Groups that fit their seals.
    pub groups: i64,
    /// Steps in them.
    pub steps: i64,
    /// The instant of the last of these steps.
    pub until: apex_model::time::Time,
    /// The first group that does not fit.
    pub damage: Option<Damage>,
    /// Other defects: schema, pages, indexes. Rows can be trusted nevertheless if `damage` is `None`.
    pub fault: Option<String>,
}

impl Integrity {
    /// Returns true if all rows are as they were written.
    pub fn is_intact(&self) -> bool {
        self.damage.is_none() && self.fault.is_none()
    }
}

/// Checks everything that can be checked of the record at `path`, whatever its state.
///
/// # Errors
/// [`RecordError`] if the file is missing, not a record, of another version, or so damaged that no table can be found.
pub fn check_integrity(path: &Path) -> Result<Integrity, RecordError> {
    let (connection, file, _copy) = connect(path)?;
    let mut fault = check::check_schema(&connection).err();
    let mut position = CheckProgress::default();
    let mut damage = None;
    if fault.is_none() {
        damage = check::check_groups(&connection, &mut position, &mut NoVisitor).err();
        fault = check::check_indexes(&connection).err();
    }
    Ok(Integrity { file, groups: position.link.id, steps: position.batch, until: position.now, damage, fault })
}
