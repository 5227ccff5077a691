//! Announcements of late targets: a target of the mission's files with `announced` = `by-event` is unknown before
//! the first event `(new-target ID)`.
//!
//! GeoJSON states which targets are late. Tables and KML only state that some are: then every announced target counts as late, and a
//! target that is never announced cannot be distinguished from one known from the start.
//! Bound: each batch is read once, and only while a late target is unannounced.

use crate::error::RecordError;
use crate::record::{RecordReader, codec};
use apex_model::event::EventKind;
use apex_model::time::Time;
use apex_model::value::Value;
use serde_json::Value as Json;
use std::collections::{BTreeMap, BTreeSet};

/// The head of the event that announces a target.
const HEAD: &str = "new-target";
/// The value of a late target's property `announced`.
const LATE: &str = "by-event";
/// Separates a target's identifier from the name of one of its wanted looks.
const LOOK: char = '/';

/// The late targets of a record and their announcements so far.
#[derive(Default)]
pub(super) struct Announcements {
    /// The identifiers of late targets that are not announced yet; none before the record was first read.
    awaited: Option<BTreeSet<String>>,
    /// True if targets that no file marks as late may be announced too.
    others: bool,
    announced_ns: BTreeMap<String, i64>,
    seen_batch: i64,
}

impl Announcements {
    /// Reads the steps recorded since the last call.
    pub(super) fn refresh(&mut self, reader: &RecordReader) -> Result<(), RecordError> {
        if self.awaited.is_none() {
            let (late, others) = late_targets(reader)?;
            (self.awaited, self.others) = (Some(late), others);
        }
        let Some(awaited) = &mut self.awaited else { return Ok(()) };
        if awaited.is_empty() && !self.others {
            return Ok(());
        }
        let variables = reader.variable_table()?;
        let broken = |error| reader.damaged("the steps", error);
        // Every agent receives the events, so the steps of all agents are read.
        let sql = "SELECT id, t_ns, events FROM main.batch WHERE id > ?1 ORDER BY id";
        let mut statement = reader.connection.prepare_cached(sql).map_err(broken)?;
        let mut rows = statement.query([self.seen_batch]).map_err(broken)?;
        while let Some(row) = rows.next().map_err(broken)? {
            let (id, t_ns): (i64, i64) = row.get(0).and_then(|id| Ok((id, row.get(1)?))).map_err(broken)?;
            let bytes = row.get_ref(2).and_then(|cell| Ok(cell.as_blob()?)).map_err(broken)?;
            self.seen_batch = id;
            if !names_head(bytes) {
                continue;
            }
            let batch = codec::decode(Time(t_ns), bytes, &variables)
                .map_err(|fault| reader.garbled(format!("batch {id} at {} cannot be read: {fault}", Time(t_ns))))?;
            for target in batch.events.iter().filter_map(|event| target_of(&event.kind)) {
                if awaited.remove(&target) || self.others {
                    self.announced_ns.entry(target).or_insert(t_ns);
                }
            }
            if awaited.is_empty() && !self.others {
                break;
            }
        }
        Ok(())
    }

    /// Returns the mission time in nanoseconds from which the target or wanted look `id` is known; `None` while it is unknown.
    pub(super) fn known_ns(&self, id: &str) -> Option<i64> {
        let is_awaited = |id: &str| self.awaited.as_ref().is_some_and(|awaited| awaited.contains(id));
        let own = id.split(LOOK).next().unwrap_or(id);
        match self.announced_ns.get(id).or_else(|| self.announced_ns.get(own)) {
            Some(&announced_ns) => Some(announced_ns),
            None if is_awaited(id) || is_awaited(own) => None,
            None => Some(i64::MIN),
        }
    }
}

/// Returns the identifiers of the GeoJSON targets that are announced by event, and true if other files may contain such targets.
fn late_targets(reader: &RecordReader) -> Result<(BTreeSet<String>, bool), RecordError> {
    let mut late = BTreeSet::new();
    let mut others = false;
    for source in reader.sources()?.into_iter().filter(|source| source.role == "data") {
        let Ok(data) = serde_json::from_slice::<Json>(&source.body) else {
            others |= source.body.windows(LATE.len()).any(|window| window == LATE.as_bytes());
            continue;
        };
        for feature in data.get("features").and_then(Json::as_array).into_iter().flatten() {
            let property = |name: &str| feature.get("properties").and_then(|all| all.get(name)).and_then(Json::as_str);
            if property("announced") == Some(LATE)
                && let Some(id) = property("id").or_else(|| feature.get("id").and_then(Json::as_str))
            {
                late.insert(id.to_lowercase());
            }
        }
    }
    Ok((late, others))
}

/// Returns true if the stored events can hold an announcement: symbols are stored as they are printed.
fn names_head(bytes: &[u8]) -> bool {
    bytes.windows(HEAD.len()).any(|window| window.eq_ignore_ascii_case(HEAD.as_bytes()))
}

/// Returns the target that an event announces.
fn target_of(kind: &EventKind) -> Option<String> {
    let EventKind::Occurrence(form) = kind else { return None };
    let [head, target, ..] = form.as_list()? else { return None };
    head.as_symbol().filter(|head| head.is(HEAD))?;
    Some(match target {
        Value::Symbol(name) => name.folded().to_owned(),
        Value::Text(name) => name.to_string(),
        other => other.to_string(),
    })
}
