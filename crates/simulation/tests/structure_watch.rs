//! `structure-watch` works as designed: it looks with its camera, plans again after every update and when the wind differs from the
//! forecast, asks the operator about smoke with a deadline and a default answer, and ends when its own plan ends.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at an unexpected result")]

use apex_geo::geodesy;
use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::{FlightOutcome, MissionFlight};
use apex_mission::report::MissionValue;
use apex_mission::situation::Situation;
use apex_model::effect::Effect;
use apex_model::event::{Batch, EventKind};
use apex_model::planned::Location;
use apex_model::problem::{Position, Problem};
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::Observer;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::TempDir;

#[path = "support/shipped.rs"]
mod shipped;

fn shipped() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/structure-watch")
}

/// Returns a copy of the mission whose planner has a tenth of the budget.
fn planned_quickly() -> TempDir {
    shipped::copy_with("structure-watch", &[(":budget 500ms", ":budget 50ms")])
}

fn fly(mission: Mission) -> FlightOutcome {
    fly_in(mission, None, &mut [])
}

fn fly_in(mission: Mission, seed: Option<u64>, observers: &mut [&mut dyn Observer]) -> FlightOutcome {
    let mission = Arc::new(mission);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("watch.apex");
    let mut recorder = apex_simulation::create_record(&path, &mission, seed).unwrap();
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let terms = MissionFlight::terms(&mission, None);
    apex_simulation::fly(Arc::clone(&mission), means, seed, terms, &mut recorder, observers).unwrap()
}

/// Returns the instant of the first note with this beginning, in seconds.
fn noted_s(flown: &FlightOutcome, text: &str) -> f64 {
    let note = flown.report.notes.iter().find(|note| note.text.starts_with(text));
    note.unwrap_or_else(|| panic!("no note `{text}`:\n{}", flown.report.text())).at.seconds()
}

#[test]
fn every_update_and_the_wind_lead_to_a_new_plan_and_every_look_to_a_picture() {
    let flown = fly(Mission::load(&shipped()).unwrap());
    let updates = [
        ("new target: camp", "replanning wanted: camp"),
        ("no longer a target: cabin-east", "replanning wanted: cabin-east"),
        ("winery is worth 300", "replanning wanted: winery"),
        ("sawmill: 0.8 events per hour", "replanning wanted: sawmill"),
        ("new forecast: winds-actual.csv", "replanning wanted: \"winds-actual.csv\""),
    ];
    for (update, plan) in updates {
        let (update_s, plan_s) = (noted_s(&flown, update), noted_s(&flown, plan));
        assert!((0.0..=300.0).contains(&(plan_s - update_s)), "{update} at {update_s} s, {plan} at {plan_s} s");
    }
    // The wind rises at 24 min and is stronger than forecast for a minute then.
    let wind_s = noted_s(&flown, "replanning wanted: wind-as-forecast");
    assert!((1_500.0..1_860.0).contains(&wind_s), "{wind_s}");
    // Smoke is seen at 1,680 s. No answer comes for 90 s, so the default applies.
    let smoke_s = noted_s(&flown, "sawmill: 0.8 events per hour");
    assert!((smoke_s - 1_770.0).abs() < 2.0, "{smoke_s}");
    assert!(flown.report.plans >= 7, "{}", flown.report.plans);
    let MissionValue::Ignorance(cost, looks) = &flown.report.value else { panic!("of another kind") };
    let visits: usize = looks.iter().map(|site| site.visits).sum();
    let seen: usize = looks.iter().map(|site| site.seen).sum();
    let counted: usize = cost.targets.iter().map(|target| target.observations).sum();
    assert!(visits >= 15 && visits == seen, "{visits} visits, {seen} with a picture");
    assert!(counted <= seen, "{counted} observations of {seen} pictures");
    // The camp was not known at the start and is watched.
    assert!(looks.iter().any(|site| site.target == "camp" && site.seen > 0), "{}", flown.report.text());
    // Pixels of 5 cm are required, from a hover straight above.
    for site in looks.iter().filter(|site| site.seen > 0) {
        let pixel_m = site.pixel_m.unwrap();
        assert!(pixel_m > 0.02 && pixel_m <= 0.05, "{site:?}");
        assert!(site.look_angle_deg.unwrap() < 5.0 && site.quality > 0.99, "{site:?}");
    }
}

/// Commanded ways that are much longer than the distance to their end, in metres: `(distance, way)`.
#[derive(Default)]
struct Detours {
    here: Option<Position>,
    found: Vec<(f64, f64)>,
}

