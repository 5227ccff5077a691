//! The guarantees of the port: determinism, order of time, rejections as sentences, scheduled events, speed.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test that fails should stop")]

mod common;

use apex_model::effect::CommandId;
use apex_model::event::{EventKind, StateVariable};
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::{Input, Vehicle};
use apex_sim::{Happening, Modem, ScheduledEvent, SimulatedWorld, Start, WorldConfig};
use apex_vehicle::VehicleModel;
use common::{Run, form, location, predator, rmax, wind, word};

fn rough_world() -> WorldConfig {
    let mut config = predator(Start::on_ground(34.905, -117.884, 702.0, 40.0));
    config.wind = wind(12.0, -4.0, 0.4);
    config.seed = 42;
    config.modems.push(Modem::satellite("ku-band"));
    config
}

/// Returns the inputs of the same script, with `advance` called at every report, or every `increment_s`.
fn flown(increment_s: Option<f64>) -> Vec<Input> {
    let mut world = SimulatedWorld::new(rough_world()).unwrap();
    let script = [
        (0.0, form("take-off", [Value::Real(2_000.0)])),
        (700.0, form("fly-to", [Value::list([35.3, -118.3, 7_010.0].map(Value::Real))])),
        (901.7, form("scanner", [word("on")])),
        (2_400.0, form("fly-line", [location(35.4, -118.4), location(35.6, -118.2)])),
        (5_000.0, form("scanner", [word("off")])),
    ];
    let mut inputs = Vec::new();
    for (index, (at, command)) in script.iter().enumerate() {
        let at = Time::from_seconds(*at);
        advance_in(&mut world, at, increment_s, &mut inputs);
        world.command(CommandId(index as u64), command, at);
    }
    advance_in(&mut world, Time::from_seconds(7_200.0), increment_s, &mut inputs);
    inputs
}

fn advance_in(world: &mut SimulatedWorld, to: Time, increment_s: Option<f64>, inputs: &mut Vec<Input>) {
    let mut now = inputs.last().map_or(Time::ZERO, |input| input.at);
    while now < to {
        now = match increment_s {
            Some(increment_s) => (now + apex_model::time::Duration::from_seconds(increment_s)).min(to),
            None => world.next_report().unwrap().max(now).min(to),
        };
        let before = inputs.len();
        world.advance(now, inputs).unwrap();
        assert!(inputs[before..].iter().all(|input| input.at <= now));
        if increment_s.is_none() && now < to && inputs.len() == before {
            now = now + apex_model::time::Duration(1);
        }
    }
    world.advance(to, inputs).unwrap();
}

#[test]
fn the_same_script_gives_the_same_inputs_however_time_is_cut() {
    let reference = flown(None);
    assert!(reference.len() > 20_000);
    assert!(reference.windows(2).all(|pair| pair[0].at <= pair[1].at));
    for increment_s in [0.37, 5.0, 333.0] {
        assert!(flown(Some(increment_s)) == reference, "cut into {increment_s} s");
    }
}

#[test]
fn another_seed_is_another_flight() {
    let roll = |seed| {
        let mut config = rough_world();
        config.start = Start::in_flight(40.0, -120.0, 7_000.0, 0.0);
        config.seed = seed;
        let mut run = Run::new(config);
        run.wait_s(60.0);
        run.numbers("roll-angle")
    };
    assert_eq!(roll(1), roll(1));
    assert_ne!(roll(1), roll(2));
}

