//! One flight that the server runs: its thread, its progress and its end.

use crate::flights::catalogue::Failure;
use crate::operation::FlightDoor;
use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::error::MissionResult;
use apex_mission::recording;
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_runtime::RunSettings;
use apex_runtime::ports::Observer;
use apex_runtime::record::Recorder;
use apex_runtime::record::view::{Report, Section};
use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, OnceLock};

/// A flight that the server has started.
#[derive(Debug)]
pub(crate) struct Flight {
    /// Number, from 1.
    pub(crate) id: u64,
    /// Name of the mission.
    pub(crate) mission: String,
    /// File of the record.
    pub(crate) record: PathBuf,
    /// Seed of the world.
    pub(crate) seed: u64,
    /// Mission time of the last step.
    now_ns: AtomicI64,
    door: FlightDoor,
    end: OnceLock<End>,
}

#[derive(Debug)]
enum End {
    Ended { reason: String, report: Report },
    Failed(Failure),
}

/// Input of a flight in addition to the mission.
pub(crate) struct Preparation {
    pub(crate) mission: Arc<Mission>,
    pub(crate) means: PlanningResources,
    pub(crate) terms: RunSettings,
    pub(crate) recorder: Recorder,
}

/// A flight in the form of the API.
#[derive(Debug, Serialize)]
pub(crate) struct FlightState {
    id: u64,
    mission: String,
    record: String,
    seed: u64,
    state: &'static str,
    now_ns: i64,
    end_reason: Option<String>,
    sections: Vec<Section>,
    failure: Option<Failure>,
}

impl Flight {
    /// Returns a flight that has not begun. `door` leads to its run.
    pub(crate) fn new(id: u64, mission: String, record: PathBuf, seed: u64, door: FlightDoor) -> Flight {
        Flight { id, mission, record, seed, now_ns: AtomicI64::new(0), door, end: OnceLock::new() }
    }

    /// Flies, and returns when the flight has ended and its record is closed. `place` is dropped before the end becomes visible.
    pub(crate) fn fly(&self, preparation: Preparation, place: impl Drop) {
        let end = match catch_unwind(AssertUnwindSafe(|| self.flown(preparation))) {
            Ok(Ok(end)) => end,
            Ok(Err(error)) => End::Failed(error.into()),
            Err(_) => End::Failed(Failure {
                message: "the flight was interrupted".into(),
                reason: Some("its thread panicked; the server's standard error says where".into()),
                help: Some("this is a fault of Apex; please report it with the record".into()),
                place: None,
            }),
        };
        // The recorder is dropped: other programs may replace the record.
        recording::release(&self.record);
        drop(place);
        // Only this thread sets the end.
        self.end.set(end).ok();
    }

    fn flown(&self, preparation: Preparation) -> MissionResult<End> {
        let Preparation { mission, means, terms, mut recorder } = preparation;
        let (mut progress, mut watch) = (Progress(&self.now_ns), self.door.watch());
        let outcome = apex_simulation::fly(
            mission,
            means,
            Some(self.seed),
            terms,
            &mut recorder,
            &mut [&mut progress, &mut watch],
        )?;
        self.now_ns.store(outcome.end.at.0, Ordering::Relaxed);
        let section = |(name, body): (&str, serde_json::Value)| Section { section: name.to_string(), body };
        let report = Report { sections: outcome.report.sections().into_iter().map(section).collect() };
        Ok(End::Ended { reason: outcome.end.reason.text(), report })
    }

    /// Requests the flight to end in an orderly way.
    pub(crate) fn stop(&self) {
        // A flight that has ended does not listen, and needs no stop.
        self.door.stop();
    }

    /// Returns the door through which commands reach the run.
    pub(crate) fn door(&self) -> &FlightDoor {
        &self.door
    }

    /// Returns true until the flight has ended or failed.
    pub(crate) fn is_flying(&self) -> bool {
        self.end.get().is_none()
    }

    /// Returns the report, if the flight has ended with one.
    pub(crate) fn report(&self) -> Option<&Report> {
        match self.end.get() {
            Some(End::Ended { report, .. }) => Some(report),
            _ => None,
        }
    }

    /// Returns the flight's state now.
    pub(crate) fn state(&self) -> FlightState {
        let end = self.end.get();
        let (state, end_reason, sections, failure) = match end {
            None => ("flying", None, Vec::new(), None),
            Some(End::Ended { reason, report }) => ("ended", Some(reason.clone()), report.sections.clone(), None),
            Some(End::Failed(failure)) => ("failed", None, Vec::new(), Some(failure.clone())),
        };
        FlightState {
            id: self.id,
            mission: self.mission.clone(),
            record: self.record.display().to_string(),
            seed: self.seed,
            state,
            now_ns: self.now_ns.load(Ordering::Relaxed),
            end_reason,
            sections,
            failure,
        }
    }
}

impl FlightState {
    /// Returns the flight's number.
    pub(crate) fn id(&self) -> u64 {
        self.id
    }
}

/// Keeps the mission time of the last step.
struct Progress<'a>(&'a AtomicI64);

impl Observer for Progress<'_> {
    fn observe(&mut self, batch: &Batch, _: &[Effect]) -> Result<(), String> {
        self.0.store(batch.now.0, Ordering::Relaxed);
        Ok(())
    }
}
