//! Pictures that are planned, flown in the simulator, recorded, and scored again from the record. For each manoeuvre of a quadrotor, a
//! helicopter and a fixed-wing mapper the flown result equals the prediction within 5 % in still air and within 10 % in wind.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at an unexpected result")]

use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::{FlightOutcome, MissionFlight};
use apex_mission::recorded::{mission_of, replay, report_of};
use apex_mission::recording;
use apex_mission::report::{MissionValue, Report};
use std::path::Path;
use std::sync::Arc;

const STILL: &str = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n0,3000,0,0,0\n";
const WIND: &str = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n0,3000,250,4,0.05\n";

/// Returns longitude and latitude of a place east and north of the pad, as a GeoJSON position.
fn place(east_m: f64, north_m: f64) -> String {
    let (latitude, longitude) = (40.0 + north_m / 111_034.0, -100.0 + east_m / 85_395.0);
    format!("[{longitude:.6}, {latitude:.6}]")
}

fn feature(properties: &str, geometry: &str, coordinates: &str) -> String {
    format!(
        r#"{{"type": "Feature", "properties": {{{properties}}}, "geometry": {{"type": "{geometry}", "coordinates": {coordinates}}}}}"#
    )
}

/// Returns a point, a line of two pieces and a field; with an oblique view of a second point for a vehicle that hovers.
fn targets(hovers: bool, pixel_m: f64, scale: f64) -> Vec<String> {
    let wanted = |id: &str| format!(r#""id": "{id}", "kind": "inspection", "value": 100, "resolution_m": {pixel_m}"#);
    let at = |east: f64, north: f64| place(scale * east, scale * north);
    let mut all = vec![
        feature(r#""id": "pad", "kind": "base""#, "Point", &place(0.0, 0.0)),
        feature(&wanted("valve"), "Point", &at(260.0, 40.0)),
        feature(
            &wanted("pipe"),
            "LineString",
            &format!("[{}, {}, {}]", at(400.0, 100.0), at(800.0, 140.0), at(1100.0, 400.0)),
        ),
        feature(
            &wanted("field"),
            "Polygon",
            &format!(
                "[[{0}, {1}, {2}, {3}, {0}]]",
                at(300.0, 500.0),
                at(560.0, 500.0),
                at(560.0, 690.0),
                at(300.0, 690.0)
            ),
        ),
    ];
    if hovers {
        let oblique = format!(r#"{}, "look_angle_deg": [30, 50]"#, wanted("facade"));
        all.push(feature(&oblique, "Point", &at(120.0, 420.0)));
    }
    all
}

/// Returns a mission with one vehicle, in a separate folder.
fn mission(folder: &Path, model: &str, winds: &str, targets: &[String]) -> Mission {
    mission_with("", folder, (model, winds), targets)
}

/// Like [`mission`], with one more library.
fn mission_with(library: &str, folder: &Path, (model, winds): (&str, &str), targets: &[String]) -> Mission {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("targets.geojson", &format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, targets.join(",\n")));
    write("winds.csv", winds);
    write(
        "mission.pdl",
        &format!(
            r#"(defapplication "Camera"
  :type native-sim
  :libraries ("vehicle" "aerial-observation" {library})
  :vehicle (sim :model {model} :at pad)
  :start "2026-06-01T17:00:00Z"
  :duration 1h
  :end-margin 5min
  :targets "targets.geojson"
  :forecast "winds.csv"
  :agents ((agent uav-1 :initial-task (see everything))))
(solver auto (index (look at the targets)) :budget 300ms)
(procedure :sequential
  (index (see everything))
  (step up (take off to 120m))
  (step look (look at the targets))
  (step home (return to pad at 120m)))"#
        ),
    );
    Mission::load(folder).unwrap()
}

fn fly(mission: Mission, path: &Path) -> FlightOutcome {
    let mission = Arc::new(mission);
    let mut recorder = apex_simulation::create_record(path, &mission, None).unwrap();
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let terms = MissionFlight::terms(&mission, None);
    apex_simulation::fly(Arc::clone(&mission), means, None, terms, &mut recorder, &mut []).unwrap()
}

/// Compares the plan and the flight of every look. Points must agree within `share`. The time from the end of the previous visit to the
/// end of this one must agree within `share` or three seconds.
fn compare(name: &str, report: &Report, share: f64) -> usize {
    const SECONDS: f64 = 3.0;
    let MissionValue::Score(score) = &report.value else { panic!("of another kind") };
    let mut before: Option<(f64, f64)> = None;
    let mut looks: Vec<_> = score.looks.iter().filter_map(|look| Some((look, look.predicted.as_ref()?))).collect();
    looks.sort_by(|a, b| a.1.begin_s.total_cmp(&b.1.begin_s));
    for (look, predicted) in &looks {
        let visit = report.visits.iter().find(|visit| visit.target == look.id).unwrap();
        let end_s = visit.end.unwrap_or_else(|| panic!("{name}: {}", report.text())).seconds();
        let (flown, quality) = (&look.flown.factors, &predicted.quality);
        let factors = [
            ("coverage", flown.coverage, quality.coverage.factor),
            ("resolution", flown.resolution, quality.resolution.factor),
            ("clarity", flown.clarity, quality.clarity.factor),
        ];
        for (factor, flown, predicted) in factors {
            let off = (flown - predicted).abs();
            println!("{name} {} {factor}: {flown:.3} flown, {predicted:.3} predicted", look.id);
            assert!(off <= share, "{name} {}: {factor} {flown} flown, {predicted} predicted", look.id);
        }
        if let Some((planned_s, flown_s)) = before {
            let (planned_s, flown_s) = (predicted.end_s - planned_s, end_s - flown_s);
            println!("{name} {}: {flown_s:.1} s flown, {planned_s:.1} s planned", look.id);
            let off = (flown_s - planned_s).abs();
            assert!(off <= (share * planned_s).max(SECONDS), "{name} {}: {flown_s} s, planned {planned_s} s", look.id);
        }
        before = Some((predicted.end_s, end_s));
    }
    looks.len()
}

#[test]
fn pictures_give_what_the_plan_predicted_in_the_time_that_it_predicted() {
    let vehicles = [("quadrotor", true, 0.01, 1.0), ("rmax", true, 0.06, 1.0), ("fixed-wing-mapper", false, 0.04, 1.6)];
    for (model, hovers, pixel_m, scale) in vehicles {
        for (winds, share) in [(STILL, 0.05), (WIND, 0.10)] {
            let folder = tempfile::tempdir().unwrap();
            let wanted = targets(hovers, pixel_m, scale);
            let path = folder.path().join("flight.apex");
            let loaded = mission(folder.path(), model, winds, &wanted);
            let flown = fly(loaded, &path);
            println!("{}", flown.report.text());
            let looks = compare(&format!("{model}, {share}"), &flown.report, share);
            assert_eq!(looks, wanted.len() - 1, "{model}: {}", flown.report.text());
            // The flight ends at home, on the ground.
            assert_eq!(flown.report.end.1, "the initial task is done", "{model}");
            // The report from the record alone equals that of the flight byte for byte.
            let (reader, warning) = recording::open(&path).unwrap();
            assert_eq!(warning, None);
            let recorded = mission_of(&reader).unwrap().unwrap();
            assert_eq!(report_of(&reader, &recorded).unwrap().text(), flown.report.text(), "{model}");
            assert_eq!(replay(&reader).unwrap().difference, None, "{model}");
        }
    }
}

/// Returns the stated reason why a mission leaves its only target unobserved.
fn reason(model: &str, targets: &[String]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let pad = feature(r#""id": "pad", "kind": "base""#, "Point", &place(0.0, 0.0));
    let all: Vec<String> = std::iter::once(&pad).chain(targets).cloned().collect();
    let loaded = mission(folder.path(), model, STILL, &all);
    let flown = fly(loaded, &folder.path().join("flight.apex"));
    let [(_, reason)] = flown.report.left_out.as_slice() else { panic!("{}", flown.report.text()) };
    reason.clone()
}

#[test]
fn a_camera_that_does_not_fit_is_named_with_what_would_do() {
    let point = |properties: &str| {
        feature(&format!(r#""id": "valve", "kind": "inspection", {properties}"#), "Point", &place(300.0, 0.0))
    };
    let fine = reason("quadrotor", &[point(r#""resolution_m": 0.001"#)]);
    assert!(fine.contains("`camera-1` needs 15 m above it or lower for pixels of 0.001 m"), "{fine}");
    assert!(fine.contains("the vehicle stays 39 m above it (requirement terrain); 0.005 m works"), "{fine}");
    let steep = reason("rmax", &[point(r#""look_angle_deg": [0, 5], "camera": "camera-2""#)]);
    assert!(steep.contains("`camera` is `camera-2`, the vehicle `rmax` carries: camera-1"), "{steep}");
    let fixed = reason("fixed-wing-mapper", &[point(r#""look_angle_deg": [30, 50]"#)]);
    assert!(fixed.contains("look straight down, `look_angle_deg` requires 30 degrees at least"), "{fixed}");
    let line = feature(
        r#""id": "wall", "kind": "inspection", "look_angle_deg": [40, 60]"#,
        "LineString",
        &format!("[{}, {}]", place(100.0, 0.0), place(300.0, 0.0)),
    );
    let line = reason("quadrotor", &[line]);
    assert!(line.contains("give points for oblique looks"), "{line}");
    let far = feature(r#""id": "dam", "kind": "inspection""#, "Point", &place(26_000.0, 0.0));
    let far = reason("quadrotor", &[point(r#""resolution_m": 0.02"#), far]);
    assert!(far.contains("the battery leaves: it has") && far.contains("above its reserve"), "{far}");
}

#[test]
fn each_of_forty_targets_can_be_observed() {
    let folder = tempfile::tempdir().unwrap();
    let mut targets = vec![feature(r#""id": "pad", "kind": "base""#, "Point", &place(0.0, 0.0))];
    for number in 0..40_u32 {
        let (east, north) = (200.0 * f64::from(number % 8), 300.0 * f64::from(number / 8));
        let wanted = format!(r#""id": "t{number}", "kind": "inspection", "value": 10, "resolution_m": 0.02"#);
        targets.push(match number % 4 {
            0 => feature(
                &wanted,
                "LineString",
                &format!("[{}, {}]", place(east, north), place(east + 150.0, north + 80.0)),
            ),
            1 => feature(
                &wanted,
                "Polygon",
                &format!(
                    "[[{0}, {1}, {2}, {3}, {0}]]",
                    place(east, north),
                    place(east + 120.0, north),
                    place(east + 120.0, north + 150.0),
                    place(east, north + 150.0)
                ),
            ),
            _ => feature(&wanted, "Point", &place(east, north)),
        });
    }
    let mission = mission(folder.path(), "quadrotor", WIND, &targets);
    let problem = apex_mission::problem::pose(
        &mission,
        &apex_mission::situation::Situation::default(),
        None,
        apex_model::time::Time::ZERO,
    );
    let apex_model::problem::Problem::SingleVisit(problem) = problem.unwrap() else { panic!("of another kind") };
    assert_eq!(problem.targets.len(), 40);
    let unobservable: Vec<_> = problem.targets.iter().filter(|target| target.manoeuvres.is_empty()).collect();
    assert!(unobservable.is_empty(), "{unobservable:?}");
}

/// An oblique view of a field: lines and hovers cannot give one, but a manoeuvre of the library can, as the plan predicts.
#[test]
fn a_planned_manoeuvre_sees_obliquely_what_lines_and_hovers_cannot() {
    let wanted =
        r#""id": "field", "kind": "inspection", "value": 100, "resolution_m": 0.3, "look_angle_deg": [30, 60]"#;
    let ring = format!(
        "[[{0}, {1}, {2}, {3}, {0}]]",
        place(300.0, 300.0),
        place(324.0, 300.0),
        place(324.0, 324.0),
        place(300.0, 324.0)
    );
    let pad = feature(r#""id": "pad", "kind": "base""#, "Point", &place(0.0, 0.0));
    let targets = [pad, feature(wanted, "Polygon", &ring)];
    let folder = tempfile::tempdir().unwrap();
    let without = mission(folder.path(), "rmax", STILL, &targets);
    let posed = |mission: &Mission| {
        let situation = apex_mission::situation::Situation::default();
        apex_mission::problem::pose(mission, &situation, None, apex_model::time::Time::ZERO)
    };
    let why = posed(&without).unwrap_err().to_string();
    assert!(why.contains("give points for oblique looks"), "{why}");
    for (winds, share) in [(STILL, 0.05), (WIND, 0.10)] {
        let folder = tempfile::tempdir().unwrap();
        let with = mission_with("\"manoeuvres\"", folder.path(), ("rmax", winds), &targets);
        let apex_model::problem::Problem::SingleVisit(problem) = posed(&with).unwrap() else {
            panic!("of another kind")
        };
        let ways = &problem.targets[0].manoeuvres;
        assert!(!ways.is_empty() && ways.iter().all(|way| way.pictures.as_ref().unwrap().form.is_some()), "{ways:?}");
        let path = folder.path().join("flight.apex");
        let flown = fly(with, &path);
        println!("{}", flown.report.text());
        assert_eq!(compare("oblique", &flown.report, share), 1, "{}", flown.report.text());
        let (reader, _) = recording::open(&path).unwrap();
        assert_eq!(replay(&reader).unwrap().difference, None);
    }
}

/// The nearest miss is in the plan, next to the targets that are visited.
#[test]
fn a_plan_names_the_targets_that_nothing_sees() {
    let point = |id: &str, pixel_m: f64, north_m: f64| {
        let wanted = format!(r#""id": "{id}", "kind": "inspection", "value": 100, "resolution_m": {pixel_m}"#);
        feature(&wanted, "Point", &place(300.0, north_m))
    };
    let pad = feature(r#""id": "pad", "kind": "base""#, "Point", &place(0.0, 0.0));
    let targets = [pad, point("valve", 0.02, 0.0), point("screw", 0.001, 200.0)];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.apex");
    let flown = fly(mission(folder.path(), "quadrotor", STILL, &targets), &path);
    let (reader, _) = recording::open(&path).unwrap();
    let recorded = mission_of(&reader).unwrap().unwrap();
    let end = apex_model::time::Time::END;
    let changes = apex_mission::recorded::situation_at(&reader, &recorded, end).unwrap().target_changes;
    let skipped = changes.iter().find(|change| change.target == "screw").unwrap();
    assert!(skipped.detail.contains("needs 15 m above it or lower for pixels of 0.001 m"), "{skipped:?}");
    assert_eq!(flown.report.left_out.len(), 1, "{}", flown.report.text());
}
