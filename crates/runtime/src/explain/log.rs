//! The record's decisions as an explanation asks for them: the last one of a kind before another, or at its instant.

use crate::error::RecordError;
use crate::record::RecordReader;
use apex_model::effect::Effect;
use apex_model::event::StateVariable;
use apex_model::source::SourceFile;
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};
use rusqlite::{Params, params};

const COLUMNS: &str = "id, t_ns, kind, task, subject, text, place, body";

/// A row of the `effect` table.
pub(super) struct Row {
    pub(super) id: i64,
    pub(super) at: Time,
    pub(super) kind: String,
    pub(super) task: Option<TaskId>,
    pub(super) subject: String,
    pub(super) text: String,
    pub(super) place: Option<String>,
    /// None when this Apex cannot read it.
    pub(super) effect: Option<Effect>,
}

/// The decisions up to an instant.
pub(super) struct Log<'a> {
    pub(super) reader: &'a RecordReader,
    /// Nothing after this is looked at.
    pub(super) until: Time,
    /// The texts that places point into.
    pub(super) sources: Vec<SourceFile>,
}

impl Log<'_> {
    fn first(&self, condition: &str, parameters: impl Params) -> Result<Option<Row>, RecordError> {
        let sql = format!("SELECT {COLUMNS} FROM effect WHERE t_ns <= {} AND {condition} LIMIT 1", self.until.0);
        let found = self.reader.connection().prepare_cached(&sql).and_then(|mut statement| {
            let mut rows = statement.query_map(parameters, |row| {
                let body: Vec<u8> = row.get(7)?;
                Ok(Row {
                    id: row.get(0)?,
                    at: Time(row.get(1)?),
                    kind: row.get(2)?,
                    task: row.get::<_, Option<i64>>(3)?.map(|task| TaskId(task as u64)),
                    subject: row.get::<_, Option<String>>(4)?.unwrap_or_default(),
                    text: row.get::<_, Option<String>>(5)?.unwrap_or_default(),
                    place: row.get(6)?,
                    effect: postcard::from_bytes(&body).ok(),
                })
            })?;
            rows.next().transpose()
        });
        found.map_err(|error| self.reader.damaged("the effects", error))
    }

    /// The transition to `state` that is nearest to the decision `id` at its instant `at`, else the last one before.
    pub(super) fn transition(
        &self,
        task: TaskId,
        state: &str,
        (id, at): (i64, Time),
    ) -> Result<Option<Row>, RecordError> {
        let condition = "task = ?1 AND kind = 'transition' AND to_state = ?2 AND (id < ?3 OR t_ns = ?4)
            ORDER BY t_ns = ?4 DESC, abs(id - ?3)";
        self.first(condition, params![task.0 as i64, state, id, at.0])
    }

    /// The last transition to `state` before the decision `id`.
    pub(super) fn transition_before(&self, task: TaskId, state: &str, id: i64) -> Result<Option<Row>, RecordError> {
        let condition = "task = ?1 AND kind = 'transition' AND to_state = ?2 AND id < ?3 ORDER BY id DESC";
        self.first(condition, params![task.0 as i64, state, id])
    }

    /// The last decision of one kind about the task before the decision `id`.
    pub(super) fn before(&self, task: TaskId, kind: &str, id: i64) -> Result<Option<Row>, RecordError> {
        self.first("task = ?1 AND kind = ?2 AND id < ?3 ORDER BY id DESC", params![task.0 as i64, kind, id])
    }

    /// The decision of one kind about the task nearest to `id` at its instant.
    pub(super) fn beside(&self, task: TaskId, kind: &str, (id, at): (i64, Time)) -> Result<Option<Row>, RecordError> {
        let condition = "task = ?1 AND kind = ?2 AND t_ns = ?4 ORDER BY abs(id - ?3)";
        self.first(condition, params![task.0 as i64, kind, id, at.0])
    }

    /// What the task was made or moved by last: its creation or its last transition.
    pub(super) fn last_move(&self, task: TaskId) -> Result<Option<Row>, RecordError> {
        self.first("task = ?1 AND kind IN ('created', 'transition') ORDER BY id DESC", params![task.0 as i64])
    }

    /// The binding of a variable that the task has.
    pub(super) fn binding(&self, task: TaskId, variable: &str, id: i64) -> Result<Option<Row>, RecordError> {
        let like = format!("?{variable} = %");
        let condition = "task = ?1 AND kind = 'bound' AND subject LIKE ?2 AND id < ?3 ORDER BY id DESC";
        self.first(condition, params![task.0 as i64, like, id])
    }

    /// The command with this number.
    pub(super) fn command(&self, number: u64) -> Result<Option<Row>, RecordError> {
        self.first("kind = 'command' AND text = ?1", params![format!("command {number}")])
    }

    /// The command with this number, by the task that sent it.
    pub(super) fn command_of(&self, task: TaskId, number: u64) -> Result<Option<Row>, RecordError> {
        let condition = "task = ?1 AND kind = 'command' AND text = ?2";
        self.first(condition, params![task.0 as i64, format!("command {number}")])
    }

    /// The last command whose form has these words.
    pub(super) fn command_like(&self, words: &str) -> Result<Option<Row>, RecordError> {
        let escaped = words.replace('\\', "\\\\").replace('%', "\\%").replace('_', "\\_");
        let condition = "kind = 'command' AND subject LIKE ?1 ESCAPE '\\' ORDER BY id DESC";
        self.first(condition, params![format!("%{escaped}%")])
    }

    /// The request to a solver with this number.
    pub(super) fn request(&self, task: TaskId, number: u64) -> Result<Option<Row>, RecordError> {
        let condition = "task = ?1 AND kind = 'solve' AND text LIKE ?2 ORDER BY id DESC";
        self.first(condition, params![task.0 as i64, format!("request {number} to %")])
    }

    /// The task's own message `form`, if the agent said it itself at this instant.
    pub(super) fn inform(&self, form: &str, at: Time) -> Result<Option<Row>, RecordError> {
        let condition =
            "batch IN (SELECT id FROM batch WHERE t_ns = ?1) AND kind = 'inform' AND subject = ?2 ORDER BY id";
        self.first(condition, params![at.0, form])
    }

    /// The largest time between two of the `samples` of a run, as they were recorded by the instant at which it was known; none for one sample, and where
    /// other instants than the run's own stand in the record: some came too late, or were no numbers.
    pub(super) fn largest_gap(
        &self,
        variable: &StateVariable,
        run: (Time, Time),
        samples: u64,
        known_at: Time,
    ) -> Result<Option<Duration>, RecordError> {
        let found = self.reader.samples_arrived(variable, run, known_at)?;
        let mut instants: Vec<Time> = found.iter().map(|sample| sample.at).collect();
        instants.sort_unstable();
        instants.dedup();
        let all = u64::try_from(instants.len()).is_ok_and(|found| found == samples);
        let spacings = instants.iter().zip(instants.iter().skip(1)).map(|(before, after)| *after - *before);
        Ok(spacings.max().filter(|_| all))
    }

    /// The line of the program at `file:line:column`.
    pub(super) fn source_line(&self, place: &str) -> Option<String> {
        let (rest, _) = place.rsplit_once(':')?;
        let (file, line) = rest.rsplit_once(':')?;
        let number: usize = line.parse().ok()?;
        let source = self.sources.iter().find(|source| &*source.name == file)?;
        let text = source.text.lines().nth(number.checked_sub(1)?)?.trim();
        (!text.is_empty()).then(|| text.to_owned())
    }
}
