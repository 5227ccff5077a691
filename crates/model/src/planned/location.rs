//! A place in the air, and its value in PDL.

use crate::problem::Position;
use crate::quantity::Dimension;
use crate::value::Value;
use serde::{Deserialize, Serialize};

/// Altitude above which no aircraft flies, and depth below which no place lies.
const ALTITUDE_M_MAX: f64 = 100_000.0;

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
        let number = |index: usize, unit: Dimension| match items.get(index)?.as_number()? {
            (number, Dimension::NONE) => Some(number),
            (si, dimension) if dimension == unit => Some(if unit == Dimension::ANGLE { si.to_degrees() } else { si }),
            _ => None,
        };
        let (latitude_deg, longitude_deg) = (number(0, Dimension::ANGLE)?, number(1, Dimension::ANGLE)?);
        let is_given = items.get(2).is_some_and(Value::is_true);
        let altitude_m = if is_given { number(2, Dimension::LENGTH)? } else { 0.0 };
        let is_near = latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 360.0 && altitude_m.abs() <= ALTITUDE_M_MAX;
        is_near.then(|| Location { position: Position::new(latitude_deg, longitude_deg), altitude_m })
    }
}
