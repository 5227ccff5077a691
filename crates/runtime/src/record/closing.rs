//! Closes a record so that it is readable at every moment of closing, even if the program is killed in the middle.
//!
//! The order is: the write-ahead log is copied into the main file and removed (SQLite can repeat that from the log at any time); the two
//! header bytes that require a log are changed by one write; the seal of the whole file is appended. No rollback journal ever exists, so
//! no reader has anything to roll back.

use super::file_seal;
use super::schema::{sibling, write_error};
use crate::error::RecordError;
use rusqlite::Connection;
use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

/// Offset of the versions for writers and readers in SQLite's header; 2 requires a write-ahead log, 1 does not.
const VERSIONS_OFFSET: u64 = 18;

/// Closes the record. While another program reads it, it remains a file with an empty log.
pub(super) fn close(connection: Connection, path: &Path) -> Result<(), RecordError> {
    let _ = connection.query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |_| Ok(()));
    connection.close().map_err(|(_, error)| write_error(path, "closing it", error))?;
    match std::fs::metadata(sibling(path, "-wal")) {
        // A reader still uses the log: it is empty, but the header must continue to name it.
        Ok(log) if log.len() == 0 => seal(path, false),
        Ok(_) => Ok(()),
        Err(_) => seal(path, true),
    }
}

fn seal(path: &Path, is_alone: bool) -> Result<(), RecordError> {
    let sealed = || -> std::io::Result<()> {
        let mut file = File::options().read(true).write(true).open(path)?;
        if is_alone {
            file.seek(SeekFrom::Start(VERSIONS_OFFSET))?;
            file.write_all(&[1, 1])?;
        }
        file_seal::append(&mut file)?;
        file.sync_all()
    };
    sealed().map_err(|error| RecordError::Unwritable {
        path: path.to_path_buf(),
        doing: "sealing it".into(),
        reason: error.to_string(),
    })
}
