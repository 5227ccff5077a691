//! Reads a flight record: facts, sources, tasks, samples. Steps are in `steps.rs`, restored agents in `restore.rs`.

use super::codec::{Variable, Variables};
use super::connect::Copied;
use super::effects::EffectTable;
use super::gap::RecordGap;
use super::known_tasks::KnownTasks;
use super::open::{self, Opened, Stamp, Trust};
use super::schema::{self, read_error};
use super::segment_join::SharedFollower;
use super::segments::{SPARE_FOLDER, SegmentPlaces};
use super::steps::Steps;
use crate::error::RecordError;
use apex_model::event::{EventKind, StateVariable};
use apex_model::library::AgentDeclaration;
use apex_model::source::SourceFile;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use rusqlite::{Connection, OptionalExtension, Row, params};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

/// An open flight record. A record that is still being written can be read; it contains the committed steps.
pub struct RecordReader {
    pub(super) path: PathBuf,
    pub(super) connection: Connection,
    /// The names of the agents.
    agents: Vec<String>,
    /// The selected agent.
    pub(super) agent: usize,
    /// Reason to trust the rows; advances with a record that grows.
    pub(super) trust: RefCell<Trust>,
    /// The copy that is read in place of the record.
    copy: Option<Arc<Copied>>,
    /// The file that the record continues, if it is missing.
    pub(super) missing: Option<PathBuf>,
    /// Continues the copy while the last segment of the record grows.
    follower: Option<SharedFollower>,
    /// The agent's effects, shared with other readers of them.
    pub(super) table: Arc<RwLock<EffectTable>>,
    /// The agent's tasks, shared as its effects are.
    pub(super) known_tasks: Arc<Mutex<KnownTasks>>,
}

/// A file that the mission was made from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredSource {
    /// Its name as given by the user.
    pub name: String,
    /// `pdl` or `data`.
    pub role: String,
    /// Its bytes.
    pub body: Vec<u8>,
}

/// A recorded sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Instant of the measurement.
    pub at: Time,
    /// Its value.
    pub value: Value,
}

impl RecordReader {
    /// Opens the record at `path`.
    ///
    /// # Errors
    /// [`RecordError`] for a missing file, a file that is not a record, and a record of a newer Apex.
    pub fn open(path: &Path) -> Result<RecordReader, RecordError> {
        RecordReader::open_at(path, 0)
    }

    /// Returns the same record, restricted to agent `agent` (from 0, in the order of [`RecordReader::agents`]): it then contains only
    /// that agent's steps, tasks and snapshots.
    ///
    /// # Errors
    /// Like [`RecordReader::open`].
    pub fn of_agent(&self, agent: usize) -> Result<RecordReader, RecordError> {
        let opened = open::open_again(&self.path, (&self.trust.borrow(), self.copy.as_ref(), self.follower.as_ref()))?;
        let mut reader = RecordReader::of_opened(&self.path, opened, agent)?;
        if agent == self.agent {
            reader.share(self);
        }
        Ok(reader)
    }

    pub(super) fn open_at(path: &Path, agent: usize) -> Result<RecordReader, RecordError> {
        RecordReader::of_opened(path, open::open(path)?, agent)
    }

    /// As [`RecordReader::open_at`], before the comparison with the seal: nothing that this reader reads may be shown before that has
    /// succeeded. `None` for a record without a seal, and for one that cannot be read.
    pub(super) fn of_unchecked(path: &Path, agent: usize) -> Option<RecordReader> {
        RecordReader::of_opened(path, open::open_unchecked(path)?, agent).ok()
    }

    /// Returns true if the rows are trusted because the whole file equals its seal, and the file is still the one with this stamp.
    pub(super) fn is_of_file(&self, stamp: Stamp) -> bool {
        matches!(&*self.trust.borrow(), Trust::File(checked) if *checked == stamp)
    }

