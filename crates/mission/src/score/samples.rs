//! The last measured state of the vehicle, as far as it matters for the sensors' view.

use apex_model::event::StateVariable;
use apex_model::planned::Location;
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_observation::attitude::Attitude;
use apex_observation::sensor::GimbalAngles;
use apex_observation::strip::AngularRates;
use std::collections::BTreeMap;

/// An angle or speed older than this is unknown.
const AGE_S_MAX: f64 = 2.5;

/// The latest measurements.
#[derive(Clone, Debug, Default)]
pub(super) struct Latest {
    /// Position and altitude above mean sea level: the true ones if the record contains them, otherwise the reported ones.
    pub(super) place: Option<(Position, f64)>,
    /// True positions are not read: on board only the reported ones are known.
    pub(super) is_blind_to_truth: bool,
    /// Instant of the last true position.
    truth_at: Option<Time>,
    /// The scanner is on.
    pub(super) is_on: bool,
    /// Share of the line of sight that is free of cloud, if recorded.
    pub(super) clear_share: Option<f64>,
    roll_deg: Option<TimedValue>,
    pitch_deg: Option<TimedValue>,
    heading_deg: Option<TimedValue>,
    speed_mps: Option<TimedValue>,
    /// Angles of the mounts of cameras by their names.
    tilts_deg: BTreeMap<String, f64>,
    pans_deg: BTreeMap<String, f64>,
    /// The last two samples of roll, pitch and heading, for the rate at which the body turns.
    turns: [Option<(Attitude, Time)>; 2],
}

#[derive(Clone, Copy, Debug)]
struct TimedValue {
    value: f64,
    at: Time,
}

impl Latest {
    /// Processes one measurement. Returns true for a new position.
    pub(super) fn take(&mut self, variable: &StateVariable, value: &Value, at: Time) -> bool {
        let (attribute, object) = (variable.attribute.folded(), &variable.object);
        let angle_deg = || match value {
            Value::Quantity(angle) if angle.dimension == Dimension::ANGLE => {
                Some(TimedValue { value: angle.si.to_degrees(), at })
            }
            _ => None,
        };
        match attribute {
            "camera-tilt" | "camera-pan" => {
                let Some(angle) = angle_deg() else { return false };
                let angles = if attribute == "camera-tilt" { &mut self.tilts_deg } else { &mut self.pans_deg };
                angles.insert(object.to_string().to_lowercase(), angle.value);
            }
            "location" | "truth-location" => {
                let Some(location) = Location::from_value(value) else { return false };
                if attribute == "truth-location" {
                    if self.is_blind_to_truth {
                        return false;
                    }
                    self.truth_at = Some(at);
                } else if self.truth_at == Some(at) {
                    return true;
                }
                self.place = Some((location.position, location.altitude_m));
                return true;
            }
            "roll-angle" => self.roll_deg = angle_deg(),
            "pitch-angle" => self.pitch_deg = angle_deg(),
            "heading" => self.heading_deg = angle_deg(),
            "ground-speed" => {
                self.speed_mps = value.as_number().map(|(value, _)| TimedValue { value, at });
            }
            "scanner-state" => self.switch(value),
            _ => {}
        }
        false
    }

    /// Processes the state of the scanner, which also reports clouds: ground that they hide counts as seen but not clear. Ground is known
    /// to be cloud-free only if clouds are reported.
    fn switch(&mut self, state: &Value) {
        let is = |word: &str| value_is(state, word);
        self.is_on = is("on") || is("obscured");
        if is("obscured") {
            self.clear_share = Some(0.0);
        } else if self.clear_share.is_some() {
            self.clear_share = Some(1.0);
        }
    }

    /// Returns roll, pitch and heading at `at`; `None` if one of them is missing or too old.
    pub(super) fn attitude(&self, at: Time) -> Option<Attitude> {
        Some(Attitude {
            heading_deg: known(self.heading_deg, at)?,
            pitch_deg: known(self.pitch_deg, at)?,
            roll_deg: known(self.roll_deg, at)?,
        })
    }

    /// Angles of a camera's mount; `None` before the first report.
    pub(super) fn angles(&self, camera: &str) -> Option<GimbalAngles> {
        let name = camera.to_lowercase();
        Some(GimbalAngles { pan_deg: *self.pans_deg.get(&name)?, tilt_deg: *self.tilts_deg.get(&name)? })
    }

    /// Stores the attitude at `at`, for the rate at which it changes.
    pub(super) fn turn(&mut self, at: Time) {
        let Some(attitude) = self.attitude(at) else { return };
        let [_, last] = self.turns;
        if last.is_none_or(|(_, before)| before < at) {
            self.turns = [last, Some((attitude, at))];
        }
    }

    /// Returns the angular rate of the body at the last sample, rad/s; 0 if samples are too far apart to tell.
    pub(super) fn rotation_rad_s(&self) -> f64 {
        let [Some((first, from)), Some((last, to))] = self.turns else { return 0.0 };
        let span_s = (to - from).seconds();
        if span_s <= 0.0 || span_s > AGE_S_MAX {
            return 0.0;
        }
        let rates = AngularRates::between(&first, &last, span_s);
        libm::sqrt(rates.roll * rates.roll + rates.pitch * rates.pitch + rates.yaw * rates.yaw)
    }

    /// Returns the speed over ground at `at`; 0 if it is not recorded.
    pub(super) fn ground_speed_mps(&self, at: Time) -> f64 {
        known(self.speed_mps, at).unwrap_or(0.0)
    }
}

fn value_is(value: &Value, word: &str) -> bool {
    value.as_symbol().is_some_and(|symbol| symbol.is(word))
}

fn known(measured: Option<TimedValue>, at: Time) -> Option<f64> {
    measured.filter(|measured| (at - measured.at).seconds() <= AGE_S_MAX).map(|measured| measured.value)
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    reason = "a test stops at an unexpected result; the numbers are copies"
)]
mod tests {
    use super::{Latest, StateVariable, Time, Value};
    use apex_model::symbol::Symbol;

    /// Returns the longitude of the place after a reported and a true position of the same instant.
    fn longitude(is_blind_to_truth: bool) -> f64 {
        let mut latest = Latest { is_blind_to_truth, ..Latest::default() };
        for (attribute, longitude) in [("location", 8.2), ("truth-location", 7.8), ("location", 8.2)] {
            let variable = StateVariable::new(Symbol::new(attribute), Value::symbol("uav-1"));
            latest.take(&variable, &Value::list([46.5, longitude, 6_000.0].map(Value::Real)), Time::from_seconds(9.0));
        }
        latest.place.unwrap().0.longitude_deg
    }

    #[test]
    fn the_true_position_counts_unless_only_the_known_one_is_read() {
        assert_eq!((longitude(false), longitude(true)), (7.8, 8.2));
    }
}
