//! Surveillance plans count only visits that can give a valid picture: by daylight, and from where the camera sees the site.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

use apex_mission::Mission;
use apex_mission::problem::{NoPlan, pose};
use apex_mission::situation::Situation;
use apex_model::problem::{Problem, SurveillanceProblem};
use apex_model::time::Time;

/// Returns two sites 300 m and 600 m north of the field at 46 N, 8 E, watched for an hour from `start` on.
fn mission(model: &str, start: &str) -> Mission {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    put(
        "places.geojson",
        r#"{"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {"id": "home", "kind": "base"}, "geometry": {"type": "Point", "coordinates": [8, 46]}},
            {"type": "Feature", "properties": {"id": "barn", "kind": "structure", "importance": 100, "rate_per_h": 0.3, "dwell_s": 30},
             "geometry": {"type": "Point", "coordinates": [8, 46.0027]}},
            {"type": "Feature", "properties": {"id": "mill", "kind": "structure", "importance": 100, "rate_per_h": 0.3, "dwell_s": 30},
             "geometry": {"type": "Point", "coordinates": [8, 46.0054]}}]}"#,
    );
    put(
        "mission.pdl",
        &format!(
            r#"(defapplication "Sites"
  :type native-sim
  :libraries ("vehicle" "aerial-observation")
  :vehicle (sim :model {model} :at home)
  :start "{start}"
  :duration 1h
  :targets "places.geojson"
  :agents ((agent uav-1 :initial-task (watch them))))
(procedure (index (watch them)) (step done (terminate)))"#
        ),
    );
    Mission::load(folder.path()).unwrap_or_else(|error| panic!("{error:?}"))
}

fn problem(model: &str, start: &str) -> Result<SurveillanceProblem, NoPlan> {
    match pose(&mission(model, start), &Situation::default(), None, Time::ZERO)? {
        Problem::Surveillance(problem) => Ok(problem),
        Problem::SingleVisit(_) => panic!("of another kind"),
    }
}

/// At 46 N, 8 E on 1 June 2026 the sun rises at about 03:38 UTC and sets at about 19:10 UTC.
#[test]
fn visits_end_with_the_daylight_that_the_camera_needs() {
    let noon = problem("quadrotor", "2026-06-01T11:00:00Z").unwrap();
    let dusk = problem("quadrotor", "2026-06-01T18:50:00Z").unwrap();
    let (left_s, all_s) = (dusk.endurance_s.unwrap(), noon.endurance_s.unwrap_or(f64::INFINITY));
    assert!((600.0..1_500.0).contains(&left_s) && all_s > left_s, "{left_s}");
    assert_eq!(dusk.horizon_s, noon.horizon_s, "ignorance costs until the end");
}

#[test]
fn visits_begin_with_the_daylight_that_the_camera_needs() {
    let dawn = problem("quadrotor", "2026-06-01T03:20:00Z").unwrap();
    let first_s = dawn.travel.from_start_s.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((700.0..1_800.0).contains(&first_s), "{first_s}");
    match problem("quadrotor", "2026-06-01T23:00:00Z") {
        Err(NoPlan::NothingLeft(why)) => assert!(why.contains("no band for the night"), "{why}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn visits_of_a_vehicle_whose_sensors_cannot_see_sites_are_not_planned() {
    for (model, what) in [("fixed-wing-mapper", "(camera-1)"), ("global-hawk", "none of its sensors")] {
        match problem(model, "2026-06-01T11:00:00Z") {
            Err(NoPlan::NothingLeft(why)) => assert!(why.contains("turned sideways") && why.contains(what), "{why}"),
            other => panic!("{other:?}"),
        }
    }
    assert!(problem("predator-b", "2026-06-01T11:00:00Z").is_ok());
}
