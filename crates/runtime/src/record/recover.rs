//! Recovery: writes a new record with everything of an old one that is valid.
//!
//! SQLite first completes its unfinished work (a write-ahead log, a half-written transaction) on a copy. Then the groups are checked in
//! order, and those that fit their seals are written into the new file, which is sealed. The old file remains unchanged.

use super::check::{CheckProgress, Damage, Visitor, check_groups, check_schema};
use super::closing;
use super::connect::connect;
use super::schema::{self, remove, write_error};
use super::seal::Seal;
use super::segment_join::{Joined, SegmentChain};
use super::tables::{ALL, TABLES, Table};
use crate::error::RecordError;
use apex_model::time::Time;
use rusqlite::types::ToSqlOutput;
use rusqlite::{Connection, Row, params, params_from_iter};
use std::path::Path;

/// Result of a recovery.
#[derive(Clone, Debug)]
pub struct Recovered {
    /// Number of groups that fit their seals.
    pub groups: i64,
    /// Number of steps in them.
    pub steps: i64,
    /// The instant of the last of these steps.
    pub until: Time,
    /// The first group that is lost.
    pub damage: Option<Damage>,
}

/// Writes the valid part of the record at `from` into a new record at `to`.
///
/// # Errors
/// [`RecordError`] if `from` is not a record of this version, or `to` cannot be written; [`RecordError::Unrecoverable`] if `from` has no
/// step that can be trusted.
pub fn recover(from: &Path, to: &Path) -> Result<Recovered, RecordError> {
    let same =
        std::fs::canonicalize(from).ok().zip(std::fs::canonicalize(to).ok()).is_some_and(|(from, to)| from == to);
    if same {
        return Err(RecordError::Question(format!("{} cannot be recovered into itself", from.display())));
    }
    // A segment whose earlier files are missing is recovered alone; other faults are found below.
    if let Ok(Some(chain)) = SegmentChain::open(from) {
        return recover_segments(&chain, from, to);
    }
    let lost = |what| RecordError::Unrecoverable { path: from.to_path_buf(), what };
    let (source, _, _copy) = connect(from).map_err(|error| match error {
        RecordError::Damaged { what, .. } => lost(what),
        other => other,
    })?;
    check_schema(&source).map_err(lost)?;
    let target = schema::create(to)?;
    let fail = |error| write_error(to, "recovering", error);
    let mut copier = Copier { target: &target, inserts: ALL.map(Table::insert), failure: None };
    target.execute_batch("BEGIN").map_err(fail)?;
    let mut position = CheckProgress::default();
    let damage = check_groups(&source, &mut position, &mut copier).err();
    let failure = copier.failure.take();
    if !target.is_autocommit() {
        target.execute_batch("ROLLBACK").map_err(fail)?;
    }
    if let Some(error) = failure {
        drop(target);
        remove(to);
        return Err(fail(error));
    }
    if position.link.id == 0 || saves_nothing(&position, damage.as_ref()) {
        drop(target);
        remove(to);
        let reason = damage.map_or_else(|| "it holds nothing".to_owned(), |damage| damage.to_string());
        return Err(lost(reason));
    }
    closing::close(target, to)?;
    Ok(Recovered { groups: position.link.id, steps: position.batch, until: position.now, damage })
}

/// Returns true if the record is damaged before its first step: a file without steps would look like a recovered flight.
fn saves_nothing(position: &CheckProgress, damage: Option<&Damage>) -> bool {
    position.batch == 0 && damage.is_some()
}

/// Joins the segments of a record into one file.
fn recover_segments(chain: &SegmentChain, from: &Path, to: &Path) -> Result<Recovered, RecordError> {
    let is_one = |path: &Path| std::fs::canonicalize(path).ok() == std::fs::canonicalize(to).ok();
    if to.exists() && chain.paths().iter().any(|path| is_one(path)) {
        return Err(RecordError::Question(format!("{} cannot be recovered into one of its segments.", from.display())));
    }
    let target = schema::create(to)?;
    match chain.join_into(&target, to) {
        Ok(Joined { position, damage: Some(damage), .. }) if saves_nothing(&position, Some(&damage)) => {
            drop(target);
            remove(to);
            Err(RecordError::Unrecoverable { path: from.to_path_buf(), what: damage.to_string() })
        }
        Ok(Joined { position, damage, .. }) => {
            closing::close(target, to)?;
            Ok(Recovered { groups: position.link.id, steps: position.batch, until: position.now, damage })
        }
        Err(error) => {
            drop(target);
            remove(to);
            Err(error)
        }
    }
}

/// Writes the rows of each group, and commits them if the seal fits.
struct Copier<'c> {
    target: &'c Connection,
    inserts: [String; TABLES],
    /// The new file cannot be written.
    failure: Option<rusqlite::Error>,
}

impl Copier<'_> {
    fn keep(&mut self, done: rusqlite::Result<()>) -> rusqlite::Result<()> {
        done.map_err(|error| {
            self.failure = Some(error);
            rusqlite::Error::InvalidQuery
        })
    }

    fn insert(&self, table: usize, row: &Row<'_>) -> rusqlite::Result<()> {
        let Some(sql) = self.inserts.get(table) else { return Ok(()) };
        let columns = row.as_ref().column_count();
        let cells = (0..columns).map(|column| row.get_ref(column).map(ToSqlOutput::Borrowed));
        let cells: Vec<ToSqlOutput<'_>> = cells.collect::<rusqlite::Result<_>>()?;
        self.target.prepare_cached(sql)?.execute(params_from_iter(cells)).map(|_| ())
    }

    fn seal(&self, seal: &Seal) -> rusqlite::Result<()> {
        let row = params![seal.id, seal.t_ns, seal.batch, seal.count_bytes(), seal.chain];
        self.target.prepare_cached("INSERT INTO seal VALUES (?1, ?2, ?3, ?4, ?5)")?.execute(row)?;
        self.target.execute_batch("COMMIT; BEGIN")
    }
}

impl Visitor for Copier<'_> {
    fn row(&mut self, table: usize, row: &Row<'_>) -> rusqlite::Result<()> {
        let done = self.insert(table, row);
        self.keep(done)
    }

    fn sealed(&mut self, seal: &Seal) -> rusqlite::Result<()> {
        let done = self.seal(seal);
        self.keep(done)
    }
}
