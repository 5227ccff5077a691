//! Flights with seeded failures of the vehicle, its sensors, its link, its clock, its planners, its operators and the recorder's disk,
//! and the rules that must hold in all of them:
//!
//! 1. a flight ends, by its application or at its time limit, and no task is silent: after every step each says what it waits for;
//! 2. an application ends on the ground, and fails for a reason that was reported; only the time limit ends a flight in the air;
//! 3. a vehicle is lost by a failure that can lose it, which held then or shortly before, and after a report;
//! 4. a violation was announced before it began, by a message that names its requirement and its zone (`rules.rs` has the windows);
//! 5. the same seed gives the same flight, and its record replays without a difference, also that of a disk which was full from some
//!    instant on.
//!
//! Shipped missions fly with failures, too, under the rules that need no guards; `APEX_FAULT_SHIPPED` sets the seeds of each.
//!
//! `APEX_FAULT_HOURS` says how many flight hours are flown (200 in `make test`, 50,000 in `make nightly`), `APEX_FAULT_SEED` where they
//! begin. A failure names its seed: `APEX_FAULT_SEED=N APEX_FAULT_HOURS=1` repeats it, and `APEX_FAULT_KEEP=FOLDER` keeps its mission with
//! the record of the flight.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a failed test should stop")]

#[path = "fault_simulator/disk.rs"]
mod disk;
#[path = "fault_simulator/draws.rs"]
mod draws;
#[path = "fault_simulator/link.rs"]
mod link;
#[path = "fault_simulator/mission.rs"]
mod mission;
#[path = "fault_simulator/rules.rs"]
mod rules;
#[path = "support/shipped.rs"]
mod shipped;
#[path = "fault_simulator/solver.rs"]
mod solver;
#[path = "fault_simulator/story.rs"]
mod story;

use apex_mission::Mission;
use apex_mission::flight::MissionFlight;
use apex_mission::recorded::replay;
use apex_mission::verification::{CheckResult, FlightCheck};
use apex_model::time::Time;
use apex_runtime::RunEnd;
use apex_runtime::ports::Observer;
use apex_runtime::record::RecordReader;
use disk::FullDisk;
use link::BadLink;
use rules::{broken, kept_by_all};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use story::Story;

/// One flight in this many is recorded, replayed and flown twice.
const REPLAYED_EVERY: u64 = 10;

