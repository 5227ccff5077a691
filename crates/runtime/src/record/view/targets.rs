//! The observation targets and the history of each.

use super::announcements::{Announcements, LOOK};
use super::goals::TargetNames;
use super::{RecordView, for_writing};
use crate::error::RecordError;
use rusqlite::Connection;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};

/// Maximum number of changes in one target's history; the oldest are left out. A target that is watched in cycles has many.
const HISTORY_MAX: usize = 500;

/// The targets that are known at an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Targets {
    /// By identifier.
    pub targets: Vec<Target>,
}

/// An observation target, as known at an instant.
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
    /// Its value to the mission at that instant: that of its files, or of the last message `(new-value ID NUMBER)`.
    pub value: Option<f64>,
    /// GeoJSON.
    #[cfg_attr(test, ts(type = "GeoJSON.Geometry | GeoJSON.Feature | GeoJSON.FeatureCollection | null"))]
    pub geometry: Option<Value>,
    /// `planned`, `observing`, `observed` or `skipped` at the requested instant; `None` before the first state.
    pub state: Option<String>,
    /// Reason for its state: that of the latest plan, where several in a row keep the state.
    pub detail: Option<String>,
    /// Mission time in nanoseconds at which this state began. A later plan that keeps the state does not change it.
    pub since_ns: Option<i64>,
    /// Mission time in nanoseconds of its announcement; `None` if it was known from the start.
    pub announced_ns: Option<i64>,
    /// Mission time in nanoseconds since which it needs no observation any longer; none if it needs one.
    pub gone_ns: Option<i64>,
    /// Mission time in nanoseconds of the end of its last observation; none if it was not observed by then.
    pub observed_ns: Option<i64>,
    /// Recorded changes up to that instant, oldest first, at most 500 entries.
    pub history: Vec<TargetChange>,
}

/// A recorded state of a target; each plan records it again.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct TargetChange {
    /// Mission time in nanoseconds.
    pub t_ns: i64,
    /// The state.
    pub state: String,
    /// Reason.
    pub detail: Option<String>,
}

impl RecordView {
    /// Returns the identifiers of all targets of the record, by their text in lower case.
    pub(super) fn target_names(&self) -> Result<Arc<TargetNames>, RecordError> {
        let mut known = self.indexes.targets.lock().unwrap_or_else(PoisonError::into_inner);
        self.query("the targets", |connection| known.refresh(connection))?;
        Ok(known.names())
    }

    /// Returns the targets known at mission time `at_ns` (nanoseconds; `None`: the record's end), with their states at that time.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn targets(&mut self, at_ns: Option<i64>) -> Result<Targets, RecordError> {
        let at_ns = at_ns.unwrap_or(i64::MAX);
        let mut announcements = for_writing(&self.indexes.announcements);
        announcements.refresh(&self.reader)?;
        self.query("the targets", |connection| read(connection, &announcements, at_ns))
    }
}

fn read(connection: &Connection, announcements: &Announcements, at_ns: i64) -> rusqlite::Result<Targets> {
    let mut histories = histories(connection, at_ns)?;
    let sql = "SELECT id, name, latitude_deg, longitude_deg, value, geometry FROM target \
               WHERE position IN (SELECT max(position) FROM target GROUP BY id) ORDER BY id";
    let mut statement = connection.prepare_cached(sql)?;
    let mut rows = statement.query([])?;
    let mut targets = Vec::new();
    while let Some(row) = rows.next()? {
        let id: String = row.get(0)?;
        let mut history = histories.remove(&id).unwrap_or_default();
        let known_ns = announcements.known_ns(&id);
        if history.is_empty() && known_ns.is_none_or(|known_ns| known_ns > at_ns) {
            continue;
        }
        let gone_ns = announcements.gone_ns(&id, at_ns);
        let now = state_of(&history, gone_ns);
        let observed_ns = history.iter().rev().find(|change| change.state == "observed").map(|change| change.t_ns);
        let older = history.len().saturating_sub(HISTORY_MAX);
        history.drain(..older);
        let geometry: Option<String> = row.get(5)?;
        targets.push(Target {
            name: row.get::<_, Option<String>>(1)?.filter(|name| !name.is_empty()).unwrap_or_else(|| id.clone()),
            latitude_deg: row.get(2)?,
            longitude_deg: row.get(3)?,
            value: announcements.value_at(&id, at_ns).map_or_else(|| row.get(4), |value| Ok(Some(value)))?,
            gone_ns,
            observed_ns,
            geometry: geometry.and_then(|text| serde_json::from_str(&text).ok()),
            state: now.as_ref().map(|change| change.state.clone()),
            detail: now.as_ref().and_then(|change| change.detail.clone()),
            since_ns: now.map(|change| change.t_ns),
            announced_ns: known_ns.filter(|&known_ns| known_ns > i64::MIN && known_ns <= at_ns),
            history,
            id,
        });
    }
    targets.extend(grown(histories, &targets, announcements, at_ns));
    targets.sort_by(|one, other| one.id.cmp(&other.id));
    Ok(Targets { targets })
}

