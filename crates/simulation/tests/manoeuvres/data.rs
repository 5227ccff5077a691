//! Handling of data: pictures of a manoeuvre stay on board, are sent as they are taken, or are processed and sent, and are on the ground
//! when predicted.

use super::cases::{STILL, mission};
use super::{acquire, length, word};
use apex_mission::Mission;
use apex_mission::acquisition::{PerformedManoeuvre, forecast, synthesised};
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::{FlightOutcome, MissionFlight};
use apex_mission::report::MissionValue;
use apex_model::event::EventKind;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_observation::manoeuvres::PayloadUse;
use std::path::Path;
use std::sync::Arc;

/// A link of 2 Mbit/s for pictures of 8 Mbit: one takes 4 s.
const LINK: &str = ":downlink (:rate-mbit-s 2 :picture-mbit 8)";
const WORLD: &str = r#"{"format": "apex-world-1",
    "downlink": {"over": "radio", "rate_mbit_s": 2, "picture_mbit": 8, "store_mbit": 4000, "processing_s": 90}}"#;

/// Returns a mission with a downlink, which the application states if `options` do.
fn linked(folder: &Path, goal: &str, options: &str) -> Mission {
    drop(mission(folder, "quadrotor", STILL, (300.0, 40.0, 120.0), goal));
    let file = folder.join("mission.pdl");
    let radio = ":modems ((radio :station pad :full-level 5km :range 9km)) :world \"world.json\"";
    let program =
        std::fs::read_to_string(&file).unwrap().replace(":duration 4h", &format!(":duration 4h {radio} {options}"));
    std::fs::write(&file, program).unwrap();
    std::fs::write(folder.join("world.json"), WORLD).unwrap();
    Mission::load(folder).unwrap()
}

/// Instants at which pictures arrived on the ground, and the reported shares of the store that are used.
#[derive(Default)]
struct Arrivals {
    at_s: Vec<f64>,
    used: Vec<f64>,
}

impl apex_runtime::ports::Observer for Arrivals {
    fn observe(&mut self, batch: &apex_model::event::Batch, _: &[apex_model::effect::Effect]) -> Result<(), String> {
        for event in &batch.events {
            match &event.kind {
                EventKind::Occurrence(form) if form.to_string().starts_with("(image-on-ground camera-1") => {
                    self.at_s.push(batch.now.seconds());
                }
                EventKind::Measurement(variable, Value::Real(share)) if variable.attribute.is("store-used") => {
                    self.used.push(*share);
                }
                _ => {}
            }
        }
        Ok(())
    }
}

fn fly(mission: Mission, folder: &Path) -> (FlightOutcome, Vec<f64>) {
    let (flight, arrivals) = fly_observed(mission, folder);
    (flight, arrivals.at_s)
}

fn fly_observed(mission: Mission, folder: &Path) -> (FlightOutcome, Arrivals) {
    let mission = Arc::new(mission);
    let mut recorder = apex_simulation::create_record(&folder.join("flight.apex"), &mission, None).unwrap();
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let terms = MissionFlight::terms(&mission, None);
    let mut arrivals = Arrivals::default();
    let flight = apex_simulation::fly(mission, means, None, terms, &mut recorder, &mut [&mut arrivals]).unwrap();
    (flight, arrivals)
}

fn process(delay_s: f64, share: f64) -> Value {
    Value::list([word("process"), Value::measured(delay_s, Dimension::TIME), Value::Real(share)])
}

fn orbit(data: &Value) -> Value {
    let fields = [("radius", 60.0), ("height", 50.0), ("turns", 1.0)];
    let fields = fields.into_iter().flat_map(|(key, figure)| [word(&format!(":{key}")), Value::Real(figure)]);
    Value::list(std::iter::once(word("orbit")).chain(fields).chain([word(":data"), data.clone()]))
}