fn number(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// A flight: its hours, its statements, and the rules that it broke.
struct Flown {
    hours: f64,
    story: Story,
    broken: Vec<String>,
}

/// Results of a flight that are kept in addition to its statements: a record that is replayed, a record, a digest.
#[derive(Clone, Copy, Default)]
struct Kept {
    replayed: bool,
    recorded: bool,
    has_digest: bool,
}

fn fly(seed: u64, wanted: Kept) -> Flown {
    let temporary = tempfile::tempdir().unwrap();
    let kept = std::env::var_os("APEX_FAULT_KEEP").map(|folder| PathBuf::from(folder).join(seed.to_string()));
    let folder = kept.as_deref().unwrap_or(temporary.path());
    std::fs::create_dir_all(folder).unwrap();
    mission::write(seed, folder);
    fly_in(folder, seed, Kept { recorded: kept.is_some(), ..wanted }, broken)
}

/// The rules that a flight broke.
type Rules = fn(&Story, &RunEnd, &CheckResult) -> Vec<String>;

/// Flies the mission in `folder`.
fn fly_in(folder: &Path, seed: u64, kept: Kept, rules: Rules) -> Flown {
    let Kept { replayed, recorded, has_digest } = kept;
    let mission = Arc::new(Mission::load(folder).unwrap_or_else(|error| panic!("mission {seed}: {error:?}")));
    let means = solver::means();
    let world = apex_simulation::world(&mission, Some(seed)).unwrap_or_else(|error| panic!("world {seed}: {error:?}"));
    let mut vehicle = BadLink::new(world, seed);
    let (mut story, mut check) = (Story::of(folder, seed, has_digest), FlightCheck::new(&mission));
    let path = folder.join("flight.apex");
    let mut recorder =
        (replayed || recorded).then(|| apex_simulation::create_record(&path, &mission, Some(seed)).unwrap());
    // Every second recorded flight meets a full disk.
    let full_from =
        (replayed && (seed / REPLAYED_EVERY).is_multiple_of(2)).then(|| Time::from_seconds(300.0 + seed as f64));
    let mut disk = recorder.as_mut().map(|recorder| FullDisk::new(recorder, full_from));
    let mut observers: Vec<&mut dyn Observer> = Vec::new();
    observers.extend(disk.as_mut().map(|disk| disk as &mut dyn Observer));
    observers.push(&mut story);
    observers.push(&mut check);
    let terms = MissionFlight::terms(&mission, None);
    let flown = MissionFlight::new(Arc::clone(&mission), means).fly(&mut vehicle, terms, &mut observers);
    // The report of the landing may still be on its way when the flight ends.
    (story.airborne, story.landed) = (vehicle.is_in_air, story.landed || (story.airborne && !vehicle.is_in_air));
    let mut broken_rules = Vec::new();
    let mut hours = mission.settings.duration.seconds() / 3_600.0;
    match flown {
        Err(error) => broken_rules.push(format!("the flight broke: {error}")),
        Ok(flown) => {
            hours = flown.end.at.seconds() / 3_600.0;
            broken_rules.extend(rules(&story, &flown.end, check.result()));
            if !broken_rules.is_empty() {
                let notes = flown.report.notes.iter().rev().take(4);
                broken_rules.extend(notes.map(|note| format!("{} {}", note.at, note.text)));
            }
            if let Some(mut recorder) = recorder {
                match (flown.store(&mut recorder), full_from) {
                    (Err(error), None) => broken_rules.push(format!("the record was not closed: {error}")),
                    (Ok(()), Some(at)) if at < flown.end.at => {
                        broken_rules.push("a record on a full disk was closed as if it were whole".to_string());
                    }
                    _ => {}
                }
                drop(recorder);
                let report = replay(&RecordReader::open(&path).unwrap()).unwrap();
                broken_rules.extend(report.difference.map(|difference| format!("replay differs: {}", difference.what)));
            }
        }
    }
    Flown { hours, story, broken: broken_rules }
}

#[test]
fn flights_with_failures_end_well_or_say_why_not() {
    let (first, wanted) = (number("APEX_FAULT_SEED", 1), number("APEX_FAULT_HOURS", 200) as f64);
    let (mut hours, mut faults, mut wrong) = (0.0, 0, Vec::new());
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let mut seed = first;
    while hours < wanted {
        let flown = fly(seed, Kept { replayed: seed.is_multiple_of(REPLAYED_EVERY), ..Kept::default() });
        hours += flown.hours;
        faults += flown.story.faults.len();
        let kinds: BTreeSet<&str> = flown.story.faults.iter().map(|span| span.kind.as_str()).collect();
        for kind in kinds {
            *seen.entry(kind.to_string()).or_default() += 1;
        }
        *seen.entry(flown.story.outcome().to_string()).or_default() += 1;
        if !flown.broken.is_empty() {
            wrong.push(format!("APEX_FAULT_SEED={seed} APEX_FAULT_HOURS=1: {}", flown.broken.join("; ")));
        }
        seed += 1;
    }
    println!("{hours:.0} flight hours in {} flights: {seen:?}", seed - first);
    if let Some(folder) = std::env::var_os("APEX_QUALITY_FOLDER") {
        let row = format!("seeds {first} to {}\t{hours:.0}\t{faults}\t{}\n", seed - 1, wrong.len());
        std::fs::write(Path::new(&folder).join("faults.tsv"), row).unwrap();
    }
    assert!(wrong.is_empty(), "{} of {} flights:\n{}", wrong.len(), seed - first, wrong.join("\n"));
    // If the simulated failures do not occur, nothing is tested.
    if wanted >= 200.0 {
        for kind in [
            "engine",
            "leak",
            "navigation",
            "freeze",
            "silence",
            "bias",
            "modem",
            "payload-power",
            "acknowledgements",
            "gimbal",
        ] {
            assert!(seen.get(kind).is_some_and(|count| *count >= 2), "no failure of {kind}: {seen:?}");
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_flight() {
    for seed in [3, 8, 21] {
        let digested = Kept { has_digest: true, ..Kept::default() };
        let (once, twice) = (fly(seed, digested), fly(seed, digested));
        assert!(once.story.digest().is_some(), "seed {seed}");
        assert_eq!(once.story.digest(), twice.story.digest(), "seed {seed}");
        assert!(once.broken.is_empty(), "seed {seed}: {:?}", once.broken);
    }
}

/// Shipped missions, in worlds with failures that their authors did not expect. Not all of them guard against contingencies.
#[test]
fn shipped_missions_with_failures_end_well() {
    let mut wrong = Vec::new();
    for name in ["pipeline-inspection", "stand-off", "structure-watch", "diagnosis"] {
        let seeds = 11..11 + number("APEX_FAULT_SHIPPED", 2);
        for seed in seeds {
            let world = (":type native-sim", ":type native-sim :world \"world.json\"");
            let changes: &[(&str, &str)] = match name {
                "pipeline-inspection" => &[world, (":budget 2s", ":budget 200ms")],
                "stand-off" => &[world],
                "structure-watch" => &[(":budget 500ms", ":budget 50ms")],
                _ => &[],
            };
            let folder = shipped::copy_with(name, changes);
            let world = mission::shipped_world(seed, 1.0, name == "diagnosis");
            std::fs::write(folder.path().join("world.json"), world).unwrap();
            let flown =
                fly_in(folder.path(), seed, Kept { replayed: true, recorded: true, has_digest: false }, kept_by_all);
            if !flown.broken.is_empty() {
                wrong.push(format!("{name} {seed}: {}", flown.broken.join("; ")));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
