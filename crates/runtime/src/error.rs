//! Errors of the runtime, as sentences for operators: failure, place, reason and remedy.

use apex_model::time::Time;
use std::path::PathBuf;
use thiserror::Error;

/// A run stopped before its end.
#[derive(Debug, Error)]
pub enum RunError {
    /// The link to the vehicle is lost.
    #[error("the vehicle failed at {at}: {message}")]
    Vehicle {
        /// Instant.
        at: Time,
        /// The vehicle's message.
        message: String,
    },
    /// An observer cannot continue, usually the recorder.
    #[error("the run stopped at {at}: {message}")]
    Observer {
        /// Instant.
        at: Time,
        /// The observer's message.
        message: String,
    },
    /// An input source produces inputs faster than the agents consume them.
    #[error(
        "more than {limit} inputs wait at {at}, because a source sends them faster than any vehicle; look for a loop in the vehicle or in the input file"
    )]
    InboxFull {
        /// Instant.
        at: Time,
        /// The limit.
        limit: usize,
    },
    /// More than the permitted number of steps at one instant.
    #[error(
        "time stands still at {at}: more than {limit} steps at one instant, the last caused by {cause}; look for a repeating step whose work takes no time"
    )]
    Stuck {
        /// Instant.
        at: Time,
        /// The limit.
        limit: u64,
        /// Cause of the last step.
        cause: String,
    },
    /// An option is invalid.
    #[error("{0}")]
    Options(String),
}

/// A flight record cannot be written or read.
#[derive(Debug, Error)]
pub enum RecordError {
    /// The file does not exist.
    #[error("there is no flight record at {}; check the name: `apex fly` prints where it writes", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// The file is not a flight record.
    #[error("{} is not a flight record of Apex ({found}), and it is left as it is; choose another file name", path.display())]
    NotARecord {
        /// The file.
        path: PathBuf,
        /// Apparent kind of the file.
        found: String,
    },
    /// The file was written by a later Apex.
    #[error("{} was written in version {found} of the record format; this Apex reads up to version {known}; use a newer Apex", path.display())]
    Newer {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: i64,
        /// The version that this Apex reads and writes.
        known: i64,
    },
    /// The file was written by an earlier Apex, in another layout.
    #[error("{} was written in version {found} of the record format; this Apex reads version {known}, whose rows are sealed; use the Apex that wrote it, or fly again", path.display())]
    Older {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: i64,
        /// The version that this Apex reads and writes.
        known: i64,
    },
    /// The file was written by an earlier Apex, in a layout that can be converted.
    #[error("the record was written in version {found} of the format, this Apex reads version {known}: write it in that version with `apex convert {0} NEW.apex`", path.display())]
    Convertible {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: i64,
        /// The version that this Apex reads and writes.
        known: i64,
    },
    /// Another program writes it now.
    #[error("{} is being written by another run; wait for its end or choose another file name", path.display())]
    Busy {
        /// The file.
        path: PathBuf,
    },
    /// The file cannot be made or written.
    #[error("the flight record {} cannot be written while {doing}: {reason}; check the folder and its permissions, or choose another place", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Activity that failed.
        doing: String,
        /// The system's reason.
        reason: String,
    },
    /// The disk is full.
    #[error("the disk is full: the flight record {} ends while {doing}, and the part before can be read; free some space or record to another disk, then fly again", path.display())]
    DiskFull {
        /// The file.
        path: PathBuf,
        /// Activity that failed.
        doing: String,
    },
    /// A write failed during the flight, and none succeeded until its end.
    #[error("the recording was lost at {since} because {reason}: the flight record {} holds {}, and {steps} later steps that were kept in memory are not in it; free some space or record to another disk, then fly again", path.display(), held_text(*held))]
    Lost {
        /// The file.
        path: PathBuf,
        /// The instant of the failed write. Earlier steps of the open group may be lost, too.
        since: Time,
        /// The instant of the last stored step; `None` if no step is stored.
        held: Option<Time>,
        /// The system's reason.
        reason: String,
        /// Number of steps that were kept in memory.
        steps: u64,
    },
    /// The file is a record, but parts of it cannot be read.
    #[error("the flight record {} is damaged: {what}; `apex recover` saves the part before the damage into a new record", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Place and kind of the damage.
        what: String,
    },
    /// A recovery that finds nothing to save.
    #[error("nothing can be recovered of the flight record {}: {what}", path.display())]
    Unrecoverable {
        /// The file.
        path: PathBuf,
        /// Place and kind of the damage.
        what: String,
    },
    /// Another file has taken the place of the record while it was read, or its contents were exchanged.
    #[error("the flight record {} is not the one that was opened: another flight was recorded or copied there; open it again to read that one", path.display())]
    Replaced {
        /// The file.
        path: PathBuf,
    },
    /// The write-ahead log next to the record belongs to another flight.
    #[error("the flight record {} cannot be read with the log {} next to it, which belongs to another flight or to an earlier state: it does not continue the {groups} groups of the file; move the log elsewhere to read the file alone, or put the log of this flight there", path.display(), log.display())]
    ForeignLog {
        /// The file.
        path: PathBuf,
        /// The log.
        log: PathBuf,
        /// Number of valid groups in the file alone.
        groups: i64,
    },
    /// The mission in the record cannot be loaded by this Apex.
    #[error("the mission inside {} cannot be loaded: {message}", path.display())]
    Load {
        /// The file.
        path: PathBuf,
        /// The loader's message.
        message: String,
    },
    /// The record contains no answer: it has no step up to the requested instant, or the name is unknown.
    #[error("{0}")]
    Question(String),
}

fn held_text(held: Option<Time>) -> String {
    held.map_or_else(|| "no step".to_string(), |at| format!("the steps up to {at}"))
}
