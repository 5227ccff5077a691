//! Geometry for PDL: the host functions `distance`, `bearing`, `offset`, `within-p` and similar ones.
//!
//! A location is a list `(latitude_deg longitude_deg [altitude_m])` of plain reals. Lengths and angles are quantities with their
//! dimension: a bare number is rejected, because 500 could be feet as well as metres.

use crate::coverage::turn_radius_m;
use crate::geodesy::{self, Position, RAD_PER_DEG};
use crate::location::Location;
use crate::plane::{self, Plane, Point};
use crate::sun;
use crate::time_limit::flight_time_limit;
use apex_model::host::HostFunctions;
use apex_model::quantity::{Dimension, Quantity, unit_named};
use apex_model::value::Value;
use std::sync::Arc;

type Body = fn(&[Value]) -> Result<Value, String>;

/// Name, least and greatest number of arguments, body; one row per function.
const FUNCTIONS: &[(&str, usize, usize, Body)] = &[
    ("distance", 2, 2, |a| Ok(length(geodesy::distance_m(at(a, 0)?.position, at(a, 1)?.position)))),
    ("slant-distance", 2, 2, slant_distance),
    ("bearing", 2, 2, |a| Ok(angle(geodesy::azimuth_deg(at(a, 0)?.position, at(a, 1)?.position)))),
    ("offset", 3, 3, offset),
    ("midpoint", 2, 2, |a| interpolated(at(a, 0)?, at(a, 1)?, 0.5)),
    ("interpolate", 3, 3, |a| interpolated(at(a, 0)?, at(a, 1)?, number(a, 2, Dimension::NONE)?)),
    ("within-p", 3, 3, within),
    ("inside-p", 2, 2, inside),
    ("along-track", 3, 3, |a| Ok(length(tracks(a)?.0))),
    ("cross-track", 3, 3, |a| Ok(length(tracks(a)?.1))),
    ("bearing-difference", 2, 2, bearing_difference),
    ("latitude-of", 1, 1, |a| Ok(angle(at(a, 0)?.position.latitude_deg))),
    ("longitude-of", 1, 1, |a| Ok(angle(at(a, 0)?.position.longitude_deg))),
    ("altitude-of", 1, 1, altitude_of),
    ("with-altitude", 2, 2, |a| {
        Ok(Location { altitude_m: Some(number(a, 1, Dimension::LENGTH)?), ..at(a, 0)? }.value())
    }),
    ("turn-radius", 2, 2, turn_radius),
    ("swath-width", 2, 2, swath_width),
    ("ground-resolution", 2, 2, |a| Ok(length(number(a, 0, Dimension::LENGTH)? * number(a, 1, Dimension::ANGLE)?))),
    ("height-for-resolution", 2, 2, height_for_resolution),
    ("solar-elevation", 2, 2, |a| {
        Ok(angle(sun::solar_elevation_deg(at(a, 0)?.position, number(a, 1, Dimension::NONE)?)))
    }),
    // A mission replaces these by functions that use its airspace, terrain and landing places.
    ("way-to", 5, 6, |_| Ok(Value::nil())),
    ("way-to-circle", 5, 6, |_| Ok(Value::nil())),
    ("way-to-line", 6, 7, |_| Ok(Value::nil())),
    ("way-to-landing", 4, 5, |_| Ok(Value::nil())),
    ("way-to-climb", 4, 4, |_| Ok(Value::nil())),
    ("way-to-segment", 6, 8, |a| Ok(Value::list(a.iter().skip(3).take(2).cloned()))),
    ("time-before-line", 6, 6, |_| Ok(Value::nil())),
    ("time-on-circle", 7, 7, |_| Ok(Value::nil())),
    ("landing-place-near", 2, 4, |_| Ok(Value::nil())),
    ("landing-place-in-glide", 3, 4, |_| Ok(Value::nil())),
    ("landing-place-zones", 2, 2, |_| Ok(Value::nil())),
    ("forecast-error", 4, 4, |_| Ok(Value::nil())),
    ("manoeuvre-path", 5, 6, |_| Err("manoeuvres need a mission: its targets, vehicle and sensors".to_string())),
    ("flight-time-limit", 3, 5, flight_time_limit),
];

/// Returns all geometry functions, ready to be registered. Each checks the number of its arguments itself as well.
pub fn host_functions() -> HostFunctions {
    let mut functions = HostFunctions::default();
    for (name, least, most, body) in FUNCTIONS {
        functions.register(
            name,
            Arc::new(move |arguments: &[Value]| {
                if !(*least..=*most).contains(&arguments.len()) {
                    let wanted = match (*least, *most) {
                        (1, 1) => "1 argument".to_string(),
                        (least, most) if least == most => format!("{least} arguments"),
                        (least, most) => format!("{least} to {most} arguments"),
                    };
                    return Err(format!("`{name}` takes {wanted} and was given {}", arguments.len()));
                }
                let value = body(arguments).map_err(|trouble| format!("`{name}`: {trouble}"))?;
                if has_nan(&value) {
                    return Err(format!("`{name}` cannot be computed for {}", Value::list(arguments.iter().cloned())));
                }
                Ok(value)
            }),
        );
    }
    functions
}

