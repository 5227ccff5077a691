//! Joins the segments of a record (`segments.rs`) into one record, whose groups are sealed as one chain.
//!
//! Each file is checked by its own seals, and each link by the chain that the later segment names. Rows that a segment repeats are taken
//! from the file that contained them first. Bound: every file is read once.

use super::check::{CheckProgress, Damage, Visitor, check_groups, check_schema};
use super::connect::{Copied, connect};
use super::disk_news::GAP;
use super::file_seal::FileSeal;
use super::kept_rows::lasts;
use super::schema::{self, write_error};
use super::seal::{ChainPosition, Seal, Sealer};
use super::segments::{CONTINUES, Continuation, SEGMENT_SNAPSHOT, continuation};
use super::tables::{ALL, TABLES, Table};
use crate::error::RecordError;
use rusqlite::types::{ToSqlOutput, ValueRef};
use rusqlite::{Connection, Row, params, params_from_iter};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Greatest number of segments of one record: with more, the links form a circle or the disk accepts almost nothing.
const CHAIN_MAX: usize = 1_000;

/// One file of a record.
struct SegmentFile {
    path: PathBuf,
    connection: Connection,
    seal: FileSeal,
    /// Keeps the copy that is read in its place.
    _copy: Option<Arc<Copied>>,
    /// The end of the part that the next segment continues; `None` in the last file.
    until: Option<ChainPosition>,
    continues: Option<Continuation>,
}

/// The files of the record that ends with the segment at `path`, the earliest first.
pub(super) struct SegmentChain(Vec<SegmentFile>);

/// Result of joining.
pub(super) struct Joined {
    /// The end of the joined record.
    pub(super) position: CheckProgress,
    /// The first group of the last segment that does not fit.
    pub(super) damage: Option<Damage>,
    /// Groups of the last segment that are in the joined record.
    progress: CheckProgress,
    state: JoinState,
}

/// The files before the segment at `path` are missing, or are not those that it continues.
#[derive(Debug)]
pub(super) enum ChainFault {
    /// The file was not found.
    Missing(PathBuf),
    /// Another fault of the record.
    Other(RecordError),
}

impl From<RecordError> for ChainFault {
    fn from(error: RecordError) -> ChainFault {
        ChainFault::Other(error)
    }
}

impl SegmentChain {
    /// Opens all files of the record that ends with `path`; `None` if that file continues no other.
    pub(super) fn open(path: &Path) -> Result<Option<SegmentChain>, ChainFault> {
        let mut files = vec![SegmentFile::open(path, None)?];
        while let Some(first) = files.last()
            && let Some(continues) = &first.continues
        {
            let earlier = continues.find(&first.path).ok_or_else(|| ChainFault::Missing(continues.path.clone()))?;
            if files.len() >= CHAIN_MAX {
                return Err(damaged(path, format!("it continues more than {CHAIN_MAX} files")).into());
            }
            let file = SegmentFile::open(&earlier, Some(continues.after))?;
            files.push(file);
        }
        files.reverse();
        Ok((files.len() > 1).then_some(SegmentChain(files)))
    }

    /// Returns the files, the earliest first.
    pub(super) fn paths(&self) -> Vec<PathBuf> {
        self.0.iter().map(|file| file.path.clone()).collect()
    }

    /// Returns true if one of the files was changed after it was closed.
    pub(super) fn is_changed(&self) -> bool {
        self.0.iter().any(|file| file.seal == FileSeal::Broken)
    }

