//! A series of flights: the same for any number of threads, the same as single flights, and bad numbers are rejected.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test stops at an unexpected result")]

use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::MissionFlight;
use apex_mission::report::MissionValue;
use apex_simulation::{RunOutcome, RunTerms, fly_runs};
use std::path::Path;
use std::sync::Arc;

fn mission(name: &str) -> Arc<Mission> {
    Arc::new(Mission::load(&Path::new("../../missions").join(name)).unwrap())
}

fn means() -> PlanningResources {
    PlanningResources::of(&Arc::new(apex_solvers::shipped()))
}

#[test]
fn rows_do_not_depend_on_threads_and_equal_single_flights() {
    let (mission, means) = (mission("first-picture"), means());
    let terms = RunTerms { first_seed: Some(5), runs: 4, jobs: 1, until: None };
    let mut flown = 0;
    let alone = fly_runs(&mission, &means, &terms, || {
        flown += 1;
        true
    });
    let alone = alone.unwrap();
    assert_eq!((flown, alone.len()), (4, 4));
    let together = fly_runs(&mission, &means, &RunTerms { jobs: 3, ..terms }, || true).unwrap();
    assert_eq!(alone, together);
    assert_eq!(alone.iter().map(|row| row.seed).collect::<Vec<_>>(), [5, 6, 7, 8]);
    let mut vehicle = apex_simulation::world(&mission, Some(7)).unwrap();
    let single = MissionFlight::new(Arc::clone(&mission), means.clone());
    let single = single.fly(&mut vehicle, MissionFlight::terms(&mission, None), &mut []).unwrap();
    assert_eq!((alone[2].end_s, &alone[2].reason), (single.end.at.seconds(), &single.end.reason.text()));
    let score = match &single.report.value {
        MissionValue::Score(score) => Some(score.score),
        _ => None,
    };
    assert_eq!(alone[2].score, score);
    assert!(alone.iter().all(|row| row.outcome == RunOutcome::Completed && row.positions > 0));
}

/// Targets with pictures outside of planned visits count once, however many messages state the picture: `observed` was 0.
#[test]
fn pictures_without_planned_visits_are_observations() {
    for (name, targets) in [("first-picture", 2), ("diagnosis", 4)] {
        let terms = RunTerms { first_seed: None, runs: 1, jobs: 1, until: None };
        let rows = fly_runs(&mission(name), &means(), &terms, || true).unwrap();
        assert_eq!(rows[0].observed, targets, "{name}");
    }
}

#[test]
fn a_series_can_be_stopped_and_flights_cut_off_are_lost() {
    let (mission, means) = (mission("first-picture"), means());
    let until = Some(apex_model::time::Time::from_seconds(20.0));
    let terms = RunTerms { first_seed: None, runs: 50, jobs: 2, until };
    let rows = fly_runs(&mission, &means, &terms, || false).unwrap();
    assert!(!rows.is_empty() && rows.len() < 50, "{}", rows.len());
    assert!(rows.iter().all(|row| row.outcome == RunOutcome::Lost && row.reason == "the time limit was reached"));
    assert_eq!(rows[0].seed, mission.settings.seed);
}

#[test]
fn numbers_out_of_range_are_refused() {
    let (mission, means) = (mission("first-picture"), means());
    for (runs, jobs) in [(0, 1), (1, 0), (1, 5_000)] {
        let terms = RunTerms { first_seed: None, runs, jobs, until: None };
        assert!(fly_runs(&mission, &means, &terms, || true).unwrap_err().to_string().contains("cannot be flown"));
    }
}
