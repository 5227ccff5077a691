//! Plans fly as fast as thin air demands, as the simulator does.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed test should stop")]

use apex_geo::geodesy;
use apex_mission::Mission;
use apex_mission::problem::pose;
use apex_mission::situation::Situation;
use apex_model::problem::{Plan, PlannedVisit, Problem};
use apex_model::time::Time;
use apex_planning::checker::violations;
use apex_planning::solver::{Environment, Solver, WorkBudget};
use apex_solvers::planners::single_visit::SingleVisit;

const PROGRAM: &str = "(defapplication \"Thin\" :type native-sim :libraries (\"vehicle\" \"aerial-observation\") \
     :vehicle (sim :model \"v.json\" :at home) :duration 6h :targets \"t.geojson\" \
     :agents ((agent uav-1 :initial-task (fly the mission))))\n\
     (procedure (index (fly the mission)) (step up (take off to 3000m)))\n";

const TARGETS: &str = r#"{"type": "FeatureCollection", "features": [
 {"type": "Feature", "properties": {"id": "home", "kind": "base", "elevation_m": 702},
  "geometry": {"type": "Point", "coordinates": [-117.884, 34.905]}},
 {"type": "Feature", "properties": {"id": "a", "kind": "fire", "acres": 1500, "elevation_m": 700, "resolution_m": 16, "value": 60},
  "geometry": {"type": "Point", "coordinates": [-118.6, 35.2]}},
 {"type": "Feature", "properties": {"id": "b", "kind": "fire", "acres": 1500, "elevation_m": 700, "resolution_m": 16, "value": 60},
  "geometry": {"type": "Point", "coordinates": [-119.6, 35.2]}}]}"#;

/// A vehicle whose slowest indicated airspeed of 44 m/s is 51 m/s through the air at its cruise altitude of 3,000 m, and 91 m/s at 12,000 m.
fn slow_vehicle() -> String {
    let mut text = include_str!("../../../library/vehicles/predator-b.json").to_owned();
    for (old, new) in [
        ("\"true_airspeed_m_s_cruise\": {\"value\": 95.2", "\"true_airspeed_m_s_cruise\": {\"value\": 52.0"),
        ("\"cruise_altitude_m\": {\"value\": 7000.0", "\"cruise_altitude_m\": {\"value\": 3000.0"),
        ("\"cruise_min\": {\"value\": 1680.0", "\"cruise_min\": {\"value\": 2250.0"),
    ] {
        assert_eq!(text.matches(old).count(), 1, "{old}");
        text = text.replace(old, new);
    }
    text
}

#[test]
fn a_slow_vehicle_is_planned_at_the_speed_that_carries_it() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("mission.pdl", PROGRAM), ("t.geojson", TARGETS), ("v.json", &slow_vehicle())] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let mission = Mission::load(folder.path()).unwrap_or_else(|error| panic!("{error:?}"));
    let problem = pose(&mission, &Situation::default(), None, Time::ZERO).unwrap();
    let mut budget = WorkBudget::new(1_000_000);
    let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
    let plan = SingleVisit.solve(&problem, &mut environment).unwrap();
    assert_eq!(violations(&problem, &plan), [] as [String; 0]);
    let (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) = (problem, plan) else { panic!("another kind") };
    // The way to the second fire has no climb, which would take longer.
    let [first, visit] = plan.visits.as_slice() else { panic!("{}", plan.summary) };
    let flown = |visit: &PlannedVisit| {
        let target = problem.targets.iter().find(|target| target.name == visit.target).unwrap();
        target.manoeuvres.get(visit.manoeuvre).unwrap()
    };
    let manoeuvre = flown(visit);
    assert_eq!(flown(first).altitude_m, manoeuvre.altitude_m);
    let needed_mps = mission.model.true_airspeed_m_s_min(manoeuvre.altitude_m);
    assert!(needed_mps > 60.0, "{} m", manoeuvre.altitude_m);
    let way_m: f64 = visit.path.windows(2).map(|ends| geodesy::distance_m(ends[0], ends[1])).sum();
    for (what, length_m, time_s) in
        [("way", way_m, visit.arrive_s - visit.depart_s), ("lines", manoeuvre.length_m, manoeuvre.duration_s)]
    {
        let speed_mps = length_m / time_s;
        assert!((speed_mps / needed_mps - 1.0).abs() < 0.03, "{what}: {speed_mps} m/s instead of {needed_mps} m/s");
    }
    // Flying faster takes more fuel than the flow of cruise for the same time.
    let cruise_kg = problem.vehicle.fuel_flow_kg_per_s * (plan.end_s - problem.start_s);
    assert!(plan.fuel_used_kg > 1.1 * cruise_kg, "{} kg, {cruise_kg} kg in cruise", plan.fuel_used_kg);
}