    /// Shares effects and tasks in memory with another reader of the same agent in the same file.
    pub(super) fn share(&mut self, other: &RecordReader) {
        self.table = Arc::clone(&other.table);
        self.known_tasks = Arc::clone(&other.known_tasks);
    }

    fn of_opened(path: &Path, opened: Opened, agent: usize) -> Result<RecordReader, RecordError> {
        let Opened { connection, trust, copy, missing, follower } = opened;
        let fail = |error| read_error(path, "the agents", error);
        let agents = schema::agents(&connection).map_err(fail)?;
        if agents.len() > 1 {
            schema::look_at_agent(&connection, agent).map_err(fail)?;
        }
        Ok(RecordReader {
            path: path.to_path_buf(),
            connection,
            agents,
            agent,
            trust: RefCell::new(trust),
            copy,
            missing,
            follower,
            table: Arc::default(),
            known_tasks: Arc::default(),
        })
    }

    /// Checks what was added since the last check; a complete record must be unchanged. Long-running readers call this before each read.
    ///
    /// # Errors
    /// [`RecordError::Damaged`], and [`RecordError::Replaced`] if another flight has taken the file.
    pub(super) fn check_growth(&self) -> Result<(), RecordError> {
        match &mut *self.trust.borrow_mut() {
            Trust::File(stamp) if *stamp == open::stamp(&self.path) => Ok(()),
            Trust::File(_) => Err(self.garbled("its file was changed while it was read".into())),
            Trust::Groups(position, _, numbers) => {
                if let Some(follower) = &self.follower {
                    follower.lock().unwrap_or_else(PoisonError::into_inner).advance()?;
                }
                open::follow(&self.connection, &self.path, (position, *numbers))
            }
        }
    }

    /// Returns the names of the agents that ran, in the order of their declarations.
    pub fn agents(&self) -> &[String] {
        &self.agents
    }

    /// Returns true if several agents ran: a task's number alone is then ambiguous.
    pub fn has_several_agents(&self) -> bool {
        self.agents.len() > 1
    }

    /// Returns the number of the agent called `name`, in any case.
    ///
    /// # Errors
    /// [`RecordError::Question`] with the names that there are.
    pub fn agent_called(&self, name: &str) -> Result<usize, RecordError> {
        self.agents.iter().position(|agent| agent.eq_ignore_ascii_case(name)).ok_or_else(|| {
            RecordError::Question(format!("No agent is called {name}; the record has {}.", self.agents.join(", ")))
        })
    }

    /// Returns declarations that contain only the names of the recorded agents, if several ran; empty for a single agent.
    pub(crate) fn stand_ins(&self) -> Vec<AgentDeclaration> {
        let of = |name: &String| AgentDeclaration { name: Symbol::new(name), ..AgentDeclaration::of_program() };
        if self.has_several_agents() { self.agents.iter().map(of).collect() } else { Vec::new() }
    }