/// Returns targets for the states that belong to ground by which a fire has grown, `FIRE/growth-1`: it has no row in the table. Its place,
/// outline and value are not recorded; the middle of its fire is outside of it.
fn grown(
    histories: BTreeMap<String, Vec<TargetChange>>,
    targets: &[Target],
    announcements: &Announcements,
    at_ns: i64,
) -> Vec<Target> {
    let of = |(id, mut history): (String, Vec<TargetChange>)| {
        let (fire, part) = id.split_once(LOOK)?;
        let fire = targets.iter().find(|target| target.id == fire)?;
        let gone_ns = announcements.gone_ns(&id, at_ns);
        let now = state_of(&history, gone_ns);
        let observed_ns = history.iter().rev().find(|change| change.state == "observed").map(|change| change.t_ns);
        let announced_ns = history.first().map(|change| change.t_ns);
        history.drain(..history.len().saturating_sub(HISTORY_MAX));
        Some(Target {
            name: format!("{} {}", fire.name, part.replace('-', " ")),
            latitude_deg: None,
            longitude_deg: None,
            value: None,
            gone_ns,
            observed_ns,
            geometry: None,
            state: now.as_ref().map(|change| change.state.clone()),
            detail: now.as_ref().and_then(|change| change.detail.clone()),
            since_ns: now.map(|change| change.t_ns),
            announced_ns,
            history,
            id,
        })
    };
    histories.into_iter().filter_map(of).collect()
}

/// Returns the present state, the instant since which it lasts, and its latest reason: each plan has a new time for every target that it
/// keeps, and a new reason for every target that it leaves out. A target that is gone has its state since then at the earliest.
fn state_of(history: &[TargetChange], gone_ns: Option<i64>) -> Option<TargetChange> {
    let last = history.last()?;
    let since_ns = gone_ns.unwrap_or(i64::MIN);
    let is_same =
        |change: &&TargetChange| change.state == last.state && (change.t_ns < since_ns) == (last.t_ns < since_ns);
    let first = history.iter().rev().take_while(is_same).last()?;
    Some(TargetChange { t_ns: first.t_ns, ..last.clone() })
}

/// Returns the recorded changes of each target up to `at_ns`.
fn histories(connection: &Connection, at_ns: i64) -> rusqlite::Result<BTreeMap<String, Vec<TargetChange>>> {
    let sql = "SELECT target, t_ns, state, detail FROM target_state WHERE t_ns <= ?1 ORDER BY t_ns, position";
    let mut statement = connection.prepare_cached(sql)?;
    let mut rows = statement.query([at_ns])?;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn change(t_ns: i64, state: &str, detail: &str) -> TargetChange {
        TargetChange { t_ns, state: state.into(), detail: Some(detail.into()) }
    }

    #[test]
    fn a_state_lasts_since_the_first_plan_of_a_run_for_the_reason_of_the_last_one() {
        let history = [change(1, "planned", "at 5"), change(2, "skipped", "too far"), change(3, "skipped", "too late")];
        assert_eq!(state_of(&history, None), Some(change(2, "skipped", "too late")));
        let gone = [change(1, "skipped", "too far"), change(2, "skipped", "no observation is needed")];
        assert_eq!(state_of(&gone, Some(2)), gone.last().cloned());
        assert_eq!(
            state_of(&gone, None),
            Some(TargetChange { t_ns: 1, ..change(2, "skipped", "no observation is needed") })
        );
        let history = [change(1, "planned", "at 5"), change(2, "planned", "at 6")];
        assert_eq!(state_of(&history, None), Some(TargetChange { t_ns: 1, ..change(2, "planned", "at 6") }));
        assert_eq!(state_of(&[], None), None);
    }
}
