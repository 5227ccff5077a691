//! Tests of the commanded route: points that are passed, orders, and centres of circles.

use super::*;
use apex_model::because::{Because, Cause};

#[test]
fn points_of_the_way_are_left_behind() {
    let mut commanded = Commanded::default();
    let at = |lat: f64, lon: f64| Position::new(lat, lon);
    let points = vec![at(33.0, -118.0), at(33.0, -117.0), at(34.0, -117.0)];
    commanded.order = Some(FlightOrder::FlyBy(points.clone()));
    commanded.via = (2, Some(5000.0));
    commanded.altitude_m = Some(7000.0);
    let ahead = |commanded: &Commanded| match &commanded.order {
        Some(FlightOrder::FlyBy(left)) => left.len(),
        other => panic!("{other:?}"),
    };
    commanded.pass(at(33.0, -119.0), (0.0, 2_000.0), || 90.0);
    commanded.pass(at(33.01, -118.1), (0.0, 2_000.0), || 90.0);
    assert_eq!((ahead(&commanded), commanded.altitude_m()), (3, Some(5000.0)), "both points are ahead");
    commanded.pass(at(33.02, -117.9), (0.0, 2_000.0), || 90.0);
    assert_eq!(ahead(&commanded), 2, "10 km beyond the first");
    commanded.pass(at(33.1, -116.99), (0.0, 2_000.0), || 10.0);
    assert_eq!((ahead(&commanded), commanded.altitude_m()), (1, Some(7000.0)), "the goal stays");
    commanded.pass(at(34.5, -117.0), (0.0, 2_000.0), || 0.0);
    assert_eq!(ahead(&commanded), 1);
    // A point closely behind when the command begins is passed already.
    commanded.order = Some(FlightOrder::FlyBy(points));
    (commanded.via, commanded.leg_from) = ((2, None), None);
    commanded.pass(at(33.0, -117.99), (0.0, 2_000.0), || 90.0);
    assert_eq!(ahead(&commanded), 2);
}

/// A helicopter climbs on the spot before it leaves; the track that it reports last is that of its arrival.
#[test]
fn a_vehicle_that_waits_or_hovers_has_passed_nothing() {
    let mut commanded = Commanded::default();
    let (here, there) = (Position::new(37.4, -121.1), Position::new(37.41, -121.11));
    commanded.order = Some(FlightOrder::Stay(vec![there, there]));
    commanded.via = (1, Some(149.0));
    commanded.altitude_m = Some(44.0);
    commanded.hold_until_s = Some(70.0);
    let away = || 135.0;
    commanded.pass(here, (10.0, 2_000.0), away);
    assert_eq!(commanded.altitude_m(), Some(149.0), "a fixed wing that waits");
    commanded.pass(here, (71.0, 0.0), away);
    assert_eq!(commanded.altitude_m(), Some(149.0), "1.4 km before the place");
    commanded.pass(Position::new(37.40997, -121.10997), (160.0, 0.0), away);
    assert_eq!(commanded.altitude_m(), Some(44.0), "4 m before the place the descent begins");
}

#[test]
fn the_open_command_is_the_route() {
    let mut commanded = Commanded::default();
    let command = |number: u64, text: &str| Effect::Command {
        command: CommandId(number),
        task: apex_model::task::TaskId(1),
        form: apex_pdl::read_value(text).unwrap(),
        because: Because::new(Cause::InitialTask, None),
    };
    let place = |value: &Value| Location::from_value(value).map(|found| (found.position, found.altitude_m));
    commanded.take(0.0, &command(1, "(fly-to (34 -118 7000) :speed 80m/s :via ((33 -117) (33.5 -117.5)))"), place);
    let by = [(33.0, -117.0), (33.5, -117.5), (34.0, -118.0)].map(|(lat, lon)| Position::new(lat, lon));
    assert_eq!(commanded.order, Some(FlightOrder::FlyBy(by.to_vec())));
    assert_eq!((commanded.altitude_m(), commanded.true_airspeed_mps), (Some(7000.0), Some(80.0)));
    commanded.hear(&EventKind::CommandAcknowledged(CommandId(7), Ok(Value::nil())));
    assert!(commanded.order.is_some(), "another command's answer");
    commanded.take(0.0, &command(2, "(land (34 -118))"), place);
    commanded.hear(&EventKind::CommandAcknowledged(CommandId(1), Err("superseded".into())));
    assert_eq!(commanded.order, Some(FlightOrder::Land(vec![Position::new(34.0, -118.0)])));
    commanded.take(0.0, &command(3, "(set-altitude 8000m)"), place);
    assert_eq!(commanded.altitude_m(), Some(8000.0), "a setpoint leaves the order");
    commanded.hear(&EventKind::CommandAcknowledged(CommandId(2), Ok(Value::nil())));
    assert_eq!(commanded.order, None);
    commanded.take(0.0, &command(5, "(fly-to (34 -118 7000) :via ((33 -117 5000) (33.5 -117.5 5000)))"), place);
    commanded.take(0.0, &command(6, "(set-altitude 8000m)"), place);
    assert_eq!(commanded.altitude_m(), Some(8000.0), "a setpoint replaces the altitudes of the way");
    commanded.hear(&EventKind::CommandAcknowledged(CommandId(5), Ok(Value::nil())));
    commanded.take(0.0, &command(4, "(loiter (34 -118 8000) :centre (34.5 -118 8000))"), place);
    assert_eq!(commanded.order, Some(FlightOrder::Circle(vec![Position::new(34.5, -118.0)])));
}

#[test]
fn circles_have_their_centres() {
    let mut commanded = Commanded::default();
    let at = |latitude_deg: f64| Position::new(latitude_deg, -118.0);
    let command = |number: u64, text: &str| Effect::Command {
        command: CommandId(number),
        task: apex_model::task::TaskId(1),
        form: apex_pdl::read_value(text).unwrap(),
        because: Because::new(Cause::InitialTask, None),
    };
    let place = |value: &Value| Location::from_value(value).map(|found| (found.position, found.altitude_m));
    commanded.take(0.0, &command(1, "(take-off 6000m)"), place);
    commanded.begin_turns(at(34.1));
    commanded.begin_turns(at(34.2));
    assert_eq!(commanded.order, Some(FlightOrder::TakeOff(vec![at(34.1)])), "where the vehicle began to turn");
    commanded.take(0.0, &command(2, "(take-off 6000m :centre (35 -118 6000))"), place);
    commanded.begin_turns(at(34.1));
    assert_eq!(commanded.order, Some(FlightOrder::TakeOff(vec![at(35.0)])));
    commanded.take(0.0, &command(3, "(fly-to (34 -118 7000) :hold 90s :hold-around (36 -118 7000))"), place);
    commanded.pass(at(34.0), (0.0, 2_000.0), || 0.0);
    assert_eq!(commanded.circle(), Some(at(36.0)));
    commanded.hear(&EventKind::CommandAcknowledged(CommandId(3), Ok(Value::nil())));
    commanded.pass(at(34.3), (0.0, 2_000.0), || 0.0);
    commanded.pass(at(34.4), (0.0, 2_000.0), || 0.0);
    assert_eq!(commanded.circle(), Some(at(34.3)), "where the command ended");
}
