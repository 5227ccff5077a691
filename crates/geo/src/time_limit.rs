//! Time limits of flight commands, for PDL: the greatest duration of a flight before it counts as failed.
//!
//! Bound: linear in the number of values in the list of places.

use crate::geodesy;
use crate::location::Location;
use apex_model::quantity::Dimension;
use apex_model::time::Duration;
use apex_model::value::Value;

/// Share of the airspeed that counts as progress over ground: a head wind of half the airspeed is allowed for.
const PROGRESS_SHARE: f64 = 0.5;
/// Share of the greatest climb rate that counts: climb rates fall towards the ceiling.
const CLIMB_SHARE: f64 = 0.25;
/// Seconds for reaction, acceleration and settling.
const BASE_S: f64 = 300.0;
/// Full circles included in the limit: turns at both ends, two further approaches. At a bank of 15 degrees a circle takes `2 pi V / (g
/// tan 15 deg)`, 2.39 s for each m/s; a wind of half the airspeed V widens it by 1.5^2.
const CIRCLES: f64 = 4.0;
const CIRCLE_S_PER_M_S: f64 = 2.25 * 2.39;
/// Limit in seconds for a flight of unknown length, because a place is given by name or the vehicle's position is unknown.
const UNKNOWN_S: f64 = 3.0 * 3_600.0;

/// Evaluates `(flight-time-limit PLACES AIRSPEED CLIMB-RATE [ALTITUDE [WAIT]])`: the duration after which a flight along `PLACES` to
/// `ALTITUDE` has failed. `PLACES` is a list of locations in the order of the flight, and of durations of waiting; nested lists are
/// searched for both. `ALTITUDE` (a length, or metres) and `WAIT` (a duration, or seconds) may be nil.
///
/// The value is twice the time in still air at `AIRSPEED`, plus all changes of altitude at a quarter of `CLIMB-RATE`, plus the durations,
/// plus 5 minutes and four full circles. A place given by name, and a list with fewer than two places, add three hours; a climb or descent
/// from an unknown position (a list without any place, and an `ALTITUDE`) counts from sea level instead.
///
/// # Errors
/// An argument of another kind, as a fragment of a message.
pub fn flight_time_limit(arguments: &[Value]) -> Result<Value, String> {
    let [places, airspeed, climb_rate, rest @ ..] = arguments else {
        return Err("it takes a list of places, an airspeed and a climb rate".to_owned());
    };
    let speed = |value: &Value, what: &str| match value.as_number() {
        Some((number, Dimension::SPEED)) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err(format!("the {what} must be a speed greater than zero such as 35 kt; got {value}")),
    };
    let optional = |index: usize, what: &str, wanted: Dimension| match rest.get(index) {
        Some(value) if value.is_true() => match value.as_number() {
            Some((number, dimension))
                if number.is_finite() && (dimension == wanted || dimension == Dimension::NONE) =>
            {
                Ok(Some(number))
            }
            _ => Err(format!("the {what} must be a number or nil; got {value}")),
        },
        _ => Ok(None),
    };
    let (airspeed, climb_rate) = (speed(airspeed, "airspeed")?, speed(climb_rate, "climb rate")?);
    let altitude_m = optional(0, "altitude", Dimension::LENGTH)?;
    let wait_s = optional(1, "time of waiting", Dimension::TIME)?.unwrap_or(0.0);
    let mut way = TimedWay::default();
    way.collect(places);
    let TimedWay { found, waits_s, names } = way;
    let mut seconds = BASE_S + CIRCLES * CIRCLE_S_PER_M_S * airspeed + waits_s + wait_s.max(0.0);
    match altitude_m {
        // The flight leads nowhere else: a take-off whose answer is lost must not wait for hours.
        Some(altitude_m) if names == 0 && found.is_empty() => seconds += altitude_m.abs() / (CLIMB_SHARE * climb_rate),
        _ if names > 0 || found.len() < 2 => seconds += UNKNOWN_S,
        _ => {}
    }
    for (from, to) in found.iter().zip(found.iter().skip(1)) {
        seconds += geodesy::distance_m(from.position, to.position) / (PROGRESS_SHARE * airspeed);
    }
    let altitudes_m: Vec<f64> = found.iter().filter_map(|place| place.altitude_m).chain(altitude_m).collect();
    for (low_m, high_m) in altitudes_m.iter().zip(altitudes_m.iter().skip(1)) {
        seconds += (high_m - low_m).abs() / (CLIMB_SHARE * climb_rate);
    }
    Ok(Value::Duration(Duration::from_seconds(libm::ceil(seconds))))
}

/// Places and waiting times of a list.
#[derive(Default)]
struct TimedWay {
    found: Vec<Location>,
    /// Sum of the durations.
    waits_s: f64,
    /// Number of places given by name.
    names: usize,
}

