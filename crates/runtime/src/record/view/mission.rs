//! The mission: its name, its span of time, and whether the record still grows.

use super::RecordView;
use crate::error::RecordError;
use apex_model::task::is_failure_word;
use rusqlite::Connection;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// An incomplete record without a write for this long has no writer. A live flight commits several times a second; the margin is for a
/// machine under load.
const WRITER_SILENCE: Duration = Duration::from_secs(10);

/// State of the record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "lowercase")]
pub enum RecordStatus {
    /// Closed properly; nothing will be added.
    Complete,
    /// Being written now.
    Live,
    /// Not closed properly, and without a writer: the flight was cut off.
    Incomplete,
}

impl RecordStatus {
    /// Returns true if the record can no longer grow.
    pub fn is_final(self) -> bool {
        self == RecordStatus::Complete
    }
}

/// Growth of a record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Growth {
    /// Mission time in nanoseconds of the last recorded step.
    pub end_ns: i64,
    /// Number of executive steps.
    pub batches: i64,
    /// State of the record.
    pub status: RecordStatus,
}

/// End of a flight.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Ending {
    /// Reason.
    pub reason: String,
    /// True if its initial task failed.
    pub failed: bool,
}

/// Facts about the flight, as known at an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Mission {
    /// The mission's name.
    pub mission: Option<String>,
    /// The agent's name.
    pub agent: Option<String>,
    /// The vehicle's name.
    pub vehicle: Option<String>,
    /// The version of Apex that wrote the record.
    pub apex_version: Option<String>,
    /// The record's file name.
    pub record: String,
    /// Civil time of mission time 0, RFC 3339.
    pub epoch_utc: Option<String>,
    /// Mission time in nanoseconds of the first recorded step.
    pub from_ns: i64,
    /// End of the flight; `None` before.
    pub ending: Option<Ending>,
    /// Growth of the record.
    #[serde(flatten)]
    pub growth: Growth,
    /// Number of tasks created by the instant.
    pub tasks: usize,
    /// Number of observation targets known by the instant.
    pub targets: usize,
    /// Number of these targets that were observed by the instant.
    pub observed: usize,
    /// The mission's score, if the report contains one; `None` before the flight's end.
    pub score: Option<f64>,
    /// Kind of the score: `mission-score`, of which more is better, or `expected-cost-of-ignorance`, of which less is; none without
    /// a score, and for scores that do not say it.
    pub score_kind: Option<String>,
}

impl RecordView {
    /// Returns facts about the flight as known at mission time `at_ns` (nanoseconds); `None` means the record's end.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn mission(&mut self, at_ns: Option<i64>) -> Result<Mission, RecordError> {
        let growth = self.growth()?;
        let at_ns = at_ns.unwrap_or(i64::MAX);
        let index = self.tasks_index()?;
        let tasks = index.tasks().values().filter(|task| task.state_at(at_ns).is_some()).count();
        let root_failed = index.tasks().values().filter(|task| task.parent.is_none()).any(|root| {
            root.state_at(at_ns)
                .is_some_and(|now| now.outcome.word().is_some_and(is_failure_word) && !now.state.is_alive())
        });
        drop(index);
        let targets = self.targets(Some(at_ns))?.targets;
        let meta = |key: &str| self.reader.meta(key).map(|value| value.filter(|text| !text.is_empty()));
        let file_name = self.reader.path().file_name();
        let report = self.report(Some(at_ns))?;
        let reason = meta("end_reason")?.filter(|_| self.is_over(&growth, at_ns));
        Ok(Mission {
            mission: meta("mission")?,
            agent: meta("agent")?,
            vehicle: meta("vehicle")?,
            apex_version: meta("apex_version")?,
            record: file_name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
            epoch_utc: meta("epoch_utc")?,
            from_ns: self.first_ns()?,
            ending: reason.map(|reason| Ending { failed: root_failed, reason }),
            tasks,
            targets: targets.len(),
            observed: targets.iter().filter(|target| target.observed_ns.is_some()).count(),
            score: report.score(),
            score_kind: report.score_kind(),
            growth,
        })
    }

    /// Returns true if the flight has ended by `at_ns`.
    pub(super) fn is_over(&self, growth: &Growth, at_ns: i64) -> bool {
        growth.status.is_final() && at_ns >= growth.end_ns
    }

    /// Returns the growth of the record.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn growth(&self) -> Result<Growth, RecordError> {
        let complete = self.reader.is_complete()?;
        let ends = [
            self.number("the steps", "SELECT t_ns FROM batch ORDER BY id DESC LIMIT 1")?,
            self.number("the track", "SELECT max(t_ns) FROM track")?,
            self.reader.meta("end_ns")?.and_then(|text| text.parse().ok()),
        ];
        let status = match complete {
            true => RecordStatus::Complete,
            false if has_writer(self.reader.path()) => RecordStatus::Live,
            false => RecordStatus::Incomplete,
        };
        Ok(Growth {
            end_ns: ends.into_iter().flatten().max().unwrap_or(0),
            batches: self.number("the steps", "SELECT max(id) FROM batch")?.unwrap_or(0),
            status,
        })
    }

    /// Returns the mission time in nanoseconds of the first recorded step.
    pub(super) fn first_ns(&self) -> Result<i64, RecordError> {
        let starts = [
            self.number("the steps", "SELECT t_ns FROM batch ORDER BY id LIMIT 1")?,
            self.number("the track", "SELECT min(t_ns) FROM track")?,
        ];
        Ok(starts.into_iter().flatten().min().unwrap_or(0))
    }

    fn number(&self, what: &str, sql: &str) -> Result<Option<i64>, RecordError> {
        self.query(what, |connection: &Connection| {
            match connection.prepare_cached(sql)?.query_row([], |row| row.get(0)) {
                Err(rusqlite::Error::QueryReturnedNoRows) => Ok(None),
                other => other,
            }
        })
    }
}

/// Returns true if the file or its write-ahead log was written to a moment ago.
fn has_writer(path: &Path) -> bool {
    let mut log = path.as_os_str().to_owned();
    log.push("-wal");
    [path.to_path_buf(), PathBuf::from(log)].iter().any(|file| {
        let Ok(data) = std::fs::metadata(file) else { return false };
        // Opening a record creates an empty log next to it, so an empty log does not indicate a writer.
        let Some(written) = data.modified().ok().filter(|_| data.len() > 0) else { return false };
        // A time in the future means that the clock was set back: the record then counts as live rather than as interrupted.
        SystemTime::now().duration_since(written).map_or(true, |silence| silence < WRITER_SILENCE)
    })
}
