//! Plans count what a missed look costs, as the score does.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed test should stop")]

use apex_mission::Mission;
use apex_mission::problem::pose;
use apex_mission::situation::Situation;
use apex_model::problem::{Plan, Problem};
use apex_model::time::Time;
use apex_planning::checker::violations;
use apex_planning::solver::{Environment, Solver, WorkBudget};
use apex_solvers::planners::single_visit::SingleVisit;

const PROGRAM: &str = "(defapplication \"Must\" :type native-sim :libraries (\"vehicle\" \"aerial-observation\") \
     :vehicle (sim :model predator-b :at home) :duration 6h :targets \"t.geojson\" \
     :agents ((agent uav-1 :initial-task (fly the mission))))\n\
     (procedure (index (fly the mission)) (step up (take off to 6000m)))\n";

/// Two fires, of which only one can be seen in time; the other one must be seen.
const TARGETS: &str = r#"{"type": "FeatureCollection", "features": [
 {"type": "Feature", "properties": {"id": "home", "kind": "base", "elevation_m": 702},
  "geometry": {"type": "Point", "coordinates": [-117.884, 34.905]}},
 {"type": "Feature", "properties": {"id": "free", "kind": "fire", "acres": 1500, "elevation_m": 700, "resolution_m": 12, "value": 60,
  "windows_h": [[0.5, 0.55]]}, "geometry": {"type": "Point", "coordinates": [-118.6, 35.2]}},
 {"type": "Feature", "properties": {"id": "bound", "kind": "fire", "acres": 1500, "elevation_m": 700, "resolution_m": 12, "value": 50,
  "windows_h": [[0.5, 0.55]], "must": true, "must_cost": 100}, "geometry": {"type": "Point", "coordinates": [-117.2, 35.2]}}]}"#;

fn planned(targets: &str) -> (Problem, Plan) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mission.pdl"), PROGRAM).unwrap();
    std::fs::write(folder.path().join("t.geojson"), targets).unwrap();
    let mission = Mission::load(folder.path()).unwrap_or_else(|error| panic!("{error:?}"));
    let problem = pose(&mission, &Situation::default(), None, Time::ZERO).unwrap();
    let mut budget = WorkBudget::new(1_000_000);
    let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
    let plan = SingleVisit.solve(&problem, &mut environment).unwrap();
    assert_eq!(violations(&problem, &plan), [] as [String; 0]);
    (problem, plan)
}

#[test]
fn a_look_that_must_be_made_comes_before_a_more_valuable_one() {
    let (_, plan) = planned(TARGETS);
    let Plan::SingleVisit(plan) = plan else { panic!("another kind") };
    let visited: Vec<&str> = plan.visits.iter().map(|visit| visit.target.as_str()).collect();
    assert_eq!(visited, ["bound"], "{}", plan.summary);
    assert!(plan.score > 45.0 && plan.score <= 50.0, "{}", plan.summary);
    assert!(plan.benefits_bound.is_some_and(|bound| bound >= plan.benefits && bound <= 111.0), "{}", plan.summary);
}

#[test]
fn a_plan_states_what_a_missed_look_costs() {
    // The look that must be made is of no use: its factors would have to exceed 1.
    let (_, plan) = planned(&TARGETS.replace("\"must\": true", "\"must\": true, \"must_factor_min\": 1"));
    let Plan::SingleVisit(plan) = plan else { panic!("another kind") };
    let visited: Vec<&str> = plan.visits.iter().map(|visit| visit.target.as_str()).collect();
    assert_eq!(visited, ["free"], "{}", plan.summary);
    assert!((-46.0..=-40.0).contains(&plan.score), "{}", plan.summary);
    assert!(plan.summary.contains("after 100.00 for missed targets"), "{}", plan.summary);
}
