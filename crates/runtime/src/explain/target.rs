//! What became of an observation target.

use super::answer::TargetMoment;
use super::scene::Scene;
use crate::error::RecordError;
use apex_model::time::Time;
use rusqlite::{OptionalExtension, params};

/// The identifier of the target called `name`.
pub(super) fn named(scene: &Scene<'_>, name: &str) -> Result<Option<String>, RecordError> {
    let sql = "SELECT id FROM target WHERE id = ?1 COLLATE NOCASE OR name = ?1 COLLATE NOCASE LIMIT 1";
    let found = scene.reader.connection().query_row(sql, [name.trim()], |row| row.get(0)).optional();
    found.map_err(|error| scene.reader.damaged("the targets", error))
}

/// All identifiers, for suggestions.
pub(super) fn names(scene: &Scene<'_>) -> Result<Vec<String>, RecordError> {
    let connection = scene.reader.connection();
    let all = connection
        .prepare("SELECT id FROM target ORDER BY id")
        .and_then(|mut statement| statement.query_map([], |row| row.get(0))?.collect());
    all.map_err(|error| scene.reader.damaged("the targets", error))
}

/// What was said of the target up to the instant of the question, the same said again left out.
pub(super) fn moments(scene: &Scene<'_>, id: &str) -> Result<Vec<TargetMoment>, RecordError> {
    let sql = "SELECT t_ns, state, detail FROM target_state WHERE target = ?1 AND t_ns <= ?2 ORDER BY rowid";
    let rows = scene.reader.connection().prepare(sql).and_then(|mut statement| {
        let read = |row: &rusqlite::Row<'_>| {
            let (t, detail): (i64, Option<String>) = (row.get(0)?, row.get(2)?);
            Ok(TargetMoment { t: Time(t).seconds(), state: row.get(1)?, detail: detail.unwrap_or_default() })
        };
        statement.query_map(params![id, scene.at.0], read)?.collect::<rusqlite::Result<Vec<TargetMoment>>>()
    });
    let mut moments = rows.map_err(|error| scene.reader.damaged("the targets", error))?;
    moments.dedup_by(|later, earlier| later.state == earlier.state && later.detail == earlier.detail);
    Ok(moments)
}
