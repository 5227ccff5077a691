//! Flights over known terrain. Heights above ground are computed here, from the recorded locations and the formula of the ground.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a failed test should stop")]
#![allow(clippy::disallowed_methods, reason = "this check computes heights apart from the product")]

use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::MissionFlight;
use apex_mission::recorded;
use apex_mission::report::{MissionValue, Report};
use apex_model::event::EventKind;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::record::RecordReader;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

/// Returns the ground elevation: 500 m, with a ridge from west to east along 37.5 N, 2,600 m higher and about 15 km wide, with a pass at
/// 116.0 W.
fn ground_m(latitude_deg: f64, longitude_deg: f64) -> f64 {
    let across = (latitude_deg - 37.5) / 0.07;
    let from_pass = (longitude_deg + 116.0) / 0.12;
    500.0 + 2_600.0 * (-across * across).exp() * (1.0 - 0.8 * (-from_pass * from_pass).exp())
}

/// Returns the ground as an ASCII grid of 0.01 degrees around 37.4 N 117 W.
fn grid() -> String {
    let (columns, rows, step) = (301, 181, 0.01);
    let (west, south) = (-118.5, 36.5);
    let mut text = format!(
        "ncols {columns}\nnrows {rows}\nxllcenter {west}\nyllcenter {south}\ncellsize {step}\nNODATA_value -9999\n"
    );
    for row in (0..rows).rev() {
        for column in 0..columns {
            let elevation_m = ground_m(south + step * f64::from(row), west + step * f64::from(column));
            write!(text, "{elevation_m:.1} ").unwrap();
        }
        text.push('\n');
    }
    text
}

const PLACES: &str = r#"{"type": "FeatureCollection", "features": [
 {"type": "Feature", "properties": {"id": "home", "kind": "base"}, "geometry": {"type": "Point", "coordinates": [-117.0, 37.1]}},
 {"type": "Feature", "properties": {"id": "burn", "kind": "fire", "acres": 3000, "value": 50, "resolution_m": 5},
  "geometry": {"type": "Point", "coordinates": [-117.0, 37.9]}},
 {"type": "Feature", "properties": {"id": "slope", "kind": "fire", "acres": 3000, "value": 50, "resolution_m": 5},
  "geometry": {"type": "Point", "coordinates": [-117.2, 37.53]}}]}"#;

fn write(folder: &Path, options: &str, body: &str, targets: &str) {
    let text = format!(
        "(defapplication \"Ridge\" :type native-sim :libraries (\"vehicle\" \"aerial-observation\" \"contingencies\") {options}\n \
         :targets \"places.geojson\" :terrain \"ground.asc\" :agents ((agent uav-1 :initial-task (fly the mission))))\n\
         (solver auto (index (map the fires)) :budget 200ms)\n\
         (primitive (index (dash to ?place)) (profile flight-path) (on-start (command (fly-to ?place) :timeout 10h)))\n{body}"
    );
    std::fs::write(folder.join("mission.pdl"), text).unwrap();
    std::fs::write(folder.join("places.geojson"), targets).unwrap();
    std::fs::write(folder.join("ground.asc"), grid()).unwrap();
}

/// A recorded flight.
struct Flown {
    report: Report,
    /// Time, height over ground, altitude.
    heights_m: Vec<(f64, f64, f64)>,
    events: Vec<(f64, String)>,
    clearance_m: f64,
}