impl TimedWay {
    /// Collects places and durations in `value`, depth first. Keywords and numbers are skipped.
    fn collect(&mut self, value: &Value) {
        if let Ok(place) = Location::of(value) {
            self.found.push(place);
        } else if let Some(items) = value.as_list() {
            items.iter().for_each(|item| self.collect(item));
        } else if let Value::Duration(wait) = value {
            self.waits_s += wait.seconds().max(0.0);
        } else if let Value::Symbol(name) = value {
            self.names += usize::from(!name.folded().starts_with(':') && value.is_true());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::quantity::{Quantity, unit_named};

    fn speed(number: f64) -> Value {
        Value::measured(number, Dimension::SPEED)
    }

    fn place(numbers: &[f64]) -> Value {
        Value::list(numbers.iter().map(|number| Value::Real(*number)))
    }

    /// Five minutes, and four circles at 50 m/s.
    const TURNS_S: f64 = 300.0 + 4.0 * 2.25 * 119.5;

    fn limit_s(places: &[Value]) -> f64 {
        let arguments = [Value::list(places.iter().cloned()), speed(50.0), speed(8.0)];
        match flight_time_limit(&arguments).unwrap() {
            Value::Duration(limit) => limit.seconds(),
            other => panic!("{other}"),
        }
    }

    #[test]
    fn a_limit_grows_with_distance_climb_and_waiting() {
        // One degree of latitude at 45 degrees is 111,132 m; 25 m/s count.
        let (here, there) = (place(&[44.5, -120.0, 1_000.0]), place(&[45.5, -120.0, 3_000.0]));
        let flown_s = 111_132.0 / 25.0;
        assert!((limit_s(&[here.clone(), there.clone()]) - (flown_s + 2_000.0 / 2.0 + TURNS_S)).abs() < 10.0);
        assert!((limit_s(&[here.clone(), place(&[45.5, -120.0])]) - (flown_s + TURNS_S)).abs() < 10.0);
        let wait = Value::Duration(Duration::from_seconds(600.0));
        let options = Value::list([Value::symbol(":hold"), wait, Value::symbol(":via"), Value::list([there.clone()])]);
        let nested = limit_s(&[here.clone(), options, there.clone()]);
        assert!((nested - limit_s(&[here.clone(), there]) - 600.0).abs() < 1e-6, "{nested}");
        assert!(limit_s(&[here.clone(), here]) < TURNS_S + 1.0);
    }

    #[test]
    fn altitude_and_waiting_may_be_given_apart() {
        let here = place(&[44.5, -120.0, 1_000.0]);
        let limit = |altitude: Value, wait: Value| {
            let places = Value::list([here.clone(), here.clone()]);
            flight_time_limit(&[places, speed(50.0), speed(8.0), altitude, wait]).unwrap().as_number().unwrap().0
        };
        let minutes = |number: f64| libm::ceil(TURNS_S + 60.0 * number);
        assert_eq!(limit(Value::nil(), Value::nil()), minutes(0.0));
        assert_eq!(limit(Value::measured(2_200.0, Dimension::LENGTH), Value::nil()), minutes(10.0));
        assert_eq!(limit(Value::Integer(2_200), Value::Integer(60)), minutes(11.0));
        assert_eq!(limit(Value::nil(), Value::Duration(Duration::from_seconds(600.0))), minutes(10.0));
    }

    #[test]
    fn a_take_off_from_an_unknown_position_has_a_limit_of_minutes() {
        let nowhere = Value::list([Value::nil(), Value::nil(), Value::nil()]);
        let altitude = Value::measured(110.0, Dimension::LENGTH);
        let limit = |places: &Value| flight_time_limit(&[places.clone(), speed(10.0), speed(2.5), altitude.clone()]);
        let limit_s = |places: &Value| limit(places).unwrap().as_number().unwrap().0;
        assert!((300.0..900.0).contains(&limit_s(&nowhere)), "{}", limit_s(&nowhere));
        assert!(limit_s(&Value::list([Value::nil(), place(&[37.0, -121.0])])) > 10_000.0, "a way of unknown length");
    }

    #[test]
    fn an_unknown_place_adds_three_hours() {
        let here = place(&[44.5, -120.0]);
        assert_eq!(limit_s(&[here.clone(), Value::symbol("edwards")]), 3.0 * 3_600.0 + libm::ceil(TURNS_S));
        assert_eq!(limit_s(&[Value::nil(), here.clone()]), 3.0 * 3_600.0 + libm::ceil(TURNS_S));
        assert_eq!(
            limit_s(&[here.clone(), Value::symbol("edwards"), here.clone()]),
            3.0 * 3_600.0 + libm::ceil(TURNS_S)
        );
    }

    #[test]
    fn speeds_must_be_speeds() {
        let places = Value::list([]);
        let metres = Value::Quantity(Quantity::of(3.0, unit_named("m").unwrap()));
        let error = flight_time_limit(&[places.clone(), metres, speed(1.0)]).unwrap_err();
        assert!(error.starts_with("the airspeed must be a speed"), "{error}");
        let error = flight_time_limit(&[places, speed(1.0), speed(0.0)]).unwrap_err();
        assert!(error.starts_with("the climb rate must be a speed"), "{error}");
    }
}