#[test]
fn bad_commands_are_refused_with_sentences() {
    let mut run = Run::new(predator(Start::in_flight(40.0, -120.0, 7_010.0, 45.0)));
    let cases = [
        (form("fly-too", [location(40.0, -120.0)]), "did you mean `fly-to`?"),
        (word("land"), "is not a command"),
        (form("fly-to", []), "it was given 0 arguments"),
        (form("fly-to", [Value::Real(3.0)]), "is not a location"),
        (form("fly-to", [location(95.0, 0.0)]), "is not on Earth"),
        (form("fly-to", [location(f64::NAN, 0.0)]), "is not on Earth"),
        (form("fly-to", [word("nowhere")]), "unknown place `nowhere`"),
        (form("fly-to", [location(40.0, -120.0), word(":sped"), Value::Real(90.0)]), "did you mean `speed`?"),
        (form("fly-to", [location(40.0, -120.0), word(":speed"), Value::Real(300.0)]), "which aircraft-1 can fly here"),
        (form("set-altitude", [Value::Real(30_000.0)]), "above the ceiling"),
        (
            form("set-altitude", [Value::Duration(apex_model::time::Duration::from_seconds(9.0))]),
            "is time and should be length",
        ),
        (form("hover", []), "cannot hover"),
        (form("loiter", [location(40.0, -120.0), word(":radius"), Value::Real(500.0)]), "too tight"),
        (form("take-off", [Value::Real(9_000.0)]), "already in the air"),
        (form("scanner", [word("maybe")]), "switched on or off"),
        (form("camera", [word("camera-2"), word("power-up")]), "unknown camera `camera-2`; did you mean `camera-1`?"),
        (form("fly-line", [location(40.0, -120.0), location(40.0, -120.0)]), "has no length"),
        (form("wait", [Value::Integer(-3)]), "is negative"),
    ];
    for (command, expected) in cases {
        let refusal = run.carry_out(command.clone(), 0.0).unwrap_err();
        assert!(refusal.contains(expected), "{command}: {refusal}");
    }
    let mut helicopter = Run::new(rmax(Start::in_flight(36.5, -121.7, 60.0, 0.0)));
    let refusal = helicopter.carry_out(form("scanner", [word("on")]), 0.0).unwrap_err();
    assert!(refusal.contains("carries no scanner"), "{refusal}");
}

#[test]
fn impossible_worlds_are_refused_with_sentences() {
    let model = || VehicleModel::named("rmax").unwrap();
    let too_high = WorldConfig::new("r", model(), Start::in_flight(36.0, -121.0, 9_000.0, 0.0));
    assert!(SimulatedWorld::new(too_high).unwrap_err().contains("above the 2500 m"));
    let nowhere = WorldConfig::new("r", model(), Start::on_ground(f64::NAN, -121.0, 0.0, 0.0));
    assert!(SimulatedWorld::new(nowhere).unwrap_err().contains("latitude NaN"));
    let nameless = WorldConfig::new(" ", model(), Start::on_ground(36.0, -121.0, 0.0, 0.0));
    assert!(SimulatedWorld::new(nameless).unwrap_err().contains("needs a name"));
}

#[test]
fn scheduled_events_come_at_their_time() {
    let mut config = rmax(Start::in_flight(36.5, -121.7, 60.0, 0.0));
    let variable = StateVariable::new(Symbol::new("likelihood"), word("site-4"));
    let sighted = form("fire-sighted", [word("site-4")]);
    config.events = vec![
        ScheduledEvent {
            at: Time::from_seconds(33.3),
            what: Happening::Measurement(variable.clone(), Value::Real(0.5)),
        },
        ScheduledEvent { at: Time::from_seconds(12.25), what: Happening::Occurrence(sighted) },
    ];
    let mut run = Run::new(config);
    run.wait_s(60.0);
    assert_eq!(run.event("(fire-sighted site-4)"), Some(12.25));
    let sample =
        run.inputs.iter().find(|input| matches!(&input.kind, EventKind::Measurement(found, _) if *found == variable));
    assert_eq!(sample.unwrap().at, Time::from_seconds(33.3));
}