    /// Writes all groups into the new record at `to`. Of the last file the groups before a damage are taken.
    pub(super) fn join_into(&self, target: &Connection, to: &Path) -> Result<Joined, RecordError> {
        let fail = |error| write_error(to, "joining segments", error);
        target.execute_batch("BEGIN").map_err(fail)?;
        let mut joiner = Joiner::new(target);
        let mut damage = None;
        let mut progress = CheckProgress::default();
        for file in &self.0 {
            joiner.begin(file);
            progress = CheckProgress::default();
            damage = check_groups(&file.connection, &mut progress, &mut joiner).err();
            if let Some(error) = joiner.failure.take() {
                return Err(fail(error));
            }
            let Some(until) = file.until else { break };
            if joiner.state.reached != Some(until) {
                let found =
                    damage.map_or_else(|| "its groups are not those before it".into(), |found| found.to_string());
                return Err(damaged(&file.path, format!("a later segment continues it, and {found}")));
            }
        }
        let state = joiner.state;
        // Rows of a group that does not fit its seal are not taken.
        target.execute_batch(if damage.is_some() { "ROLLBACK" } else { "COMMIT" }).map_err(fail)?;
        let mut position = CheckProgress::default();
        check_groups(target, &mut position, &mut super::check::NoVisitor)
            .map_err(|damage| damaged(to, damage.to_string()))?;
        Ok(Joined { position, damage, progress, state })
    }

    /// Continues a joined record from now on.
    pub(super) fn follow(mut self, target: Connection, joined: Joined) -> Option<SharedFollower> {
        let Joined { progress, state, .. } = joined;
        let file = self.0.pop()?;
        Some(Arc::new(Mutex::new(SegmentFollower { target, file, progress, state })))
    }
}

/// Continues a joined record while its last segment grows; shared by the readers of the joined record.
pub(super) type SharedFollower = Arc<Mutex<SegmentFollower>>;

/// Continues a joined record while its last segment grows.
pub(super) struct SegmentFollower {
    target: Connection,
    file: SegmentFile,
    /// Groups of the last segment that are in the joined record.
    progress: CheckProgress,
    state: JoinState,
}

impl SegmentFollower {
    /// Writes the groups that the last segment has got since the last call into the joined record.
    pub(super) fn advance(&mut self) -> Result<(), RecordError> {
        let SegmentFollower { target, file, progress, state } = self;
        let last = file.connection.prepare_cached("SELECT max(id) FROM main.seal");
        let last = last.and_then(|mut statement| statement.query_row([], |row| row.get::<_, Option<i64>>(0)));
        if last.map_err(|error| schema::read_error(&file.path, "its seals", error))?.unwrap_or(0) == progress.link.id {
            return Ok(());
        }
        let fail = |error| write_error(&file.path, "joining segments", error);
        match take_new_groups(target, &file.connection, progress, state) {
            Ok(Ok(())) => Ok(()),
            Ok(Err(damage)) => Err(damaged(&file.path, damage.to_string())),
            Err(error) => Err(fail(error)),
        }
    }
}

/// Writes the groups of a growing segment after `progress` into the joined record. Each group is committed as soon as it was found to fit
/// its seal. After damage or a failed write nothing of the group concerned remains, so that a later call can take it as a whole.
fn take_new_groups(
    target: &Connection,
    segment: &Connection,
    progress: &mut CheckProgress,
    state: &mut JoinState,
) -> rusqlite::Result<Result<(), Damage>> {
    target.execute_batch("BEGIN")?;
    let mut joiner = Joiner { target, state: std::mem::take(state), failure: None };
    joiner.state.extra = extra_snapshots(segment);
    let checked = check_groups(segment, progress, &mut joiner);
    let failure = joiner.failure.take();
    *state = joiner.state;
    if failure.is_none() && checked.is_ok() {
        target.execute_batch("COMMIT")?;
        return Ok(Ok(()));
    }
    state.keys = state.sealed_keys;
    state.sealer.clear();
    // A full disk may have ended the transaction already.
    if !target.is_autocommit() {
        target.execute_batch("ROLLBACK")?;
    }
    failure.map_or(Ok(checked), Err)
}