/// Streamed pictures are taken slowly enough for the link; products of half the size wait for each other.
#[test]
fn data_are_on_the_ground_when_predicted() {
    for (data, every_m) in [(word("stream"), 30.0), (process(30.0, 0.5), 10.0), (process(5.0, 0.1), 20.0)] {
        let folder = tempfile::tempdir().unwrap();
        let form = orbit(&data);
        let goal = format!("(perform {form} at field with camera-1 at 6m/s every {every_m}m)");
        let mission = linked(folder.path(), &goal, LINK);
        let wanted = PerformedManoeuvre {
            form: &form,
            target: "field",
            sensor: Some("camera-1"),
            speed_mps: Some(6.0),
            payload: PayloadUse::StillsEvery(every_m),
            from_s: 0.0,
        };
        let predicted = forecast(&mission, &wanted).unwrap();
        let predicted_s = predicted.on_ground_s.unwrap() - predicted.time_s;
        let (flight, arrivals_s) = fly(mission, folder.path());
        let visit = &flight.report.visits[0];
        let flown_s = arrivals_s.iter().copied().fold(0.0, f64::max) - visit.end.unwrap().seconds();
        println!("{goal}: {flown_s:.1} s flown, {predicted_s:.1} s predicted; {} pictures", arrivals_s.len());
        assert!(
            (flown_s - predicted_s).abs() <= 0.05 * predicted_s.abs() + 2.0,
            "{goal}: {flown_s} s of {predicted_s} s"
        );
        assert!(arrivals_s.len().abs_diff(predicted.pictures) <= 1, "{} of {}", arrivals_s.len(), predicted.pictures);
    }
}

/// Without `:data` the world handles pictures: here it processes each for 90 s.
#[test]
fn stored_data_stay_on_board() {
    let goal = |data: &str| {
        format!("(perform (orbit :radius 60m :height 50m {data}) at field with camera-1 at 6m/s every 30m)")
    };
    let arrivals = |data: &str| {
        let folder = tempfile::tempdir().unwrap();
        fly(linked(folder.path(), &goal(data), ""), folder.path()).1
    };
    assert_eq!(arrivals(":data store"), [] as [f64; 0]);
    assert!(!arrivals("").is_empty());
}

#[test]
fn data_that_the_link_does_not_carry_are_refused_with_what_works() {
    let failed = |data: &str, options: &str| {
        let folder = tempfile::tempdir().unwrap();
        let goal =
            format!("(perform (orbit :radius 60m :height 50m :data {data}) at field with camera-1 at 6m/s every 10m)");
        let (flight, _) = fly(linked(folder.path(), &goal, options), folder.path());
        flight.report.failed_because.unwrap_or_else(|| panic!("{data} {options} is flown"))
    };
    let why = failed("stream", LINK);
    assert!(why.contains("take a picture every 4.0 s, store the data, or process it on board"), "{why}");
    let why = failed("stream", "");
    assert!(why.contains("the mission states none; add `:downlink (:rate-mbit-s 2 :picture-mbit 40)`"), "{why}");
    let why = failed("later", LINK);
    assert!(why.contains("write store, stream, or (process DELAY SHARE)"), "{why}");
}

#[test]
fn a_landing_empties_the_store() {
    let folder = tempfile::tempdir().unwrap();
    let goal = "(perform (orbit :radius 60m :height 50m :data store) at field with camera-1 at 6m/s every 30m)";
    drop(linked(folder.path(), goal, ""));
    let file = folder.path().join("mission.pdl");
    let program = std::fs::read_to_string(&file).unwrap();
    let program = program
        .replace("(step home (return to pad at 120m))", "(step home (return to pad at 120m)) (step rest (wait 1min))");
    assert!(program.contains("(step rest"), "{program}");
    std::fs::write(&file, program).unwrap();
    let used = fly_observed(Mission::load(folder.path()).unwrap(), folder.path()).1.used;
    assert!(used.iter().any(|share| *share > 0.01) && used.last() == Some(&0.0), "{used:?}");
}

