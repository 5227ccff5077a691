//! A recorded flight of a mission with the built-in simulator.

use crate::world::world;
use apex_mission::Mission;
use apex_mission::deliberation::Means;
use apex_mission::error::MissionResult;
use apex_mission::flight::{FlightOutcome, MissionFlight};
use apex_mission::recording;
use apex_runtime::FlyOptions;
use apex_runtime::ports::Observer;
use apex_runtime::record::Recorder;
use std::path::Path;
use std::sync::Arc;

/// `vehicle_type` of records whose vehicle the built-in simulator moved.
pub(crate) const BUILT_IN: &str = "built-in simulator";

/// Starts the record of a flight of `mission` in the world of `seed`, or of the mission's own seed.
///
/// # Errors
/// As [`recording::of_mission`].
pub fn create_record(path: &Path, mission: &Mission, seed: Option<u64>) -> MissionResult<Recorder> {
    let mut recorder = recording::of_mission(path, mission)?;
    let seed = seed.unwrap_or(mission.settings.seed).to_string();
    let described = recorder.meta("vehicle_type", BUILT_IN).and_then(|()| recorder.meta("seed", &seed));
    described.map_err(recording::written)?;
    Ok(recorder)
}

/// Flies `mission` in the world of `seed` and closes the record. The observers see each step after the recorder.
///
/// # Errors
/// A mission that cannot be simulated, a flight that breaks, a record that cannot be written.
pub fn fly(
    mission: Arc<Mission>,
    means: Means,
    seed: Option<u64>,
    terms: FlyOptions,
    recorder: &mut Recorder,
    observers: &mut [&mut dyn Observer],
) -> MissionResult<FlightOutcome> {
    let mut vehicle = world(&mission, seed)?;
    let outcome = {
        let mut all: Vec<&mut dyn Observer> = vec![&mut *recorder];
        all.extend(observers.iter_mut().map(|observer| &mut **observer as &mut dyn Observer));
        MissionFlight::new(mission, means).fly(&mut vehicle, terms, &mut all)?
    };
    outcome.store(recorder).map_err(recording::written)?;
    Ok(outcome)
}
