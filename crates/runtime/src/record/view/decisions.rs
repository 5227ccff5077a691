//! Decisions as an explanation asks for them: the last one of a kind before another, or at its instant; the decisions
//! about a task; what was said about a target.

use super::targets::TargetChange;
use crate::error::RecordError;
use crate::record::RecordReader;
use apex_model::effect::Effect;
use apex_model::task::TaskId;
use apex_model::time::Time;
use rusqlite::{OptionalExtension, Params, Row, params};

const COLUMNS: &str = "id, t_ns, kind, task, from_state, to_state, outcome, subject, text, place, body";

/// A row of the `effect` table.
pub(crate) struct DecisionRow {
    pub(crate) id: i64,
    pub(crate) at: Time,
    pub(crate) kind: String,
    pub(crate) task: Option<TaskId>,
    /// State before, for `transition`.
    pub(crate) from: Option<String>,
    /// State after, for `transition`.
    pub(crate) to: Option<String>,
    /// `success`, `failure` or `cut`, for the transition to `terminated`.
    pub(crate) outcome: Option<String>,
    pub(crate) subject: String,
    pub(crate) text: String,
    pub(crate) place: Option<String>,
    /// None if this Apex cannot read it.
    pub(crate) effect: Option<Effect>,
}

impl DecisionRow {
    /// Reads a row of [`COLUMNS`].
    fn read(row: &Row<'_>) -> rusqlite::Result<DecisionRow> {
        let body = row.get_ref(10)?.as_blob()?;
        Ok(DecisionRow {
            id: row.get(0)?,
            at: Time(row.get(1)?),
            kind: row.get(2)?,
            task: row.get::<_, Option<i64>>(3)?.map(|task| TaskId(task.cast_unsigned())),
            from: row.get(4)?,
            to: row.get(5)?,
            outcome: row.get::<_, Option<String>>(6)?.filter(|word| !word.is_empty()),
            subject: row.get::<_, Option<String>>(7)?.unwrap_or_default(),
            text: row.get::<_, Option<String>>(8)?.unwrap_or_default(),
            place: row.get::<_, Option<String>>(9)?.filter(|place| !place.is_empty()),
            effect: postcard::from_bytes(body).ok(),
        })
    }
}

/// The decisions of a record up to an instant.
#[derive(Clone, Copy)]
pub(crate) struct Decisions<'a> {
    pub(crate) reader: &'a RecordReader,
    /// Later decisions are ignored.
    pub(crate) until: Time,
}

type DecisionResult = Result<Option<DecisionRow>, RecordError>;

