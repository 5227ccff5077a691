//! Continuing a recorded flight in the built-in simulator, with changes.

use crate::flight::{BUILT_IN, create_record};
use crate::world::world;
use apex_mission::deliberation::PlanningResources;
use apex_mission::error::{MissionError, MissionResult};
use apex_mission::flight::{FlightOutcome, MissionFlight};
use apex_mission::fork::{Changes, Fork};
use apex_mission::report::Report;
use apex_mission::{Mission, recorded, recording};
use apex_model::problem::WindField;
use apex_model::time::Time;
use apex_runtime::ports::Observer;
use apex_runtime::record::RecordReader;
use apex_runtime::{Control, RunSettings};
use apex_sim::SimulatedWorld;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::Receiver;

/// `forked_with` of a fork that changes nothing.
const NOTHING: &str = "nothing is changed";

/// Changes to the simulated world.
#[derive(Clone, Debug, Default)]
pub struct WorldChanges {
    /// The wind after the instant; `None` leaves it unchanged.
    pub wind: Option<WindField>,
    /// Seed of turbulence and radio links after the instant; `None` leaves it unchanged.
    pub seed: Option<u64>,
}

/// Settings of the continued flight. By default it flies to the end of the mission, without commands or additional observers.
#[derive(Default)]
pub struct ForkTerms<'o> {
    /// Latest end of the continued flight.
    pub until: Option<Time>,
    /// Commands from the caller, such as to stop.
    pub controls: Option<Receiver<Control>>,
    /// Receives all steps in addition to the recorder, including those before the instant.
    pub observer: Option<&'o mut dyn Observer>,
}

/// The original flight and the fork.
pub struct Forked {
    /// The report of the recorded flight, computed from its record.
    pub recorded: Report,
    /// The continued flight.
    pub forked: FlightOutcome,
}

/// Continues the flight in `reader` from `at` on, and records the whole flight at `output`. `text` is the description of the changes for
/// the new record; `None` if there are no changes.
///
/// # Errors
/// A record without a mission flown in the built-in simulator; a record that is itself a fork with changes, or that ends before `at`; an
/// output that is the record itself; all errors of a flight.
pub fn fork(
    reader: &RecordReader,
    at: Time,
    (changes, world_changes, text): (Changes, WorldChanges, Option<String>),
    means: PlanningResources,
    terms: ForkTerms<'_>,
    output: &Path,
) -> MissionResult<Forked> {
    // An older record at `output` is replaced only by a fork that can be flown.
    let mission = Arc::new(check_fork(reader, at, &changes)?);
    if let Some(until) = terms.until.filter(|until| *until < at) {
        return Err(MissionError::data(format!("the end at {until} is before {at}, where the fork begins"))
            .help("give a later end, or fork earlier"));
    }
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    if real(output).is_some() && real(output) == real(reader.path()) {
        let message = "the forked flight would overwrite the record that it continues";
        return Err(MissionError::data(message).help("give `--output` another file"));
    }
    let seed = fact(reader, "seed")?.and_then(|seed| seed.parse().ok());
    let mut vehicle = world(&mission, seed)?;
    let mut recorder = create_record(output, &mission, seed)?;
    let text = text.unwrap_or_else(|| NOTHING.to_string());
    recorder
        .meta("forked_from", &reader.path().display().to_string())
        .and_then(|()| recorder.meta("forked_at_ns", &at.0.to_string()))
        .and_then(|()| recorder.meta("forked_with", &text))
        .map_err(recording::written)?;
    let change = |vehicle: &mut SimulatedWorld| {
        if let Some(wind) = world_changes.wind {
            vehicle.change_wind(wind);
        }
        if let Some(seed) = world_changes.seed {
            vehicle.reseed(seed);
        }
    };
    let ForkTerms { until, controls, observer } = terms;
    let terms = RunSettings { controls, ..MissionFlight::terms(&mission, until) };
    let fork = Fork { reader, mission: Arc::clone(&mission), means, at };
    let mut observers: Vec<&mut dyn Observer> = vec![&mut recorder];
    if let Some(observer) = observer {
        observers.push(observer);
    }
    let forked = fork.fly(&mut vehicle, change, changes, terms, &mut observers)?;
    forked.store(&mut recorder).map_err(recording::written)?;
    Ok(Forked { recorded: recorded::report_of(reader, &mission)?, forked })
}

/// Returns the mission of a record that can be forked at `at` with these changes. No file is changed.
///
/// # Errors
/// As [`fork`], except those of the output and of the flight.
pub fn check_fork(reader: &RecordReader, at: Time, changes: &Changes) -> MissionResult<Mission> {
    let mission = forkable(reader, at)?;
    changes.check(&mission, at)?;
    Ok(mission)
}

/// Returns the mission of a record that can be forked at `at`.
fn forkable(reader: &RecordReader, at: Time) -> MissionResult<Mission> {
    let path = reader.path().display();
    let cannot =
        |why: String, help: &str| Err(MissionError::data(format!("{path} cannot be forked")).because(why).help(help));
    let fly = "fork a record that `apex fly` has written";
    if let Some(changes) = fact(reader, "forked_with")?.filter(|changes| changes != NOTHING) {
        let why = format!("it is itself a fork ({changes}), and its simulated world differs before the change");
        return cannot(why, "fork the record that it continues");
    }
    let Some(mission) = recorded::mission_of(reader)? else {
        return cannot("its program names no vehicle and no targets".to_string(), fly);
    };
    if fact(reader, "vehicle_type")?.as_deref() != Some(BUILT_IN) {
        let why = "its vehicle was not the built-in simulator, and only that one can repeat a flight";
        return cannot(why.to_string(), fly);
    }
    let Some((first, last)) = reader.span().map_err(recording::read)? else {
        return cannot("it holds no steps".to_string(), "fly the mission again");
    };
    let end = fact(reader, "end_ns")?.and_then(|text| text.parse().ok());
    let last = end.map_or(last, |end| last.max(Time(end)));
    if !(first..=last).contains(&at) {
        return Err(MissionError::data(format!("the instant {at} lies outside of the record"))
            .because(format!("it holds the flight from {first} to {last}"))
            .help("give an instant between"));
    }
    Ok(mission)
}

fn fact(reader: &RecordReader, key: &str) -> MissionResult<Option<String>> {
    reader.meta(key).map_err(recording::read)
}
