//! The independent check counts a position as in the air unless the record says or shows otherwise, and says what it could not judge.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at an unexpected result")]

use apex_mission::Mission;
use apex_mission::deliberation::{MissionDeliberator, PlanningResources};
use apex_mission::verification::{CheckResult, FlightCheck};
use apex_model::because::{Because, Cause};
use apex_model::effect::{CommandId, Effect};
use apex_model::event::{Batch, Event, EventKind, StateVariable};
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::Deliberator;
use std::path::Path;
use std::sync::Arc;

/// A place inside the zone `quarry` of the mission, and one outside of every zone.
const IN_THE_QUARRY: [f64; 2] = [37.4120, -121.0890];
const HOME: [f64; 2] = [37.405, -121.105];

/// A flight that is checked.
struct Checked {
    check: FlightCheck,
    now_s: f64,
}

fn mission() -> Mission {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/structure-watch");
    Mission::load(&path).unwrap_or_else(|error| panic!("{error:?}"))
}

fn command(number: u64, form: Value) -> Effect {
    let because = Because::new(Cause::InitialTask, None);
    Effect::Command { command: CommandId(number), task: TaskId(1), form, because }
}

fn done(number: u64) -> EventKind {
    EventKind::CommandAcknowledged(CommandId(number), Ok(Value::nil()))
}

fn batch(now_s: f64, kinds: Vec<EventKind>) -> Batch {
    let now = Time::from_seconds(now_s);
    let events = kinds.into_iter().map(|kind| Event { sequence: 1, at: now, kind }).collect();
    Batch { now, events }
}

impl Checked {
    fn new() -> Checked {
        Checked { check: FlightCheck::new(&mission()), now_s: 0.0 }
    }

    fn step(&mut self, kinds: Vec<EventKind>, effects: &[Effect]) {
        self.now_s += 10.0;
        self.check.take(&batch(self.now_s, kinds), effects);
    }

    fn command(&mut self, number: u64, head: &str) {
        self.step(Vec::new(), &[command(number, Value::list([Value::symbol(head)]))]);
    }

    fn done(&mut self, number: u64) {
        self.step(vec![done(number)], &[]);
    }

    fn at(&mut self, [latitude_deg, longitude_deg]: [f64; 2], altitude_m: f64) {
        self.step(vec![location([latitude_deg, longitude_deg], altitude_m)], &[]);
    }

    fn result(self) -> CheckResult {
        self.check.finish()
    }
}

fn measured(attribute: &str, value: Value) -> EventKind {
    EventKind::Measurement(StateVariable::new(Symbol::new(attribute), Value::symbol("rotorcraft-1")), value)
}

fn location([latitude_deg, longitude_deg]: [f64; 2], altitude_m: f64) -> EventKind {
    measured("location", Value::list([latitude_deg, longitude_deg, altitude_m].map(Value::Real)))
}

#[test]
fn a_flight_without_on_ground_is_checked() {
    let mut flight = Checked::new();
    flight.at(HOME, 5.0);
    flight.command(0, "take-off");
    flight.done(0);
    for _ in 0..3 {
        flight.at(IN_THE_QUARRY, 60.0);
    }
    let result = flight.result();
    assert_eq!((result.positions, result.inside_zones), (3, 3), "{result}");
    assert!(!result.is_verified());
}