impl SegmentFile {
    fn open(path: &Path, until: Option<ChainPosition>) -> Result<SegmentFile, RecordError> {
        let (connection, seal, copy) = connect(path)?;
        check_schema(&connection).map_err(|what| damaged(path, what))?;
        let fact = continuation(&connection).map_err(|error| schema::read_error(path, "the facts", error))?;
        let parse = |text: String| {
            Continuation::parse(&text).ok_or_else(|| damaged(path, format!("the fact `{CONTINUES}` is garbled")))
        };
        let continues = fact.map(parse).transpose()?;
        Ok(SegmentFile { path: path.to_path_buf(), connection, seal, _copy: copy, until, continues })
    }
}

fn damaged(path: &Path, what: String) -> RecordError {
    RecordError::Damaged { path: path.to_path_buf(), what }
}

/// Writes the rows of segments into one record.
struct Joiner<'c> {
    target: &'c Connection,
    state: JoinState,
    /// The joined record cannot be written.
    failure: Option<rusqlite::Error>,
}

/// Progress of joining.
#[derive(Default)]
struct JoinState {
    inserts: [String; TABLES],
    sealer: Sealer,
    link: ChainPosition,
    /// Last keys that the joined record has.
    keys: [i64; TABLES],
    /// Last keys of its sealed groups.
    sealed_keys: [i64; TABLES],
    until: Option<ChainPosition>,
    /// The seal at which the file ends, once it was found.
    reached: Option<ChainPosition>,
    /// The gap before a segment, which its earlier files fill.
    filled: Option<String>,
    /// Steps after which a snapshot exists only because a segment began: replay takes none there.
    extra: Vec<i64>,
}

impl<'c> Joiner<'c> {
    fn new(target: &'c Connection) -> Joiner<'c> {
        let inserts = ALL.map(Table::insert);
        Joiner {
            target,
            state: JoinState {
                inserts,
                keys: [i64::MIN; TABLES],
                sealed_keys: [i64::MIN; TABLES],
                ..JoinState::default()
            },
            failure: None,
        }
    }

    fn begin(&mut self, file: &SegmentFile) {
        self.state.sealer.clear();
        (self.state.until, self.state.reached) = (file.until, None);
        self.state.filled = file.continues.as_ref().map(|continues| format!("1 {}", continues.batch));
        self.state.extra = extra_snapshots(&file.connection);
    }

    /// Returns true for a row that the joined record needs.
    fn takes(&self, table: Table, key: i64, row: &Row<'_>) -> rusqlite::Result<bool> {
        let last = self.state.keys.get(table.index()).copied().unwrap_or(i64::MIN);
        if lasts(table) && key <= last {
            return Ok(false);
        }
        match table {
            Table::Meta => {
                let (fact, value): (String, String) = (row.get(1)?, row.get(2)?);
                let of_segment = [CONTINUES, SEGMENT_SNAPSHOT].contains(&&*fact);
                let is_filled = fact == GAP && self.state.filled.as_ref() == Some(&value);
                Ok(!(of_segment || is_filled))
            }
            Table::Snapshot | Table::Situation => Ok(!self.state.extra.contains(&key)),
            _ => Ok(true),
        }
    }

    fn write(&mut self, table: Table, row: &Row<'_>) -> rusqlite::Result<()> {
        let columns = row.as_ref().column_count();
        let cells: Vec<ValueRef<'_>> =
            (0..columns).map(|column| row.get_ref(column)).collect::<rusqlite::Result<_>>()?;
        let sql = self.state.inserts.get(table.index()).map_or("", String::as_str);
        let values = cells.iter().map(|cell| ToSqlOutput::Borrowed(*cell));
        self.target.prepare_cached(sql)?.execute(params_from_iter(values))?;
        self.state.sealer.row(table.index(), cells.iter().copied());
        Ok(())
    }

    fn seal(&mut self, seal: &Seal) -> rusqlite::Result<()> {
        if self.state.sealer.is_empty() {
            return Ok(());
        }
        let seal = self.state.sealer.seal(self.state.link, seal.t_ns, seal.batch);
        let row = params![seal.id, seal.t_ns, seal.batch, seal.count_bytes(), seal.chain];
        self.target.prepare_cached("INSERT INTO seal VALUES (?1, ?2, ?3, ?4, ?5)")?.execute(row)?;
        self.target.execute_batch("COMMIT; BEGIN")?;
        (self.state.link, self.state.sealed_keys) = (seal.link(), self.state.keys);
        Ok(())
    }

    fn keep<T>(&mut self, done: rusqlite::Result<T>) -> rusqlite::Result<T> {
        done.map_err(|error| {
            self.failure = Some(error);
            rusqlite::Error::InvalidQuery
        })
    }
}

/// Returns the steps after which a segment has a snapshot only because it began there.
fn extra_snapshots(connection: &Connection) -> Vec<i64> {
    let sql = "SELECT CAST(value AS INTEGER) FROM main.meta WHERE key = ?1";
    let found = connection.prepare(sql).and_then(|mut statement| {
        statement.query_map([SEGMENT_SNAPSHOT], |row| row.get(0))?.collect::<rusqlite::Result<Vec<i64>>>()
    });
    // Facts that cannot be read are found by the check of their group.
    found.unwrap_or_default()
}

impl Visitor for Joiner<'_> {
    fn row(&mut self, table: usize, row: &Row<'_>) -> rusqlite::Result<()> {
        // A segment also has the rows of later groups of the preceding file: those groups were not acknowledged to the recorder.
        let is_over = self.state.until.is_some() && self.state.reached.is_some();
        let Some(table) = ALL.get(table).copied().filter(|_| !is_over) else { return Ok(()) };
        let key: i64 = row.get(0)?;
        if !self.takes(table, key, row)? {
            return Ok(());
        }
        let written = self.write(table, row);
        self.keep(written)?;
        if let Some(last) = self.state.keys.get_mut(table.index()) {
            *last = key;
        }
        Ok(())
    }

