//! Random commands at random times: nothing hangs, nothing is lost or late, and every number is finite.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test that fails should stop")]

mod common;

use apex_geo::geodesy;
use apex_model::event::EventKind;
use apex_model::problem::Position;
use apex_model::time::Duration;
use apex_model::value::Value;
use apex_runtime::ports::Vehicle;
use apex_sim::{Modem, Start, WorldConfig};
use common::{Run, form, location, predator, rmax, wind, word};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Random numbers from a stream that the simulator does not use.
struct TestRng(ChaCha8Rng);

impl TestRng {
    fn new(seed: u64) -> TestRng {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(u64::MAX);
        TestRng(generator)
    }

    fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / 9_007_199_254_740_992.0
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn pick(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }
}

fn somewhere(rng: &mut TestRng, centre: Position, radius_m: f64) -> Value {
    let place = geodesy::destination(centre, rng.between(0.0, 360.0), rng.between(0.0, radius_m));
    location(place.latitude_deg, place.longitude_deg)
}

fn random_command(
    rng: &mut TestRng,
    centre: Position,
    radius_m: f64,
    altitude_m: (f64, f64),
    speed: (f64, f64),
) -> Value {
    let span = Value::Duration(Duration::from_seconds(rng.between(0.0, 300.0)));
    let height = Value::Real(rng.between(altitude_m.0, altitude_m.1));
    match rng.pick(17) {
        0 | 1 => form("fly-to", [somewhere(rng, centre, radius_m)]),
        2 => form("fly-to", [somewhere(rng, centre, radius_m), word(":altitude"), height]),
        3 | 4 => form("fly-line", [somewhere(rng, centre, radius_m), somewhere(rng, centre, radius_m)]),
        5 => form("join-line", [somewhere(rng, centre, radius_m), somewhere(rng, centre, radius_m)]),
        6 => form("loiter", [somewhere(rng, centre, radius_m), word(":duration"), span]),
        7 => form("hover", [word(":duration"), span]),
        8 => form("set-altitude", [height]),
        9 => form("set-speed", [Value::Real(rng.between(speed.0, speed.1))]),
        10 => form("scanner", [word(if rng.unit() < 0.5 { "on" } else { "off" })]),
        11 => form("wait", [span]),
        12 => form("camera", [word("camera-1"), word(if rng.unit() < 0.7 { "power-up" } else { "power-off" })]),
        13 => form("point-camera", [word("camera-1"), somewhere(rng, centre, radius_m)]),
        14 => form("take-picture", [word("camera-1")]),
        15 => form("land", [somewhere(rng, centre, radius_m)]),
        _ => form("take-off", [height]),
    }
}

fn storm(config: WorldConfig, seed: u64, radius_m: f64, altitude_m: (f64, f64), speed: (f64, f64)) {
    let centre = config.start.position;
    let mut run = Run::new(config);
    let mut rng = TestRng::new(seed);
    let mut sent = Vec::new();
    let mut withdrawn = Vec::new();
    for _ in 0..100 {
        let command = random_command(&mut rng, centre, radius_m, altitude_m, speed);
        sent.push((run.send(command.clone()), command));
        if rng.unit() < 0.1 {
            let (id, _) = sent[rng.pick(sent.len())];
            run.world.withdraw(id, run.now);
            withdrawn.push(id);
        }
        let wait_s = rng.between(0.0, 400.0);
        run.wait_watchfully_s(wait_s);
    }
    run.wait_s(9_000.0);
    for pair in run.inputs.windows(2) {
        assert!(pair[0].at <= pair[1].at);
    }
    for input in &run.inputs {
        if let EventKind::Measurement(variable, value) = &input.kind {
            let number = value.as_number().map_or(0.0, |(number, _)| number);
            assert!(number.is_finite(), "{variable} is {value} at {}", input.at);
        }
    }
    for (id, command) in &sent {
        let answers = run
            .inputs
            .iter()
            .filter(|input| matches!(&input.kind, EventKind::CommandAcknowledged(found, _) if found == id));
        let count = answers.count();
        // An endless loiter, a camera that never sees its target and the last landing may be without an answer.
        assert!(count <= 1, "{command} was answered {count} times");
        let may_be_open = withdrawn.contains(id) || !command.to_string().starts_with("(fly-");
        assert!(count == 1 || may_be_open, "{command} was never answered");
    }
}

#[test]
fn a_fixed_wing_survives_random_commands() {
    for seed in 0..4 {
        let mut config = predator(Start::in_flight(40.0, -120.0, 5_000.0, 45.0));
        config.seed = seed;
        config.wind = wind(25.0 * (seed as f64 - 2.0) / 3.0, 12.0, 0.3);
        config.modems.push(Modem::satellite("ku-band"));
        storm(config, seed, 60_000.0, (1_000.0, 9_000.0), (70.0, 115.0));
    }
}

#[test]
fn a_helicopter_survives_random_commands() {
    for seed in 0..4 {
        let mut config = rmax(Start::in_flight(36.5, -121.7, 60.0, 0.0));
        config.seed = seed;
        config.wind = wind(8.0 * (seed as f64 - 2.0) / 3.0, 3.0, 0.2);
        config.modems.push(Modem::at_station("900MHzModem", Position::new(36.5, -121.7), 200.0));
        storm(config, seed, 1_500.0, (20.0, 120.0), (3.0, 18.0));
    }
}

/// From anywhere, in any wind: a line is joined in reasonable time and flown level and straight.
#[test]
fn lines_are_joined_from_everywhere() {
    let mut rng = TestRng::new(99);
    for case in 0..60 {
        let mut config = predator(Start::in_flight(44.0, -115.0, 7_000.0, rng.between(0.0, 360.0)));
        let (east, north) = (rng.between(-35.0, 35.0), rng.between(-35.0, 35.0));
        config.wind = wind(east, north, 0.0);
        let mut run = Run::new(config);
        let from =
            geodesy::destination(Position::new(44.0, -115.0), rng.between(0.0, 360.0), rng.between(0.0, 25_000.0));
        let to = geodesy::destination(from, rng.between(0.0, 360.0), rng.between(4_000.0, 30_000.0));
        let ends = [location(from.latitude_deg, from.longitude_deg), location(to.latitude_deg, to.longitude_deg)];
        let share = run.carry_out(form("fly-line", ends), 8_000.0).unwrap().as_number().unwrap().0;
        assert!(share > 0.97, "case {case}: level share {share}, wind {east} {north}");
        let slowest = 95.2 - libm::hypot(east, north);
        let path_m = geodesy::distance_m(Position::new(44.0, -115.0), from) + geodesy::distance_m(from, to);
        let limit_s = (path_m + 90_000.0) / slowest;
        assert!(run.now.seconds() < limit_s, "case {case}: {} s, limit {limit_s}", run.now.seconds());
        assert!(geodesy::distance_m(run.world.position(), to) < 250.0, "case {case}");
    }
}
