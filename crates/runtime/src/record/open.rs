//! Opens a record for reading, after comparing it with its seals.
//!
//! A closed record is checked as a whole file; any other by the hash chain of its groups, its schema and its indexes. A record in a
//! folder without write access, or one that was interrupted, is read in place or from a copy in the folder for temporary files. Bound:
//! the file is read once.

use super::check::{self, CheckProgress, Damage, NoVisitor};
use super::connect::{Copied, check_version, connect, immutable, plain};
use super::file_seal::{self, FileSeal};
use super::identity::{FileNumbers, check_same, file_numbers};
use super::schema::{self, SCHEMA_VERSION};
use super::segment_join::{ChainFault, Joined, SegmentChain, SharedFollower};
use super::segments::continuation;
use crate::error::RecordError;
use rusqlite::Connection;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// Reason to trust the rows of an open record.
#[derive(Clone, Debug)]
pub(super) enum Trust {
    /// The file equals its seal, with this length and modification time.
    File(Stamp),
    /// The groups up to here fit their seals; the seal of the file is missing or broken. The numbers are those of the file, `None` for a
    /// copy, which no other flight replaces.
    Groups(CheckProgress, FileSeal, Option<FileNumbers>),
}

/// Length and time of the last change of a file.
pub(super) type Stamp = (u64, Option<SystemTime>);

/// An open record.
pub(super) struct Opened {
    pub(super) connection: Connection,
    pub(super) trust: Trust,
    /// The copy that is read in place of the record itself.
    pub(super) copy: Option<Arc<Copied>>,
    /// The file that the record continues, if it cannot be found: this file is then read alone.
    pub(super) missing: Option<PathBuf>,
    /// Continues the copy of joined segments.
    pub(super) follower: Option<SharedFollower>,
}

/// Opens the record at `path` and checks it.
pub(super) fn open(path: &Path) -> Result<Opened, RecordError> {
    let numbers = file_numbers(path);
    let (connection, seal, copy) = connect(path)?;
    let is_segment = check::check_schema(&connection).is_ok() && !matches!(continuation(&connection), Ok(None));
    let mut missing = None;
    if is_segment {
        match SegmentChain::open(path) {
            Ok(Some(chain)) => return joined(chain),
            Ok(None) => {}
            Err(ChainFault::Missing(earlier)) => missing = Some(earlier),
            Err(ChainFault::Other(error)) => return Err(error),
        }
    }
    let damaged = |what| RecordError::Damaged { path: path.to_path_buf(), what };
    check::check_schema(&connection).map_err(damaged)?;
    let trust = match seal {
        FileSeal::Intact => Trust::File(stamp(path)),
        FileSeal::None | FileSeal::Broken => {
            let mut position = CheckProgress::default();
            check::check_groups(&connection, &mut position, &mut NoVisitor)
                .map_err(|damage| damaged(damage.to_string()))?;
            check::check_indexes(&connection).map_err(damaged)?;
            Trust::Groups(position, seal, numbers.filter(|_| copy.is_none()))
        }
    };
    Ok(Opened { connection, trust, copy, missing, follower: None })
}

/// Opens a closed record before the comparison with its seal; its rows must not be trusted until that has succeeded. `None` for a file
/// without a seal, and for one that cannot be opened.
pub(super) fn open_unchecked(path: &Path) -> Option<Opened> {
    let stamped = stamp(path);
    file_seal::bytes(&mut File::open(path).ok()?).ok()??;
    let connection = immutable(path).ok()?;
    check_version(&connection, path, SCHEMA_VERSION).ok()?;
    check::check_schema(&connection).ok()?;
    Some(Opened { connection, trust: Trust::File(stamped), copy: None, missing: None, follower: None })
}

/// Opens a joined copy of the segments of a record: in the folder for temporary files, or next to the last segment where that takes
/// none, because both are on the disk that is full.
fn joined(chain: SegmentChain) -> Result<Opened, RecordError> {
    let path = chain.paths().pop().unwrap_or_default();
    let is_changed = chain.is_changed();
    let made = join_in(&chain, &path, &std::env::temp_dir());
    let next_to = path.parent().filter(|_| made.as_ref().is_err_and(is_of_the_disk));
    let (copy, target, found) = next_to.map_or(made, |folder| join_in(&chain, &path, folder))?;
    if let Some(damage) = &found.damage {
        return Err(RecordError::Damaged { path, what: damage.to_string() });
    }
    let position = found.position.clone();
    let follower = chain.follow(target, found);
    let seal = if is_changed { FileSeal::Broken } else { FileSeal::None };
    let connection = plain(&copy.record, &path)?;
    let trust = Trust::Groups(position, seal, None);
    Ok(Opened { connection, trust, copy: Some(Arc::new(copy)), missing: None, follower })
}

/// Joins the segments of the record that ends with `path` into a copy in a folder.
fn join_in(chain: &SegmentChain, path: &Path, folder: &Path) -> Result<(Copied, Connection, Joined), RecordError> {
    let copy = Copied::folder_in(folder).map_err(|error| RecordError::Unwritable {
        path: path.to_path_buf(),
        doing: "joining its segments".into(),
        reason: error.to_string(),
    })?;
    let target = schema::create(&copy.record)?;
    let found = chain.join_into(&target, &copy.record)?;
    Ok((copy, target, found))
}

