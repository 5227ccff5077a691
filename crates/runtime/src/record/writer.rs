//! The recorder: an observer that stores every step. Inputs are written before they are used, effects before they are
//! sent; steps are committed in groups, so a crash loses at most the last group and never the order.

use super::codec::{self, Variables};
use super::difference::RowDifference;
use super::disk_news::{DiskNews, Resumption};
use super::effects::EffectEncoder;
use super::layout::STATE_LAYOUT;
use super::segments::{SEGMENT_SNAPSHOT, SPARE_FOLDER, SegmentPlaces};
use super::signature::SigningKey;
use super::store::{Durability, RowStore, SqlValue, Store, real, text};
use super::store_thread::StoreThread;
use super::tables::Table;
use super::track::{TrackRow, TrackWatcher};
use crate::error::RecordError;
use crate::limits::{RECORDING_KEPT_BYTES_MAX, SNAPSHOT_BATCHES_MAX, SNAPSHOT_BATCHES_MIN, SNAPSHOT_BYTES_MAX};
use crate::ports::{Deliberator, News, Observer, SolverAnswer};
use apex_executive::state::agent::Agent;
use apex_model::effect::{Effect, SolveRequest, SolveRequestId};
use apex_model::event::{Batch, SolverReport};
use apex_model::library::Library;
use apex_model::time::Time;
use apex_model::value::Value;
use std::path::{Path, PathBuf};

/// The fact that names the vehicle whose measurements make the track.
pub(super) const TRACK_OF: &str = "track_of";

/// The beginning of the note of a record that was lost.
pub const RECORDING_LOST: &str = "the flight is not being recorded";
/// The beginning of the note of a record that continues.
pub const RECORDING_RESUMED: &str = "the flight is recorded again";

/// The fact that names the key which signs the record.
pub const SIGNED_BY: &str = "signed_by";

/// Options of a record, beyond inputs and effects.
#[derive(Clone, Debug, Default)]
pub struct RecordOptions {
    /// The vehicle whose measurements make the track, for example `aircraft-1`; `None` for no track.
    pub vehicle: Option<String>,
    /// Largest size of each file in the record's folder, in bytes; `None` is without limit.
    pub bytes_max: Option<u64>,
    /// Folder on another disk in which the record continues when its own disk accepts no more writes.
    pub spare_folder: Option<PathBuf>,
    /// Durability of a committed group.
    pub durability: Durability,
    /// Maximum number of bytes of the newest steps kept in memory while the disk accepts none; `None` is [`RECORDING_KEPT_BYTES_MAX`].
    pub kept_bytes_max: Option<usize>,
    /// A separate thread writes the rows: for flights in simulation, as nothing outside depends on a row.
    pub has_thread: bool,
}

/// Writes a flight record during the flight. Put it first among the observers of a run.
pub struct Recorder {
    pub(super) store: Box<dyn RowStore>,
    agents: Vec<RecordedAgent>,
    /// Agent whose steps are stored.
    turn: usize,
    variables: Variables,
    encoder: EffectEncoder,
    track: Option<TrackWatcher>,
    bytes: Vec<u8>,
    /// Number of the last batch: if `begun`, of the one that is being executed.
    batch: i64,
    effect: i64,
    begun: bool,
    /// Number of changes of targets' states that are stored.
    pub(super) stored_changes: usize,
    /// True once the flight has begun: from then on a failed write does not end it.
    flies: bool,
}

/// Stored state of each agent while its steps are stored.
#[derive(Default)]
struct RecordedAgent {
    snapshots: Snapshots,
    /// True if a segment has begun, from which states are to be restored without its earlier files.
    begins_segment: bool,
}

/// Schedule of snapshots, by their size.
#[derive(Default)]
struct Snapshots {
    batches_since: u64,
    input_bytes_since: usize,
    last_bytes: usize,
    impossible: bool,
    /// True if a snapshot is taken after this step, regardless of its cost.
    is_wanted: bool,
}

impl Snapshots {
    fn is_due(&self) -> bool {
        let paid_for = self.input_bytes_since >= self.last_bytes && self.batches_since >= SNAPSHOT_BATCHES_MIN;
        self.is_wanted || !self.impossible && (paid_for || self.batches_since >= SNAPSHOT_BATCHES_MAX)
    }
}

