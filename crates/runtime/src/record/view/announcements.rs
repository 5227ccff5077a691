//! Messages about targets. Announcements of late targets: a target of the mission's files with `announced` = `by-event` is unknown before
//! the first event `(new-target ID)`. Values: the last event `(new-value ID NUMBER)` counts. A target that needs no observation any longer
//! is gone from the event `(target-gone ID)` until another `(new-target ID)`.
//!
//! GeoJSON states which targets are late. Tables and KML only state that some are: then every announced target counts as late, and a
//! target that is never announced cannot be distinguished from one known from the start.
//! Bound: each batch is read once, and only while a late target is unannounced.

use crate::error::RecordError;
use crate::record::{RecordReader, codec};
use crate::target_state::{NEW_VALUE, TARGET_VALUE_MAX};
use apex_model::event::EventKind;
use apex_model::quantity::Dimension;
use apex_model::time::Time;
use apex_model::value::Value;
use serde_json::Value as Json;
use std::collections::{BTreeMap, BTreeSet};

/// The head of the event that announces a target.
const HEAD: &str = "new-target";
/// The head of the event about a target that needs no observation any longer.
const GONE: &str = "target-gone";
/// The value of a late target's property `announced`.
const LATE: &str = "by-event";
/// Separates a target's identifier from the name of one of its wanted looks.
pub(super) const LOOK: char = '/';

/// The late targets of a record and their announcements so far.
#[derive(Default)]
pub(super) struct Announcements {
    /// True if the record has targets: without any, no step is read.
    has_targets: bool,
    /// The identifiers of late targets that are not announced yet; `None` before the record was first read.
    awaited: Option<BTreeSet<String>>,
    /// True if targets that no file marks as late may be announced too.
    others: bool,
    announced_ns: BTreeMap<String, i64>,
    /// Values by target, with the instants from which they hold.
    values: BTreeMap<String, Vec<(i64, f64)>>,
    gone: GoneChanges,
    seen_batch: i64,
}

impl Announcements {
    /// Reads the steps recorded since the last call.
    pub(super) fn refresh(&mut self, reader: &RecordReader) -> Result<(), RecordError> {
        if !self.has_targets {
            let sql = "SELECT EXISTS (SELECT 1 FROM target)";
            let found = reader.connection.query_row(sql, [], |row| row.get(0));
            self.has_targets = found.map_err(|error| reader.damaged("the targets", error))?;
            if !self.has_targets {
                return Ok(());
            }
        }
        if self.awaited.is_none() {
            let (late, others) = late_targets(reader)?;
            (self.awaited, self.others) = (Some(late), others);
        }
        let Some(awaited) = &mut self.awaited else { return Ok(()) };
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
            for message in batch.events.iter().filter_map(|event| message_of(&event.kind)) {
                match &message {
                    TargetMessage::Announced(target) => set_gone(&mut self.gone, target, t_ns, false),
                    TargetMessage::Gone(target) => set_gone(&mut self.gone, target, t_ns, true),
                    TargetMessage::Value(..) => {}
                }
                match message {
                    TargetMessage::Announced(target) if awaited.remove(&target) || self.others => {
                        self.announced_ns.entry(target).or_insert(t_ns);
                    }
                    TargetMessage::Announced(_) | TargetMessage::Gone(_) => {}
                    TargetMessage::Value(target, value) => self.values.entry(target).or_default().push((t_ns, value)),
                }
            }
        }
        Ok(())
    }

    /// Returns the value that messages have given to the target `id` by `at_ns`; `None` if there was none.
    pub(super) fn value_at(&self, id: &str, at_ns: i64) -> Option<f64> {
        let values = self.values.get(&id.to_lowercase())?;
        let later = values.partition_point(|(since_ns, _)| *since_ns <= at_ns);
        later.checked_sub(1).and_then(|last| values.get(last)).map(|(_, value)| *value)
    }

    /// Returns the mission time in nanoseconds since which the target or wanted look `id` is gone at `at_ns`; `None` if it is not.
    pub(super) fn gone_ns(&self, id: &str, at_ns: i64) -> Option<i64> {
        let id = id.to_lowercase();
        let own = id.split(LOOK).next().unwrap_or(&id);
        let changes = self.gone.get(&id).or_else(|| self.gone.get(own))?;
        let later = changes.partition_point(|(since_ns, _)| *since_ns <= at_ns);
        let (since_ns, is_gone) = *changes.get(later.checked_sub(1)?)?;
        is_gone.then_some(since_ns)
    }

    /// Returns the mission time in nanoseconds from which the target or wanted look `id` is known; `None` as long as it is not.
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

/// By target: the instants from which it is gone, or not, oldest first.
type GoneChanges = BTreeMap<String, Vec<(i64, bool)>>;

/// Takes a message by which a target is gone or, by a new announcement, is not.
fn set_gone(gone: &mut GoneChanges, target: &str, t_ns: i64, is_gone: bool) {
    let changes = gone.entry(target.to_owned()).or_default();
    if changes.last().is_some_and(|(_, known)| *known) != is_gone {
        changes.push((t_ns, is_gone));
    }
}

/// Message about a target.
enum TargetMessage {
    Announced(String),
    Gone(String),
    Value(String, f64),
}

/// Returns the identifiers of the targets in GeoJSON that are announced by event, and whether other files may have such targets.
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
    // Each head has a hyphen, and few bytes are hyphens, so those are looked for.
    let mut hyphens = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'-').map(|(at, _)| at);
    let has = |start: usize, head: &str| {
        bytes.get(start..start + head.len()).is_some_and(|found| found.eq_ignore_ascii_case(head.as_bytes()))
    };
    let begins = |at: usize, head: &str| {
        head.find('-').and_then(|before| at.checked_sub(before)).is_some_and(|start| has(start, head))
    };
    hyphens.any(|at| [HEAD, NEW_VALUE, GONE].iter().any(|head| begins(at, head)))
}

/// Returns what an event says about a target. A value that no target can have changes nothing.
fn message_of(kind: &EventKind) -> Option<TargetMessage> {
    let EventKind::Occurrence(form) = kind else { return None };
    let [head, target, more @ ..] = form.as_list()? else { return None };
    let head = head.as_symbol()?;
    let target = match target {
        Value::Symbol(name) => name.folded().to_owned(),
        Value::Text(name) => name.to_string(),
        other => other.to_string(),
    };
    if head.is(HEAD) {
        return Some(TargetMessage::Announced(target));
    }
    if head.is(GONE) {
        return Some(TargetMessage::Gone(target));
    }
    let number = more.first().filter(|_| head.is(NEW_VALUE))?.as_number();
    let number = number.filter(|(_, dimension)| *dimension == Dimension::NONE).map(|(number, _)| number);
    number.filter(|number| (0.0..=TARGET_VALUE_MAX).contains(number)).map(|number| TargetMessage::Value(target, number))
}
