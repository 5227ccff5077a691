//! The vehicle as last measured, as far as it matters for what a sensor sees.

use apex_model::planned::Location;
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_observation::attitude::Attitude;

/// An angle or speed older than this is not known any more.
const AGE_S_MAX: f64 = 2.5;

/// The latest measurements.
#[derive(Clone, Debug, Default)]
pub(super) struct Latest {
    /// Position and altitude above mean sea level.
    pub(super) place: Option<(Position, f64)>,
    /// The scanner is on.
    pub(super) is_on: bool,
    /// Share of the line of sight that is free of cloud, where the record knows it.
    pub(super) clear_share: Option<f64>,
    roll_deg: Option<Measured>,
    pitch_deg: Option<Measured>,
    heading_deg: Option<Measured>,
    speed_mps: Option<Measured>,
}

#[derive(Clone, Copy, Debug)]
struct Measured {
    value: f64,
    at: Time,
}

impl Latest {
    /// Takes one measurement; is it a new position?
    pub(super) fn take(&mut self, attribute: &str, value: &Value, at: Time) -> bool {
        let angle_deg = || match value {
            Value::Quantity(angle) if angle.dimension == Dimension::ANGLE => {
                Some(Measured { value: angle.si.to_degrees(), at })
            }
            _ => None,
        };
        match attribute {
            "location" => {
                let Some(location) = Location::from_value(value) else { return false };
                self.place = Some((location.position, location.altitude_m));
                return true;
            }
            "roll-angle" => self.roll_deg = angle_deg(),
            "pitch-angle" => self.pitch_deg = angle_deg(),
            "heading" => self.heading_deg = angle_deg(),
            "ground-speed" => {
                self.speed_mps = value.as_number().map(|(value, _)| Measured { value, at });
            }
            "scanner-state" => self.is_on = value.as_symbol().is_some_and(|state| state.is("on")),
            _ => {}
        }
        false
    }

    /// Roll, pitch and heading at `at`; none if one of them is not in the record, or too old.
    pub(super) fn attitude(&self, at: Time) -> Option<Attitude> {
        Some(Attitude {
            heading_deg: known(self.heading_deg, at)?,
            pitch_deg: known(self.pitch_deg, at)?,
            roll_deg: known(self.roll_deg, at)?,
        })
    }

    /// Speed over ground at `at`; 0 if it is not in the record.
    pub(super) fn ground_speed_mps(&self, at: Time) -> f64 {
        known(self.speed_mps, at).unwrap_or(0.0)
    }
}

fn known(measured: Option<Measured>, at: Time) -> Option<f64> {
    measured.filter(|measured| (at - measured.at).seconds() <= AGE_S_MAX).map(|measured| measured.value)
}