#[test]
fn what_cannot_be_judged_is_stated_with_its_count() {
    let mut flight = Checked::new();
    flight.command(0, "take-off");
    flight.done(0);
    flight.at(HOME, 60.0);
    flight.at(HOME, 60.0);
    let result = flight.result();
    assert_eq!((result.height_unknown, result.air_derived, result.repeats_unjudged), (2, 2, 1));
    let text = result.to_string();
    for part in [
        "? under way below 36 m over ground",
        "2 of the positions have no `height-above-ground`",
        "2 of the positions count as in the air by commands",
        "1 of the positions repeat the one before",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn a_check_of_nothing_is_not_a_success() {
    let empty = Checked::new().result();
    assert!(!empty.is_verified() && empty.to_string().contains("holds no steps"), "{empty}");
    let mut parked = Checked::new();
    parked.at(HOME, 5.0);
    parked.at(HOME, 5.0);
    let parked = parked.result();
    assert_eq!(parked.positions, 0);
    assert!(!parked.is_verified() && parked.to_string().contains("no position of the vehicle in the air"), "{parked}");
}

#[test]
fn take_off_and_landing_are_known_by_their_commands() {
    let mut flight = Checked::new();
    let low = |height_m: f64| {
        vec![
            measured("on-ground", Value::nil()),
            measured("height-above-ground", Value::measured(height_m, Dimension::LENGTH)),
            location(HOME, 5.0 + height_m),
        ]
    };
    flight.command(0, "take-off");
    flight.step(low(8.0), &[]);
    flight.done(0);
    for _ in 0..4 {
        flight.step(low(60.0), &[]);
    }
    flight.step(low(12.0), &[]);
    assert_eq!(flight.check.result().near_ground, 1, "under way");
    flight.command(1, "land");
    flight.step(low(12.0), &[]);
    flight.step(low(2.0), &[]);
    assert_eq!(flight.result().near_ground, 1, "the landing");
}

/// Returns a deliberator that has observed an acknowledged take-off of a vehicle that does not report whether it is on the ground.
fn taken_off() -> MissionDeliberator {
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let mut deliberator = MissionDeliberator::new(Arc::new(mission()), means);
    deliberator.observe(
        0,
        &batch(0.0, vec![location(HOME, 5.0)]),
        &[command(0, Value::list([Value::symbol("take-off")]))],
    );
    deliberator.observe(0, &batch(40.0, vec![done(0)]), &[]);
    deliberator.observe(0, &batch(41.0, vec![location(HOME, 110.0)]), &[]);
    deliberator
}

#[test]
fn a_flight_that_ends_in_the_air_is_reported_without_on_ground() {
    let deliberator = taken_off();
    let report = deliberator.report((Time::from_seconds(60.0), "the end".into()));
    let not_landed = report.not_landed.unwrap_or_default();
    assert!(
        not_landed.contains("in the air at 110 m") && not_landed.contains("does not report `on-ground`"),
        "{not_landed}"
    );
    let notes: Vec<&str> = deliberator.situation().notes.iter().map(|note| note.text.as_str()).collect();
    let missing = notes.iter().filter(|note| note.starts_with("the vehicle does not report `on-ground`"));
    assert_eq!(missing.count(), 1, "{notes:?}");
}

/// Returns true if the requirement `terrain` is at risk during a descent at home under this command.
fn is_terrain_at_risk(head: &str) -> bool {
    let mut deliberator = taken_off();
    let home = Value::list([Value::Real(HOME[0]), Value::Real(HOME[1]), Value::Real(5.0)]);
    deliberator.observe(0, &batch(50.0, Vec::new()), &[command(1, Value::list([Value::symbol(head), home]))]);
    (0..40).any(|second| {
        let height_m = 85.0 - 2.0 * f64::from(second);
        let height = measured("height-above-ground", Value::measured(height_m, Dimension::LENGTH));
        let speed = measured("true-airspeed", Value::measured(2.0, Dimension::SPEED));
        deliberator.observe(
            0,
            &batch(51.0 + f64::from(second), vec![height, speed, location(HOME, 5.0 + height_m)]),
            &[],
        );
        deliberator.derive().iter().any(|input| match &input.kind {
            EventKind::Occurrence(form) => form.to_string().starts_with("(requirement-at-risk terrain"),
            _ => false,
        })
    })
}

#[test]
fn the_final_landing_is_not_at_risk_of_terrain_without_a_flight_phase() {
    assert!(is_terrain_at_risk("fly-to"), "a descent under way");
    assert!(!is_terrain_at_risk("land"));
}

#[test]
fn a_position_that_no_flight_explains_is_stated() {
    let mut flight = Checked::new();
    flight.command(0, "take-off");
    flight.done(0);
    flight.at(HOME, 60.0);
    flight.at([0.0, 0.0], 60.0);
    flight.at(HOME, 60.0);
    flight.at(HOME, 40_000.0);
    let result = flight.result();
    assert_eq!((result.jumps, result.first_jump_s), (3, Some(40.0)), "{result}");
    assert!(result.to_string().contains("3 times, first at 40s, the reported position jumps"), "{result}");
}
