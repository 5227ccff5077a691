//! `/api/targets`: what is to be observed, and how that went.

use crate::answer::Answer;
use crate::record::Reader;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// Changes of state in one target's history at most; a target watched in cycles has many.
const HISTORY_MAX: usize = 500;

/// Parameters.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TargetsQuery {
    at: Option<i64>,
}

/// The answer.
#[derive(Debug, Serialize)]
pub(crate) struct Targets {
    targets: Vec<Target>,
}

#[derive(Debug, Serialize)]
struct Target {
    id: String,
    name: String,
    latitude_deg: Option<f64>,
    longitude_deg: Option<f64>,
    value: Option<f64>,
    /// GeoJSON, or null.
    geometry: Option<Value>,
    /// The state at `at` (at the end, when not given); null before the first.
    state: Option<String>,
    detail: Option<String>,
    since_ns: Option<i64>,
    /// All changes over the whole record, oldest first.
    history: Vec<TargetChange>,
}

#[derive(Clone, Debug, Serialize)]
struct TargetChange {
    t_ns: i64,
    state: String,
    detail: Option<String>,
}

/// Answers `/api/targets`.
pub(crate) fn targets(reader: &Reader, query: &TargetsQuery) -> Answer<Targets> {
    let at = query.at.unwrap_or(i64::MAX);
    let mut histories = histories(reader)?;
    let mut statement = reader
        .connection
        .prepare_cached("SELECT id, name, latitude_deg, longitude_deg, value, geometry FROM target ORDER BY id")?;
    let rows = statement.query_map([], |row| {
        let id: String = row.get(0)?;
        let mut history = histories.remove(&id).unwrap_or_default();
        let now = history.iter().rev().find(|change| change.t_ns <= at).cloned();
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

fn histories(reader: &Reader) -> Result<BTreeMap<String, Vec<TargetChange>>, rusqlite::Error> {
    let mut statement = reader
        .connection
        .prepare_cached("SELECT target, t_ns, state, detail FROM target_state ORDER BY t_ns, rowid")?;
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
