//! The dynamic world in whole flights: the realised cost of ignorance against the expected one, bad world files, and two failures that a
//! fault model distinguishes.
//!
//! `APEX_IGNORANCE_SEEDS` sets the number of seeds.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a failed test should stop")]
#![allow(clippy::disallowed_methods, reason = "this check computes distances apart from the product")]

#[path = "contingencies/flown.rs"]
mod flown;

use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::MissionFlight;
use apex_mission::recorded::{replay, report_of, situation_at};
use apex_mission::recording;
use apex_mission::report::MissionValue;
use apex_mission::situation::Situation;
use apex_mission::verification::verify;
use apex_model::time::Time;
use apex_runtime::explain::{Explainer, Question};
use apex_runtime::record::RecordReader;
use apex_runtime::record::view::RecordView;
use apex_simulation::{IgnoranceSummary, RunSummary, RunTerms, fly_runs};
use std::path::Path;
use std::sync::Arc;

fn means() -> PlanningResources {
    PlanningResources::of(&Arc::new(apex_solvers::shipped()))
}

/// Returns a mission in which a helicopter watches two structures in turn, each about every 90 seconds, regardless of its findings.
fn watch(folder: &Path, world: &str) -> Mission {
    let site = |id: &str, north_deg: f64, more: &str| {
        format!(
            r#"{{"type": "Feature", "properties": {{"id": "{id}", {more}}}, "geometry": {{"type": "Point", "coordinates": [-100.0, {}]}}}}"#,
            40.0 + north_deg
        )
    };
    let often = r#""kind": "structure", "rate_per_h": 6, "importance": 100, "cost": "linear", "cost_growth_per_h": 6, "dwell_s": 20, "initial_age_s": 120"#;
    let changing = r#""kind": "structure", "rates_per_h": [[0, 2], [0.08, 9]], "importance": 200, "cost_growth_per_h": 4, "dwell_s": 20"#;
    let features =
        [site("pad", -0.002, r#""kind": "base""#), site("barn", 0.001, often), site("mill", 0.003, changing)];
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("sites.geojson", &format!("{{\"type\": \"FeatureCollection\", \"features\": [{}]}}", features.join(", ")));
    write("world.json", world);
    write(
        "mission.pdl",
        r#"(defapplication "Watch"
  :type native-sim
  :libraries ("vehicle" "aerial-observation")
  :vehicle (sim :model rmax :at pad)
  :duration 12min
  :end-margin 0s
  :targets "sites.geojson"
  :world "world.json"
  :agents ((agent uav-1 :initial-task (watch them))))
(procedure :sequential (index (watch them)) (step up (take off to 60m)) (step round (watch in turn)))
(procedure (index (watch in turn)) (step round (once round) (repeating)))
(procedure :sequential
  (index (once round))
  (step barn (visit barn at (40.001 -100.0 60) for 20s with camera-1))
  (step mill (visit mill at (40.003 -100.0 60) for 20s with camera-1)))"#,
    );
    Mission::load(folder).unwrap_or_else(|error| panic!("{error:?}"))
}

fn ignorance(world: &str, runs: usize) -> IgnoranceSummary {
    let folder = tempfile::tempdir().unwrap();
    let mission = Arc::new(watch(folder.path(), world));
    let terms = RunTerms { first_seed: Some(1), runs, jobs: 2, until: None };
    let rows = fly_runs(&mission, &means(), &terms, || true).unwrap();
    let summary = RunSummary::of(&rows);
    println!("{summary}");
    summary.ignorance.unwrap()
}

/// Check of the metric: over many worlds the mean cost of fires equals the expected cost.
#[test]
fn expected_and_realised_ignorance_agree() {
    let seeds = std::env::var("APEX_IGNORANCE_SEEDS").ok().and_then(|text| text.parse().ok()).unwrap_or(1_000);
    let seen = ignorance(r#"{"format": "apex-world-1", "ignitions": {}}"#, seeds);
    // Barn: 6 per hour for the 2 min before and the 12 min of the flight. Mill: 2 per hour for 4.8 min, 9 for 7.2 min. In all 2.64 fires.
    let fires = seen.fires as f64 / seen.flights as f64;
    assert!((fires - 2.64).abs() < 4.0 * (2.64 / seen.flights as f64).sqrt(), "{fires} fires a flight");
    assert!(seen.deviation().abs() <= 3.0, "{seen:?}");
    assert!(seen.standard_error < 0.1 * seen.expected, "{seen:?}");
}

/// Looks that detect half of the fires cost more than the metric, which assumes that they detect all.
#[test]
fn looks_that_miss_fires_cost_more_than_expected() {
    let missed = ignorance(r#"{"format": "apex-world-1", "ignitions": {"detection": 0.4}}"#, 150);
    assert!(missed.deviation() > 3.0, "{missed:?}");
    let clouds = r#""clouds": [{"latitude_deg": 40, "longitude_deg": -100, "radius_m": 50000, "base_m": 10, "top_m": 50, "cover": 1}]"#;
    let hidden = ignorance(&format!(r#"{{"format": "apex-world-1", "ignitions": {{}}, {clouds}}}"#), 20);
    assert_eq!(hidden.seen, 0, "{hidden:?}");
}

#[test]
fn bad_world_files_are_refused_with_the_field_and_what_would_be_right() {
    for (world, words) in [
        ("{", "world.json:1:1"),
        (r#"{"format": "apex-world-2"}"#, "\"apex-world-1\""),
        (r#"{"format": "apex-world-1", "fault": []}"#, "unknown field `fault`"),
        (r#"{"format": "apex-world-1", "faults": [{"fault": "gimbel", "at_s": 1}]}"#, "unknown variant `gimbel`"),
        (
            r#"{"format": "apex-world-1", "faults": [{"fault": "gimbal", "of": "camera-2", "at_s": 1}]}"#,
            "did you mean `camera-1`",
        ),
        (r#"{"format": "apex-world-1", "faults": [{"fault": "gimbal", "at_s": 1}]}"#, "needs `of`"),
        (r#"{"format": "apex-world-1", "faults": [{"fault": "engine"}]}"#, "neither `at_s` nor `rate_per_h`"),
        (
            r#"{"format": "apex-world-1", "faults": [{"fault": "engine", "at_s": 1, "rate_per_h": 1}]}"#,
            "both `at_s` and `rate_per_h`",
        ),
        (r#"{"format": "apex-world-1", "faults": [{"fault": "engine", "at_s": -1}]}"#, "at_s is -1"),
        (r#"{"format": "apex-world-1", "faults": [{"fault": "bias", "of": "altitude", "at_s": 1}]}"#, "needs `by`"),
        (
            r#"{"format": "apex-world-1", "faults": [{"fault": "freeze", "of": "altitud", "at_s": 1}]}"#,
            "did you mean `altitude`",
        ),
        (r#"{"format": "apex-world-1", "faults": [{"fault": "modem", "of": "radio", "at_s": 1}]}"#, "unknown modem"),
        (r#"{"format": "apex-world-1", "ignitions": {"detection": 1.5}}"#, "ignitions.detection is 1.5"),
        (
            r#"{"format": "apex-world-1", "perimeters": {"every_h": 0}}"#,
            "perimeters.every_h is 0; it must be at least 0.1",
        ),
        (r#"{"format": "apex-world-1", "perimeters": {}}"#, "this mission has no fire with an outline"),
        (
            r#"{"format": "apex-world-1", "clouds": [{"latitude_deg": 95, "longitude_deg": 0, "radius_m": 1, "base_m": 0, "top_m": 1, "cover": 0}]}"#,
            "clouds[0].latitude_deg",
        ),
        (
            r#"{"format": "apex-world-1", "downlink": {"over": "radio", "rate_mbit_s": 1, "picture_mbit": 1, "store_mbit": 9}}"#,
            "downlink.over",
        ),
        (r#"{"format": "apex-world-1", "wind_error": {"correlation_h": 0}}"#, "wind_error.correlation_h is 0"),
        (
            r#"{"format": "apex-world-1", "wind_error": {"sigma_mps": 100}}"#,
            "sigma_mps is 100; it must be from 0 to 50",
        ),
        (
            r#"{"format": "apex-world-1", "faults": [{"fault": "bias", "of": "location", "by": 3, "at_s": 1}]}"#,
            "`location` is not a number",
        ),
        (
            r#"{"format": "apex-world-1", "faults": [{"fault": "bias", "of": "flight-phase", "by": 3, "at_s": 1}]}"#,
            "`flight-phase` is not a number",
        ),
        (r#"{"format": "apex-world-1", "faults": [{"fault": "leak", "by": 1e9, "at_s": 1}]}"#, "by is 1000000000"),
        (r#"{"format": "apex-world-1", "faults": [{"fault": "engine", "at_s": 1e7}]}"#, "the mission ends at"),
        (
            r#"{"format": "apex-world-1", "storms": [{"latitude_deg": 44, "longitude_deg": 0, "radius_m": 1, "edr": 9}]}"#,
            "storms[0].edr is 9; it must be from 0 to 1",
        ),
        (
            r#"{"format": "apex-world-1", "storms": [{"latitude_deg": 44, "longitude_deg": 0, "radius_m": 1, "east_mps": 1e6}]}"#,
            "storms[0].east_mps is 1000000",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let mission = watch(folder.path(), world);
        let error = apex_simulation::world(&mission, None).err().unwrap_or_else(|| panic!("accepted: {world}"));
        let text = format!("{error} {error:?}");
        assert!(text.contains(words) && text.contains("world.json"), "{world}: {text}");
    }
}

/// Mission `diagnosis`: first the mount fails, later the power of the payload. The fault model distinguishes the two, and the mission
/// continues.
#[test]
fn a_mount_and_a_bus_that_fail_are_distinguished_and_the_rest_is_used() {
    let folder = tempfile::tempdir().unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/diagnosis");
    let flown = flown::fly_mission(&shipped, folder);
    let health = |component: &str, at_s: f64| flown.word_at(&format!("(health {component})"), at_s);
    // The mount sticks at 900 s, the payload loses its power at 2,000 s.
    assert_eq!(
        ["gimbal-drive", "payload-converter", "sensor-head"].map(|one| health(one, 890.0)),
        ["good", "good", "good"]
    );
    assert_eq!(
        ["gimbal-drive", "payload-converter"].map(|one| health(one, 1_600.0)),
        ["bad", "good"],
        "{}",
        flown.story()
    );
    assert_eq!(health("payload-converter", 2_050.0), "bad", "{}", flown.story());
    let (turret_s, payload_s) =
        (flown.first_s("(turret-lost gimbal-drive)"), flown.first_s("(payload-lost payload-converter)"));
    assert!((900.0..1_600.0).contains(&turret_s) && (2_000.0..2_040.0).contains(&payload_s), "{turret_s} {payload_s}");
    // Pictures before the first failure only, scans between the two, neither after the second.
    let pictures = flown.said.iter().filter(|(_, said)| said.starts_with("(image-taken")).map(|(at_s, _)| *at_s);
    let pictures: Vec<f64> = pictures.collect();
    assert!(!pictures.is_empty() && pictures.iter().all(|at_s| *at_s < 900.0), "{pictures:?}");
    let scans = flown.words("(scanner-state aircraft-1)").into_iter().filter(|(_, word)| word == "on");
    let scans: Vec<f64> = scans.map(|(at_s, _)| at_s).collect();
    assert!(!scans.is_empty() && scans.iter().all(|at_s| (900.0..2_000.0).contains(at_s)), "{scans:?}");
    let bridges = ["narrows", "old-ford", "railway", "canyon", "aqueduct", "dry-creek"];
    let served = |bridge: &&&str| {
        flown.count(&format!("(observed {bridge})")) + flown.count(&format!("(relaying {bridge})")) == 1
    };
    assert_eq!(bridges.iter().filter(served).count(), 6, "{}", flown.story());
    assert!(flown.count("(relaying") >= 1 && flown.count("(landed aircraft-1)") == 1, "{}", flown.story());
    flown.assert_replays();
}

/// `western-states/living.pdl`: planners wait until clouds have cleared, fly below a deck and near a satellite pass, and the record names
/// places hidden by clouds that were not forecast.
#[test]
fn a_living_sky_is_planned_for_and_scored() {
    let folder = tempfile::tempdir().unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/western-states/living.pdl");
    let mission = Arc::new(Mission::load(&shipped).unwrap_or_else(|error| panic!("{error:?}")));
    let path = folder.path().join("flight.apex");
    let mut recorder = apex_simulation::create_record(&path, &mission, None).unwrap();
    let terms = MissionFlight::terms(&mission, None);
    apex_simulation::fly(Arc::clone(&mission), means(), None, terms, &mut recorder, &mut []).unwrap();
    drop(recorder);
    let (reader, _) = recording::open(&path).unwrap();
    let checked = verify(&reader, &mission).unwrap();
    assert!(checked.positions > 10_000 && checked.violations() == 0, "{checked}");
    let report = report_of(&reader, &mission).unwrap();
    let visit =
        |target: &str| report.visits.iter().rfind(|visit| visit.target == target && visit.end.is_some()).unwrap();
    // The clouds over Zaca clear after six hours; the satellite passes after nine hours and a quarter.
    assert!(visit("zaca").begin.seconds() > 6.0 * 3_600.0, "{}", report.text());
    let known = RecordView::open(&path, 0).unwrap().targets(Some(5 * 3_600_000_000_000)).unwrap();
    let planned = known.targets.iter().find(|target| target.id == "castle-rock").unwrap().detail.clone().unwrap();
    assert!(planned.starts_with("for 8:5") || planned.starts_with("for 9:"), "{planned}");
    let MissionValue::Score(score) = &report.value else { panic!("of another kind") };
    let look = |target: &str| &score.looks.iter().find(|look| look.id == target).unwrap().flown;
    assert!(look("zaca").factors.clarity > 0.95, "{}", report.text());
    let lost = |target: &str, cause: &str| {
        let lost = look(target).losses.iter().filter(|loss| loss.cause.words() == cause).map(|loss| loss.points);
        lost.sum::<f64>()
    };
    assert!(lost("egley-complex", "cloud") > 5.0 && lost("zaca", "cloud") < 1.0, "{}", report.text());
    // Both fires are reported larger on the way to them: they are flown by the outlines that are then known.
    for grown in ["elk-complex", "lick"] {
        assert!(lost(grown, "not seen") < 1.0, "{grown}: {}", report.text());
    }
    assert!(score.score > 500.0, "{}", report.text());
    // Growth is a target: it has states, can be asked about, and is known since the report of its fire.
    assert!(report.left_out.iter().all(|(_, why)| why != "never announced"), "{}", report.text());
    let known = RecordView::open(&path, 0).unwrap().targets(None).unwrap();
    let growth = known.targets.iter().find(|target| target.id == "gw/growth-1").unwrap();
    assert_eq!((growth.name.as_str(), growth.state.as_deref()), ("GW growth 1", Some("observed")));
    assert_eq!(growth.latitude_deg, None, "the middle of the fire is outside of the ground by which it has grown");
    let asked = |what: &str, at_h: f64| {
        let question = Question::new(what, Time::from_seconds(3_600.0 * at_h));
        Explainer::of_decisions(&reader).why_not(&question).unwrap().answer
    };
    assert!(asked("gw/growth-1", 12.0).starts_with("gw/growth-1 was observed"), "{}", asked("gw/growth-1", 12.0));
    assert!(asked("castle-rock", 1.0).contains("has not been announced by 1:00:00"), "{}", asked("castle-rock", 1.0));
    assert!(asked("castle-rock", 5.0).contains("planned"), "{}", asked("castle-rock", 5.0));
    let replayed = replay(&reader).unwrap();
    assert!(replayed.difference.is_none(), "{:?}", replayed.difference.map(|difference| difference.what.to_string()));
    assert_continues_stored(&reader, &mission);
}

/// The situation that continues a stored one is the situation of all steps, at instants before, at and after the stored one.
fn assert_continues_stored(reader: &RecordReader, mission: &Mission) {
    let stored = reader.situations().unwrap();
    assert!(stored.len() >= 3, "{} stored situations", stored.len());
    let mut instants: Vec<Time> = [1, stored.len() - 1].iter().map(|index| stored[*index].at).collect();
    let nearby = |at: &Time| [Time(at.0 - 1), *at, Time(at.0 + 30_000_000_000)];
    instants = instants.iter().flat_map(nearby).chain([Time::END]).collect();
    let mut steps = reader.steps_of_all(Time::END).unwrap().map(Result::unwrap).peekable();
    let mut of_all_steps = Situation::default();
    for at in instants {
        while let Some(step) = steps.next_if(|step| step.batch.now <= at) {
            of_all_steps.observe(mission, step.agent, &step.batch, &step.decoded_effects().unwrap());
        }
        let (mut continued, mut expected) = (situation_at(reader, mission, at).unwrap(), of_all_steps.clone());
        // What the last step adds to the next batch is not stored.
        let _ = (continued.take_derived(), expected.take_derived());
        assert!(continued == expected, "the situations differ at {at}");
    }
}

/// A fire of 20,000 acres that is mapped after more than an hour, in a wind of 8 m/s from the west.
fn late_survey(folder: &Path, world: &str) -> Mission {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write(
        "targets.geojson",
        r#"{"type": "FeatureCollection", "features": [
{"type": "Feature", "properties": {"id": "home", "kind": "base"}, "geometry": {"type": "Point", "coordinates": [-117.0, 37.0]}},
{"type": "Feature", "properties": {"id": "brush", "kind": "fire", "acres": 20000, "value": 100, "resolution_m": 20},
 "geometry": {"type": "Point", "coordinates": [-117.0, 37.4]}}]}"#,
    );
    write("winds.csv", "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n-100,20000,270,8,0\n");
    write("world.json", world);
    write(
        "mission.pdl",
        r#"(defapplication "Late survey" :type native-sim :libraries ("vehicle" "aerial-observation")
  :vehicle (sim :model predator-b :at home) :duration 5h :targets "targets.geojson" :forecast "winds.csv" :world "world.json"
  :agents ((agent uav-1 :initial-task (fly the mission))))
(solver auto (index (map the fires)) :budget 200ms)
(procedure :sequential (index (fly the mission))
  (step up (take off to 5000m)) (step pause (wait 55min)) (step survey (map the fires)) (step home (return to home at 5000m)))"#,
    );
    Mission::load(folder).unwrap_or_else(|error| panic!("{error:?}"))
}

/// A fire that has grown is mapped and judged by its new outline, from the record alone, too.
#[test]
fn a_fire_that_grows_is_mapped_where_it_burns_now() {
    let survey = |world: &str| {
        let folder = tempfile::tempdir().unwrap();
        let mission = Arc::new(late_survey(folder.path(), world));
        let path = folder.path().join("flight.apex");
        let mut recorder = apex_simulation::create_record(&path, &mission, None).unwrap();
        let terms = MissionFlight::terms(&mission, None);
        let flown = apex_simulation::fly(Arc::clone(&mission), means(), None, terms, &mut recorder, &mut []).unwrap();
        drop(recorder);
        let (reader, _) = recording::open(&path).unwrap();
        assert_eq!(replay(&reader).unwrap().difference, None);
        assert_eq!(report_of(&reader, &mission).unwrap().text(), flown.report.text());
        flown.report
    };
    let coverage = |report: &apex_mission::report::Report| {
        let MissionValue::Score(score) = &report.value else { panic!("of another kind") };
        let look = &score.looks[0];
        (look.flown.factors.coverage, look.predicted.as_ref().unwrap().quality.coverage.factor)
    };
    let time_s = |report: &apex_mission::report::Report| {
        let visit = &report.visits[0];
        (visit.end.unwrap() - visit.begin).seconds()
    };
    let still = survey(r#"{"format": "apex-world-1"}"#);
    let grown = survey(r#"{"format": "apex-world-1", "perimeters": {"every_h": 0.5, "until_h": 1}}"#);
    for (flown, predicted) in [coverage(&still), coverage(&grown)] {
        assert!(
            flown > 0.9 && (flown - predicted).abs() < 0.02,
            "{flown} flown, {predicted} predicted\n{}",
            grown.text()
        );
    }
    // A tenth of 8 m/s for an hour: 2.9 km more than the initial length of 10.2 km.
    assert!(time_s(&grown) > 1.15 * time_s(&still), "{} s for {} s", time_s(&grown), time_s(&still));
    let notes = grown.notes.iter().filter(|note| note.text.starts_with("brush burns on"));
    assert_eq!(notes.count(), 2, "{}", grown.text());
    // Two reports arrive after the plan, the second a minute before the first line; the report after it changes nothing.
    let late = survey(r#"{"format": "apex-world-1", "perimeters": {"every_h": 0.3}}"#);
    let (flown, predicted) = coverage(&late);
    // A fortieth of the fire burns beyond the lines.
    assert!(flown < predicted - 0.02, "{flown} flown, {predicted} predicted");
    assert!(late.notes.iter().any(|note| note.text == "brush has grown since it was observed"), "{}", late.text());
}