    /// Returns the file in which this record continues: the last, if it continues more than once. `None` for a record that was closed.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn successor(&self) -> Result<Option<PathBuf>, RecordError> {
        if self.is_complete()? {
            return Ok(None);
        }
        let spare_folder = self.meta(SPARE_FOLDER)?.map(PathBuf::from);
        Ok(SegmentPlaces { spare_folder, bytes_max: None }.successor(&self.path))
    }

    /// Returns the number of the selected agent.
    pub fn agent_number(&self) -> usize {
        self.agent
    }

    /// Returns the record's file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns a fact about the flight; see the `meta` table.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn meta(&self, key: &str) -> Result<Option<String>, RecordError> {
        self.connection
            .query_row("SELECT value FROM meta WHERE key = ?1 ORDER BY position DESC LIMIT 1", [key], |row| row.get(0))
            .optional()
            .map_err(|error| self.damaged("the facts", error))
    }

    /// Returns true if the record was closed properly.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn is_complete(&self) -> Result<bool, RecordError> {
        Ok(self.meta("complete")?.as_deref() == Some("1"))
    }

    /// Returns the gaps of the record in order: steps that are missing because the disk accepted no writes.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn gaps(&self) -> Result<Vec<RecordGap>, RecordError> {
        let texts: Vec<String> =
            self.rows("the facts", "SELECT value FROM meta WHERE key = 'gap' ORDER BY position", |row| row.get(0))?;
        texts.iter().map(|text| self.gap(text)).collect()
    }

    fn gap(&self, text: &str) -> Result<RecordGap, RecordError> {
        let numbers = text.split_once(' ').and_then(|(first, last)| Some((first.parse().ok()?, last.parse().ok()?)));
        let (first_batch, last_batch): (i64, i64) =
            numbers.ok_or_else(|| self.garbled(format!("the fact `gap` is `{}`", text.escape_debug())))?;
        let at = |sql: &str, batch: i64| {
            let found = self.connection.query_row(sql, [batch], |row| row.get::<_, Option<i64>>(0));
            found.optional().map(|at| at.flatten().map(Time)).map_err(|error| self.damaged("the steps", error))
        };
        let after = at("SELECT t_ns FROM main.batch WHERE id < ?1 ORDER BY id DESC LIMIT 1", first_batch)?;
        let before = at("SELECT t_ns FROM main.batch WHERE id > ?1 ORDER BY id LIMIT 1", last_batch)?;
        Ok(RecordGap { first_batch, last_batch, after: after.unwrap_or(Time::ZERO), before })
    }

    /// Returns the first and last recorded instant; `None` if no step is recorded.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn span(&self) -> Result<Option<(Time, Time)>, RecordError> {
        // One aggregate at a time is read from the end of the index; both together would read all of it.
        let sql = "SELECT (SELECT min(t_ns) FROM main.batch), (SELECT max(t_ns) FROM main.batch)";
        let both: (Option<i64>, Option<i64>) = self
            .connection
            .query_row(sql, [], |row| Ok((row.get(0)?, row.get(1)?)))
            .map_err(|error| self.damaged("the steps", error))?;
        Ok(both.0.zip(both.1).map(|(first, last)| (Time(first), Time(last))))
    }

    /// Returns all files that the mission was made from, in order.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn sources(&self) -> Result<Vec<StoredSource>, RecordError> {
        self.rows("the sources", "SELECT name, role, body FROM source ORDER BY position", |row| {
            Ok(StoredSource { name: row.get(0)?, role: row.get(1)?, body: row.get(2)? })
        })
    }

    /// Returns the PDL sources in load order, which replay loads again.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn pdl_sources(&self) -> Result<Vec<SourceFile>, RecordError> {
        let sources = self.sources()?.into_iter().filter(|source| source.role == "pdl");
        let file = |source: StoredSource| match String::from_utf8(source.body) {
            Ok(text) => Ok(SourceFile { name: Arc::from(source.name), text: Arc::from(text) }),
            Err(_) => Err(self.garbled(format!("the source {} is not UTF-8 text", source.name))),
        };
        sources.map(file).collect()
    }

    /// Returns the decisions of the runtime, with times: dropped solver answers and the like.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn notes(&self) -> Result<Vec<(Time, String)>, RecordError> {
        let sql = "SELECT t_ns, text FROM note ORDER BY position";
        self.rows("the notes", sql, |row| Ok((Time(row.get(0)?), row.get(1)?)))
    }

    /// Returns the sections of the final report, as name and JSON text, in order; none before the flight has ended.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn report_sections(&self) -> Result<Vec<(String, String)>, RecordError> {
        let sql = "SELECT section, body FROM report ORDER BY position";
        self.rows("the report", sql, |row| Ok((row.get(0)?, row.get(1)?)))
    }

    /// Returns the state variables that were measured, in order of first appearance.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn variables(&self) -> Result<Vec<StateVariable>, RecordError> {
        let variables = self.variable_table()?;
        Ok((1..).map_while(|number| variables.get(number)).map(|known| known.variable.clone()).collect())
    }

    /// Returns all samples of `variable` with `from <= at <= to`, in order of arrival.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn samples(&self, variable: &StateVariable, from: Time, to: Time) -> Result<Vec<Sample>, RecordError> {
        self.samples_arrived(variable, (from, to), Time::END)
    }

    /// Like [`RecordReader::samples`], for samples that had arrived by `arrived`.
    pub(crate) fn samples_arrived(
        &self,
        variable: &StateVariable,
        (from, to): (Time, Time),
        arrived: Time,
    ) -> Result<Vec<Sample>, RecordError> {
        let mut samples = Vec::new();
        for step in self.steps_between(from, arrived)?.without_effects() {
            for event in step?.batch.events {
                if let EventKind::Measurement(measured, value) = event.kind
                    && measured == *variable
                    && (from..=to).contains(&event.at)
                {
                    samples.push(Sample { at: event.at, value });
                }
            }
        }
        Ok(samples)
    }

    /// Returns all steps in order.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn steps(&self) -> Result<Steps<'_>, RecordError> {
        self.steps_between(Time::BEGINNING, Time::END)
    }

    /// Returns the steps with `from <= now <= to`, in order.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn steps_between(&self, from: Time, to: Time) -> Result<Steps<'_>, RecordError> {
        self.check_growth()?;
        let sql = "SELECT ifnull((SELECT id FROM batch WHERE t_ns >= ?1 ORDER BY t_ns, id LIMIT 1), 0)";
        let first = self
            .connection
            .query_row(sql, [from.0], |row| row.get::<_, i64>(0))
            .map_err(|error| self.damaged("the steps", error))?;
        Steps::new(self, first, to)
    }

    /// Returns the steps of all agents up to `to`, in the order in which they were executed.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn steps_of_all(&self, to: Time) -> Result<Steps<'_>, RecordError> {
        self.check_growth()?;
        Steps::new(self, 1, to).map(Steps::of_all)
    }

    pub(super) fn variable_table(&self) -> Result<Variables, RecordError> {
        let mut variables = Variables::default();
        let bodies: Vec<Vec<u8>> =
            self.rows("the state variables", "SELECT body FROM variable ORDER BY id", |row| row.get(0))?;
        for body in bodies {
            let variable: Variable = postcard::from_bytes(&body).map_err(|error| {
                self.garbled(format!("state variable {} is garbled ({error})", variables.len() + 1))
            })?;
            variables.add(variable);
        }
        Ok(variables)
    }

    /// Returns the latest snapshot of a batch not after `to`: batch number and bytes.
    pub(super) fn snapshot_before(&self, to: Time) -> Result<Option<(i64, Vec<u8>)>, RecordError> {
        let sql = "SELECT batch, body FROM snapshot WHERE t_ns <= ?1 AND batch <= (SELECT id FROM batch WHERE t_ns <= ?1 ORDER BY t_ns DESC, id DESC LIMIT 1) \
                   ORDER BY batch DESC LIMIT 1";
        self.connection
            .query_row(sql, params![to.0], |row| Ok((row.get(0)?, row.get(1)?)))
            .optional()
            .map_err(|error| self.damaged("the snapshots", error))
    }

    pub(super) fn rows<T>(
        &self,
        what: &str,
        sql: &str,
        read: impl FnMut(&Row<'_>) -> rusqlite::Result<T>,
    ) -> Result<Vec<T>, RecordError> {
        let all = self.connection.prepare(sql).and_then(|mut statement| statement.query_map([], read)?.collect());
        all.map_err(|error| self.damaged(what, error))
    }

    pub(crate) fn damaged(&self, what: &str, error: rusqlite::Error) -> RecordError {
        read_error(&self.path, what, error)
    }

    pub(crate) fn garbled(&self, what: String) -> RecordError {
        RecordError::Damaged { path: self.path.clone(), what }
    }
}