/// Returns name, least and greatest number of arguments of every geometry function, for the checker, where `None` would mean any number.
pub fn host_signatures() -> Vec<(&'static str, usize, Option<usize>)> {
    FUNCTIONS.iter().map(|(name, least, most, _)| (*name, *least, Some(*most))).collect()
}

fn at(arguments: &[Value], index: usize) -> Result<Location, String> {
    arguments.get(index).map_or_else(|| Err("an argument is missing".to_string()), Location::of)
}

fn number(arguments: &[Value], index: usize, wanted: Dimension) -> Result<f64, String> {
    let value = arguments.get(index).ok_or("an argument is missing")?;
    match value.as_number() {
        Some((number, dimension)) if dimension == wanted && number.is_finite() => Ok(number),
        _ => {
            let example = match wanted {
                Dimension::LENGTH => "a length such as 500 m or 2 nm",
                Dimension::ANGLE => "an angle such as 90 deg",
                Dimension::SPEED => "a speed such as 35 kt",
                _ => "a plain number",
            };
            Err(format!("argument {} must be {example}; got {value}", index + 1))
        }
    }
}

fn length(metres: f64) -> Value {
    Value::measured(metres, Dimension::LENGTH)
}

fn angle(degrees: f64) -> Value {
    match unit_named("deg") {
        Some(unit) => Value::Quantity(Quantity::of(degrees, unit)),
        None => Value::measured(degrees * RAD_PER_DEG, Dimension::ANGLE),
    }
}

fn has_nan(value: &Value) -> bool {
    match value {
        Value::List(items) => items.iter().any(has_nan),
        other => other.as_number().is_some_and(|(number, _)| number.is_nan()),
    }
}

fn slant_distance(arguments: &[Value]) -> Result<Value, String> {
    let (from, to) = (at(arguments, 0)?, at(arguments, 1)?);
    let (Some(low_m), Some(high_m)) = (from.altitude_m, to.altitude_m) else {
        return Err("both locations need an altitude".to_string());
    };
    Ok(length(libm::hypot(geodesy::distance_m(from.position, to.position), high_m - low_m)))
}

fn offset(arguments: &[Value]) -> Result<Value, String> {
    let from = at(arguments, 0)?;
    let azimuth_deg = number(arguments, 1, Dimension::ANGLE)? / RAD_PER_DEG;
    let distance_m = number(arguments, 2, Dimension::LENGTH)?;
    Ok(Location { position: geodesy::destination(from.position, azimuth_deg, distance_m), ..from }.value())
}

fn interpolated(from: Location, to: Location, fraction: f64) -> Result<Value, String> {
    let altitude_m = match (from.altitude_m, to.altitude_m) {
        (Some(low_m), Some(high_m)) => Some(low_m + fraction * (high_m - low_m)),
        (one, other) => one.or(other),
    };
    Ok(Location { position: geodesy::interpolate(from.position, to.position, fraction), altitude_m }.value())
}

fn within(arguments: &[Value]) -> Result<Value, String> {
    let limit_m = number(arguments, 2, Dimension::LENGTH)?;
    let distance_m = geodesy::distance_m(at(arguments, 0)?.position, at(arguments, 1)?.position);
    Ok(Value::truth(distance_m <= limit_m))
}

fn inside(arguments: &[Value]) -> Result<Value, String> {
    let position = at(arguments, 0)?.position;
    let corners = arguments.get(1).and_then(Value::as_list).ok_or("argument 2 must be a list of corner locations")?;
    let corners: Vec<Position> =
        corners.iter().map(|corner| Ok(Location::of(corner)?.position)).collect::<Result<_, String>>()?;
    if corners.len() < 3 {
        return Err(format!("a polygon needs three corners; got {}", corners.len()));
    }
    let plane = Plane::around(&corners);
    let flat: Option<Vec<Point>> = corners.iter().map(|corner| plane.project(*corner)).collect();
    let flat = flat.ok_or("the polygon is too large for one map")?;
    Ok(Value::truth(plane.project(position).is_some_and(|point| plane::inside(point, &flat))))
}

fn tracks(arguments: &[Value]) -> Result<(f64, f64), String> {
    let (point, from, to) = (at(arguments, 0)?, at(arguments, 1)?, at(arguments, 2)?);
    Ok(geodesy::along_cross_track_m(from.position, to.position, point.position))
}

fn bearing_difference(arguments: &[Value]) -> Result<Value, String> {
    let (from, to) = (number(arguments, 0, Dimension::ANGLE)?, number(arguments, 1, Dimension::ANGLE)?);
    Ok(angle(geodesy::wrap_180((to - from) / RAD_PER_DEG)))
}

fn altitude_of(arguments: &[Value]) -> Result<Value, String> {
    let altitude_m = at(arguments, 0)?.altitude_m;
    altitude_m.map(length).ok_or_else(|| "the location has no altitude".to_string())
}

