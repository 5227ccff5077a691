//! One flight of a mission with any kind of vehicle: planning, recording, score, report.

use crate::Mission;
use crate::crew;
use crate::deliberation::{MissionDeliberator, PlanningResources};
use crate::error::{MissionError, MissionResult};
use crate::report::Report;
use apex_executive::Agent;
use apex_model::time::Time;
use apex_runtime::limits::SOLVER_GRACE;
use apex_runtime::ports::{Deliberator, Observer, Vehicle};
use apex_runtime::record::{Recorder, SITUATION_LAYOUT, TargetRow};
use apex_runtime::{RecordError, RunEnd, RunError, RunSettings};
use std::sync::Arc;

/// A mission that is ready to be flown.
pub struct MissionFlight {
    mission: Arc<Mission>,
    means: PlanningResources,
}

/// Outcome of a flight.
pub struct FlightOutcome {
    /// Reason and instant of its end.
    pub end: RunEnd,
    /// Report of the flight.
    pub report: Report,
    /// Wall time that planners took.
    pub planned_for: std::time::Duration,
}

impl MissionFlight {
    /// Returns a flight of `mission` that plans by `means`.
    pub fn new(mission: Arc<Mission>, means: PlanningResources) -> MissionFlight {
        MissionFlight { mission, means }
    }

    /// Returns the options of a run that ends at `until`, or after the mission's duration if that is earlier, with the scripted inputs of
    /// the mission.
    pub fn terms(mission: &Mission, until: Option<Time>) -> RunSettings {
        let limit = Time::ZERO + mission.settings.duration;
        let until = until.map_or(limit, |until| until.min(limit));
        RunSettings { until, inputs: mission.scenario.clone(), ..RunSettings::default() }
    }

    /// Flies with `vehicle`. A recorder must come first among the `observers`, so that every input is stored before it is used.
    ///
    /// # Errors
    /// A program that cannot be executed, a link or a record that breaks.
    pub fn fly(
        &self,
        vehicle: &mut dyn Vehicle,
        terms: RunSettings,
        observers: &mut [&mut dyn Observer],
    ) -> MissionResult<FlightOutcome> {
        self.run(terms, |agents, deliberator, terms| {
            apex_runtime::fly_all(agents, vehicle, deliberator, observers, terms)
        })
    }

    /// Like [`MissionFlight::fly`], where `drive` runs the agents: with a vehicle, or at the clock of an external simulator.
    ///
    /// # Errors
    /// Like [`MissionFlight::fly`].
    pub fn run(
        &self,
        terms: RunSettings,
        drive: impl FnOnce(&mut [Agent], &mut dyn Deliberator, RunSettings) -> Result<RunEnd, RunError>,
    ) -> MissionResult<FlightOutcome> {
        // The job's thread waits longer than the solver's timeout, so that the solver times out first.
        let terms = RunSettings { solver_timeout: self.means.timeout + 10 * SOLVER_GRACE, ..terms };
        let mut deliberator = MissionDeliberator::new(Arc::clone(&self.mission), self.means.clone());
        let mut agents = crew::crew_of_mission(&self.mission)?;
        let end =
            drive(&mut agents, &mut deliberator, terms).map_err(|error| MissionError::flight(error.to_string()))?;
        let report = deliberator.report((end.at, end.reason.text()));
        Ok(FlightOutcome { end, report, planned_for: deliberator.planned_for() })
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

/// Records the parts of a mission other than its program: data files, names, targets.
///
/// # Errors
/// The record cannot be written.
pub fn describe(mission: &Mission, recorder: &mut Recorder) -> Result<(), RecordError> {
    for (name, bytes) in mission.data.iter() {
        recorder.source(name, "data", bytes)?;
    }
    facts(mission).into_iter().try_for_each(|(key, value)| recorder.meta(key, &value))?;
    recorder.meta(SITUATION_LAYOUT, env!("APEX_SITUATION_LAYOUT"))?;
    target_rows(mission).iter().try_for_each(|target| recorder.target(target))
}

/// The facts of a record that follow from its mission, present or not.
pub(crate) const MISSION_FACTS: [&str; 4] = ["mission", "agent", "vehicle", "epoch_utc"];

/// Returns the facts of a record that follow from its mission, those of [`MISSION_FACTS`].
pub(crate) fn facts(mission: &Mission) -> Vec<(&'static str, String)> {
    let mut facts = vec![
        ("mission", mission.settings.name.clone()),
        ("agent", mission.agent.name.printed().to_string()),
        ("vehicle", mission.model.name.clone()),
    ];
    facts.extend(mission.settings.epoch_text.iter().map(|epoch| ("epoch_utc", epoch.clone())));
    facts
}

/// Returns the targets of a record that follow from its mission.
pub(crate) fn target_rows(mission: &Mission) -> Vec<TargetRow> {
    let mut rows = Vec::new();
    for target in mission.targets.iter().filter(|target| target.is_observable()) {
        rows.extend(target.plan_names().into_iter().map(|(id, name, value)| TargetRow {
            id,
            name,
            latitude_deg: target.position.latitude_deg,
            longitude_deg: target.position.longitude_deg,
            value,
            geometry: target.geometry.clone(),
        }));
    }
    rows
}
