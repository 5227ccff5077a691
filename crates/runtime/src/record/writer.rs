//! The recorder: an observer that stores every step. Inputs are written before they are used, effects before they are
//! sent; steps are committed in groups, so a crash loses at most the last group and never the order.

use super::codec::{self, Variables};
use super::store::Store;
use super::track::{Track, TrackRow};
use crate::effect_describer::{EffectDescriber, EffectRow, outcome_word};
use crate::error::RecordError;
use crate::limits::{SNAPSHOT_BATCHES_MAX, SNAPSHOT_BATCHES_MIN, SNAPSHOT_BYTES_MAX};
use crate::ports::{Deliberator, Observer, SolverAnswer};
use apex_executive::state::agent::Agent;
use apex_model::effect::{Decision, DecisionKind, Effect, SolveRequest, SolveRequestId};
use apex_model::event::{Batch, SolverReport};
use apex_model::library::Library;
use apex_model::task::TaskState;
use apex_model::time::Time;
use rusqlite::params;
use std::path::Path;

/// What to record, beyond inputs and effects.
#[derive(Clone, Debug, Default)]
pub struct RecordOptions {
    /// The vehicle whose measurements make the track, for example `aircraft-1`; none draws no track.
    pub vehicle: Option<String>,
    /// Largest size of the file in bytes; none is as much as the disk holds.
    pub bytes_max: Option<u64>,
}

/// Writes a flight record while the flight goes on. Put it first among the observers of a run.
pub struct Recorder {
    pub(super) store: Store,
    agents: Vec<RecordedAgent>,
    /// Whose steps are stored.
    turn: usize,
    variables: Variables,
    track: Option<Track>,
    bytes: Vec<u8>,
    /// Number of the last batch; the batch that is being executed when `begun`.
    batch: i64,
    effect: i64,
    begun: bool,
    /// Changes of targets' states that are stored.
    pub(super) stored_changes: usize,
}

/// What is kept of each agent while its steps are stored.
struct RecordedAgent {
    describer: EffectDescriber,
    snapshots: Snapshots,
}

/// When the next snapshot is worth its bytes.
#[derive(Default)]
struct Snapshots {
    batches_since: u64,
    input_bytes_since: usize,
    last_bytes: usize,
    impossible: bool,
}

impl Snapshots {
    fn is_due(&self) -> bool {
        let paid_for = self.input_bytes_since >= self.last_bytes && self.batches_since >= SNAPSHOT_BATCHES_MIN;
        !self.impossible && (paid_for || self.batches_since >= SNAPSHOT_BATCHES_MAX)
    }
}

impl Recorder {
    /// Makes a record at `path` for a run of `library`. An older flight record there is replaced; any other file is
    /// left alone. The record counts as incomplete until [`Recorder::finish`].
    ///
    /// # Errors
    /// [`RecordError`] with what, where, why and what to do.
    pub fn create(path: &Path, library: &Library, options: RecordOptions) -> Result<Recorder, RecordError> {
        let mut recorder = Recorder {
            store: Store::create(path, options.bytes_max)?,
            agents: Vec::new(),
            turn: 0,
            variables: Variables::default(),
            track: options.vehicle.as_deref().map(Track::new),
            bytes: Vec::new(),
            batch: 0,
            effect: 0,
            begun: false,
            stored_changes: 0,
        };
        for (agent, number) in library.crew().iter().zip(0_i64..) {
            recorder
                .agents
                .push(RecordedAgent { describer: EffectDescriber::new(library), snapshots: Snapshots::default() });
            let sql = "INSERT INTO agent VALUES (?1, ?2)";
            recorder.store.write("storing the agents", sql, params![number, agent.name.printed()])?;
        }
        recorder.meta("apex_version", env!("CARGO_PKG_VERSION"))?;
        recorder.meta("complete", "0")?;
        if let Some(vehicle) = &options.vehicle {
            recorder.meta("vehicle", vehicle)?;
        }
        recorder.store.commit()?;
        Ok(recorder)
    }

