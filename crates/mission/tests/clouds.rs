//! Clouds: the expectation of planners under a cloud forecast, and the value of a record with hidden ground.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

use apex_mission::Mission;
use apex_mission::problem::pose;
use apex_mission::report::{MissionValue, report};
use apex_mission::score::FlownScore;
use apex_mission::situation::Situation;
use apex_model::event::{Batch, Event, EventKind, StateVariable};
use apex_model::problem::{Manoeuvre, Problem};
use apex_model::quantity::{Quantity, UNITS};
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_observation::result::{LookResult, LossCause};

/// Returns a Predator B and one fire of 8 by 8 km at sea level, 50 km north of the field, below these clouds.
fn mission(clouds: Option<&str>) -> Mission {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    put(
        "places.geojson",
        r#"{"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {"id": "home", "kind": "base"}, "geometry": {"type": "Point", "coordinates": [-115, 40]}},
            {"type": "Feature", "properties": {"id": "fire", "kind": "fire", "value": 100, "resolution_m": 20, "elevation_m": 0},
             "geometry": {"type": "Polygon", "coordinates": [[[-115.047, 40.414], [-114.953, 40.414], [-114.953, 40.486],
             [-115.047, 40.486], [-115.047, 40.414]]]}}]}"#,
    );
    let named = match clouds {
        Some(text) => {
            put("clouds.csv", text);
            r#":cloud-forecast "clouds.csv""#
        }
        None => "",
    };
    put(
        "mission.pdl",
        &format!(
            r#"(defapplication "Clouds"
  :type native-sim
  :libraries ("vehicle" "aerial-observation")
  :vehicle (sim :model predator-b :at home)
  :start "2007-09-08T18:00:00Z"
  :duration 6h
  :targets "places.geojson"
  {named}
  :agents ((agent uav-1 :initial-task (map them))))
(procedure (index (map them)) (step done (terminate)))"#
        ),
    );
    Mission::load(folder.path()).unwrap_or_else(|error| panic!("{error:?}"))
}

fn manoeuvres(clouds: Option<&str>) -> Vec<Manoeuvre> {
    match pose(&mission(clouds), &Situation::default(), None, Time::ZERO).unwrap() {
        Problem::SingleVisit(problem) => problem.targets[0].manoeuvres.clone(),
        Problem::Surveillance(_) => panic!("of another kind"),
    }
}

const HALF_COVERED: &str = "base_m,top_m,cover\n2000,2500,0.4\n";

#[test]
fn planners_expect_the_clarity_that_the_clouds_leave() {
    let (clear, cloudy) = (manoeuvres(None), manoeuvres(Some(HALF_COVERED)));
    let best = |all: &[Manoeuvre], above_m: f64| {
        let above = all.iter().filter(|one| one.altitude_m > above_m).map(|one| one.quality.clarity.factor);
        above.fold(0.0, f64::max)
    };
    assert!(best(&clear, 2_000.0) > 0.95, "{}", best(&clear, 2_000.0));
    // Straight down 0.6, at 43 degrees 0.6^1.47 = 0.47.
    assert!((0.47..0.6).contains(&best(&cloudy, 2_000.0)), "{}", best(&cloudy, 2_000.0));
    let told =
        cloudy.iter().filter(|one| one.altitude_m > 2_000.0).all(|one| one.quality.clarity.cause.contains("cloud"));
    assert!(told, "{:?}", cloudy[0].quality.clarity);
}

#[test]
fn planners_fly_below_an_overcast_sky() {
    let below = manoeuvres(Some("base_m,top_m,cover\n5200,6000,1\n"));
    assert!(manoeuvres(None).iter().any(|one| one.altitude_m > 5_200.0));
    assert!(!below.is_empty() && below.iter().all(|one| one.altitude_m <= 5_200.0), "{below:?}");
}

/// Returns a line of 10 km over the middle of the fire, from west to east, at 5,000 m and 100 m/s; clouds hide the ground from `hidden_s`
/// on.
fn flown(hidden_s: f64) -> LookResult {
    let mission = mission(None);
    let mut score = FlownScore::new(&mission).unwrap().unwrap();
    let measured = |attribute: &str, value: Value| {
        EventKind::Measurement(StateVariable::new(Symbol::new(attribute), Value::symbol("uav-1")), value)
    };
    let angle = |deg: f64| Value::Quantity(Quantity::of(deg, UNITS.iter().find(|unit| unit.name == "deg").unwrap()));
    let mut last = "off";
    for step in 0..=500_u32 {
        let after_s = 0.2 * f64::from(step);
        let longitude_deg = -115.0 + (after_s - 50.0) * 100.0 / 84_600.0;
        let place = [40.45, longitude_deg, 5_000.0].map(Value::Real);
        let mut kinds = vec![
            measured("location", Value::list(place)),
            measured("heading", angle(90.0)),
            measured("roll-angle", angle(0.0)),
            measured("pitch-angle", angle(0.0)),
        ];
        let state = if step == 500 {
            "off"
        } else if after_s >= hidden_s {
            "obscured"
        } else {
            "on"
        };
        if state != last {
            kinds.push(measured("scanner-state", Value::symbol(state)));
            last = state;
        }
        let now = Time::from_seconds(3_600.0 + after_s);
        let events = kinds.into_iter().map(|kind| Event { sequence: u64::from(step), at: now, kind }).collect();
        score.observe(&Batch { now, events });
    }
    let end = (Time::from_seconds(4_000.0), "it is over".to_string());
    match report(&mission, &Situation::default(), Ok(&score), end).value {
        MissionValue::Score(score) => score.looks[0].flown.clone(),
        MissionValue::Ignorance(..) | MissionValue::None => panic!("of another kind"),
    }
}

#[test]
fn hidden_ground_is_seen_and_not_clear() {
    let (clear, half) = (flown(1e9), flown(50.0));
    assert!((half.factors.coverage - clear.factors.coverage).abs() < 1e-9, "{half:?}");
    assert!((clear.factors.clarity - 1.0).abs() < 1e-9, "{clear:?}");
    assert!((half.factors.clarity - 0.5).abs() < 0.01, "{half:?}");
    let lost = |result: &LookResult| {
        let lost = result.losses.iter().filter(|loss| loss.cause == LossCause::Cloud).map(|loss| loss.points);
        lost.sum::<f64>()
    };
    assert_eq!(lost(&clear), 0.0);
    assert!((lost(&half) - 0.5 * clear.points).abs() < 1.0, "{half:?}");
}
