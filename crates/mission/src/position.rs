//! Reported positions that are accepted: a receiver without a fix reports positions that no vehicle can have reached.
//!
//! A position is accepted if the vehicle can have flown there since the last accepted one, and the first one if it is near to the
//! mission's start or to a target: a receiver often begins without a fix. Another one is doubted, until the reports have
//! agreed with each other for [`AGREED_S`]: then the earlier position was wrong, or the vehicle was moved.

use crate::Mission;
use apex_model::planned::Location;
use apex_model::problem::Position;
use apex_model::value::Value;
use apex_vehicle::VehicleModel;
use serde::{Deserialize, Serialize};

/// Time for which doubted positions must agree to be accepted, in seconds.
const AGREED_S: f64 = 60.0;
/// Greatest wind that carries the vehicle, in m/s: more than the jet stream.
const WIND_MPS: f64 = 120.0;
/// Distance of the first position from the mission's start or a target within which it is accepted: a vehicle may begin at another
/// field, or while it is under way.
const FIRST_M: f64 = 100_000.0;
/// Length of a degree of latitude.
const M_PER_DEG: f64 = 111_320.0;
/// Distance within which positions agree whatever the time: errors of receivers, and coarse reports.
const AGREED_M: f64 = 500.0;

/// The last accepted position of a vehicle, and the doubted ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PositionFilter {
    /// The instant in seconds and the position.
    accepted: Option<(f64, Location)>,
    /// The first instant of the doubted positions, and the last one with its position.
    doubted: Option<(f64, f64, Location)>,
}

impl PositionFilter {
    /// Returns false for a sample of a location that states no position, or one that is not accepted; true for other samples.
    pub(crate) fn admits(&mut self, mission: &Mission, at_s: f64, attribute: &str, value: &Value) -> bool {
        let places = || std::iter::once(mission.start).chain(mission.targets.iter().map(|target| target.position));
        let is_in_region = |here: Position| places().any(|place| distance_m(place, here) <= FIRST_M);
        let mut is_accepted =
            || Location::from_value(value).is_some_and(|here| self.accepts(&mission.model, is_in_region, at_s, here));
        attribute != "location" || is_accepted()
    }

    /// Returns true if a position reported at `at_s` is accepted; the first one must be in the region of the mission.
    fn accepts(
        &mut self,
        model: &VehicleModel,
        is_in_region: impl Fn(Position) -> bool,
        at_s: f64,
        here: Location,
    ) -> bool {
        let speed_mps = model.true_airspeed_m_s_max + WIND_MPS;
        let reaches = |from_s: f64, from: Location| {
            let distance_m = distance_m(from.position, here.position);
            let climb_m = (here.altitude_m - from.altitude_m).abs();
            distance_m.max(climb_m) <= AGREED_M + speed_mps * (at_s - from_s).max(0.0)
        };
        let is_near = match self.accepted {
            Some((from_s, from)) => reaches(from_s, from),
            None => is_in_region(here.position),
        };
        let since_s = match self.doubted {
            Some((since_s, from_s, from)) if reaches(from_s, from) => since_s,
            _ => at_s,
        };
        if is_near || at_s - since_s >= AGREED_S {
            (self.accepted, self.doubted) = (Some((at_s, here)), None);
            return true;
        }
        self.doubted = Some((since_s, at_s, here));
        false
    }
}

/// Returns the distance on a sphere between places near to each other; for places far apart it is far, too.
fn distance_m(from: Position, to: Position) -> f64 {
    let turn_deg = (to.longitude_deg - from.longitude_deg).rem_euclid(360.0);
    let east_deg = turn_deg.min(360.0 - turn_deg) * libm::cos(from.latitude_deg.to_radians());
    libm::hypot(to.latitude_deg - from.latitude_deg, east_deg) * M_PER_DEG
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::quantity::Dimension;

    fn at(latitude_deg: f64, altitude_m: f64) -> Location {
        Location { position: Position::new(latitude_deg, -121.0), altitude_m }
    }

    fn is_in_region(here: Position) -> bool {
        here.latitude_deg > 36.0
    }

    fn model() -> VehicleModel {
        VehicleModel::named("rmax").unwrap()
    }

    #[test]
    fn a_receiver_without_a_fix_is_not_accepted_and_the_next_true_position_is() {
        let (mut filter, model) = (PositionFilter::default(), model());
        assert!(filter.accepts(&model, is_in_region, 0.0, at(37.0, 60.0)));
        for second in 1..10 {
            assert!(!filter.accepts(&model, is_in_region, f64::from(second), at(0.0, 60.0)), "{second}");
        }
        assert!(filter.accepts(&model, is_in_region, 10.0, at(37.0005, 60.0)));
        assert!(!filter.accepts(&model, is_in_region, 11.0, at(37.0005, 1e6)), "no vehicle climbs so fast");
    }

    #[test]
    fn a_receiver_that_begins_without_a_fix_does_not_hide_the_first_true_position() {
        let (mut filter, model) = (PositionFilter::default(), model());
        assert!((0..10).all(|second| !filter.accepts(&model, is_in_region, f64::from(second), at(0.0, 0.0))));
        assert!(filter.accepts(&model, is_in_region, 10.0, at(37.0, 60.0)));
    }

    #[test]
    fn positions_that_agree_for_a_minute_are_accepted() {
        let (mut filter, model) = (PositionFilter::default(), model());
        assert!(filter.accepts(&model, is_in_region, 0.0, at(37.0, 60.0)));
        let accepted =
            (1..=100).find(|second| filter.accepts(&model, is_in_region, f64::from(*second), at(39.0, 60.0)));
        assert_eq!(accepted, Some(61));
    }

    #[test]
    fn after_a_gap_the_vehicle_may_be_as_far_as_it_can_have_flown() {
        let (mut filter, model) = (PositionFilter::default(), model());
        assert!(filter.accepts(&model, is_in_region, 0.0, at(37.0, 60.0)));
        assert!(filter.accepts(&model, is_in_region, 600.0, at(37.5, 60.0)));
    }

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