    fn sealed(&mut self, seal: &Seal) -> rusqlite::Result<()> {
        if self.state.until.is_some() && self.state.reached.is_some() {
            return Ok(());
        }
        let sealed = self.seal(seal);
        self.keep(sealed)?;
        if self.state.until.is_some_and(|until| until.id == seal.id) {
            self.state.reached = Some(seal.link());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::check::NoVisitor;
    use crate::record::tests::closed_record;

    #[test]
    fn a_group_that_could_not_be_written_is_taken_as_a_whole_later() {
        let (folder, path) = closed_record();
        let (segment, _, _) = connect(&path).unwrap();
        let target = schema::create(&folder.path().join("joined.apex")).unwrap();
        let mut state = Joiner::new(&target).state;
        let mut progress = CheckProgress::default();
        let count = |connection: &Connection, table: &str| {
            connection.query_row(&format!("SELECT count(*) FROM main.{table}"), [], |row| row.get::<_, i64>(0)).unwrap()
        };
        let refusal =
            "CREATE TEMP TRIGGER refusal BEFORE INSERT ON main.effects BEGIN SELECT RAISE(ABORT, 'full'); END";
        target.execute_batch(refusal).unwrap();
        assert!(take_new_groups(&target, &segment, &mut progress, &mut state).is_err());
        assert_eq!(count(&target, "seal"), progress.link.id, "only whole groups are in the joined record");
        target.execute_batch("DROP TRIGGER temp.refusal").unwrap();
        take_new_groups(&target, &segment, &mut progress, &mut state).unwrap().unwrap();
        for table in ["batch", "effects", "source", "word", "note", "meta"] {
            assert_eq!(count(&target, table), count(&segment, table), "{table}");
        }
        let mut position = CheckProgress::default();
        check_groups(&target, &mut position, &mut NoVisitor).unwrap();
        assert_eq!(position.batch, progress.batch);
    }
}
