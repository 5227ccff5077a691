//! Attempts to store the steps kept since a failed write, in the same file or in a new segment.

use super::checkpoints::Checkpoints;
use super::disk_news::{DiskNews, GAP, Resumption};
use super::kept_rows::{KeptPart, KeptRows};
use super::schema::remove;
use super::seal::ChainPosition;
use super::segments::{self, CONTINUES, Continuation};
use super::store::{SqlValue, Store, text};
use super::tables::{TABLES, Table};
use crate::error::RecordError;
use crate::limits::RECORDING_SEGMENT_ATTEMPTS;
use apex_model::time::Time;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Number of bytes of kept rows that are stored as one group: small, so that a nearly full disk still accepts some groups.
const PART_BYTES: usize = 64 << 10;

impl Store {
    /// Tries to store the steps kept since a failed write: in the same file, later in a new segment. `is_last`: no further attempt
    /// follows.
    pub(super) fn resume(&mut self, is_last: bool) {
        let Some(loss) = &mut self.loss else { return };
        loss.attempts += 1;
        let may_leave = is_last || loss.attempts >= RECORDING_SEGMENT_ATTEMPTS;
        self.group = None;
        let mut kept = std::mem::replace(&mut self.kept, KeptRows::new(0));
        let (steps, gap) = (kept.steps(), kept.gap().map(|gap| (gap.first_batch, gap.last_batch)));
        let mut segment = None;
        let mut is_stored = self.store_parts(&mut kept);
        while !is_stored && may_leave {
            let Some(begun) = self.begin_segment(&mut kept) else { break };
            segment = Some(begun);
            is_stored = self.store_parts(&mut kept);
        }
        let stored = steps.saturating_sub(kept.steps());
        self.kept = kept;
        let Some(loss) = &mut self.loss else { return };
        loss.stored += stored;
        loss.segment = segment.or(loss.segment.take());
        loss.gap = loss.gap.or(gap.filter(|_| stored > 0));
        loss.tried = Instant::now();
        if is_stored {
            let resumption = Resumption { kept: loss.stored, gap: loss.gap.or(gap), segment: loss.segment.take() };
            self.kept.clear();
            self.loss = None;
            self.news.push(DiskNews::Resumed(resumption));
        }
    }

    /// Stores the kept rows part by part, and forgets the stored parts. Returns false if the file accepts no more.
    fn store_parts(&mut self, kept: &mut KeptRows) -> bool {
        while let Some(part) = kept.part(PART_BYTES) {
            let stored = self.store_part(kept, &part).or_else(|error| {
                // The log has reached the size limit of files, or its disk is full; the main file may still accept the contents of the log.
                self.abandon_group();
                self.empty_log().map_err(|_| error)?;
                self.store_part(kept, &part)
            });
            if stored.is_err() {
                self.abandon_group();
                return false;
            }
            self.group = None;
            kept.stored(&part);
        }
        true
    }

    fn store_part(&mut self, kept: &mut KeptRows, part: &KeptPart) -> rusqlite::Result<()> {
        self.store_facts(kept, &gap_of(kept))?;
        kept.each(part, |table, cells| self.store(table, cells.iter().copied()))?;
        self.seal_part(part)
    }

    /// Commits the rows of a part with a seal that names its own last step.
    fn seal_part(&mut self, part: &KeptPart) -> rusqlite::Result<()> {
        let last = part.last.map(|(batch, at_ns)| (batch, Time(at_ns)));
        self.seal_and_commit_as(last.unwrap_or((self.committed_batch, self.committed_at.unwrap_or(Time::ZERO))))
    }

    /// Moves what the log holds into the main file, and cuts the log.
    fn empty_log(&self) -> rusqlite::Result<()> {
        let Some(connection) = &self.connection else { return Err(rusqlite::Error::InvalidQuery) };
        let busy: i64 = connection.query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |row| row.get(0))?;
        if busy == 0 { Ok(()) } else { Err(rusqlite::Error::InvalidQuery) }
    }

    /// Stores facts before those that are kept: rows of a table come in the order of their positions.
    fn store_facts(&mut self, kept: &mut KeptRows, facts: &[(&str, String)]) -> rusqlite::Result<()> {
        let count = facts.len() as u64;
        let Some(meta) = self.counts.get_mut(Table::Meta.index()).filter(|_| count > 0) else { return Ok(()) };
        *meta += count;
        let last = meta.cast_signed();
        let first = kept.make_way(count.cast_signed()).unwrap_or(last - count.cast_signed() + 1);
        for (position, (key, value)) in (first..).zip(facts) {
            let row = [SqlValue::Integer(position), text(Some(key)), text(Some(value))];
            self.store(Table::Meta, row.into_iter())?;
        }
        Ok(())
    }

    /// Continues in the first new file that accepts the first part of the kept rows.
    fn begin_segment(&mut self, kept: &mut KeptRows) -> Option<PathBuf> {
        let part = kept.part(PART_BYTES)?;
        let candidates = self.places.next(&self.path);
        let segment = candidates.into_iter().find(|segment| self.try_segment(segment, kept, &part).is_ok())?;
        self.group = None;
        kept.stored(&part);
        Some(segment)
    }

    fn try_segment(&mut self, segment: &Path, kept: &mut KeptRows, part: &KeptPart) -> Result<(), RecordError> {
        let connection = self.places.make(segment, &self.path)?;
        connection.set_prepared_statement_cache_capacity(2 * TABLES);
        let before = (self.connection.replace(connection), self.link, self.counts);
        match self.store_segment(kept, part) {
            Ok(()) => {
                self.checkpoints = Checkpoints::begin(segment);
                let path = std::mem::replace(&mut self.path, segment.to_path_buf());
                segments::leave(before.0, &path);
                Ok(())
            }
            Err(error) => {
                self.abandon_group();
                let facts = self.counts.get(Table::Meta.index()).copied();
                (self.connection, self.link, self.counts) = before;
                // The kept facts were moved to higher positions (`make_way`); the next fact comes after them.
                if let Some((count, facts)) = self.counts.get_mut(Table::Meta.index()).zip(facts) {
                    *count = facts;
                }
                remove(segment);
                Err(super::schema::write_error(segment, "beginning a segment", error))
            }
        }
    }

    /// Stores the first group of a segment, which says what it continues.
    fn store_segment(&mut self, kept: &mut KeptRows, part: &KeptPart) -> rusqlite::Result<()> {
        let path = std::path::absolute(&self.path).unwrap_or_else(|_| self.path.clone());
        let continuation = Continuation { after: self.link, batch: self.committed_batch, path };
        self.link = ChainPosition::default();
        if let Some(connection) = &self.connection {
            connection.execute_batch(self.durability.pragma())?;
        }
        kept.each_committed(|table, cells| self.store(table, cells.iter().copied()))?;
        let mut facts = vec![(CONTINUES, continuation.to_string())];
        if continuation.batch > 0 {
            facts.push((GAP, format!("1 {}", continuation.batch)));
        }
        facts.extend(gap_of(kept));
        self.store_facts(kept, &facts)?;
        kept.each(part, |table, cells| self.store(table, cells.iter().copied()))?;
        self.seal_part(part)
    }
}

/// Returns the fact that says which steps the record does not have.
fn gap_of(kept: &KeptRows) -> Vec<(&'static str, String)> {
    kept.gap().map(|gap| (GAP, format!("{} {}", gap.first_batch, gap.last_batch))).into_iter().collect()
}