#[test]
fn waits_and_zero_durations_end() {
    let mut run = Run::new(rmax(Start::in_flight(36.5, -121.7, 60.0, 0.0)));
    run.carry_out(form("wait", [Value::Real(7.5)]), 8.0).unwrap();
    assert_eq!(run.now, Time::from_seconds(7.5));
    run.carry_out(form("hover", [word(":duration"), Value::Integer(0)]), 10.0).unwrap();
}

#[test]
fn every_answer_and_event_comes_at_a_whole_millisecond_and_when_announced() {
    let mut run = Run::new(rough_world());
    let seconds = |seconds: f64| Value::Duration(apex_model::time::Duration::from_seconds(seconds));
    run.send(form("take-off", [Value::Real(1_500.0)]));
    run.wait_watchfully_s(400.000_000_7);
    run.send(form("wait", [seconds(7.123_456_789)]));
    run.send(form("camera", [word("camera-1"), word("power-up")]));
    run.wait_watchfully_s(0.013_3);
    run.send(form("loiter", [location(34.95, -117.9), word(":duration"), seconds(33.333_333)]));
    run.wait_watchfully_s(3_000.0);
    run.send(form("point-camera", [word("camera-1"), location(34.95, -117.9)]));
    run.wait_watchfully_s(61.5);
    run.send(form("take-picture", [word("camera-1")]));
    run.send(form("fly-line", [location(34.95, -117.9), location(35.1, -117.8)]));
    run.wait_watchfully_s(2_000.0);
    let answers = run.inputs.iter().filter(|input| matches!(input.kind, EventKind::CommandAcknowledged(..)));
    assert_eq!(answers.count(), 7);
    assert_eq!(run.answer(CommandId(2)).unwrap().0, Time::from_seconds(407.125));
}

#[test]
fn a_leg_is_answered_with_the_location_that_is_published_at_that_instant() {
    for mut run in [
        Run::new(predator(Start::in_flight(40.0, -120.0, 7_010.0, 45.0))),
        Run::new(rmax(Start::in_flight(36.5, -121.7, 60.0, 0.0))),
    ] {
        let start = run.world.position();
        let goal = location(start.latitude_deg + 0.01, start.longitude_deg - 0.012_345_678_9);
        let answer = run.carry_out(form("fly-to", [goal.clone()]), 1_000.0).unwrap();
        let (at, published) = run.values("location").pop().unwrap();
        assert!(at == run.now.seconds() && answer.equals(&published), "{answer} and {published} at {at}");
        assert!(!answer.equals(&goal));
    }
}

#[test]
fn published_numbers_are_short_to_read() {
    let mut run = Run::new(rough_world());
    run.send(form("take-off", [Value::Real(2_000.0)]));
    run.wait_s(600.0);
    for input in &run.inputs {
        let EventKind::Measurement(variable, value) = &input.kind else { continue };
        let numbers: Vec<String> = match value.as_list() {
            Some(items) => items.iter().map(Value::to_string).collect(),
            None => vec![value.to_string()],
        };
        for text in numbers.iter().filter(|text| text.contains('.')) {
            let decimals = text.split('.').nth(1).unwrap().chars().take_while(char::is_ascii_digit).count();
            assert!(decimals <= 7 && !text.starts_with("-0deg"), "{variable} is {value}");
        }
    }
}

#[test]
fn a_day_of_flight_is_simulated_quickly() {
    let mut run = Run::new(rough_world());
    run.carry_out(form("take-off", [Value::Real(2_000.0)]), 1_000.0).unwrap();
    let (near, far) = ([34.5, -120.5, 7_010.0], [47.5, -115.0, 7_010.0]);
    for index in 0..4 {
        let goal = if index % 2 == 0 { far } else { near };
        run.carry_out(form("fly-to", [Value::list(goal.map(Value::Real))]), 40_000.0).unwrap();
    }
    assert!(run.now.seconds() > 60_000.0, "{}", run.now.seconds());
    let packets = run.numbers("roll-angle").len();
    assert!(packets > 5_000 && packets < 20_000, "{packets}");
}