fn is_of_the_disk(error: &RecordError) -> bool {
    matches!(error, RecordError::Unwritable { .. } | RecordError::DiskFull { .. })
}

/// Opens a record again that was checked a moment ago.
pub(super) fn open_again(
    path: &Path,
    before: (&Trust, Option<&Arc<Copied>>, Option<&SharedFollower>),
) -> Result<Opened, RecordError> {
    let (trust, copy, follower) = before;
    match trust {
        Trust::File(stamped) if *stamped != stamp(path) => open(path),
        Trust::File(_) => {
            let connection = immutable(path)?;
            Ok(Opened { connection, trust: trust.clone(), copy: None, missing: None, follower: None })
        }
        Trust::Groups(position, _, numbers) => {
            let place = copy.map_or(path, |copy| &copy.record);
            let connection = plain(place, path).or_else(|_| immutable(place))?;
            check_same(&connection, path, (position.link, *numbers))?;
            check::check_schema(&connection).map_err(|what| RecordError::Damaged { path: path.to_path_buf(), what })?;
            let (copy, follower) = (copy.cloned(), follower.cloned());
            Ok(Opened { connection, trust: trust.clone(), copy, missing: None, follower })
        }
    }
}

/// Checks the groups that were added after `position` to a record that grows, and that it is still the same record.
pub(super) fn follow(
    connection: &Connection,
    path: &Path,
    (position, numbers): (&mut CheckProgress, Option<FileNumbers>),
) -> Result<(), RecordError> {
    check_same(connection, path, (position.link, numbers))?;
    let last = connection.prepare_cached("SELECT max(id) FROM main.seal");
    let last = last.and_then(|mut statement| statement.query_row([], |row| row.get::<_, Option<i64>>(0)));
    if last.is_ok_and(|last| last.unwrap_or(0) == position.link.id) {
        return Ok(());
    }
    check::check_groups(connection, position, &mut NoVisitor)
        .map_err(|damage| RecordError::Damaged { path: path.to_path_buf(), what: damage.to_string() })
}

pub(super) fn stamp(path: &Path) -> Stamp {
    fs::metadata(path).map_or((0, None), |found| (found.len(), found.modified().ok()))
}

/// Result of a check of a whole record.
#[derive(Clone, Debug)]
pub struct Integrity {
    /// Whether the file equals its seal.
    pub file: FileSeal,
    /// Number of groups that fit their seals.
    pub groups: i64,
    /// Number of steps in them.
    pub steps: i64,
    /// The instant of the last of these steps.
    pub until: apex_model::time::Time,
    /// The first group that does not fit.
    pub damage: Option<Damage>,
    /// The files that the record continues, the earliest first.
    pub earlier: Vec<PathBuf>,
    /// Other defects: schema, pages, indexes. Rows can be trusted nevertheless if `damage` is `None`.
    pub fault: Option<String>,
}

impl Integrity {
    /// Returns true if all rows are as they were written.
    pub fn is_intact(&self) -> bool {
        self.damage.is_none() && self.fault.is_none()
    }
}

/// Checks everything that can be checked in the record at `path`, whatever its state.
///
/// # Errors
/// [`RecordError`] if the file is missing, is not a record, has another version, or is so damaged that no table can be found.
pub fn check_integrity(path: &Path) -> Result<Integrity, RecordError> {
    let (connection, file, _copy) = connect(path)?;
    let mut fault = check::check_schema(&connection).err();
    let mut position = CheckProgress::default();
    let mut damage = None;
    if fault.is_none() {
        damage = check::check_groups(&connection, &mut position, &mut NoVisitor).err();
        fault = check::check_indexes(&connection).err();
    }
    let mut earlier = Vec::new();
    if damage.is_none() && fault.is_none() && !matches!(continuation(&connection), Ok(None)) {
        match check_segments(path) {
            Ok((paths, joined)) => (earlier, position) = (paths, joined),
            Err(why) => fault = Some(why),
        }
    }
    Ok(Integrity { file, groups: position.link.id, steps: position.batch, until: position.now, damage, earlier, fault })
}

/// Checks the files that the segment at `path` continues, by joining them; returns their names, and the end of the joined record.
fn check_segments(path: &Path) -> Result<(Vec<PathBuf>, CheckProgress), String> {
    let chain = SegmentChain::open(path).map_err(|fault| match fault {
        ChainFault::Missing(earlier) => format!("it continues {}, which is not there", earlier.display()),
        ChainFault::Other(error) => error.to_string(),
    })?;
    let chain = chain.ok_or("its segments cannot be found")?;
    let copy = Copied::folder().map_err(|error| format!("its segments cannot be joined ({error})"))?;
    let target = schema::create(&copy.record).map_err(|error| error.to_string())?;
    let mut paths = chain.paths();
    paths.pop();
    let joined = chain.join_into(&target, &copy.record).map_err(|error| error.to_string())?;
    Ok((paths, joined.position))
}