fn fly(options: &str, body: &str) -> Flown {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), options, body, PLACES);
    let mission = Arc::new(Mission::load(folder.path()).unwrap_or_else(|error| panic!("{error:?}")));
    let record = folder.path().join("flight.apex");
    let mut recorder = apex_simulation::create_record(&record, &mission, None).unwrap();
    let terms = MissionFlight::terms(&mission, None);
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let outcome = apex_simulation::fly(Arc::clone(&mission), means, None, terms, &mut recorder, &mut []).unwrap();
    drop(recorder);
    let reader = RecordReader::open(&record).unwrap();
    let (mut heights_m, mut events) = (Vec::new(), Vec::new());
    for step in reader.steps_of_all(Time::END).unwrap() {
        for event in step.unwrap().batch.events {
            let at_s = event.at.seconds();
            match event.kind {
                EventKind::Measurement(variable, Value::List(items)) if variable.attribute.is("location") => {
                    let number = |index: usize| items[index].as_number().unwrap().0;
                    heights_m.push((at_s, number(2) - ground_m(number(0), number(1)), number(2)));
                }
                EventKind::Occurrence(form) => events.push((at_s, form.to_string())),
                _ => {}
            }
        }
    }
    let replayed = recorded::replay(&reader).unwrap();
    assert_eq!(replayed.difference, None, "{replayed}");
    let clearance_m = mission.requirements.terrain_clearance_m.unwrap();
    Flown { report: outcome.report, heights_m, events, clearance_m }
}

impl Flown {
    fn at_s(&self, head: &str) -> Option<f64> {
        self.events.iter().find(|(_, text)| text.starts_with(&format!("({head} "))).map(|(at_s, _)| *at_s)
    }

    /// Returns the least height above ground between the climb from the airfield and the approach to it.
    fn least_m(&self) -> f64 {
        let from_s = self.at_s("airborne").unwrap() + 300.0;
        let until_s = self.at_s("landed").map_or(f64::INFINITY, |landed_s| landed_s - 900.0);
        let under_way = self.heights_m.iter().filter(|(at_s, ..)| (from_s..until_s).contains(at_s));
        under_way.map(|(_, height_m, _)| *height_m).fold(f64::INFINITY, f64::min)
    }
}

#[test]
fn a_survey_beyond_a_ridge_keeps_its_clearance_and_scores_the_slope() {
    let flown = fly(
        ":vehicle (sim :model predator-b :at home) :duration 5h",
        "(procedure (index (fly the mission)) (step up (take off to 1500m)) \
           (step survey (map the fires) (waitfor (end ?up))) (step guard (guard the flight)) \
           (step home (return to home at 1500m) (waitfor (end ?survey))) (step finish (terminate) (waitfor (end ?home))))",
    );
    assert!(flown.at_s("landed").is_some(), "{}\n{:?}", flown.report.text(), flown.events);
    assert_eq!(flown.at_s("requirement-broken"), None, "{:?}", flown.events);
    let least_m = flown.least_m();
    assert!(least_m >= flown.clearance_m, "{least_m} m over ground, clearance {} m", flown.clearance_m);
    let MissionValue::Score(score) = &flown.report.value else { panic!("no score") };
    let looks = |id: &str| score.looks.iter().find(|look| look.id == id);
    for id in ["burn", "slope"] {
        let look = looks(id).unwrap();
        assert!(look.flown.factors.coverage > 0.95, "{id}: {:?}", look.flown.factors);
    }
}

#[test]
fn an_aircraft_that_is_sent_against_a_ridge_climbs_over_it_in_time() {
    let flown = fly(
        ":vehicle (sim :model predator-b :at home) :duration 2h",
        "(procedure :sequential (index (fly the mission)) (step up (take off to 2000m)) (step work (work)))\n\
         (procedure (index (work)) (step guard (guard the flight)) (step go (dash to (37.9 -117.0 2000))) \
           (step end (terminate) (waitfor (:delay 30min))))",
    );
    let alarm = flown.events.iter().find(|(_, text)| text.starts_with("(requirement-at-risk ")).unwrap();
    assert!(alarm.1.starts_with("(requirement-at-risk terrain \"ground\""), "{}", alarm.1);
    let least_m = flown.least_m();
    assert!(least_m >= flown.clearance_m, "{least_m} m over ground, clearance {} m", flown.clearance_m);
    let highest_m = flown.heights_m.iter().map(|(.., altitude_m)| *altitude_m).fold(0.0, f64::max);
    assert!(highest_m < 4_200.0, "{highest_m} m: higher than the ridge asks for");
}

