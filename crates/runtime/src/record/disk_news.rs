//! Messages about the disk of a record, and their state while the disk accepts no writes.

use crate::error::RecordError;
use apex_model::time::Time;
use std::path::PathBuf;
use std::time::Instant;

/// The fact that names steps which are not in the record: numbers of the first and the last.
pub(super) const GAP: &str = "gap";

/// A message about the disk under a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum DiskNews {
    /// A write failed, for this reason: steps are kept in memory from now on.
    Lost(String),
    /// The kept steps are stored.
    Resumed(Resumption),
}

/// The continuation of a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Resumption {
    /// Number of steps that were kept in memory.
    pub(super) kept: u64,
    /// First and last of the batches that memory could not keep.
    pub(super) gap: Option<(i64, i64)>,
    /// The new file in which the record continues; `None` if it continues in the same file.
    pub(super) segment: Option<PathBuf>,
}

/// Since when and why nothing is written.
pub(super) struct RecordingLoss {
    pub(super) since: Time,
    pub(super) reason: String,
    pub(super) tried: Instant,
    pub(super) attempts: u32,
    /// Kept steps that attempts have stored so far, and the segment that the last of them has begun.
    pub(super) stored: u64,
    pub(super) segment: Option<PathBuf>,
    /// First and last batch of those that memory could not keep.
    pub(super) gap: Option<(i64, i64)>,
}

impl RecordingLoss {
    pub(super) fn new(since: Time, reason: String) -> RecordingLoss {
        RecordingLoss { since, reason, tried: Instant::now(), attempts: 0, stored: 0, segment: None, gap: None }
    }
}

/// Returns the reason in a few words.
pub(super) fn reason_of(error: &RecordError) -> String {
    match error {
        RecordError::DiskFull { .. } => "the disk is full".into(),
        RecordError::Unwritable { reason, .. } => reason.clone(),
        other => other.to_string(),
    }
}