    /// Stores the PDL sources of `library` in load order, as [`Recorder::source`] with role `pdl`.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn program(&mut self, library: &Library) -> Result<(), RecordError> {
        library.sources.iter().try_for_each(|source| self.source(&source.name, "pdl", source.text.as_bytes()))
    }

    /// The record's file.
    pub fn path(&self) -> &Path {
        self.store.path()
    }

    /// Closes the record properly: it is complete from now on. `reason` is [`crate::EndReason::text`] or a fault.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn finish(&mut self, end: Time, reason: &str) -> Result<(), RecordError> {
        self.meta("end_ns", &end.0.to_string())?;
        self.meta("end_reason", reason)?;
        self.meta("complete", "1")?;
        self.store.commit()?;
        self.store.fold();
        Ok(())
    }

    fn store_batch(&mut self, batch: &Batch) -> Result<(), RecordError> {
        self.store.now = batch.now;
        self.batch += 1;
        let known = self.variables.len();
        let mut bytes = std::mem::take(&mut self.bytes);
        codec::encode(batch, &mut self.variables, &mut bytes)
            .map_err(|error| self.store.unstorable("an input", error))?;
        for number in known..self.variables.len() {
            self.store_variable(number as u64 + 1)?;
        }
        let sql = "INSERT INTO batch VALUES (?1, ?2, ?3, ?4)";
        self.store.write("storing the inputs", sql, params![self.batch, batch.now.0, bytes, self.turn as i64])?;
        if let Some(agent) = self.agents.get_mut(self.turn) {
            agent.snapshots.batches_since += 1;
            agent.snapshots.input_bytes_since += bytes.len();
            agent.describer.hear(batch);
        }
        self.bytes = bytes;
        match self.track.as_mut().and_then(|track| track.hear(batch)) {
            Some(row) => self.store_track(&row),
            None => Ok(()),
        }
    }

    fn store_variable(&mut self, number: u64) -> Result<(), RecordError> {
        let Some(variable) = self.variables.get(number) else { return Ok(()) };
        let name = variable.variable.to_string();
        let body = postcard::to_stdvec(variable).map_err(|error| self.store.unstorable(&name, error))?;
        let sql = "INSERT INTO variable VALUES (?1, ?2, ?3)";
        self.store.write("storing a state variable", sql, params![number as i64, name, body])
    }

    fn store_track(&mut self, row: &TrackRow) -> Result<(), RecordError> {
        let TrackRow { at, latitude_deg, longitude_deg, altitude_m, heading_deg, roll_deg, ground_speed_mps, fuel_kg } =
            row;
        self.store.write(
            "storing the track",
            "INSERT OR REPLACE INTO track VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
            params![at.0, latitude_deg, longitude_deg, altitude_m, heading_deg, roll_deg, ground_speed_mps, fuel_kg],
        )
    }

    fn store_effect(&mut self, effect: &Effect) -> Result<(), RecordError> {
        let Some(agent) = self.agents.get_mut(self.turn) else { return Ok(()) };
        let told = agent.describer.tell(effect);
        let body = postcard::to_stdvec(effect).map_err(|error| self.store.unstorable(told.kind, error))?;
        self.effect += 1;
        let states = (told.from.map(TaskState::word), told.to.map(TaskState::word));
        let now = self.store.now.0;
        self.store.write(
            "storing the effects",
            "INSERT INTO effect VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13)",
            params![
                self.effect,
                self.batch,
                now,
                told.kind,
                told.task.map(|task| task.0 as i64),
                states.0,
                states.1,
                told.outcome,
                told.subject,
                told.text,
                told.place,
                body,
                self.turn as i64
            ],
        )?;
        match effect {
            Effect::Decided(decision) => self.keep_task(decision, &told),
            _ => Ok(()),
        }
    }

    /// Brings the row of the decision's task up to date.
    fn keep_task(&mut self, decision: &Decision, told: &EffectRow) -> Result<(), RecordError> {
        let Some(task) = decision.task.map(|task| task.0 as i64) else { return Ok(()) };
        let doing = "keeping the tasks";
        let (now, agent) = (self.store.now.0, self.turn as i64);
        match &decision.kind {
            DecisionKind::Created { parent, .. } => self.store.write(
                doing,
                "INSERT OR REPLACE INTO task VALUES (?1, ?2, ?3, ?4, ?5, NULL, NULL, NULL, ?6, ?7)",
                params![task, parent.map(|parent| parent.0 as i64), told.tag, told.subject, now, told.place, agent],
            ),
            DecisionKind::Selected { method, .. } => {
                let method = self.agents.get(self.turn).map(|agent| agent.describer.method(method));
                self.store.write(
                    doing,
                    "UPDATE task SET goal = ?2, method = ?3 WHERE id = ?1 AND agent = ?4",
                    params![task, told.subject, method, agent],
                )
            }
            DecisionKind::Transition { to: TaskState::Terminated, outcome, .. } => self.store.write(
                doing,
                "UPDATE task SET ended_ns = ?2, outcome = ?3 WHERE id = ?1 AND agent = ?4",
                params![task, now, outcome.as_ref().map(outcome_word), agent],
            ),
            // A repeating step lives again.
            DecisionKind::Transition { from: TaskState::Terminated, .. } => {
                let sql = "UPDATE task SET ended_ns = NULL, outcome = NULL WHERE id = ?1 AND agent = ?2";
                self.store.write(doing, sql, params![task, agent])
            }
            _ => Ok(()),
        }
    }

    fn store_step(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), RecordError> {
        if !std::mem::take(&mut self.begun) {
            self.store_batch(batch)?;
        }
        effects.iter().try_for_each(|effect| self.store_effect(effect))
    }

    /// Stores the agent and the mission's situation when a snapshot is due.
    fn store_snapshot(&mut self, agent: &Agent, deliberator: &dyn Deliberator, now: Time) -> Result<(), RecordError> {
        let Some(recorded) = self.agents.get_mut(self.turn) else { return Ok(()) };
        if recorded.snapshots.is_due() {
            let body = postcard::to_stdvec(agent).map_err(|error| self.store.unstorable("the agent", error))?;
            recorded.snapshots = Snapshots { last_bytes: body.len(), ..Snapshots::default() };
            recorded.snapshots.impossible = body.len() > SNAPSHOT_BYTES_MAX;
            if !recorded.snapshots.impossible {
                let sql = "INSERT OR REPLACE INTO snapshot VALUES (?1, ?2, ?3, ?4)";
                self.store.write("storing a snapshot", sql, params![self.batch, now.0, body, self.turn as i64])?;
                if let Some(body) = deliberator.snapshot() {
                    let sql = "INSERT OR REPLACE INTO situation VALUES (?1, ?2, ?3)";
                    self.store.write("storing a snapshot", sql, params![self.batch, now.0, body])?;
                }
            }
        }
        self.store.end_step()
    }

    fn store_problem(&mut self, request: &SolveRequest, at: Time, problem: &str) -> Result<(), RecordError> {
        let SolveRequest { request, goal, solver, .. } = request;
        self.store.write(
            "storing a planning problem",
            "INSERT OR REPLACE INTO problem VALUES (?1, ?2, ?3, ?4, ?5, ?6, NULL, NULL, NULL, NULL)",
            params![request.0 as i64, self.batch, at.0, goal.to_string(), solver.printed(), problem],
        )
    }

    fn store_answer(&mut self, request: SolveRequestId, due: Time, answer: &SolverAnswer) -> Result<(), RecordError> {
        let doing = "storing a solver's answer";
        let (detail, plan, report) = match &answer.result {
            Ok(procedure) => {
                let plan = procedure.plan.as_ref().map(serde_json::to_string).transpose();
                let plan = plan.map_err(|error| self.store.unstorable("a plan", error))?;
                (&procedure.summary, plan, SolverReport::Plan(procedure.clone()))
            }
            Err(reason) => (reason, None, SolverReport::Failed(reason.clone())),
        };
        let report = postcard::to_stdvec(&report).map_err(|error| self.store.unstorable("a solver's answer", error))?;
        let sql = "UPDATE problem SET due_ns = ?2, detail = ?3, plan = ?4, report = ?5 WHERE request = ?1";
        self.store.write(doing, sql, params![request.0 as i64, due.0, detail, plan, report])
    }

    fn store_note(&mut self, at: Time, text: &str) -> Result<(), RecordError> {
        let sql = "INSERT INTO note (batch, t_ns, text) VALUES (?1, ?2, ?3)";
        self.store.write("storing a note", sql, params![self.batch, at.0, text])
    }
}

