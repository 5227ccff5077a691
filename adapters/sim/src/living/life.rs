//! State of the dynamic world during a flight: failures, moving weather, fires, detectors, ice and the downlink.

use super::disturbances::Disturbances;
use super::downlink::Downlink;
use super::faults::Faults;
use super::ignitions::Ignitions;
use super::perimeters::Perimeters;
use super::wind_error::WindError;
use super::{FaultKind, LivingWorld};
use apex_geo::wind::Wind;
use apex_model::problem::Position;
use apex_model::time::Time;
use libm::exp;

/// Thermal model of a detector: heat while powered (W), loss to the surroundings (W/K), heat capacity (J/K).
const DETECTOR_W: f64 = 30.0;
const DETECTOR_W_PER_K: f64 = 2.0;
const DETECTOR_W_PER_K_UNCOOLED: f64 = 0.5;
const DETECTOR_J_PER_K: f64 = 600.0;
/// Temperature of the surroundings of detectors.
pub(crate) const BAY_K: f64 = 293.15;
/// Detector temperature from which no images are delivered.
pub(crate) const DETECTOR_K_MAX: f64 = 343.15;
/// Ice forms in clouds between these temperatures, K.
const ICING_K: std::ops::RangeInclusive<f64> = 253.15..=273.15;
/// Seconds of icing that double the drain of energy.
const ICE_S_DOUBLING: f64 = 1_200.0;
/// Ratio of the rates at which ice disappears and forms.
const THAW: f64 = 2.0;

/// State of the dynamic world.
#[derive(Clone, Debug)]
pub(crate) struct Living {
    pub(crate) spec: LivingWorld,
    pub(crate) seed: u64,
    pub(crate) faults: Faults,
    pub(crate) ignitions: Option<Ignitions>,
    pub(crate) perimeters: Option<Perimeters>,
    pub(crate) wind_error: Option<WindError>,
    pub(crate) downlink: Option<Downlink>,
    pub(crate) disturbances: Disturbances,
    /// Temperature of each camera's detector.
    pub(crate) detectors_k: Vec<f64>,
    /// Seconds of icing that the airframe carries.
    pub(crate) ice_s: f64,
    /// Civil time of mission time zero, if the mission states it.
    pub(crate) epoch_unix_s: Option<f64>,
}

impl Living {
    /// Returns the true wind, computed from the `wind` of the mission's weather.
    pub(crate) fn wind(&self, wind: Wind, position: Position, altitude_m: f64, time_s: f64) -> Wind {
        let mut wind = match &self.wind_error {
            Some(error) => error.applied(wind, position, time_s),
            None => wind,
        };
        for storm in &self.spec.storms {
            let inside = altitude_m < storm.top_m && storm.distance_m(position, time_s).is_some_and(|m| m < 0.0);
            if inside {
                wind.edr = wind.edr.max(storm.edr);
            }
        }
        wind
    }

    /// Returns the energy drained in addition, as a factor and an amount for each second.
    pub(crate) fn drain(&self, is_fuel: bool, now: Time) -> (f64, f64) {
        let leak = self.faults.find(FaultKind::Leak, "", now).and_then(|span| span.by).unwrap_or(0.0);
        (1.0 + self.ice_s / ICE_S_DOUBLING, if is_fuel { leak / 3_600.0 } else { leak })
    }

    pub(crate) fn is_in_cloud(&self, position: Position, altitude_m: f64, time_s: f64) -> bool {
        super::sky::is_in_cloud(&self.spec.clouds, position, altitude_m, time_s)
    }

    /// Returns true if ice forms on an aircraft here.
    pub(crate) fn is_icing(&self, position: Position, altitude_m: f64, temperature_k: f64, time_s: f64) -> bool {
        ICING_K.contains(&temperature_k) && self.is_in_cloud(position, altitude_m, time_s)
    }

    /// Forms ice for `dt` seconds, or removes it if there is no icing.
    pub(crate) fn freeze(&mut self, icing: bool, dt: f64) {
        self.ice_s = if icing { self.ice_s + dt } else { (self.ice_s - THAW * dt).max(0.0) };
    }

    /// Warms or cools the detector of a camera for `dt` seconds; exact for any length of step.
    pub(crate) fn warm(&mut self, camera: usize, powered: bool, cooled: bool, dt: f64) {
        let heat = if powered { DETECTOR_W } else { 0.0 };
        let loss = if cooled { DETECTOR_W_PER_K } else { DETECTOR_W_PER_K_UNCOOLED };
        let end_k = BAY_K + heat / loss;
        if let Some(detector_k) = self.detectors_k.get_mut(camera) {
            *detector_k = end_k + (*detector_k - end_k) * exp(-loss / DETECTOR_J_PER_K * dt);
        }
    }

    /// Returns the next instant at which something begins or ends.
    pub(crate) fn next_due(&self, now: Time) -> Option<Time> {
        let fire = self.ignitions.as_ref().and_then(Ignitions::next_s);
        let report = self.perimeters.as_ref().and_then(Perimeters::next_s);
        let instant = |at_s: f64| crate::instants::not_before(Time::from_seconds(at_s).max(Time::ZERO));
        let others = fire.into_iter().chain(report).map(instant);
        self.faults.next_change(now).into_iter().chain(others).min()
    }
}

/// Returns the next instant at which the dynamic world changes, without any command.
pub(crate) fn next_due(living: Option<&Living>, now: Time) -> Option<Time> {
    living.and_then(|living| living.next_due(now))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn living() -> Living {
        Living {
            spec: LivingWorld::default(),
            seed: 1,
            faults: Faults::new(&[], 1),
            ignitions: None,
            perimeters: None,
            wind_error: None,
            downlink: None,
            disturbances: Disturbances::default(),
            detectors_k: vec![BAY_K],
            ice_s: 0.0,
            epoch_unix_s: None,
        }
    }

    /// The cooled detector reaches 35 degrees Celsius; without cooling it reaches 45 degrees after C/G ln(45/35) = 302 s.
    #[test]
    fn a_detector_without_cooling_gets_hot() {
        let mut living = living();
        (0..3_600).for_each(|_| living.warm(0, true, true, 1.0));
        assert!((living.detectors_k[0] - 308.15).abs() < 0.01, "{:?}", living.detectors_k);
        let mut seconds = 0;
        while living.detectors_k[0] < 318.15 {
            living.warm(0, true, false, 1.0);
            seconds += 1;
        }
        assert!((301..=303).contains(&seconds), "{seconds}");
        let mut coarse = living.clone();
        (0..100).for_each(|_| living.warm(0, true, false, 1.0));
        coarse.warm(0, true, false, 100.0);
        assert!((living.detectors_k[0] - coarse.detectors_k[0]).abs() < 1e-9);
    }

    #[test]
    fn ice_costs_energy_and_thaws() {
        let mut living = living();
        living.freeze(true, 600.0);
        assert_eq!(living.drain(true, Time::ZERO), (1.5, 0.0));
        living.freeze(false, 300.0);
        assert_eq!(living.drain(true, Time::ZERO), (1.0, 0.0));
    }
}
