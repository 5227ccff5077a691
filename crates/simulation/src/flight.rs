//! A recorded flight of a mission with the built-in simulator.

use crate::world::world;
use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::error::{MissionError, MissionResult};
use apex_mission::flight::{FlightOutcome, MissionFlight};
use apex_mission::recording;
use apex_runtime::RunSettings;
use apex_runtime::ports::Observer;
use apex_runtime::record::{RecordOptions, Recorder};
use std::path::Path;
use std::sync::Arc;

/// `vehicle_type` of records whose vehicle the built-in simulator moved.
pub(crate) const BUILT_IN: &str = "built-in simulator";

/// Starts the record of a flight of `mission` in the world of `seed`, or of the mission's own seed.
///
/// # Errors
/// Like [`recording::of_mission`].
pub fn create_record(path: &Path, mission: &Mission, seed: Option<u64>) -> MissionResult<Recorder> {
    create_record_with(path, mission, seed, RecordOptions::default())
}

/// Like [`create_record`], with these options.
///
/// # Errors
/// As [`recording::of_mission`].
pub fn create_record_with(
    path: &Path,
    mission: &Mission,
    seed: Option<u64>,
    options: RecordOptions,
) -> MissionResult<Recorder> {
    // Nothing outside depends on a simulated flight, so no step has to wait until its row is written.
    let options = RecordOptions { has_thread: true, ..options };
    let mut recorder = recording::of_mission(path, mission, options)?;
    let seed = seed.unwrap_or(mission.settings.seed).to_string();
    let described = recorder.meta("vehicle_type", BUILT_IN).and_then(|()| recorder.meta("seed", &seed));
    described.map_err(recording::written)?;
    Ok(recorder)
}

/// Returns the pace at which `mission` is flown: a mission in real time has pace 1 unless another one is requested. `None`: as fast as possible.
///
/// # Errors
/// The clock of the mission belongs to an external simulator.
pub fn pace_of(mission: &Mission, wished: Option<f64>) -> MissionResult<Option<f64>> {
    match kind_of(mission).as_deref() {
        Some("foreign-sim") => Err(MissionError::setting("an external simulator owns the clock")
            .at(&mission.settings.place)
            .because("the application is of type foreign-sim, and `apex fly` flies the built-in simulator")
            .help("connect the simulator to `apex run`, or write `:type native-sim`")),
        Some("realtime") => Ok(wished.or(Some(1.0))),
        _ => Ok(wished),
    }
}

fn kind_of(mission: &Mission) -> Option<String> {
    mission.library.application.as_ref().map(|application| application.kind.folded().to_string())
}

fn is_real_time(mission: &Mission) -> bool {
    kind_of(mission).as_deref() == Some("realtime")
}

/// Flies `mission` in the world of `seed` and closes the record. The observers see each step after the recorder.
///
/// # Errors
/// A mission that cannot be simulated, a flight that breaks, a record that cannot be written.
pub fn fly(
    mission: Arc<Mission>,
    means: PlanningResources,
    seed: Option<u64>,
    terms: RunSettings,
    recorder: &mut Recorder,
    observers: &mut [&mut dyn Observer],
) -> MissionResult<FlightOutcome> {
    let (outcome, lost) = fly_to_the_end(mission, means, seed, terms, recorder, observers)?;
    lost.map_or(Ok(outcome), Err)
}

/// Like [`fly`], but a flight whose record was interrupted still returns its outcome, together with the error of the record.
///
/// # Errors
/// A mission that cannot be simulated, a flight that breaks.
pub fn fly_to_the_end(
    mission: Arc<Mission>,
    means: PlanningResources,
    seed: Option<u64>,
    terms: RunSettings,
    recorder: &mut Recorder,
    observers: &mut [&mut dyn Observer],
) -> MissionResult<(FlightOutcome, Option<MissionError>)> {
    let mut vehicle = world(&mission, seed)?;
    // In simulated time the pace of watching has no influence: planners get the same time at every pace.
    let terms = RunSettings { hold_for_solvers: !is_real_time(&mission), ..terms };
    let outcome = {
        let mut all: Vec<&mut dyn Observer> = vec![&mut *recorder];
        all.extend(observers.iter_mut().map(|observer| &mut **observer as &mut dyn Observer));
        MissionFlight::new(mission, means).fly(&mut vehicle, terms, &mut all)?
    };
    let lost = outcome.store(recorder).map_err(recording::written).err();
    Ok((outcome, lost))
}
