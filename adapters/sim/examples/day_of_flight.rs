//! Measures the cost of the simulator alone: a flight of one day with the scanner on and a report every second.
//!
//! Build with `cargo build --release -p apex-sim --example day_of_flight`, then run it under `time`, `perf stat` or `perf record`. It
//! prints the number of packets and inputs of the day, so that the cost of each can be computed.

use apex_model::effect::CommandId;
use apex_model::event::EventKind;
use apex_model::problem::{FOREVER_S, Position, WindField, WindLayer};
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::Vehicle;
use apex_sim::{GroundPatch, Modem, SimulatedWorld, Start, WorldConfig};
use apex_vehicle::VehicleModel;

const DAY_S: f64 = 86_400.0;

fn main() -> Result<(), String> {
    let mut world = SimulatedWorld::new(config()?)?;
    let places = [(34.5, -120.5), (47.5, -115.0), (42.0, -123.0), (36.0, -118.0)];
    let mut inputs = Vec::new();
    let (mut packets, mut count, mut sent) = (0_u64, 0_usize, 1);
    world.command(CommandId(1), &Value::list([Value::symbol("scanner"), Value::symbol("on")]), Time::ZERO);
    let mut next = places.iter().cycle();
    let mut free = true;
    loop {
        let now = world.next_report().unwrap_or(Time::END);
        if now.seconds() > DAY_S {
            break;
        }
        inputs.clear();
        world.advance(now, &mut inputs)?;
        count += inputs.len();
        for input in &inputs {
            match &input.kind {
                EventKind::Measurement(variable, _) if variable.attribute.is("latitude") => packets += 1,
                EventKind::CommandAcknowledged(command, _) if command.0 > 1 => free = true,
                _ => {}
            }
        }
        if free && let Some((latitude_deg, longitude_deg)) = next.next() {
            free = false;
            sent += 1;
            let place = Value::list([Value::Real(*latitude_deg), Value::Real(*longitude_deg)]);
            // Commands alternate between lines and legs.
            let form = if sent % 2 == 0 {
                Value::list([Value::symbol("fly-to"), place])
            } else {
                let end = Value::list([Value::Real(latitude_deg + 0.5), Value::Real(longitude_deg + 0.5)]);
                Value::list([Value::symbol("fly-line"), place, end])
            };
            world.command(CommandId(sent), &form, now);
        }
    }
    println!("{packets} packets, {count} inputs, {} commands, {:.0} kg of fuel left", sent, world.stored());
    Ok(())
}

/// Returns a world with fifty patches of ground, layered wind, turbulence and two radios, as in the shipped missions.
fn config() -> Result<WorldConfig, String> {
    let mut start = Start::in_flight(34.9, -117.9, 7_010.0, 45.0);
    start.fuel_share = Some(1.0);
    let mut config = WorldConfig::new("aircraft-1", VehicleModel::named("predator-b")?, start);
    let layer = |altitude_m_min: f64, wind_east_mps: f64| WindLayer {
        area: None,
        altitude_m_min,
        altitude_m_max: altitude_m_min + 4_000.0,
        from_s: -FOREVER_S,
        until_s: FOREVER_S,
        wind_east_mps,
        wind_north_mps: -4.0,
        edr: 0.05,
    };
    config.wind = WindField { layers: vec![layer(0.0, 5.0), layer(4_000.0, 12.0), layer(8_000.0, 20.0)], blend: true };
    for index in 0..50 {
        let index = f64::from(index);
        config.ground.patches.push(GroundPatch {
            position: Position::new(34.0 + 0.28 * index, -123.0 + 0.16 * index),
            radius_m: 15_000.0,
            elevation_m: 500.0 + 20.0 * index,
        });
    }
    config.modems =
        vec![Modem::satellite("ku-band"), Modem::at_station("900MHzModem", Position::new(34.9, -117.9), 5_000.0)];
    Ok(config)
}