fn turn_radius(arguments: &[Value]) -> Result<Value, String> {
    let (speed_mps, bank_rad) = (number(arguments, 0, Dimension::SPEED)?, number(arguments, 1, Dimension::ANGLE)?);
    if !(1e-6..1.57).contains(&bank_rad.abs()) {
        return Err("the bank angle must be between 0 and 90 deg".to_string());
    }
    Ok(length(turn_radius_m(speed_mps, bank_rad.abs() / RAD_PER_DEG)))
}

fn swath_width(arguments: &[Value]) -> Result<Value, String> {
    let (height_m, view_rad) = (number(arguments, 0, Dimension::LENGTH)?, number(arguments, 1, Dimension::ANGLE)?);
    if !(0.0..std::f64::consts::PI).contains(&view_rad) {
        return Err("the field of view must be between 0 and 180 deg".to_string());
    }
    Ok(length(2.0 * height_m * libm::tan(0.5 * view_rad)))
}

fn height_for_resolution(arguments: &[Value]) -> Result<Value, String> {
    let (pixel_m, pixel_rad) = (number(arguments, 0, Dimension::LENGTH)?, number(arguments, 1, Dimension::ANGLE)?);
    if pixel_rad <= 0.0 {
        return Err("the angle of a pixel must be positive".to_string());
    }
    Ok(length(pixel_m / pixel_rad))
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::symbol::Symbol;

    fn call(name: &str, arguments: &[Value]) -> Result<Value, String> {
        (host_functions().get(&Symbol::new(name)).unwrap())(arguments)
    }

    fn location(numbers: &[f64]) -> Value {
        Value::list(numbers.iter().map(|number| Value::Real(*number)))
    }

    fn measure(number: f64, unit: &str) -> Value {
        Value::Quantity(Quantity::of(number, unit_named(unit).unwrap()))
    }

    #[test]
    fn offset_and_back() {
        let home = location(&[34.905, -117.884, 700.0]);
        let there = call("offset", &[home.clone(), measure(45.0, "deg"), measure(10.0, "nm")]).unwrap();
        let (distance, _) = call("distance", &[home.clone(), there.clone()]).unwrap().as_number().unwrap();
        assert!((distance - 18_520.0).abs() < 1e-6);
        let (bearing, dimension) = call("bearing", &[home.clone(), there.clone()]).unwrap().as_number().unwrap();
        assert!((bearing / RAD_PER_DEG - 45.0).abs() < 1e-9 && dimension == Dimension::ANGLE);
        assert!(call("within-p", &[there.clone(), home.clone(), measure(19.0, "km")]).unwrap().is_true());
        assert!(!call("within-p", &[there.clone(), home, measure(18.0, "km")]).unwrap().is_true());
        assert_eq!(call("altitude-of", &[there]).unwrap().to_string(), "700m");
    }

    #[test]
    fn wrong_arguments_are_explained() {
        let home = location(&[34.905, -117.884]);
        let message = call("offset", &[home.clone(), Value::Integer(90), measure(1.0, "km")]).unwrap_err();
        assert_eq!(message, "`offset`: argument 2 must be an angle such as 90 deg; got 90");
        let message = call("distance", &[home.clone(), Value::symbol("edwards")]).unwrap_err();
        assert!(message.contains("a location is (latitude longitude [altitude])"), "{message}");
        assert!(call("distance", &[home.clone(), location(&[95.0, 0.0])]).is_err());
        assert_eq!(
            call("distance", std::slice::from_ref(&home)).unwrap_err(),
            "`distance` takes 2 arguments and was given 1"
        );
        let seven = [0.0; 7].map(Value::Real);
        assert_eq!(call("way-to", &seven).unwrap_err(), "`way-to` takes 5 to 6 arguments and was given 7");
        assert!(call("altitude-of", &[home]).unwrap_err().contains("no altitude"));
    }

    #[test]
    fn signatures_and_functions_agree() {
        let functions = host_functions();
        let signatures = host_signatures();
        assert_eq!(functions.names().count(), signatures.len());
        assert!(signatures.iter().all(|(name, _, _)| functions.get(&Symbol::new(name)).is_some()));
    }

    #[test]
    fn polygons_and_tracks() {
        let corners = [[39.0, -121.0], [39.0, -119.0], [41.0, -119.0], [41.0, -121.0]];
        let polygon = Value::list(corners.iter().map(|corner| location(corner)));
        assert!(call("inside-p", &[location(&[40.0, -120.0]), polygon.clone()]).unwrap().is_true());
        assert!(!call("inside-p", &[location(&[40.0, -122.0]), polygon]).unwrap().is_true());
        let track = [location(&[40.0, -120.5]), location(&[39.0, -120.0]), location(&[41.0, -120.0])];
        let (left, _) = call("cross-track", &track).unwrap().as_number().unwrap();
        assert!((left + 42_700.0).abs() < 300.0, "left of track is negative: {left}");
        let difference = call("bearing-difference", &[measure(350.0, "deg"), measure(10.0, "deg")]).unwrap();
        assert_eq!(difference.to_string(), "20deg");
    }
}
