//! Locations of PDL: `(latitude_deg longitude_deg [altitude_m])`.

use crate::geodesy::Position;
use apex_model::quantity::Dimension;
use apex_model::value::Value;

/// A location as a Rust value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Location {
    /// Latitude and longitude.
    pub position: Position,
    /// Altitude above mean sea level, if stated.
    pub altitude_m: Option<f64>,
}

impl Location {
    /// Reads a location `(latitude_deg longitude_deg [altitude_m])`; angles with a unit are converted.
    ///
    /// # Errors
    /// An error message that states the forms of a location and the given value.
    pub fn of(value: &Value) -> Result<Location, String> {
        let refused = || format!("a location is (latitude longitude [altitude]) in degrees and metres; got {value}");
        let items = value.as_list().ok_or_else(refused)?;
        let plain = |value: &Value| match value.as_number() {
            Some((number, Dimension::NONE)) if number.is_finite() => Some(number),
            Some((radians, Dimension::ANGLE)) if radians.is_finite() => Some(radians.to_degrees()),
            _ => None,
        };
        let altitude = |value: &Value| match value.as_number() {
            Some((metres, Dimension::NONE | Dimension::LENGTH)) if metres.is_finite() => Some(metres),
            _ => None,
        };
        let (latitude_deg, longitude_deg, altitude_m) = match items {
            [latitude, longitude] => (plain(latitude), plain(longitude), None),
            [latitude, longitude, height] => {
                (plain(latitude), plain(longitude), Some(altitude(height).ok_or_else(refused)?))
            }
            _ => return Err(refused()),
        };
        match (latitude_deg, longitude_deg) {
            (Some(latitude_deg), Some(longitude_deg)) if latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 360.0 => {
                Ok(Location { position: Position { latitude_deg, longitude_deg }, altitude_m })
            }
            _ => Err(refused()),
        }
    }

    /// Returns the PDL value.
    pub fn value(&self) -> Value {
        let plane = [self.position.latitude_deg, self.position.longitude_deg];
        Value::list(plane.into_iter().chain(self.altitude_m).map(Value::Real))
    }
}