impl Observer for Detours {
    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        for event in &batch.events {
            if let EventKind::Measurement(variable, value) = &event.kind
                && variable.attribute.is("location")
            {
                self.here = Location::from_value(value).map(|at| at.position).or(self.here);
            }
        }
        for effect in effects {
            if let Effect::Command { form, .. } = effect
                && let Some([Value::Symbol(head), to, Value::Symbol(via), Value::List(points), ..]) = form.as_list()
                && head.is("fly-to")
                && via.is(":via")
                && let (Some(here), Some(to)) = (self.here, Location::from_value(to))
            {
                let points = points.iter().filter_map(Location::from_value).map(|at| at.position);
                let way: Vec<Position> = std::iter::once(here).chain(points).chain([to.position]).collect();
                let way_m = way.iter().zip(way.iter().skip(1)).map(|(a, b)| geodesy::distance_m(*a, *b)).sum::<f64>();
                let distance_m = geodesy::distance_m(here, to.position);
                if way_m > 3.0 * distance_m + 300.0 {
                    self.found.push((distance_m, way_m));
                }
            }
        }
        Ok(())
    }
}

/// Bends of planned ways are stated to about a metre: a leg between them must not be a little too near to a corner to be flown.
#[test]
fn planned_ways_around_obstacles_are_flown_without_detours() {
    let mut detours = Detours::default();
    fly_in(Mission::load(planned_quickly().path()).unwrap(), None, &mut [&mut detours]);
    assert_eq!(detours.found, Vec::new());
}

/// Sites of fires that pictures showed, with the instants.
#[derive(Default)]
struct Sightings(Vec<(String, f64)>);

impl Observer for Sightings {
    fn observe(&mut self, batch: &Batch, _: &[Effect]) -> Result<(), String> {
        for event in &batch.events {
            if let EventKind::Occurrence(form) = &event.kind
                && let Some([Value::Symbol(head), Value::Symbol(site)]) = form.as_list()
                && head.is("fire-sighted")
            {
                self.0.push((site.folded().to_string(), event.at.seconds()));
            }
        }
        Ok(())
    }
}

#[test]
fn a_fire_that_a_picture_shows_is_likelier_to_burn_again_and_leads_to_a_new_plan() {
    let mut count = 0;
    for seed in 2..=4 {
        let mut sightings = Sightings::default();
        let flown = fly_in(Mission::load(planned_quickly().path()).unwrap(), Some(seed), &mut [&mut sightings]);
        // The last plan is made some minutes before the end of the watch.
        for (site, seen_s) in sightings.0.iter().filter(|(_, seen_s)| *seen_s < 2_700.0) {
            count += 1;
            let after =
                |text: &str| {
                    flown.report.notes.iter().any(|note| {
                        (*seen_s..=seen_s + 300.0).contains(&note.at.seconds()) && note.text.starts_with(text)
                    })
                };
            let text = flown.report.text();
            assert!(after(&format!("{site}: 0.8 events per hour")), "{site} at {seen_s} s, seed {seed}\n{text}");
            assert!(after("replanning wanted"), "{site} at {seen_s} s, seed {seed}\n{text}");
        }
    }
    assert!(count >= 1, "no fire was seen in three flights");
}

#[test]
fn the_planner_plans_to_the_end_of_the_watch() {
    let mission = Mission::load(&shipped()).unwrap();
    let problem =
        apex_mission::problem::pose(&mission, &Situation::default(), None, Time::from_seconds(300.0)).unwrap();
    let Problem::Surveillance(problem) = problem else { panic!("of another kind") };
    assert!((problem.horizon_s - (55.0 * 60.0 - 300.0)).abs() < 1e-9, "{}", problem.horizon_s);
}

#[test]
fn a_camera_that_sees_too_coarsely_observes_nothing() {
    let folder = planned_quickly();
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let entry = entry.unwrap();
        let text = std::fs::read_to_string(entry.path()).unwrap();
        // The helicopter stays 39 m above the ground: 2.5 cm are the finest pixels.
        let text = text.replace("\"resolution_m\": 0.05", "\"resolution_m\": 0.01");
        std::fs::write(entry.path(), text).unwrap();
    }
    let flown = fly(Mission::load(folder.path()).unwrap());
    let MissionValue::Ignorance(cost, looks) = &flown.report.value else { panic!("of another kind") };
    assert_eq!(looks.iter().map(|site| site.visits).sum::<usize>(), 0, "visits that show nothing are not planned");
    let left_out = &flown.report.left_out;
    assert!(left_out.iter().any(|(_, why)| why.contains("pixels of 1.0 cm are wanted")), "{left_out:?}");
    assert_eq!(looks.iter().map(|site| site.seen).sum::<usize>(), 0, "{}", flown.report.text());
    assert_eq!(cost.targets.iter().map(|target| target.observations).sum::<usize>(), 0);
}
