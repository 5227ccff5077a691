//! Beginnings of lines: joined there, on the course, at the speed of the line, by a small and a large aircraft.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test that fails should stop")]

mod common;

use apex_geo::geodesy;
use apex_model::problem::Position;
use apex_model::quantity::{Quantity, unit_named};
use apex_model::value::Value;
use apex_sim::{Start, WorldConfig};
use apex_vehicle::VehicleModel;
use common::{Run, form, location, wind, word};

const BEGIN: Position = Position { latitude_deg: 37.41227, longitude_deg: -121.11157 };

fn place(position: Position) -> Value {
    location(position.latitude_deg, position.longitude_deg)
}

fn speed(metres_per_second: f64) -> Value {
    Value::Quantity(Quantity::of(metres_per_second, unit_named("m/s").unwrap()))
}

/// Returns a vehicle that flies east, `along_m` past the beginning of an eastward line and `across_m` to its left, and the line's ends.
fn next_to(
    model: &str,
    (along_m, across_m): (f64, f64),
    length_m: f64,
    wind_mps: (f64, f64),
) -> (Run, (Position, Position)) {
    let altitude_m = if model == "predator-b" { 3_000.0 } else { 120.0 };
    let end = geodesy::destination(BEGIN, 90.0, length_m);
    let at = geodesy::destination(geodesy::destination(BEGIN, 90.0, along_m), 0.0, across_m);
    let start = Start::in_flight(at.latitude_deg, at.longitude_deg, altitude_m, 90.0);
    let mut config = WorldConfig::new("aircraft-1", VehicleModel::named(model).unwrap(), start);
    config.wind = wind(wind_mps.0, wind_mps.1, 0.0);
    (Run::new(config), (BEGIN, end))
}

/// Distances past the beginning and across the line at the answer of a join, and the angle between track and line in degrees.
fn joined(run: &mut Run, (from, to): (Position, Position), options: Vec<Value>) -> (f64, f64, f64) {
    let arguments = [place(from), place(to)].into_iter().chain(options);
    run.carry_out(form("join-line", arguments), 6_000.0).unwrap();
    let (along_m, across_m) = geodesy::along_cross_track_m(from, to, run.world.position());
    let track_deg = run.last_number("track") / geodesy::RAD_PER_DEG;
    (along_m, across_m, geodesy::wrap_180(track_deg - geodesy::azimuth_deg(from, to)).abs())
}

/// A mapper that had flown a parallel line 42 m away, and was 70 m past the beginning, "joined" in the same second: no picture showed the
/// target. The tolerances were those of a large aircraft.
#[test]
fn a_line_is_joined_at_its_beginning_from_next_to_it() {
    for (model, scale) in [("fixed-wing-mapper", 1.0), ("predator-b", 7.3)] {
        for (along, across) in [(70.0, 42.0), (30.0, -15.0), (-20.0, 30.0), (20.0, 0.0)] {
            for (east, north) in [(0.0, 0.0), (0.3, 0.2)] {
                let wind_mps = (east * 13.0 * scale, north * 13.0 * scale);
                let (mut run, ends) = next_to(model, (along * scale, across * scale), 140.0 * scale, wind_mps);
                let (along_m, across_m, off_deg) = joined(&mut run, ends, Vec::new());
                let case = format!("{model} from {along}, {across}, wind {wind_mps:?}: {along_m} {across_m} {off_deg}");
                assert!((0.0..2.0 * scale).contains(&along_m), "{case}");
                assert!(across_m.abs() < 9.75 * scale && off_deg < 5.0, "{case}");
            }
        }
    }
}

/// The answer came up to a second after the beginning: a scanner that is switched on then misses 95 m.
#[test]
fn a_join_is_answered_where_the_line_begins() {
    for before_m in [9_000.0, 4_321.0, 1_000.0, 50.0] {
        let (mut run, ends) = next_to("predator-b", (-before_m, 0.0), 20_000.0, (0.0, 0.0));
        let (along_m, across_m, _) = joined(&mut run, ends, Vec::new());
        assert!((0.0..2.0).contains(&along_m) && across_m.abs() < 5.0, "{before_m}: {along_m} {across_m}");
    }
}

#[test]
fn a_line_begins_at_the_speed_that_the_command_states() {
    for (wind_mps, wanted) in [((0.0, 0.0), 60.0), ((15.0, 0.0), 60.0), ((-20.0, 10.0), 70.0), ((0.0, 0.0), 110.0)] {
        let (mut run, ends) = next_to("predator-b", (-9_000.0, 0.0), 20_000.0, wind_mps);
        let way = Value::list([place(geodesy::destination(BEGIN, 270.0, 2_400.0))]);
        let options = vec![word(":line-speed"), speed(wanted), word(":via"), way];
        let (along_m, ..) = joined(&mut run, ends, options);
        let reached = run.last_number("true-airspeed");
        assert!((reached - wanted).abs() < 1.0, "wind {wind_mps:?}: {reached} m/s, wanted {wanted}");
        assert!((0.0..2.5).contains(&along_m), "{along_m}");
        // The way before it is flown at the speed of before, as long as that is possible.
        let speeds = run.numbers("true-airspeed");
        let at_first = speeds.iter().filter(|(at, _)| (5.0..20.0).contains(at));
        assert!(at_first.into_iter().all(|(_, airspeed)| (airspeed - 95.2).abs() < 0.5), "{speeds:?}");
        run.wait_s(20.0);
        assert!((run.last_number("true-airspeed") - wanted).abs() < 0.5);
    }
    let (mut run, (from, to)) = next_to("predator-b", (-9_000.0, 0.0), 20_000.0, (0.0, 0.0));
    let refused = run.carry_out(form("join-line", [place(from), place(to), word(":line-speed"), speed(20.0)]), 1.0);
    assert!(refused.unwrap_err().contains("20.00 m/s true airspeed is outside of"));
}
