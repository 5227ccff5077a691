//! The observation targets and the history of each.

use super::RecordView;
use crate::error::RecordError;
use rusqlite::Connection;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// Maximum number of changes in one target's history; the oldest are left out. A target watched in cycles has many.
const HISTORY_MAX: usize = 500;

/// All targets.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Targets {
    /// By identifier.
    pub targets: Vec<Target>,
}

/// An observation target.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Target {
    /// Its name in PDL.
    pub id: String,
    /// Its name for operators.
    pub name: String,
    /// Centre, degrees north.
    pub latitude_deg: Option<f64>,
    /// Centre, degrees east.
    pub longitude_deg: Option<f64>,
    /// Its value to the mission.
    pub value: Option<f64>,
    /// GeoJSON.
    #[cfg_attr(test, ts(type = "GeoJSON.Geometry | GeoJSON.Feature | GeoJSON.FeatureCollection | null"))]
    pub geometry: Option<Value>,
    /// `planned`, `observing`, `observed` or `skipped` at the instant asked for; none before the first.
    pub state: Option<String>,
    /// Why it is in this state.
    pub detail: Option<String>,
    /// Mission time in nanoseconds at which this state began.
    pub since_ns: Option<i64>,
    /// All changes over the whole record, oldest first.
    pub history: Vec<TargetChange>,
}

/// A change of a target's state.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct TargetChange {
    /// Mission time in nanoseconds.
    pub t_ns: i64,
    /// The new state.
    pub state: String,
    /// Why.
    pub detail: Option<String>,
}

impl RecordView {
    /// All targets with their states at mission time `at_ns` (nanoseconds); none means the record's end.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn targets(&self, at_ns: Option<i64>) -> Result<Targets, RecordError> {
        let at_ns = at_ns.unwrap_or(i64::MAX);
        self.query("the targets", |connection| read(connection, at_ns))
    }
}

fn read(connection: &Connection, at_ns: i64) -> rusqlite::Result<Targets> {
    let mut histories = histories(connection)?;
    let sql = "SELECT id, name, latitude_deg, longitude_deg, value, geometry FROM target \
               WHERE position IN (SELECT max(position) FROM target GROUP BY id) ORDER BY id";
    let mut statement = connection.prepare_cached(sql)?;
    let rows = statement.query_map([], |row| {
        let id: String = row.get(0)?;
        let mut history = histories.remove(&id).unwrap_or_default();
        let now = history.iter().rev().find(|change| change.t_ns <= at_ns).cloned();
        let older = history.len().saturating_sub(HISTORY_MAX);
        history.drain(..older);
        let geometry: Option<String> = row.get(5)?;
        Ok(Target {
            name: row.get::<_, Option<String>>(1)?.filter(|name| !name.is_empty()).unwrap_or_else(|| id.clone()),
            latitude_deg: row.get(2)?,
            longitude_deg: row.get(3)?,
            value: row.get(4)?,
            geometry: geometry.and_then(|text| serde_json::from_str(&text).ok()),
            state: now.as_ref().map(|change| change.state.clone()),
            detail: now.as_ref().and_then(|change| change.detail.clone()),
            since_ns: now.map(|change| change.t_ns),
            history,
            id,
        })
    })?;
    Ok(Targets { targets: rows.collect::<Result<_, _>>()? })
}

fn histories(connection: &Connection) -> rusqlite::Result<BTreeMap<String, Vec<TargetChange>>> {
    let sql = "SELECT target, t_ns, state, detail FROM target_state ORDER BY t_ns, position";
    let mut statement = connection.prepare_cached(sql)?;
    let mut rows = statement.query([])?;
    let mut histories: BTreeMap<String, Vec<TargetChange>> = BTreeMap::new();
    while let Some(row) = rows.next()? {
        let change = TargetChange {
            t_ns: row.get(1)?,
            state: row.get(2)?,
            detail: row.get::<_, Option<String>>(3)?.filter(|text| !text.is_empty()),
        };
        histories.entry(row.get(0)?).or_default().push(change);
    }
    Ok(histories)
}
