//! `/api/track`: where the vehicle was, as columns.

use crate::answer::Answer;
use crate::record::Reader;
use serde::{Deserialize, Serialize};

/// Samples in one answer unless asked otherwise: about two per pixel of a wide screen.
const POINTS_DEFAULT: usize = 4_000;
/// Samples in one answer at most.
const POINTS_MAX: usize = 50_000;

/// Parameters.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TrackQuery {
    from: Option<i64>,
    to: Option<i64>,
    points: Option<usize>,
}

/// The answer: one list per quantity, all of one length, by time.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Track {
    t_ns: Vec<i64>,
    latitude_deg: Vec<Option<f64>>,
    longitude_deg: Vec<Option<f64>>,
    altitude_m: Vec<Option<f64>>,
    heading_deg: Vec<Option<f64>>,
    roll_deg: Vec<Option<f64>>,
    ground_speed_mps: Vec<Option<f64>>,
    fuel_kg: Vec<Option<f64>>,
    /// Samples in the record for this time; more than the lists hold when they were thinned.
    recorded: usize,
}

/// Answers `/api/track`. Thinning takes every n-th sample and always the first and the last.
pub(crate) fn track(reader: &Reader, query: &TrackQuery) -> Answer<Track> {
    let (from, to) = (query.from.unwrap_or(i64::MIN), query.to.unwrap_or(i64::MAX));
    let recorded: i64 = reader
        .connection
        .prepare_cached("SELECT count(*) FROM track WHERE t_ns BETWEEN ?1 AND ?2")?
        .query_row([from, to], |row| row.get(0))?;
    let recorded = usize::try_from(recorded).unwrap_or(0);
    let points = query.points.unwrap_or(POINTS_DEFAULT).clamp(2, POINTS_MAX);
    let stride = recorded.div_ceil(points).max(1);
    let mut statement = reader.connection.prepare_cached(
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