impl Recorder {
    /// Creates a record at `path` for a run of `library`. An older flight record there is replaced; any other file is left alone. The
    /// record counts as incomplete until [`Recorder::finish`].
    ///
    /// # Errors
    /// [`RecordError`] with the failed action, the place, the reason and the remedy.
    pub fn create(path: &Path, library: &Library, options: RecordOptions) -> Result<Recorder, RecordError> {
        let kept_bytes_max = options.kept_bytes_max.unwrap_or(RECORDING_KEPT_BYTES_MAX);
        let spare_folder = options.spare_folder.map(|folder| std::path::absolute(&folder).unwrap_or(folder));
        let spare = spare_folder.as_ref().map(|folder| folder.display().to_string());
        let places = SegmentPlaces { spare_folder, bytes_max: options.bytes_max };
        let mut store: Box<dyn RowStore> = Box::new(Store::create(path, places, options.durability, kept_bytes_max)?);
        if options.has_thread {
            store = Box::new(StoreThread::new(store));
        }
        let mut recorder = Recorder::with_store(store, library, options.vehicle.as_deref())?;
        recorder.meta("apex_version", env!("CARGO_PKG_VERSION"))?;
        recorder.meta(STATE_LAYOUT, env!("APEX_STATE_LAYOUT"))?;
        recorder.meta("complete", "0")?;
        if let Some(vehicle) = &options.vehicle {
            recorder.meta("vehicle", vehicle)?;
            recorder.meta(TRACK_OF, vehicle)?;
        }
        if let Some(folder) = &spare {
            recorder.meta(SPARE_FOLDER, folder)?;
        }
        recorder.store.commit()?;
        Ok(recorder)
    }

    /// Returns a recorder that writes its rows into `store`; the agents of `library` are registered in it.
    pub(super) fn with_store(
        store: Box<dyn RowStore>,
        library: &Library,
        vehicle: Option<&str>,
    ) -> Result<Recorder, RecordError> {
        let mut recorder = Recorder {
            store,
            agents: Vec::new(),
            turn: 0,
            variables: Variables::default(),
            encoder: EffectEncoder::default(),
            track: vehicle.map(TrackWatcher::new),
            bytes: Vec::new(),
            batch: 0,
            effect: 0,
            begun: false,
            stored_changes: 0,
            flies: false,
        };
        for (agent, number) in library.crew().iter().zip(0_i64..) {
            recorder.agents.push(RecordedAgent::default());
            let row = [SqlValue::Integer(number), text(Some(agent.name.printed()))];
            recorder.store.insert("storing the agents", Table::Agent, &row)?;
        }
        Ok(recorder)
    }

