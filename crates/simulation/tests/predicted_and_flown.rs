//! A fire that is planned, flown in the simulator, recorded, and scored again from the record: in still air the flight matches the
//! prediction.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test stops at an unexpected result")]

use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::MissionFlight;
use apex_mission::recorded::{mission_of, replay, report_of};
use apex_mission::recording;
use apex_mission::report::MissionValue;
use apex_mission::situation::Visit;
use std::path::Path;
use std::sync::Arc;

/// Two of the fires of `western-states`, in still, smooth air: one is scanned by lines over it, the other along its perimeter.
const FIRES: [&str; 2] = ["lick", "gw"];

/// Fires in wind: far from each other, with several lines each.
const FAR_FIRES: [&str; 5] = ["butler-2", "zaca", "lick", "moonlight", "egley-complex"];
/// Permitted difference between planned and flown begin of an observation, in a flight of six hours. It covers the first descent, and
/// turns that are planned longer than they are flown.
const BEGIN_S: f64 = 120.0;

fn mission() -> Mission {
    mission_of_fires(&FIRES, true)
}

/// `western-states` with these fires and without events, in still air or with the forecast winds.
fn mission_of_fires(fires: &[&str], is_still: bool) -> Mission {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/western-states");
    let mission = Mission::load(&folder).unwrap();
    let mut data: Vec<_> = mission.data.iter().cloned().collect();
    let forecast = data.iter().find(|(name, _)| name == "winds-forecast.csv").unwrap().1.clone();
    for (name, bytes) in &mut data {
        match name.as_str() {
            "fires.geojson" => {
                let mut all: serde_json::Value = serde_json::from_slice(bytes).unwrap();
                let keeps =
                    |feature: &serde_json::Value| fires.contains(&feature["properties"]["id"].as_str().unwrap());
                all["features"].as_array_mut().unwrap().retain(keeps);
                *bytes = all.to_string().into_bytes();
            }
            "winds-actual.csv" if !is_still => *bytes = forecast.clone(),
            "winds-forecast.csv" | "winds-actual.csv" if is_still => {
                *bytes = b"altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps\n0,20000,0,0\n".to_vec();
            }
            "scenario.jsonl" => *bytes = b"# Nothing happens.\n".to_vec(),
            _ => {}
        }
    }
    Mission::from_sources(&mission.library.sources, data).unwrap()
}

/// Returns the observations whose lines and turns took longer or shorter than planned by more than this share. Instants are those of the
/// simulator's steps, half a second apart.
fn off_by_more(visits: &[Visit], share: f64) -> Vec<String> {
    let times = visits.iter().map(|visit| {
        let predicted = visit.predicted.as_ref().unwrap();
        let took_s = (visit.end.unwrap() - visit.begin).seconds();
        (&visit.target, took_s, predicted.end_s - predicted.begin_s)
    });
    let told = times.map(|(target, took_s, planned_s)| {
        let told = format!("{target}: {took_s:.0} s flown, {planned_s:.0} s planned");
        println!("{told}");
        (told, (took_s - planned_s).abs() > share * planned_s + 1.0)
    });
    told.filter(|(_, is_off)| *is_off).map(|(told, _)| told).collect()
}

#[test]
fn in_still_air_the_flight_is_worth_what_the_plan_predicted() {
    let mission = Arc::new(mission());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("still.apex");
    let mut recorder = apex_simulation::create_record(&path, &mission, None).unwrap();
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let terms = MissionFlight::terms(&mission, None);
    let flight = apex_simulation::fly(Arc::clone(&mission), means, None, terms, &mut recorder, &mut []).unwrap();
    drop(recorder);
    let MissionValue::Score(score) = &flight.report.value else { panic!("of another kind") };
    assert_eq!(score.looks.len(), FIRES.len(), "{}", flight.report.text());
    for look in &score.looks {
        let predicted = look.predicted.as_ref().unwrap();
        let flown = &look.flown;
        let off = (flown.points - predicted.worth).abs() / flown.value;
        assert!(
            off <= 0.01,
            "{}: {} flown, {} predicted\n{}",
            look.id,
            flown.points,
            predicted.worth,
            flight.report.text()
        );
        println!("{}: {} of {} points", look.id, flown.points, predicted.worth);
    }
    assert_eq!(off_by_more(&flight.report.visits, 0.05), [] as [String; 0]);
    // From the record alone, byte for byte.
    let (reader, warning) = recording::open(&path).unwrap();
    assert_eq!(warning, None);
    let recorded = mission_of(&reader).unwrap().unwrap();
    let again = report_of(&reader, &recorded).unwrap();
    assert_eq!(again.text(), flight.report.text());
    assert_eq!(again.json().to_string(), flight.report.json().to_string());
    let replayed = replay(&reader).unwrap();
    assert_eq!(replayed.difference, None);
}

/// In forecast wind and turbulence, along the planned way: joins, turns between lines, and legs take as long as planned.
#[test]
fn observations_begin_when_the_plan_says() {
    let mission = Arc::new(mission_of_fires(&FAR_FIRES, false));
    let folder = tempfile::tempdir().unwrap();
    let mut recorder = apex_simulation::create_record(&folder.path().join("wind.apex"), &mission, None).unwrap();
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let terms = MissionFlight::terms(&mission, None);
    let flight = apex_simulation::fly(Arc::clone(&mission), means, None, terms, &mut recorder, &mut []).unwrap();
    let visits = &flight.report.visits;
    assert_eq!(visits.len(), FAR_FIRES.len(), "{}", flight.report.text());
    let mut late = Vec::new();
    for visit in visits {
        let predicted = visit.predicted.as_ref().unwrap();
        let late_s = visit.begin.seconds() - predicted.begin_s;
        println!("{}: planned for {:.0} s, flown {late_s:+.0} s", visit.target, predicted.begin_s);
        if late_s.abs() > BEGIN_S {
            late.push((visit.target.clone(), late_s));
        }
    }
    assert_eq!(late, []);
    assert_eq!(off_by_more(visits, 0.10), [] as [String; 0]);
}
