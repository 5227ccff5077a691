//! Identity of a record: another flight may take its file, or leave a log next to it, while it is read.
//!
//! A record is the same if its groups up to a known one have the chain of that group (`seal.rs`): a chain covers everything before it. Files
//! are compared by the numbers of the system, which a new file of the same name does not have.

use super::check::{self, CheckProgress, NoVisitor};
use super::schema::sibling;
use super::seal::{ChainPosition, Hash};
use crate::error::RecordError;
use rusqlite::{Connection, ErrorCode, OptionalExtension};
use std::fs::Metadata;
use std::path::Path;

/// Numbers of a file's device and of the file on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FileNumbers(u64, u64);

/// Returns the numbers of the file at `path`; `None` if there is none, and where the system has no such numbers.
pub(super) fn file_numbers(path: &Path) -> Option<FileNumbers> {
    std::fs::metadata(path).ok().and_then(|found| numbers_of(&found))
}

#[cfg(unix)]
fn numbers_of(found: &Metadata) -> Option<FileNumbers> {
    use std::os::unix::fs::MetadataExt;
    Some(FileNumbers(found.dev(), found.ino()))
}

#[cfg(not(unix))]
fn numbers_of(_: &Metadata) -> Option<FileNumbers> {
    None
}

/// Checks that an open record still contains the group `known`, and that the file at `path` is still `file`, if that is given.
///
/// # Errors
/// [`RecordError::Replaced`].
pub(super) fn check_same(
    connection: &Connection,
    path: &Path,
    (known, file): (ChainPosition, Option<FileNumbers>),
) -> Result<(), RecordError> {
    let is_same_file = file.is_none() || file_numbers(path) == file;
    // Seals that cannot be read are reported by the check of the groups.
    let is_same_chain =
        known.id == 0 || chain_of(connection, known.id).map_or(true, |chain| chain == Some(known.chain));
    if is_same_file && is_same_chain {
        return Ok(());
    }
    Err(RecordError::Replaced { path: path.to_path_buf() })
}

/// Compares the log next to the file at `path` with the file: SQLite takes every log of that name for the log of the file, and reads its
/// pages in place of the file's. `connection` reads both, and `file` the file alone.
///
/// # Errors
/// [`RecordError::ForeignLog`] if the file alone has a valid group that is not in the record as it is read with its log.
pub(super) fn check_log(connection: &Connection, file: &Connection, path: &Path) -> Result<(), RecordError> {
    let has = |known: ChainPosition| known.id == 0 || chain_of(connection, known.id) == Ok(Some(known.chain));
    let last = last_group(file);
    if last.is_ok_and(has) {
        return Ok(());
    }
    // The log may just be copied into the file, or the copying was cut off: only groups that fit their seals count.
    let mut position = CheckProgress::default();
    _ = check::check_schema(file).map(|()| check::check_groups(file, &mut position, &mut NoVisitor));
    let known = position.link;
    match chain_of(connection, known.id) {
        _ if has(known) => Ok(()),
        Err(Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked)) => Ok(()),
        _ => Err(RecordError::ForeignLog { path: path.to_path_buf(), log: sibling(path, "-wal"), groups: known.id }),
    }
}

/// Returns the chain of a group; `None` if the record does not have it.
fn chain_of(connection: &Connection, id: i64) -> Result<Option<Hash>, Option<ErrorCode>> {
    let found = connection
        .prepare_cached("SELECT chain FROM main.seal WHERE id = ?1")
        .and_then(|mut statement| statement.query_row([id], |row| row.get::<_, Hash>(0)).optional());
    found.map_err(|error| error.sqlite_error_code())
}