impl Decisions<'_> {
    fn first(&self, condition: &str, parameters: impl Params) -> DecisionResult {
        let sql = format!("SELECT {COLUMNS} FROM effect WHERE t_ns <= {} AND {condition} LIMIT 1", self.until.0);
        let found = self.reader.connection.prepare_cached(&sql).and_then(|mut statement| {
            let mut rows = statement.query_map(parameters, DecisionRow::read)?;
            rows.next().transpose()
        });
        found.map_err(|error| self.reader.damaged("the effects", error))
    }

    /// The transition to `state` that is nearest to the decision `id` at its instant `at`, else the last one before.
    pub(crate) fn transition(&self, task: TaskId, state: &str, (id, at): (i64, Time)) -> DecisionResult {
        let condition = "task = ?1 AND kind = 'transition' AND to_state = ?2 AND (id < ?3 OR t_ns = ?4)
            ORDER BY t_ns = ?4 DESC, abs(id - ?3)";
        self.first(condition, params![number(task), state, id, at.0])
    }

    /// The last transition to `state` before the decision `id`.
    pub(crate) fn transition_before(&self, task: TaskId, state: &str, id: i64) -> DecisionResult {
        let condition = "task = ?1 AND kind = 'transition' AND to_state = ?2 AND id < ?3 ORDER BY id DESC";
        self.first(condition, params![number(task), state, id])
    }

    /// The last decision of one kind about the task before the decision `id`.
    pub(crate) fn before(&self, task: TaskId, kind: &str, id: i64) -> DecisionResult {
        self.first("task = ?1 AND kind = ?2 AND id < ?3 ORDER BY id DESC", params![number(task), kind, id])
    }

    /// The decision of one kind about the task nearest to `id` at its instant.
    pub(crate) fn beside(&self, task: TaskId, kind: &str, (id, at): (i64, Time)) -> DecisionResult {
        let condition = "task = ?1 AND kind = ?2 AND t_ns = ?4 ORDER BY abs(id - ?3)";
        self.first(condition, params![number(task), kind, id, at.0])
    }

    /// The creation or last transition of the task.
    pub(crate) fn last_move(&self, task: TaskId) -> DecisionResult {
        self.first("task = ?1 AND kind IN ('created', 'transition') ORDER BY id DESC", params![number(task)])
    }

    /// The last binding of a variable of the task before the decision `id`.
    pub(crate) fn binding(&self, task: TaskId, variable: &str, id: i64) -> DecisionResult {
        let like = format!("?{variable} = %");
        let condition = "task = ?1 AND kind = 'bound' AND subject LIKE ?2 AND id < ?3 ORDER BY id DESC";
        self.first(condition, params![number(task), like, id])
    }

    /// The command with this number.
    pub(crate) fn command(&self, command: u64) -> DecisionResult {
        self.first("kind = 'command' AND text = ?1", params![format!("command {command}")])
    }

    /// The command with this number, by the task that sent it.
    pub(crate) fn command_of(&self, task: TaskId, command: u64) -> DecisionResult {
        let condition = "task = ?1 AND kind = 'command' AND text = ?2";
        self.first(condition, params![number(task), format!("command {command}")])
    }

    /// The last command whose form contains `words`.
    pub(crate) fn command_like(&self, words: &str) -> DecisionResult {
        let escaped = words.replace('\\', "\\\\").replace('%', "\\%").replace('_', "\\_");
        let condition = "kind = 'command' AND subject LIKE ?1 ESCAPE '\\' ORDER BY id DESC";
        self.first(condition, params![format!("%{escaped}%")])
    }

    /// The request to a solver with this number.
    pub(crate) fn request(&self, task: TaskId, request: u64) -> DecisionResult {
        let condition = "task = ?1 AND kind = 'solve' AND text LIKE ?2 ORDER BY id DESC";
        self.first(condition, params![number(task), format!("request {request} to %")])
    }

    /// The message `form` of one of the agent's own tasks at this instant.
    pub(crate) fn inform(&self, form: &str, at: Time) -> DecisionResult {
        let condition =
            "batch IN (SELECT id FROM batch WHERE t_ns = ?1) AND kind = 'inform' AND subject = ?2 ORDER BY id";
        self.first(condition, params![at.0, form])
    }

    /// The sample `subject`, `(count x) = 3`, that one of the agent's own tasks published at this instant.
    pub(crate) fn publish(&self, subject: &str, at: Time) -> DecisionResult {
        let condition =
            "batch IN (SELECT id FROM batch WHERE t_ns = ?1) AND kind = 'publish' AND subject = ?2 ORDER BY id DESC";
        self.first(condition, params![at.0, subject])
    }

    /// Calls `take` with every decision about the task, oldest first.
    pub(crate) fn about(&self, task: TaskId, mut take: impl FnMut(DecisionRow)) -> Result<(), RecordError> {
        let sql = format!("SELECT {COLUMNS} FROM effect WHERE task = ?1 AND t_ns <= ?2 ORDER BY id");
        let mut read = || {
            let mut statement = self.reader.connection.prepare_cached(&sql)?;
            let mut rows = statement.query(params![number(task), self.until.0])?;
            while let Some(row) = rows.next()? {
                take(DecisionRow::read(row)?);
            }
            Ok(())
        };
        read().map_err(|error| self.reader.damaged("the effects", error))
    }

    /// The word of the task's state at the end of the interval; none if it was never moved.
    pub(crate) fn state(&self, task: TaskId) -> Result<Option<String>, RecordError> {
        let sql = "SELECT to_state FROM effect WHERE task = ?1 AND t_ns <= ?2 AND kind = 'transition' \
                   ORDER BY id DESC LIMIT 1";
        let parameters = params![number(task), self.until.0];
        let state = self.reader.connection.query_row(sql, parameters, |row| row.get(0)).optional();
        state.map_err(|error| self.reader.damaged("the effects", error))
    }

    /// The identifier of the target with this identifier or name, in any case.
    pub(crate) fn target_called(&self, name: &str) -> Result<Option<String>, RecordError> {
        let sql =
            "SELECT id FROM target WHERE id = ?1 COLLATE NOCASE OR name = ?1 COLLATE NOCASE ORDER BY position LIMIT 1";
        let found = self.reader.connection.query_row(sql, [name], |row| row.get(0)).optional();
        found.map_err(|error| self.reader.damaged("the targets", error))
    }

    /// The identifiers of all targets.
    pub(crate) fn target_ids(&self) -> Result<Vec<String>, RecordError> {
        let read = || {
            let mut statement = self.reader.connection.prepare("SELECT id FROM target ORDER BY id")?;
            statement.query_map([], |row| row.get(0))?.collect::<rusqlite::Result<_>>()
        };
        read().map_err(|error| self.reader.damaged("the targets", error))
    }

    /// The recorded states of the target, in the order of recording.
    pub(crate) fn target_changes(&self, id: &str) -> Result<Vec<TargetChange>, RecordError> {
        let sql = "SELECT t_ns, state, detail FROM target_state WHERE target = ?1 AND t_ns <= ?2 ORDER BY position";
        let read = || {
            let mut statement = self.reader.connection.prepare(sql)?;
            let rows = statement.query_map(params![id, self.until.0], |row| {
                Ok(TargetChange { t_ns: row.get(0)?, state: row.get(1)?, detail: row.get(2)? })
            })?;
            rows.collect::<rusqlite::Result<_>>()
        };
        read().map_err(|error| self.reader.damaged("the targets", error))
    }
}

/// SQLite knows signed numbers only.
fn number(task: TaskId) -> i64 {
    task.0.cast_signed()
}
