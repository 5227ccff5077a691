//! A place in the air, and its value in PDL.

use crate::problem::Position;
use crate::quantity::Dimension;
use crate::value::Value;
use serde::{Deserialize, Serialize};

/// Altitude above which no aircraft flies, and depth below which no place lies.
const ALTITUDE_M_MAX: f64 = 100_000.0;
const DEGREES_PER_RADIAN: f64 = 180.0 / std::f64::consts::PI;

/// A point above the WGS84 ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Location {
    /// Latitude and longitude.
    pub position: Position,
    /// Above mean sea level.
    pub altitude_m: f64,
}

impl Location {
    /// Returns the PDL value `(LATITUDE LONGITUDE ALTITUDE)`.
    pub fn value(&self) -> Value {
        let Position { latitude_deg, longitude_deg } = self.position;
        Value::list([latitude_deg, longitude_deg, self.altitude_m].map(Value::Real))
    }

    /// Reads `(LATITUDE LONGITUDE)` or `(LATITUDE LONGITUDE ALTITUDE)`; a missing altitude is 0. Numbers are degrees and metres;
    /// quantities are angles and a length. `None` for other values, and for places that are not on the Earth or near it.
    pub fn from_value(value: &Value) -> Option<Location> {
        let items = value.as_list()?;
        let in_unit = |index: usize, unit: Dimension, per_si: f64| match items.get(index)?.as_number()? {
            (number, Dimension::NONE) => Some(number),
            (si, dimension) if dimension == unit => Some(si * per_si),
            _ => None,
        };
        let degrees = |index: usize| in_unit(index, Dimension::ANGLE, DEGREES_PER_RADIAN);
        let (latitude_deg, longitude_deg) = (degrees(0)?, degrees(1)?);
        let is_given = items.get(2).is_some_and(Value::is_true);
        let altitude_m = if is_given { in_unit(2, Dimension::LENGTH, 1.0)? } else { 0.0 };
        let is_near = latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 360.0 && altitude_m.abs() <= ALTITUDE_M_MAX;
        is_near.then(|| Location { position: Position::new(latitude_deg, longitude_deg), altitude_m })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_degrees_and_metres_and_quantities_have_their_units() {
        let read = |items: [Value; 3]| Location::from_value(&Value::list(items));
        let plain = read([37.5, -121.0, 60.0].map(Value::Real)).unwrap();
        let angle = |degrees: f64| Value::measured(degrees.to_radians(), Dimension::ANGLE);
        let stated = read([angle(37.5), angle(-121.0), Value::measured(60.0, Dimension::LENGTH)]).unwrap();
        assert!((stated.position.latitude_deg - plain.position.latitude_deg).abs() < 1e-9);
        assert!((stated.position.longitude_deg - plain.position.longitude_deg).abs() < 1e-9);
        assert_eq!(stated.altitude_m, 60.0);
        let seconds = Value::measured(60.0, Dimension::TIME);
        assert_eq!(read([Value::Real(37.5), Value::Real(-121.0), seconds]), None);
        for wrong in [[95.0, -121.0, 0.0], [37.0, 500.0, 0.0], [37.0, -121.0, 1e9], [f64::NAN, 0.0, 0.0]] {
            assert_eq!(read(wrong.map(Value::Real)), None, "{wrong:?}");
        }
    }
}