impl Observer for Recorder {
    fn turn(&mut self, agent: usize) -> Result<(), String> {
        self.turn = agent;
        Ok(())
    }

    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        self.begun = true;
        self.store_batch(batch).map_err(|error| error.to_string())
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        self.store_step(batch, effects).map_err(|error| error.to_string())
    }

    fn inspect(&mut self, agent: &Agent, deliberator: &dyn Deliberator, now: Time) -> Result<(), String> {
        let stored = self.target_changes(deliberator.target_changes());
        stored.and_then(|()| self.store_snapshot(agent, deliberator, now)).map_err(|error| error.to_string())
    }

    fn posed(&mut self, request: &SolveRequest, at: Time, problem: &str) -> Result<(), String> {
        self.store_problem(request, at, problem).map_err(|error| error.to_string())
    }

    fn answered(&mut self, request: SolveRequestId, due: Time, answer: &SolverAnswer) -> Result<(), String> {
        self.store_answer(request, due, answer).map_err(|error| error.to_string())
    }

    fn note(&mut self, at: Time, text: &str) -> Result<(), String> {
        self.store_note(at, text).map_err(|error| error.to_string())
    }

    fn flush(&mut self) -> Result<(), String> {
        self.store.commit().map_err(|error| error.to_string())
    }
}
