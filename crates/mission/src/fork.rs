//! Fork: continues a recorded flight from an instant on with other inputs, another plan, or another vehicle's world.

use crate::crew;
use crate::deliberation::{MissionDeliberator, PlanningResources};
use crate::error::{MissionError, MissionResult};
use crate::flight::{FlightOutcome, MissionFlight};
use crate::recording::read;
use crate::{Mission, TargetKind};
use apex_model::event::EventKind;
use apex_model::problem::WindField;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_runtime::RunSettings;
use apex_runtime::limits::SOLVER_GRACE;
use apex_runtime::ports::{Input, Observer, Vehicle};
use apex_runtime::record::RecordReader;
use std::sync::Arc;

/// Changes to the recorded flight after the instant, except the vehicle's world.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// Inputs after the instant.
    pub inputs: Vec<Input>,
    /// Targets to visit in this order instead of planning; empty for normal planning.
    pub plan: Vec<String>,
}

impl Changes {
    /// Checks that the changes can be made after `at`.
    ///
    /// # Errors
    /// An input that is not after the instant, or an unknown target.
    pub fn check(&self, mission: &Mission, at: Time) -> MissionResult {
        if let Some(early) = self.inputs.iter().find(|input| input.at <= at) {
            return Err(MissionError::data(format!(
                "an input at {} is not after {at}, where the fork begins",
                early.at
            ))
            .help("give inputs that come later, or fork earlier"));
        }
        let targets = || mission.targets.iter().filter(|target| !matches!(target.kind, TargetKind::Base));
        let known = |id: &&String| targets().any(|target| target.goes_by(id));
        match self.plan.iter().find(|id| !known(id)) {
            Some(unknown) => {
                let ids: Vec<&str> = targets().map(|target| target.id.as_str()).collect();
                Err(MissionError::data(format!("the plan names `{unknown}`, which is not a target of this mission"))
                    .help(format!("name targets among {}", ids.join(", "))))
            }
            None => Ok(()),
        }
    }
}

/// A recorded flight that is to be continued from `at` on.
pub struct Fork<'a> {
    /// The record.
    pub reader: &'a RecordReader,
    /// Its mission.
    pub mission: Arc<Mission>,
    /// Planners after `at`.
    pub means: PlanningResources,
    /// The instant.
    pub at: Time,
}

impl Fork<'_> {
    /// Repeats the record up to the instant, changes the vehicle by `change`, and continues the flight with the mission's scenario and
    /// the changes. The observers receive the flight from its beginning.
    ///
    /// # Errors
    /// An input that is not after the instant, an unknown target, a record that this version or this vehicle cannot repeat, and all
    /// errors of a flight.
    pub fn fly<V: Vehicle>(
        self,
        vehicle: &mut V,
        change: impl FnOnce(&mut V),
        changes: Changes,
        terms: RunSettings,
        observers: &mut [&mut dyn Observer],
    ) -> MissionResult<FlightOutcome> {
        let Fork { reader, mission, means, at } = self;
        changes.check(&mission, at)?;
        let mut inputs = MissionFlight::terms(&mission, None).inputs;
        inputs.extend(imposed(&changes.plan, at));
        inputs.extend(changes.inputs);
        let terms = RunSettings { inputs, solver_timeout: means.timeout + 10 * SOLVER_GRACE, ..terms };
        let mut deliberator = MissionDeliberator::new(Arc::clone(&mission), means);
        let program = reader.load(&|sources| crew::load_recorded_mission(&mission, sources)).map_err(read)?;
        let flown =
            apex_runtime::fork::fork((reader, &program), at, vehicle, change, &mut deliberator, observers, terms);
        let end =
            flown.map_err(|error| MissionError::flight("the recorded flight cannot be continued").because(error))?;
        let report = deliberator.report((end.at, end.reason.text()));
        Ok(FlightOutcome { end, report, planned_for: deliberator.planned_for() })
    }
}

/// Returns the inputs that impose a plan and make the mission plan again.
fn imposed(plan: &[String], at: Time) -> Vec<Input> {
    if plan.is_empty() {
        return Vec::new();
    }
    let soon = at + Duration(1_000_000);
    let visits = Value::list(plan.iter().map(|id| Value::symbol(id)));
    let event = |words: Vec<Value>| Input::new(soon, EventKind::Occurrence(Value::list(words)));
    vec![
        event(vec![Value::symbol("plan-imposed"), visits]),
        event(vec![Value::symbol("off-schedule"), Value::symbol("imposed-plan")]),
    ]
}

/// Returns the wind with `factor` times its speed; the turbulence is unchanged.
pub fn scaled_wind(wind: &WindField, factor: f64) -> WindField {
    let mut wind = wind.clone();
    for layer in &mut wind.layers {
        layer.wind_east_mps *= factor;
        layer.wind_north_mps *= factor;
    }
    wind
}
