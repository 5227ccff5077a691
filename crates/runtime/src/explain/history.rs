//! A task's history, from the rows of its decisions.

use crate::error::RecordError;
use crate::record::RecordReader;
use apex_model::because::{Cause, Strength};
use apex_model::effect::{Decision, Effect};
use apex_model::task::TaskId;
use apex_model::time::Time;
use rusqlite::{OptionalExtension, params};
use serde::Serialize;
use std::fmt;

/// Something that happened to a task.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Moment {
    /// Seconds of mission time.
    pub t: f64,
    /// The kind, as in the record's `effect` table.
    pub kind: String,
    /// What, in words.
    pub what: String,
    /// Why, in words; empty where `what` says it all.
    pub because: String,
    /// Where the clause stands.
    pub place: Option<String>,
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "  {:>12}  {}", Time::from_seconds(self.t).to_string(), self.what)?;
        if !self.because.is_empty() {
            write!(f, " because {}", self.because)?;
        }
        match &self.place {
            Some(place) => write!(f, "; from {place}"),
            None => Ok(()),
        }
    }
}

/// A task's history up to an instant.
pub(super) struct History {
    pub(super) moments: Vec<Moment>,
    /// The state's word.
    pub(super) state: String,
    /// The goal as known last.
    pub(super) goal: Option<String>,
    pub(super) method: Option<String>,
    pub(super) blocked: Option<Conflict>,
}

/// The conflict that a task lost last, if it has not won since.
pub(super) struct Conflict {
    pub(super) by: TaskId,
    pub(super) resource: String,
    pub(super) since: Time,
    pub(super) winner: Strength,
    pub(super) loser: Strength,
}

/// A row of the `effect` table.
struct Row {
    at: Time,
    kind: String,
    from: Option<String>,
    to: Option<String>,
    outcome: Option<String>,
    subject: String,
    text: String,
    place: Option<String>,
    body: Vec<u8>,
}

impl History {
    /// Reads what was decided about `task` until `at`.
    pub(super) fn read(reader: &RecordReader, task: TaskId, at: Time) -> Result<History, RecordError> {
        let mut history =
            History { moments: Vec::new(), state: "pending".into(), goal: None, method: None, blocked: None };
        for row in rows(reader, task, at).map_err(|error| reader.damaged("the effects", error))? {
            history.add(row);
        }
        Ok(history)
    }

    /// True for states in which a task waits for something that the agent can name.
    pub(super) fn waits(&self) -> bool {
        self.state != "terminated"
    }

    fn add(&mut self, row: Row) {
        let (what, because) = match row.kind.as_str() {
            "created" => {
                self.goal = Some(row.subject);
                ("created".to_owned(), row.text)
            }
            "transition" => {
                self.state = row.to.clone().unwrap_or_default();
                self.blocked = self.conflict(&row.body, row.at);
                let outcome = row.outcome.map(|outcome| format!(" ({outcome})")).unwrap_or_default();
                let states = format!("{} -> {}", row.from.unwrap_or_default(), row.to.unwrap_or_default());
                (format!("{states}{outcome}"), row.text)
            }
            "selected" => {
                self.goal = Some(row.subject);
                let (method, because) = row.text.split_once(" because ").unwrap_or((&row.text, ""));
                self.method = Some(method.to_owned());
                (format!("selected {method}"), because.to_owned())
            }
            "refused" => {
                self.blocked = self.conflict(&row.body, row.at);
                (format!("refused {}", row.subject), row.text)
            }
            "satisfied" => (format!("{} satisfied", row.subject), row.text),
            "bound" | "procedure-added" => (row.subject, row.text),
            // The message of a failure that is handled is its cause, told already.
            "trouble" if row.subject.starts_with(&row.text) => (format!("trouble: {}", row.text), String::new()),
            // The message of a failure that is handled is its cause, told already.
            "trouble" if row.subject.starts_with(&row.text) => (format!("trouble: {}", row.text), String::new()),
            "trouble" => (format!("trouble: {}", row.subject), row.text),
            "print" => (format!("prints {}", row.text), String::new()),
            "solve" | "ask" => (format!("{}s: {} ({})", row.kind, row.subject, row.text), String::new()),
            other => (format!("{other} {}", row.subject), String::new()),
        };
        let what = what.replace('\n', "\\n");
        self.moments.push(Moment { t: row.at.seconds(), kind: row.kind, what, because, place: row.place });
    }

    /// The conflict that this decision tells of; the same conflict told again began earlier.
    fn conflict(&self, body: &[u8], at: Time) -> Option<Conflict> {
        let Ok(Effect::Decided(Decision { because, .. })) = postcard::from_bytes(body) else { return None };
        let Cause::Outranked { by, resource, winner, loser, .. } = because.cause else { return None };
        let resource = resource.to_string();
        let known = self.blocked.as_ref().filter(|known| known.by == by && known.resource == resource);
        let since = known.map_or(at, |known| known.since);
        Some(Conflict { by, resource, since, winner, loser })
    }
}

fn rows(reader: &RecordReader, task: TaskId, at: Time) -> rusqlite::Result<Vec<Row>> {
    let sql = "SELECT t_ns, kind, from_state, to_state, outcome, subject, text, place, body FROM effect
               WHERE task = ?1 AND t_ns <= ?2 ORDER BY id";
    let mut statement = reader.connection().prepare(sql)?;
    let rows = statement.query_map(params![task.0 as i64, at.0], |row| {
        Ok(Row {
            at: Time(row.get(0)?),
            kind: row.get(1)?,
            from: row.get(2)?,
            to: row.get(3)?,
            outcome: row.get(4)?,
            subject: row.get(5)?,
            text: row.get(6)?,
            place: row.get(7)?,
            body: row.get(8)?,
        })
    })?;
    rows.collect()
}

/// The word of the state in which `task` was at `at`.
pub(super) fn state_at(reader: &RecordReader, task: TaskId, at: Time) -> Result<String, RecordError> {
    let sql =
        "SELECT to_state FROM effect WHERE task = ?1 AND t_ns <= ?2 AND kind = 'transition' ORDER BY id DESC LIMIT 1";
    let state = reader.connection().query_row(sql, params![task.0 as i64, at.0], |row| row.get(0)).optional();
    let state: Option<String> = state.map_err(|error| reader.damaged("the effects", error))?;
    Ok(state.unwrap_or_else(|| "pending".into()))
}