#[test]
fn terrain_and_places_must_agree() {
    let refused = |options: &str, targets: &str| {
        let folder = tempfile::tempdir().unwrap();
        let body = "(procedure (index (fly the mission)) (step end (terminate)))";
        write(folder.path(), options, body, targets);
        let error = Mission::load(folder.path()).unwrap_err();
        assert!(error.help.is_some() && error.place.is_some(), "{error:?}");
        format!("{} {} {}", error.place.as_deref().unwrap(), error.message, error.reason.unwrap_or_default())
    };
    let vehicle = ":vehicle (sim :model predator-b :at home)";
    let outside = refused(vehicle, &PLACES.replace("37.9]", "39.9]"));
    assert!(outside.contains("places.geojson") && outside.contains("does not cover `burn`"), "{outside}");
    let half_outside = refused(vehicle, &PLACES.replace("[-117.0, 37.9]", "[-115.51, 37.9]"));
    assert!(half_outside.contains("does not cover `burn`"), "{half_outside}");
    let other = refused(vehicle, &PLACES.replace("\"kind\": \"base\"", "\"kind\": \"base\", \"elevation_m\": 2900"));
    assert!(other.contains("`home`") && other.contains("2900 m") && other.contains("500 m"), "{other}");
    let start = refused(":vehicle (sim :model predator-b :at (20.0 -117.0))", PLACES);
    assert!(start.contains("does not cover the start"), "{start}");
}

/// Hills of a helicopter's inspection: the ground rises and falls by 22 m within 220 m.
fn hills() -> String {
    let mut text =
        String::from("ncols 100\nnrows 60\nxllcorner -121.14\nyllcorner 37.4\ncellsize 0.0005\nNODATA_value -9999\n");
    for _ in 0..60 {
        for column in 0..100_u32 {
            let step = column % 10;
            write!(text, "{:.1} ", 5.0 + 4.4 * f64::from(step.min(10 - step))).unwrap();
        }
        text.push('\n');
    }
    text
}

/// A plan holds only manoeuvres that keep the clearance along their paths: a path over higher ground than the target's was planned, and
/// refused when it was to be flown.
#[test]
fn planned_manoeuvres_over_hills_are_flown() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    put("hills.asc", &hills());
    let point = |id: &str, rest: &str, east_deg: f64, north_deg: f64| {
        format!(
            r#"{{"type": "Feature", "properties": {{"id": "{id}", {rest}}},
               "geometry": {{"type": "Point", "coordinates": [{east_deg}, {north_deg}]}}}}"#
        )
    };
    let look = r#""kind": "inspection", "value": 10, "resolution_m": 0.03"#;
    let places = [
        point("pad", r#""kind": "base""#, -121.123_75, 37.411_35),
        point("p0", look, -121.117_13, 37.414_77),
        point("p1", look, -121.115_34, 37.415_74),
        point("p2", look, -121.111_87, 37.407_01),
    ];
    put("places.geojson", &format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, places.join(",")));
    put(
        "mission.pdl",
        r#"(defapplication "Hills" :type native-sim
  :libraries ("vehicle" "aerial-observation" "manoeuvres" "contingencies")
  :vehicle (sim :model rmax :at pad) :start "2026-08-18T20:00:00Z" :duration 60min :end-margin 5min
  :targets "places.geojson" :terrain "hills.asc" :agents ((agent a :initial-task (go all))))
(solver auto (index (inspect the sites)) :budget 300ms)
(procedure :sequential (index (go all))
  (step up (take off to 80m))
  (step survey (inspect the sites))
  (step home (return to pad at 80m)))"#,
    );
    let mission = Arc::new(Mission::load(folder.path()).unwrap_or_else(|error| panic!("{error:?}")));
    let mut recorder = apex_simulation::create_record(&folder.path().join("flight.apex"), &mission, None).unwrap();
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let terms = MissionFlight::terms(&mission, None);
    let flown = apex_simulation::fly(mission, means, None, terms, &mut recorder, &mut []).unwrap();
    let observed = flown.report.visits.iter().filter(|visit| visit.end.is_some()).count();
    assert_eq!((observed, &flown.report.left_out), (3, &Vec::new()), "{:#?}", flown.report.notes);
    let MissionValue::Score(score) = &flown.report.value else { panic!("no score") };
    assert!(score.benefits > 25.0, "{} of 30 points", score.benefits);
}
