//! Flights stay out of zones, inside the permitted area, above the ground and within landing distance, for any mission: seeds of
//! `western-states`, and random missions with random zones, replans, lost links and returns. The check is `apex_mission::verification`,
//! which shares no arithmetic with the code that plans the ways.
//!
//! `APEX_GUARDED_SEEDS` and `APEX_GUARDED_MISSIONS` set how many of each are flown, `APEX_GUARDED_FIRST` the first of them.

#![allow(clippy::unwrap_used, reason = "a failed test should stop")]

#[path = "guarded/random_mission.rs"]
mod random_mission;
#[path = "support/shipped.rs"]
mod shipped;

use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::MissionFlight;
use apex_mission::recorded::replay;
use apex_mission::recording;
use apex_mission::verification::{CheckResult, FlightCheck, verify};
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_runtime::EndReason;
use apex_runtime::ports::Observer;
use apex_simulation::{create_record, world};
use random_mission::RandomMission;
use std::sync::Arc;

fn number(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// Prints failures, where output is wanted.
struct Failures;

impl Observer for Failures {
    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        for effect in effects {
            let text = format!("{effect:?}");
            if let Effect::Command { form, .. } = effect {
                println!("{}: {form}", batch.now);
            }
            if ["ExpressionFailed", "CommandFailed", "CommandTimedOut"].iter().any(|word| text.contains(word)) {
                println!("{}: {text}", batch.now);
            }
        }
        Ok(())
    }
}

fn fly(mission: &Arc<Mission>, seed: u64) -> (EndReason, CheckResult) {
    let mut check = FlightCheck::new(mission);
    let mut vehicle = world(mission, Some(seed)).unwrap();
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let terms = MissionFlight::terms(mission, None);
    let told = std::env::var_os("APEX_GUARDED_NOTES").is_some();
    let mut observers: Vec<&mut dyn Observer> = vec![&mut check];
    let mut failures = Failures;
    if told {
        observers.push(&mut failures);
    }
    let flown = MissionFlight::new(Arc::clone(mission), means).fly(&mut vehicle, terms, &mut observers).unwrap();
    if told {
        println!("{:?}", flown.end);
        flown.report.notes.iter().for_each(|note| println!("{note:?}"));
    }
    (flown.end.reason, check.result().clone())
}

fn shown(name: &str, result: &CheckResult) -> Option<String> {
    (result.violations() > 0 || !result.said_broken.is_empty()).then(|| format!("{name}: {result}"))
}

#[test]
fn western_states_keeps_its_requirements() {
    let folder = shipped::copy_with("western-states", &[(":budget 3s", ":budget 200ms")]);
    let mission = Arc::new(Mission::load(folder.path()).unwrap());
    let mut wrong = Vec::new();
    let mut positions = 0;
    let first = number("APEX_GUARDED_FIRST", 1);
    for seed in first..first + number("APEX_GUARDED_SEEDS", 5) {
        let (end, result) = fly(&mission, seed);
        positions += result.positions;
        wrong.extend(shown(&format!("seed {seed}"), &result));
        if !end.is_success() {
            wrong.push(format!("seed {seed}: it has not landed, because {}", end.text()));
        }
    }
    assert!(positions > 1_000, "{positions} positions are too few to say anything");
    assert!(wrong.is_empty(), "{} flights:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_recorded_flight_by_ways_is_replayed_and_verified() {
    let folder = tempfile::tempdir().unwrap();
    // Its flight needs ways, waits and a circle aside.
    RandomMission::new(154).write(folder.path());
    let mission = Arc::new(Mission::load(folder.path()).unwrap());
    let path = folder.path().join("flight.apex");
    let mut recorder = create_record(&path, &mission, Some(154)).unwrap();
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let terms = MissionFlight::terms(&mission, None);
    apex_simulation::fly(Arc::clone(&mission), means, Some(154), terms, &mut recorder, &mut []).unwrap();
    drop(recorder);
    let (reader, _) = recording::open(&path).unwrap();
    let replayed = replay(&reader).unwrap();
    assert!(replayed.difference.is_none(), "{:?}", replayed.difference.map(|difference| difference.what.to_string()));
    let result = verify(&reader, &mission).unwrap();
    assert!(result.positions > 1_000 && result.unsaid().next().is_none(), "{result}");
}

/// The aircraft waits for hours next to a zone, and meanwhile descends to the altitude of its way.
#[test]
fn a_wait_keeps_out_of_zones_at_every_altitude_that_it_is_flown_at() {
    let folder = tempfile::tempdir().unwrap();
    RandomMission::new(266).write(folder.path());
    let mission = Arc::new(Mission::load(folder.path()).unwrap());
    let (_, result) = fly(&mission, 266);
    assert!(result.positions > 1_000 && result.unsaid().next().is_none(), "{result}");
}

#[test]
fn random_missions_keep_their_requirements() {
    let (mut wrong, mut positions, mut broken) = (Vec::new(), 0, 0);
    let first = number("APEX_GUARDED_FIRST", 1);
    for seed in first..first + number("APEX_GUARDED_MISSIONS", 10) {
        let folder = tempfile::tempdir().unwrap();
        RandomMission::new(seed).write(folder.path());
        let mission = Arc::new(Mission::load(folder.path()).unwrap_or_else(|error| panic!("mission {seed}: {error}")));
        let (_, result) = fly(&mission, seed);
        positions += result.positions;
        broken += result.said_broken.len();
        for said in &result.said_broken {
            println!("mission {seed} at {:.0} s: {:?} ({} violations)", said.t_s, said.names, result.violations());
        }
        // Violations that the flight announced are accepted: it has to reach an airfield or a place where the mission forbids it to be.
        if result.unsaid().next().is_some() {
            wrong.push(format!("mission {seed}: {result}"));
        }
    }
    println!("{positions} positions, {broken} times a requirement had to be broken");
    assert!(positions > 1_000, "{positions} positions are too few to say anything");
    assert!(wrong.is_empty(), "{} flights:\n{}", wrong.len(), wrong.join("\n"));
}