/// Returns the last group of a record; number 0 if it has none.
fn last_group(connection: &Connection) -> rusqlite::Result<ChainPosition> {
    let sql = "SELECT id, chain FROM main.seal ORDER BY id DESC LIMIT 1";
    let found = connection.query_row(sql, [], |row| Ok(ChainPosition { id: row.get(0)?, chain: row.get(1)? }));
    found.optional().map(Option::unwrap_or_default)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ports::Observer;
    use crate::record::tests::{place_for_record, record_samples};
    use crate::record::{RecordReader, check_integrity, recover};
    use apex_model::time::Time;
    use std::fs;
    use std::path::PathBuf;

    /// Returns the record of a flight that was killed, as its file and its log: the file holds `in_file` and the beginning, the log the
    /// rest with the fact `in_log`.
    fn killed(folder: &Path, in_file: &str, in_log: &str) -> (PathBuf, PathBuf) {
        let running = folder.join(format!("{in_file}.apex"));
        let mut recorder = record_samples(&running);
        recorder.meta("mission", in_file).unwrap();
        recorder.flush().unwrap();
        let copied: i64 = Connection::open(&running)
            .unwrap()
            .query_row("PRAGMA wal_checkpoint(PASSIVE)", [], |row| row.get(2))
            .unwrap();
        assert!(copied > 0);
        recorder.meta("mission", in_log).unwrap();
        recorder.flush().unwrap();
        let file = folder.join(format!("{in_file}-killed.apex"));
        fs::copy(&running, &file).unwrap();
        fs::copy(sibling(&running, "-wal"), sibling(&file, "-wal")).unwrap();
        recorder.finish(Time::ZERO, "stopped").unwrap();
        (file.clone(), sibling(&file, "-wal"))
    }

    #[test]
    fn the_log_of_another_flight_is_not_read_in_place_of_the_record() {
        let (folder, _) = place_for_record();
        let (first, first_log) = killed(folder.path(), "fires", "later fires");
        let (_, second_log) = killed(folder.path(), "dikes", "later dikes");
        let own = RecordReader::open(&first).unwrap();
        assert_eq!(own.meta("mission").unwrap().as_deref(), Some("later fires"));
        drop(own);
        fs::remove_file(sibling(&first, "-shm")).unwrap_or_default();
        fs::copy(&second_log, &first_log).unwrap();
        let refused = RecordReader::open(&first).err().unwrap();
        assert!(matches!(refused, RecordError::ForeignLog { .. }), "{refused}");
        let text = refused.to_string();
        assert!(text.contains("fires-killed.apex-wal") && text.contains("another flight"), "{text}");
        assert!(check_integrity(&first).is_err());
        assert!(recover(&first, &folder.path().join("new.apex")).is_err());
        // The file alone can be read.
        fs::remove_file(&first_log).unwrap();
        fs::remove_file(sibling(&first, "-shm")).unwrap_or_default();
        assert_eq!(RecordReader::open(&first).unwrap().meta("mission").unwrap().as_deref(), Some("fires"));
    }

    #[test]
    fn a_record_whose_file_another_flight_has_taken_is_not_mixed_with_it() {
        let (_folder, path) = place_for_record();
        let mut recorder = record_samples(&path);
        recorder.flush().unwrap();
        let reader = RecordReader::open(&path).unwrap();
        recorder.finish(Time::ZERO, "stopped").unwrap();
        drop(recorder);
        assert_eq!(reader.of_agent(0).unwrap().meta("end_reason").unwrap().as_deref(), Some("stopped"));
        let mut other = record_samples(&path);
        other.meta("mission", "another").unwrap();
        other.flush().unwrap();
        let is_refused = |error: RecordError| matches!(error, RecordError::Replaced { .. });
        assert!(reader.of_agent(0).err().is_some_and(is_refused));
        assert!(reader.steps().err().is_some_and(is_refused));
    }

    #[test]
    fn a_flight_that_is_copied_over_the_record_is_found_by_its_chain() {
        let (folder, path) = place_for_record();
        let mut recorder = record_samples(&path);
        recorder.flush().unwrap();
        let reader = RecordReader::open(&path).unwrap();
        recorder.finish(Time::ZERO, "stopped").unwrap();
        drop(recorder);
        let (other, _) = killed(folder.path(), "dikes", "later dikes");
        let alone = fs::read(other).unwrap();
        fs::write(&path, alone).unwrap();
        assert!(reader.of_agent(0).is_err());
    }
}
