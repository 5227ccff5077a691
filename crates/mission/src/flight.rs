//! One flight of a mission, with whatever moves the vehicle: plan, book, score, report.

use crate::Mission;
use crate::bookkeeping::{Bookkeeping, BookkeepingObserver, SharedBookkeeping, lock};
use crate::deliberator::{Means, MissionDeliberator};
use crate::error::{ErrorKind, MissionError, MissionResult};
use crate::program;
use crate::report::{Report, report};
use apex_executive::Agent;
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::time::Time;
use apex_runtime::contained::Contained;
use apex_runtime::limits::SOLVER_GRACE;
use apex_runtime::ports::{Deliberator, Observer, Vehicle};
use apex_runtime::record::{Recorder, TargetRow, TargetState};
use apex_runtime::{FlyOptions, RecordError, RunEnd, RunError};
use std::sync::{Arc, Mutex, PoisonError};

/// The recorder of a flight, which the mission shares with the run.
pub type SharedRecorder = Arc<Mutex<Recorder>>;

/// A change of a target's state: target, time, state, detail.
type TargetChange = (String, Time, TargetState, String);

/// A mission that is ready to be flown.
pub struct MissionFlight {
    mission: Arc<Mission>,
    means: Means,
}

/// What a flight came to.
pub struct FlightOutcome {
    /// How and when it ended.
    pub end: RunEnd,
    /// What it achieved.
    pub report: Report,
}

impl MissionFlight {
    /// A flight of `mission` that plans by `means`.
    pub fn new(mission: Arc<Mission>, means: Means) -> MissionFlight {
        MissionFlight { mission, means }
    }

    /// The terms of a run that ends at `until`, or after the mission's duration if that is earlier, with the scripted inputs
    /// of the mission.
    pub fn terms(mission: &Mission, until: Option<Time>) -> FlyOptions {
        let limit = Time::ZERO + mission.settings.duration;
        let until = until.map_or(limit, |until| until.min(limit));
        FlyOptions { until, inputs: mission.scenario.clone(), ..FlyOptions::default() }
    }

    /// Flies with `vehicle`. The recorder sees each step first; `observers` see it after the mission's own bookkeeping.
    ///
    /// # Errors
    /// A program that cannot be executed, a link or a record that breaks, a machine that gives no thread.
    pub fn fly(
        &self,
        vehicle: &mut dyn Vehicle,
        terms: FlyOptions,
        observers: &mut [&mut dyn Observer],
        recorder: Option<&SharedRecorder>,
    ) -> MissionResult<FlightOutcome> {
        self.run(observers, recorder, |agents, deliberator, observers| {
            apex_runtime::fly_all(agents, vehicle, deliberator, observers, terms)
        })
    }

    /// As [`MissionFlight::fly`], where `drive` runs the agents: with a vehicle, or at the clock of an outside simulator.
    ///
    /// # Errors
    /// As [`MissionFlight::fly`].
    pub fn run(
        &self,
        observers: &mut [&mut dyn Observer],
        recorder: Option<&SharedRecorder>,
        drive: impl FnOnce(
            &mut [Agent],
            &mut (dyn Deliberator + Send),
            &mut [&mut dyn Observer],
        ) -> Result<RunEnd, RunError>,
    ) -> MissionResult<FlightOutcome> {
        let books: SharedBookkeeping = Arc::new(Mutex::new(Bookkeeping::default()));
        // A solver times out before the thread that calls it.
        let patience = self.means.patience + 10 * SOLVER_GRACE;
        let deliberator = MissionDeliberator::new(Arc::clone(&self.mission), Arc::clone(&books), self.means.clone());
        let mut deliberator = Contained::new(Box::new(deliberator), patience)
            .map_err(|reason| MissionError::flight("no thread for the solvers").because(reason))?;
        let mut agents = program::crew_of(&self.mission.library)?;
        let mut bookkeeper = BookkeepingObserver::new(Arc::clone(&books));
        let mut targets =
            TargetObserver { recorder: recorder.cloned(), books: Arc::clone(&books), changes: Vec::new() };
        let mut shared_recorder = recorder.cloned();
        let mut all: Vec<&mut dyn Observer> = Vec::new();
        if let Some(recorder) = &mut shared_recorder {
            all.push(recorder);
        }
        all.push(&mut bookkeeper);
        all.push(&mut targets);
        all.extend(observers.iter_mut().map(|observer| &mut **observer as &mut dyn Observer));
        let end =
            drive(&mut agents, &mut deliberator, &mut all).map_err(|error| MissionError::flight(error.to_string()))?;
        let report = report(&self.mission, &lock(&books), &targets.changes, (end.at, end.reason.text()));
        Ok(FlightOutcome { end, report })
    }
}

impl FlightOutcome {
    /// Stores the report and the end in the flight's record.
    ///
    /// # Errors
    /// The record cannot be written.
    pub fn store(&self, recorder: &mut Recorder) -> Result<(), RecordError> {
        for (section, body) in self.report.sections() {
            recorder.report(section, &body.to_string())?;
        }
        recorder.finish(self.end.at, &self.end.reason.text())
    }
}

/// Writes what a record must hold of a mission other than its program: data files, names, targets.
///
/// # Errors
/// The record cannot be written.
pub fn describe(mission: &Mission, recorder: &mut Recorder) -> Result<(), RecordError> {
    for (name, bytes) in mission.data.iter() {
        recorder.source(name, "data", bytes)?;
    }
    recorder.meta("mission", &mission.settings.name)?;
    recorder.meta("agent", mission.agent.name.printed())?;
    recorder.meta("vehicle", &mission.model.name)?;
    if let Some(epoch) = &mission.settings.epoch_text {
        recorder.meta("epoch_utc", epoch)?;
    }
    mission.targets.iter().filter(|target| target.is_observable()).try_for_each(|target| {
        recorder.target(&TargetRow {
            id: target.id.clone(),
            name: target.name.clone(),
            latitude_deg: target.position.latitude_deg,
            longitude_deg: target.position.longitude_deg,
            value: target.worth(),
            geometry: target.geometry.clone(),
        })
    })
}

impl From<RecordError> for MissionError {
    fn from(error: RecordError) -> MissionError {
        MissionError::new(ErrorKind::Record, error.to_string())
    }
}

/// Moves changes of targets' states from the books into the record.
struct TargetObserver {
    recorder: Option<SharedRecorder>,
    books: SharedBookkeeping,
    changes: Vec<TargetChange>,
}

impl Observer for TargetObserver {
    fn observe(&mut self, _: &Batch, _: &[Effect]) -> Result<(), String> {
        let new = std::mem::take(&mut lock(&self.books).target_changes);
        if new.is_empty() {
            return Ok(());
        }
        if let Some(recorder) = &self.recorder {
            let mut recorder = recorder.lock().unwrap_or_else(PoisonError::into_inner);
            for (target, at, state, detail) in &new {
                recorder.target_state(target, *at, *state, detail).map_err(|error| error.to_string())?;
            }
        }
        self.changes.extend(new);
        Ok(())
    }
}
