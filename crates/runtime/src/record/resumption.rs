//! Attempts to store the steps kept since a failed write, in the same file or in a new segment.

use super::checkpoints::Checkpoints;
use super::disk_news::{DiskNews, GAP, Resumption};
use super::kept_rows::KeptRows;
use super::schema::remove;
use super::seal::ChainPosition;
use super::segments::{self, CONTINUES, Continuation};
use super::store::{Store, text};
use super::tables::{TABLES, Table};
use crate::error::RecordError;
use crate::limits::RECORDING_SEGMENT_ATTEMPTS;
use std::path::{Path, PathBuf};
use std::time::Instant;

impl Store {
    /// Tries to store the steps kept since a failed write: in the same file, later in a new segment. `is_last`: no further attempt
    /// follows.
    pub(super) fn resume(&mut self, is_last: bool) {
        let Some(loss) = &mut self.loss else { return };
        loss.attempts += 1;
        let may_leave = is_last || loss.attempts >= RECORDING_SEGMENT_ATTEMPTS;
        self.group = None;
        let kept = std::mem::replace(&mut self.kept, KeptRows::new(0));
        let gap = kept.gap().map(|gap| (gap.first_batch, gap.last_batch));
        let mut segment = None;
        let mut is_stored = self.store_kept(&kept).inspect_err(|_| self.abandon_group()).is_ok();
        if !is_stored && may_leave {
            segment = self.begin_segment(&kept);
            is_stored = segment.is_some();
        }
        let resumption = Resumption { kept: kept.steps(), gap, segment };
        self.kept = kept;
        if is_stored {
            self.group = None;
            self.kept.clear();
            self.loss = None;
            self.news.push(DiskNews::Resumed(resumption));
        } else if let Some(loss) = &mut self.loss {
            loss.tried = Instant::now();
        }
    }

    fn store_kept(&mut self, kept: &KeptRows) -> rusqlite::Result<()> {
        kept.each(|table, cells| self.store(table, cells.iter().copied()))?;
        self.store_gap(kept)?;
        self.seal_and_commit()
    }

    /// Records in the file which steps are missing.
    fn store_gap(&mut self, kept: &KeptRows) -> rusqlite::Result<()> {
        let Some(gap) = kept.gap() else { return Ok(()) };
        self.store_fact(GAP, &format!("{} {}", gap.first_batch, gap.last_batch))
    }

    fn store_fact(&mut self, key: &str, value: &str) -> rusqlite::Result<()> {
        let position = self.next_position(Table::Meta);
        self.store(Table::Meta, position.into_iter().chain([text(Some(key)), text(Some(value))]))
    }

    /// Continues in the first new file that accepts the kept steps.
    fn begin_segment(&mut self, kept: &KeptRows) -> Option<PathBuf> {
        let candidates = self.places.next(&self.path);
        candidates.into_iter().find(|segment| self.try_segment(segment, kept).is_ok())
    }

    fn try_segment(&mut self, segment: &Path, kept: &KeptRows) -> Result<(), RecordError> {
        let connection = self.places.make(segment, &self.path)?;
        connection.set_prepared_statement_cache_capacity(2 * TABLES);
        let before = (self.connection.replace(connection), self.link, self.counts);
        match self.store_segment(kept) {
            Ok(()) => {
                self.checkpoints = Checkpoints::begin(segment);
                let path = std::mem::replace(&mut self.path, segment.to_path_buf());
                segments::leave(before.0, &path);
                Ok(())
            }
            Err(error) => {
                self.abandon_group();
                (self.connection, self.link, self.counts) = before;
                remove(segment);
                Err(super::schema::write_error(segment, "beginning a segment", error))
            }
        }
    }

    /// Stores the first group of a segment, which names the file that it continues.
    fn store_segment(&mut self, kept: &KeptRows) -> rusqlite::Result<()> {
        let path = std::path::absolute(&self.path).unwrap_or_else(|_| self.path.clone());
        let continuation = Continuation { after: self.link, batch: self.committed_batch, path };
        self.link = ChainPosition::default();
        if let Some(connection) = &self.connection {
            connection.execute_batch(self.durability.pragma())?;
        }
        kept.each_of_segment(|table, cells| self.store(table, cells.iter().copied()))?;
        self.store_fact(CONTINUES, &continuation.to_string())?;
        if continuation.batch > 0 {
            self.store_fact(GAP, &format!("1 {}", continuation.batch))?;
        }
        self.store_gap(kept)?;
        self.seal_and_commit()
    }
}