    /// Writes everything that waits to the file.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn commit(&mut self) -> Result<(), RecordError> {
        self.store.commit()
    }

    /// Stores the PDL sources of `library` in load order, as [`Recorder::source`] with role `pdl`.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn program(&mut self, library: &Library) -> Result<(), RecordError> {
        library.sources.iter().try_for_each(|source| self.source(&source.name, "pdl", source.text.as_bytes()))
    }

    /// Returns the first row in which the replay differs from the stored record; for recorders of a replay.
    pub(crate) fn difference(&self) -> Option<&RowDifference> {
        self.store.difference()
    }

    /// Changes the largest size of the record ([`RecordOptions::bytes_max`]), after space was made for example.
    ///
    /// # Errors
    /// [`RecordError`] if the file refuses.
    pub fn set_bytes_max(&mut self, bytes: u64) -> Result<(), RecordError> {
        self.store.set_bytes_max(bytes)
    }

    /// Signs the record with `key` when it is closed; from now on the record names the key.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn sign_with(&mut self, key: SigningKey) -> Result<(), RecordError> {
        self.meta(SIGNED_BY, &key.public())?;
        self.store.sign_with(key);
        Ok(())
    }

    /// Returns the record's file.
    pub fn path(&self) -> &Path {
        self.store.path()
    }

    /// Closes the record: it is complete from now on. `reason` is [`crate::EndReason::text`].
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be written.
    pub fn finish(&mut self, end: Time, reason: &str) -> Result<(), RecordError> {
        self.meta("end_ns", &end.0.to_string())?;
        self.meta("end_reason", reason)?;
        self.meta("complete", "1")?;
        self.store.close()
    }

    fn store_batch(&mut self, batch: &Batch) -> Result<(), RecordError> {
        self.store.set_now(batch.now);
        if !std::mem::replace(&mut self.flies, true) {
            // The rows that every reader needs must be on the disk before the flight begins.
            self.store.commit()?;
            self.store.outlive_the_disk();
        }
        self.batch += 1;
        let known = self.variables.len();
        let mut bytes = std::mem::take(&mut self.bytes);
        codec::encode(batch, &mut self.variables, &mut bytes)
            .map_err(|error| self.store.unstorable("an input", error.to_string()))?;
        for number in known..self.variables.len() {
            self.store_variable(number as u64 + 1)?;
        }
        let row = [
            SqlValue::Integer(self.batch),
            SqlValue::Integer(batch.now.0),
            SqlValue::Blob(&bytes),
            SqlValue::Integer(self.turn as i64),
        ];
        self.store.insert("storing the inputs", Table::Batch, &row)?;
        if let Some(agent) = self.agents.get_mut(self.turn) {
            agent.snapshots.batches_since += 1;
            agent.snapshots.input_bytes_since += bytes.len();
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
        let encoded = postcard::to_stdvec(variable);
        let body = encoded.map_err(|error| self.store.unstorable(&name, error.to_string()))?;
        let row = [SqlValue::Integer(number as i64), text(Some(&name)), SqlValue::Blob(&body)];
        self.store.insert("storing a state variable", Table::Variable, &row)
    }

    fn store_track(&mut self, row: &TrackRow) -> Result<(), RecordError> {
        let TrackRow { at, latitude_deg, longitude_deg, altitude_m, heading_deg, roll_deg, ground_speed_mps, fuel_kg } =
            *row;
        let row = [
            SqlValue::Integer(at.0),
            SqlValue::Real(latitude_deg),
            SqlValue::Real(longitude_deg),
            real(altitude_m),
            real(heading_deg),
            real(roll_deg),
            real(ground_speed_mps),
            real(fuel_kg),
        ];
        self.store.insert("storing the track", Table::Track, &row)
    }

    /// Stores the effects of a step as one row, after the new words and shapes in it.
    fn store_effects(&mut self, now: Time, effects: &[Effect]) -> Result<(), RecordError> {
        if effects.is_empty() {
            return Ok(());
        }
        let mut bytes = std::mem::take(&mut self.bytes);
        let encoded = self.encoder.encode(now, effects, &mut bytes);
        encoded.map_err(|error| self.store.unstorable("an effect", error.to_string()))?;
        let store = &mut self.store;
        self.encoder.new_rows(|table, row| store.insert("storing words and shapes of effects", table, row))?;
        let row = [SqlValue::Integer(self.batch), SqlValue::Integer(self.effect + 1), SqlValue::Blob(&bytes)];
        self.store.insert("storing the effects", Table::Effects, &row)?;
        self.effect += effects.len() as i64;
        self.bytes = bytes;
        Ok(())
    }

    fn store_step(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), RecordError> {
        if !std::mem::take(&mut self.begun) {
            self.store_batch(batch)?;
        }
        self.store_effects(batch.now, effects)
    }

    /// Stores the agent and the mission's situation when a snapshot is due.
    fn store_snapshot(&mut self, agent: &Agent, deliberator: &dyn Deliberator, now: Time) -> Result<(), RecordError> {
        let Some(recorded) = self.agents.get_mut(self.turn) else { return Ok(()) };
        let begins_segment = std::mem::take(&mut recorded.begins_segment);
        if recorded.snapshots.is_due() {
            let encoded = postcard::to_stdvec(agent);
            let body = encoded.map_err(|error| self.store.unstorable("the agent", error.to_string()))?;
            recorded.snapshots = Snapshots { last_bytes: body.len(), ..Snapshots::default() };
            let is_wanted = std::mem::take(&mut recorded.snapshots.is_wanted);
            recorded.snapshots.impossible = body.len() > SNAPSHOT_BYTES_MAX;
            if is_wanted || !recorded.snapshots.impossible {
                self.store_state(&body, deliberator, now)?;
            }
        } else if begins_segment {
            // The snapshot schedule is that of the whole record, so that a replay of the joined segments takes the same snapshots.
            let encoded = postcard::to_stdvec(agent);
            let body = encoded.map_err(|error| self.store.unstorable("the agent", error.to_string()))?;
            self.store_state(&body, deliberator, now)?;
            self.meta(SEGMENT_SNAPSHOT, &self.batch.to_string())?;
        }
        self.store.end_step()
    }

    /// Stores an agent, as `body`, and the mission's situation after the last step.
    fn store_state(&mut self, body: &[u8], deliberator: &dyn Deliberator, now: Time) -> Result<(), RecordError> {
        let (batch, now) = (SqlValue::Integer(self.batch), SqlValue::Integer(now.0));
        let row = [batch, now, SqlValue::Blob(body), SqlValue::Integer(self.turn as i64)];
        self.store.insert("storing a snapshot", Table::Snapshot, &row)?;
        match deliberator.snapshot() {
            Some(body) => {
                self.store.insert("storing a snapshot", Table::Situation, &[batch, now, SqlValue::Blob(&body)])
            }
            None => Ok(()),
        }
    }

    fn store_problem(&mut self, request: &SolveRequest, at: Time, problem: &str) -> Result<(), RecordError> {
        let SolveRequest { request, goal, solver, .. } = request;
        let goal = goal.to_string();
        let row = [
            SqlValue::Integer(request.0 as i64),
            SqlValue::Integer(self.batch),
            SqlValue::Integer(at.0),
            text(Some(&goal)),
            text(Some(solver.printed())),
            text(Some(problem)),
        ];
        self.store.insert("storing a planning problem", Table::Problem, &row)
    }

    fn store_answer(&mut self, request: SolveRequestId, due: Time, answer: &SolverAnswer) -> Result<(), RecordError> {
        let (detail, plan, report) = match &answer.result {
            Ok(procedure) => {
                let plan = procedure.plan.as_ref().map(serde_json::to_string).transpose();
                let plan = plan.map_err(|error| self.store.unstorable("a plan", error.to_string()))?;
                (&procedure.summary, plan, SolverReport::Plan(procedure.clone()))
            }
            Err(reason) => (reason, None, SolverReport::Failed(reason.clone())),
        };
        let encoded = postcard::to_stdvec(&report);
        let report = encoded.map_err(|error| self.store.unstorable("a solver's answer", error.to_string()))?;
        let (request, due) = (SqlValue::Integer(request.0 as i64), SqlValue::Integer(due.0));
        let row = [request, due, text(Some(detail)), text(plan.as_deref()), SqlValue::Blob(&report)];
        self.store.insert("storing a solver's answer", Table::Answer, &row)
    }

    fn store_note(&mut self, at: Time, note: &str) -> Result<(), RecordError> {
        let row = [SqlValue::Integer(self.batch), SqlValue::Integer(at.0), text(Some(note))];
        self.store.insert("storing a note", Table::Note, &row)
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

    fn take_news(&mut self) -> Option<News> {
        let news = self.store.take_news()?;
        if let DiskNews::Resumed(Resumption { gap, segment, .. }) = &news {
            // A snapshot is needed to restore the steps after a gap, and those of a segment.
            for agent in &mut self.agents {
                agent.snapshots.is_wanted |= gap.is_some();
                agent.begins_segment |= segment.is_some();
            }
        }
        Some(news_of(&news))
    }
}

/// Returns the message and the note about the disk for agents, operators and the record.
fn news_of(news: &DiskNews) -> News {
    let word = |word: &str| Value::symbol(word);
    let count = |number: u64| Value::Integer(i64::try_from(number).unwrap_or(i64::MAX));
    match news {
        DiskNews::Lost(reason) => News {
            message: Value::list([word("recording-lost"), Value::text(reason)]),
            note: format!("{RECORDING_LOST}: {reason}; it continues, and its newest steps are kept in memory"),
        },
        DiskNews::Resumed(Resumption { kept, gap, segment }) => {
            let place = segment.as_ref().map(|path| format!(" in the new segment {}", path.display()));
            let place = place.unwrap_or_default();
            let dropped = gap.map_or(0, |(first, last)| u64::try_from(last - first + 1).unwrap_or(0));
            let note = match gap {
                None => {
                    format!(
                        "{RECORDING_RESUMED}{place}, without a gap: {kept} steps that were kept in memory are stored"
                    )
                }
                Some((first, last)) => format!(
                    "{RECORDING_RESUMED}{place}: {kept} steps that were kept in memory are stored; steps {first} to {last} are \
                     not in the record"
                ),
            };
            News { message: Value::list([word("recording-resumed"), count(*kept), count(dropped)]), note }
        }
    }
}
