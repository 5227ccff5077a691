//! Observations that a separate thread accumulates: a reader gets all observations up to the instant at which it reads.

#![allow(clippy::unwrap_used, clippy::float_arithmetic, reason = "a test stops at an unexpected result")]

use apex_mission::Mission;
use apex_mission::score::FlownScore;
use apex_model::event::{Batch, Event, EventKind, StateVariable};
use apex_model::quantity::{Quantity, UNITS};
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::path::Path;

/// Steps of 0.2 s: enough for several parts that are handed over together.
const STEPS: u32 = 4_000;
/// Samples and switches that are handed over together.
const PART: u32 = 1_024;
/// Steps of a line over the fire; the scanner is off in the last tenth.
const LINE: u32 = 700;

fn measured(attribute: &str, value: Value) -> EventKind {
    EventKind::Measurement(StateVariable::new(Symbol::new(attribute), Value::symbol("aircraft-1")), value)
}

fn angle(deg: f64) -> Value {
    Value::Quantity(Quantity::of(deg, UNITS.iter().find(|unit| unit.name == "deg").unwrap()))
}

/// Returns a step of a flight forth and back over a fire, with the given roll.
fn batch(number: u32, (latitude_deg, longitude_deg): (f64, f64), roll_deg: f64) -> Batch {
    let at = Time::from_seconds(f64::from(number) * 0.2);
    let (line, along) = (number / LINE, number % LINE);
    let share = f64::from(along) / f64::from(LINE) - 0.5;
    let east_deg = 0.2 * if line.is_multiple_of(2) { share } else { -share };
    let north_deg = 0.01 * f64::from(line % 5) - 0.02;
    let place = [latitude_deg + north_deg, longitude_deg + east_deg, 7_500.0].map(Value::Real);
    let mut kinds = vec![
        measured("location", Value::list(place)),
        measured("heading", angle(if line.is_multiple_of(2) { 90.0 } else { 270.0 })),
        measured("roll-angle", angle(roll_deg)),
        measured("pitch-angle", angle(1.0)),
    ];
    match along {
        0 => kinds.push(measured("scanner-state", Value::symbol("on"))),
        _ if along == LINE * 9 / 10 => kinds.push(measured("scanner-state", Value::symbol("off"))),
        _ => {}
    }
    let event = |(kind, sequence)| Event { sequence, at, kind };
    Batch { now: at, events: kinds.into_iter().zip(u64::from(number) * 10 + 1..).map(event).collect() }
}

#[test]
fn observations_are_those_of_the_flight_up_to_now_at_each_instant_of_reading() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/western-states");
    let mission = Mission::load(&folder).unwrap();
    let fire = mission.targets.iter().find(|target| target.outline().is_some()).unwrap();
    let (name, middle) = (fire.id.clone(), (fire.position.latitude_deg, fire.position.longitude_deg));
    let mut draws = ChaCha8Rng::seed_from_u64(11);
    let new = || FlownScore::new(&mission).unwrap().unwrap();
    // The witness is read after each step, so that nothing is ever behind.
    let (mut witness, mut flown, mut copied) = (new(), new(), new());
    let (mut compared, mut unread) = (0, 0);
    for number in 0..STEPS {
        let step = batch(number, middle, f64::from(draws.next_u32() % 100) * 0.1 - 5.0);
        [&mut witness, &mut flown, &mut copied].into_iter().for_each(|score| score.observe(&step));
        witness.saw("nothing", 0.0, 0.0);
        let along = number % LINE;
        unread += u32::from(along <= LINE * 9 / 10) + u32::from([0, LINE * 9 / 10].contains(&along));
        if draws.next_u32().is_multiple_of(1_000) {
            copied = copied.clone();
        }
        // Mostly reads at the instant at which a part was handed over, when its thread has hardly begun.
        if unread >= PART || draws.next_u32().is_multiple_of(2_000) {
            assert_eq!(flown.result(&name), witness.result(&name), "after step {number}");
            (compared, unread) = (compared + 1, 0);
        }
    }
    let results = witness.results();
    assert!(flown.results() == results && copied.results() == results);
    let seen = results.iter().find(|result| result.name == name).unwrap();
    assert!(compared > 3 && format!("{seen:?}") != format!("{:?}", new().result(&name)), "{seen:?}");
    assert!(new().results() != results, "the flight sees something");
}
