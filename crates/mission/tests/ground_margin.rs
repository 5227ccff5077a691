//! The height over ground that the independent check requires depends on the mission's vehicle.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at an unexpected result")]

use apex_mission::Mission;
use apex_mission::verification::FlightCheck;
use apex_model::event::{Batch, Event, EventKind, StateVariable};
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;

/// Returns a mission with a vehicle and further options.
fn mission(vehicle: &str, options: &str) -> Mission {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: String| std::fs::write(folder.path().join(name), text).unwrap();
    let home = r#"{"type": "Feature", "properties": {"id": "home", "kind": "base"}, "geometry": {"type": "Point", "coordinates": [-115, 40]}}"#;
    put("places.geojson", format!(r#"{{"type": "FeatureCollection", "features": [{home}]}}"#));
    put(
        "mission.pdl",
        format!(
            r#"(defapplication "Low"
  :type native-sim
  :libraries ("vehicle")
  :vehicle (sim :model {vehicle} :at home)
  :duration 1h
  :targets "places.geojson" {options}
  :agents ((agent uav-1 :initial-task (go))))
(procedure (index (go)) (step done (terminate)))"#
        ),
    );
    Mission::load(folder.path()).unwrap_or_else(|error| panic!("{error:?}"))
}

/// Returns positions that count as too near to the ground, in level flight at this height.
fn too_near(vehicle: &str, height_m: f64) -> u64 {
    too_near_with(vehicle, "", height_m)
}

fn too_near_with(vehicle: &str, options: &str, height_m: f64) -> u64 {
    let mut check = FlightCheck::new(&mission(vehicle, options));
    let measured = |attribute: &str, value: Value| {
        EventKind::Measurement(StateVariable::new(Symbol::new(attribute), Value::symbol("uav-1")), value)
    };
    let kinds = [
        measured("on-ground", Value::nil()),
        measured("flight-phase", Value::symbol("en-route")),
        measured("height-above-ground", Value::measured(height_m, Dimension::LENGTH)),
        measured("location", Value::list([40.0, -115.0, height_m].map(Value::Real))),
    ];
    let now = Time::from_seconds(600.0);
    let events = kinds.into_iter().map(|kind| Event { sequence: 1, at: now, kind }).collect();
    check.take(&Batch { now, events }, &[]);
    assert_eq!(check.result().positions, 1);
    check.result().near_ground
}

#[test]
fn a_small_aircraft_may_fly_lower_than_a_large_one() {
    assert_eq!([too_near("fixed-wing-mapper", 40.0), too_near("fixed-wing-mapper", 38.0)], [0, 1]);
    assert_eq!([too_near("predator-b", 286.0), too_near("predator-b", 285.0)], [0, 1]);
    assert_eq!([too_near("rmax", 37.0), too_near("rmax", 35.0)], [0, 1]);
}

/// The height is the one that the mission requires: a flight that the mission forbids was verified, and a permitted one was not.
#[test]
fn the_clearance_of_the_mission_counts() {
    let stated = ":requirements ((terrain :clearance 100m))";
    assert_eq!([too_near_with("rmax", stated, 101.0), too_near_with("rmax", stated, 60.0)], [0, 1]);
    let none = ":requirements ((terrain :off))";
    assert_eq!([too_near_with("predator-b", none, 301.0), too_near_with("predator-b", none, 299.0)], [0, 1]);
}
