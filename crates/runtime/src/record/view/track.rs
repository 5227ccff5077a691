//! The track: the positions of the vehicle, as columns.

use super::RecordView;
use crate::error::RecordError;
use rusqlite::Connection;
use serde::Serialize;

/// Maximum number of samples of an answer, unless the query states one: about two per pixel of a wide screen.
const POINTS_DEFAULT: usize = 4_000;
/// Maximum number of samples of any answer.
const POINTS_MAX: usize = 50_000;

/// A query of the track.
#[derive(Clone, Debug, Default)]
pub struct TrackQuery {
    /// Earliest mission time in nanoseconds; default: the record's start.
    pub from_ns: Option<i64>,
    /// Latest mission time in nanoseconds; default: the record's end.
    pub to_ns: Option<i64>,
    /// Maximum number of samples; default 4,000, at least 2 (the first and the last), at most 50,000.
    pub points: Option<usize>,
}

/// One list per quantity, all of the same length, in order of time.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Track {
    /// Mission time in nanoseconds.
    pub t_ns: Vec<i64>,
    /// Degrees north.
    pub latitude_deg: Vec<Option<f64>>,
    /// Degrees east.
    pub longitude_deg: Vec<Option<f64>>,
    /// Metres above sea level.
    pub altitude_m: Vec<Option<f64>>,
    /// Degrees from north, clockwise.
    pub heading_deg: Vec<Option<f64>>,
    /// Degrees, right wing down positive.
    pub roll_deg: Vec<Option<f64>>,
    /// Metres per second.
    pub ground_speed_mps: Vec<Option<f64>>,
    /// Kilograms.
    pub fuel_kg: Vec<Option<f64>>,
    /// Number of samples in the record for this time; more than the lists hold if they are thinned.
    pub recorded: usize,
}

impl RecordView {
    /// Returns the track. Thinning takes every n-th sample and always the first and the last.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn track(&self, query: &TrackQuery) -> Result<Track, RecordError> {
        self.query("the track", |connection| read(connection, query))
    }
}

fn read(connection: &Connection, query: &TrackQuery) -> rusqlite::Result<Track> {
    let (from, to) = (query.from_ns.unwrap_or(i64::MIN), query.to_ns.unwrap_or(i64::MAX));
    let recorded: i64 = connection
        .prepare_cached("SELECT count(*) FROM track WHERE t_ns BETWEEN ?1 AND ?2")?
        .query_row([from, to], |row| row.get(0))?;
    let recorded = usize::try_from(recorded).unwrap_or(0);
    let points = query.points.unwrap_or(POINTS_DEFAULT).clamp(2, POINTS_MAX);
    // The last sample is listed after every n-th one before it.
    let stride = recorded.saturating_sub(1).div_ceil(points - 1).max(1);
    let mut statement = connection.prepare_cached(
        "SELECT t_ns, latitude_deg, longitude_deg, altitude_m, heading_deg, roll_deg, ground_speed_mps, fuel_kg \
         FROM track WHERE t_ns BETWEEN ?1 AND ?2 ORDER BY t_ns",
    )?;
    let mut rows = statement.query([from, to])?;
    let mut track = Track { recorded, ..Track::default() };
    let mut position = 0;
    while let Some(row) = rows.next()? {
        if position % stride == 0 || position + 1 == recorded {
            track.t_ns.push(row.get(0)?);
            track.latitude_deg.push(row.get(1)?);
            track.longitude_deg.push(row.get(2)?);
            track.altitude_m.push(row.get(3)?);
            track.heading_deg.push(row.get(4)?);
            track.roll_deg.push(row.get(5)?);
            track.ground_speed_mps.push(row.get(6)?);
            track.fuel_kg.push(row.get(7)?);
        }
        position += 1;
    }
    Ok(track)
}