/// The application states a link that the world does not have: the vehicle refuses to send.
#[test]
fn nothing_is_sent_in_a_world_without_a_downlink() {
    let folder = tempfile::tempdir().unwrap();
    let goal = "(perform (orbit :radius 60m :height 50m :data stream) at field with camera-1 at 6m/s every 30m)";
    drop(linked(folder.path(), goal, LINK));
    std::fs::write(folder.path().join("world.json"), r#"{"format": "apex-world-1"}"#).unwrap();
    let (flight, arrivals_s) = fly(Mission::load(folder.path()).unwrap(), folder.path());
    let why = flight.report.failed_because.unwrap_or_else(|| panic!("it is flown"));
    assert!(why.contains("images cannot be sent, because the world file states no `downlink`"), "{why}");
    assert_eq!(arrivals_s, [] as [f64; 0]);
}

/// A goal with a handling of its data is answered by a manoeuvre in that handling, and `:latency` counts with it.
#[test]
fn a_goal_states_how_its_data_are_handled() {
    let seconds = |s: f64| Value::Duration(apex_model::time::Duration::from_seconds(s));
    let goal = |data: Value, latency_s: f64| {
        acquire("field", &[("resolution", length(0.05)), ("latency", seconds(latency_s)), ("data", data)])
    };
    let folder = tempfile::tempdir().unwrap();
    let mission = linked(folder.path(), "(wait 1s)", LINK);
    assert!(synthesised(&mission, &goal(process(5.0, 0.1), 60.0), 0.0).is_ok());
    let why = synthesised(&mission, &goal(process(90.0, 0.1), 60.0), 0.0).unwrap_err();
    assert!(why.contains("data are sent as the goal states, and on the ground"), "{why}");
    let folder = tempfile::tempdir().unwrap();
    let wanted = "(acquire field :product stills :resolution 5cm :data (process 5s 0.1))";
    let (flight, arrivals_s) = fly(linked(folder.path(), wanted, LINK), folder.path());
    assert!(flight.end.reason.is_success() && !arrivals_s.is_empty(), "{}", flight.report.text());
}

/// The pictures of the field stay on board until the landing, about five minutes after the last one; those of the second manoeuvre of the
/// same camera, which are sent, are not theirs. A world without a downlink, where all images are read after the landing, is the witness.
#[test]
fn stored_pictures_do_not_arrive_with_those_of_a_later_manoeuvre() {
    let orbit = |data: &str, at: &str| {
        format!("(perform (orbit :radius 60m :height 50m :data {data}) at {at} with camera-1 at 6m/s every 30m)")
    };
    let timing = |data: [&str; 2], has_downlink: bool| {
        let folder = tempfile::tempdir().unwrap();
        let away = "(40.004 -99.996 0.0)";
        let goal =
            format!("{})\n  (step wait (wait 3min))\n  (step second {}", orbit(data[0], "field"), orbit(data[1], away));
        drop(linked(folder.path(), &goal, LINK));
        let change = |name: &str, from: &str, to: &str| {
            let file = folder.path().join(name);
            let text = std::fs::read_to_string(&file).unwrap();
            assert!(text.contains(from), "{name}: {from}");
            std::fs::write(&file, text.replace(from, to)).unwrap();
        };
        change("targets.geojson", r#""resolution_m": 5"#, r#""resolution_m": 5, "latency_min": [2, 30]"#);
        if !has_downlink {
            std::fs::write(folder.path().join("world.json"), r#"{"format": "apex-world-1"}"#).unwrap();
        }
        let (flight, arrivals_s) = fly(Mission::load(folder.path()).unwrap(), folder.path());
        assert!(flight.end.reason.is_success(), "{}", flight.report.text());
        let MissionValue::Score(score) = &flight.report.value else { panic!("of another kind") };
        (score.looks[0].flown.factors.timing, arrivals_s.len())
    };
    let (stored, sent) = timing(["store", "stream"], true);
    let (read_after_landing, none) = timing(["store", "store"], false);
    let (streamed, _) = timing(["stream", "store"], true);
    assert!(sent >= 5 && none == 0, "{sent} {none}");
    assert!((stored - read_after_landing).abs() < 1e-6 && stored < 0.95, "{stored} {read_after_landing}");
    assert_eq!(streamed, 1.0);
}
