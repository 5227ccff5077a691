//! `/api/mission`: what was flown, over which time, and whether it is still going on.

use crate::answer::Answer;
use crate::queries::report;
use crate::record::Reader;
use rusqlite::Connection;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// A record that is not complete and was not written to for this long has lost its writer. A live flight commits
/// several times a second; the margin is for a machine under load.
const WRITER_SILENCE: Duration = Duration::from_secs(10);

/// Whether the record is finished.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Status {
    /// Closed properly; nothing will be added.
    Complete,
    /// Being written now.
    Live,
    /// Not closed properly, and nobody writes it: the flight broke off.
    Incomplete,
}

impl Status {
    /// True when the record can no longer grow.
    pub(crate) fn is_final(self) -> bool {
        self == Status::Complete
    }
}

/// How far the record has grown; the messages of `/api/live`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Growth {
    /// Mission time of the last thing recorded.
    pub(crate) end_ns: i64,
    /// Executive steps so far.
    pub(crate) batches: i64,
    /// Finished, growing or broken off.
    pub(crate) status: Status,
}

/// The answer.
#[derive(Debug, Serialize)]
pub(crate) struct Mission {
    mission: Option<String>,
    agent: Option<String>,
    vehicle: Option<String>,
    apex_version: Option<String>,
    /// The record's file name.
    record: String,
    /// Civil time of mission time 0, RFC 3339.
    epoch_utc: Option<String>,
    from_ns: i64,
    end_reason: Option<String>,
    #[serde(flatten)]
    growth: Growth,
    tasks: usize,
    targets: i64,
    /// The mission's score, when the report has one.
    score: Option<f64>,
}

/// Answers `/api/mission`.
pub(crate) fn mission(reader: &mut Reader) -> Answer<Mission> {
    let tasks = reader.tasks()?.tasks().len();
    let meta = |key: &str| reader.meta(key).map(|value| value.filter(|text| !text.is_empty()));
    Ok(Mission {
        mission: meta("mission")?,
        agent: meta("agent")?,
        vehicle: meta("vehicle")?,
        apex_version: meta("apex_version")?,
        record: reader.path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
        epoch_utc: meta("epoch_utc")?,
        from_ns: first_ns(&reader.connection)?,
        end_reason: meta("end_reason")?,
        growth: growth(reader)?,
        tasks,
        targets: number(&reader.connection, "SELECT count(*) FROM target")?.unwrap_or(0),
        score: report::score(reader)?,
    })
}

/// How far the record has grown.
pub(crate) fn growth(reader: &Reader) -> Answer<Growth> {
    let connection = &reader.connection;
    let complete = reader.meta("complete")?.as_deref() == Some("1");
    let ends = [
        number(connection, "SELECT t_ns FROM batch ORDER BY id DESC LIMIT 1")?,
        number(connection, "SELECT max(t_ns) FROM track")?,
        reader.meta("end_ns")?.and_then(|text| text.parse().ok()),
    ];
    let status = match complete {
        true => Status::Complete,
        false if has_writer(&reader.path) => Status::Live,
        false => Status::Incomplete,
    };
    Ok(Growth {
        end_ns: ends.into_iter().flatten().max().unwrap_or(0),
        batches: number(connection, "SELECT max(id) FROM batch")?.unwrap_or(0),
        status,
    })
}

/// Mission time of the first thing recorded.
pub(crate) fn first_ns(connection: &Connection) -> Answer<i64> {
    let starts = [
        number(connection, "SELECT t_ns FROM batch ORDER BY id LIMIT 1")?,
        number(connection, "SELECT min(t_ns) FROM track")?,
    ];
    Ok(starts.into_iter().flatten().min().unwrap_or(0))
}

fn number(connection: &Connection, sql: &str) -> Result<Option<i64>, rusqlite::Error> {
    match connection.prepare_cached(sql)?.query_row([], |row| row.get(0)) {
        Err(rusqlite::Error::QueryReturnedNoRows) => Ok(None),
        other => other,
    }
}

/// True when the file or its write-ahead log was written to a moment ago.
fn has_writer(path: &Path) -> bool {
    let mut log = path.as_os_str().to_owned();
    log.push("-wal");
    [path.to_path_buf(), PathBuf::from(log)].iter().any(|file| {
        let Ok(data) = std::fs::metadata(file) else { return false };
        // Opening a record makes an empty log beside it: that is this reader, not a writer.
        let Some(written) = data.modified().ok().filter(|_| data.len() > 0) else { return false };
        // A time in the future means that the clock was set back: better to call it live than broken.
        SystemTime::now().duration_since(written).map_or(true, |silence| silence < WRITER_SILENCE)
    })
}
