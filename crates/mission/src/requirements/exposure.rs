//! Requirements on quantities that accumulate along the commanded route: ice on the airframe, time without link, heat of detectors.

use super::readings::{Reading, Scene};
use super::response::Response;
use crate::link::belief::Beliefs;
use apex_geo::geodesy;
use apex_model::planned::Location;
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_requirements::Concern;
use apex_requirements::margin::sensor::Detector;
use apex_requirements::margin::{link, weather};

/// Steps along the route.
const STEP_S: f64 = 10.0;
/// Temperature falls by this with altitude in the standard atmosphere, K/m.
const LAPSE_K_M: f64 = 0.0065;
/// Zero degrees Celsius.
const ICE_K: f64 = 273.15;
/// Height range around the present altitude in which icing is assumed to continue, because the extent of the cloud is unknown.
const SAME_CLOUD_M: f64 = 250.0;
/// Rate at which ice disappears, as a multiple of the rate at which it forms.
const THAW: f64 = 2.0;
/// Height of a change of altitude after which the vehicle is assumed to have left the ice.
const LAYER_M: f64 = 500.0;
/// A climb takes longer than at the rate with which it begins.
const LEVEL_SHARE: f64 = 1.25;
/// Time in which a camera is switched off.
const SWITCH_S: f64 = 5.0;

impl Scene<'_> {
    /// Returns the seconds of ice on the airframe, compared with the permitted ones; `None` unless icing is reported.
    pub(super) fn icing(&self) -> Option<Reading> {
        let allowed_s = self.requirements().icing_s?;
        let carried_s = self.flown.ice_s?;
        let ahead = self.first_spent(allowed_s, carried_s, THAW, |position, altitude_m, after_s| {
            self.is_icing_at(position, altitude_m, after_s)
        });
        let margin = weather::icing_s(carried_s, allowed_s);
        Some(Reading {
            concern: Concern::Weather,
            name: "icing",
            margin,
            unit: Dimension::TIME,
            after_s: if margin < 0.0 { Some(0.0) } else { ahead },
            response_s: self.leaves_ice_s(),
            what: "icing".to_string(),
            response: Response::Descend,
        })
    }

    /// Returns the time of the change of altitude that ends the icing: to the altitude without ice where ice was met, else by [`LAYER_M`].
    fn leaves_ice_s(&self) -> f64 {
        let level_m = self.flown.ice.level_m.map_or(0.0, |level_m| (level_m - self.flown.altitude_m).abs());
        (LEVEL_SHARE * level_m).max(LAYER_M) / self.motion.climb_mps.min(self.motion.descent_mps).max(0.5)
    }

    /// Returns true if ice may form on the path ahead at an altitude. The extent of a cloud in which ice was met is unknown: near it, only
    /// air that is warm or cold enough ends the icing.
    pub(super) fn may_ice_at_level(&self, altitude_m: f64) -> bool {
        let until_s = self.route.end_s().min(self.requirements().look_ahead_s);
        let steps = libm::ceil(until_s / STEP_S) as u32;
        let is_icing = |number: u32| {
            self.route
                .at((f64::from(number) * STEP_S).min(until_s))
                .is_some_and(|state| self.is_icing_at(self.plane.position(state.point), altitude_m, state.after_s))
        };
        let is_met = self.flown.is_icing || self.flown.ice.is_met_near(self.here);
        is_met && self.is_freezing_at(altitude_m) || (0..=steps).any(is_icing)
    }

    fn is_freezing_at(&self, altitude_m: f64) -> bool {
        let there_k = self.flown.outside_k.map(|here_k| here_k - LAPSE_K_M * (altitude_m - self.flown.altitude_m));
        there_k.is_some_and(|there_k| weather::is_icing(there_k - ICE_K, true, 0.0))
    }

    /// Returns true if icing is expected: between -20 and 0 degrees Celsius, by the measured temperature and the standard lapse rate, in
    /// a forecast cloud or in the cloud around the vehicle.
    pub(super) fn is_icing_at(&self, position: Position, altitude_m: f64, after_s: f64) -> bool {
        let time_s = self.now_s + after_s;
        let is_forecast = self.mission.clouds.iter().any(|deck| deck.contains(position, altitude_m, time_s));
        let is_here = self.flown.is_icing && (altitude_m - self.flown.altitude_m).abs() <= SAME_CLOUD_M;
        (is_forecast || is_here) && self.is_freezing_at(altitude_m)
    }

    /// Returns the worst reading of the links that have a station: the time for which each has been weak, compared with the time allowed.
    pub(super) fn link(&self) -> Option<Reading> {
        let allowed_s = self.requirements().link_lost_s?;
        let mut worst: Option<(f64, Option<f64>, &str)> = None;
        for stated in &self.mission.link_map {
            let beliefs = Beliefs::new(self.mission, stated, self.links.link(&stated.name));
            let since_s = self.flown.weak_since_s.get(&stated.name.to_lowercase());
            let weak_s = since_s.map_or(0.0, |from_s| self.now_s - from_s);
            // The present measurement counts: a weak link is assumed to remain weak on the path ahead.
            let ahead = match weak_s > 0.0 {
                true => Some((allowed_s - weak_s).max(0.0)),
                false => self.first_spent(allowed_s, 0.0, f64::INFINITY, |position, altitude_m, _| {
                    beliefs.weak_at(position, altitude_m).is_some()
                }),
            };
            let margin_s = link::loss_s(weak_s, allowed_s);
            let after_s = if margin_s < 0.0 { Some(0.0) } else { ahead };
            let order = |after: Option<f64>, margin: f64| (after.unwrap_or(f64::INFINITY), margin);
            if worst.is_none_or(|(margin, after, _)| order(after_s, margin_s) < order(after, margin)) {
                worst = Some((margin_s, after_s, &stated.name));
            }
        }
        let (margin, after_s, name) = worst?;
        Some(Reading {
            concern: Concern::Link,
            name: "link",
            margin,
            unit: Dimension::TIME,
            after_s,
            response_s: self.turn_away_s() + self.way_back_s(name),
            what: name.to_string(),
            response: Response::TurnAway,
        })
    }

    /// Returns the flight time to the place where a link was good last; 0 if there is none.
    fn way_back_s(&self, name: &str) -> f64 {
        let good = self.links.link(name).and_then(|learned| learned.good_place);
        let away_m = good.map_or(0.0, |good| geodesy::distance_m(self.here, good.position));
        away_m / self.motion.true_airspeed_mps.max(1.0)
    }

    /// Returns the place where the link of a reading was good last.
    pub(super) fn good_link_place(&self, reading: &Reading) -> Option<Location> {
        self.links.link(&reading.what)?.good_place
    }

    /// Returns the reading of the detector nearest to its limit: by its rate of warming, or by the heat balance of its sensor file.
    pub(super) fn heat(&self) -> Option<Reading> {
        let mut worst: Option<(f64, Option<f64>, &str)> = None;
        for (name, reported) in &self.flown.cameras {
            let carried = self.mission.model.sensors.iter().find(|sensor| sensor.name.eq_ignore_ascii_case(name));
            let file = carried.and_then(|carried| carried.model.temperature.as_ref());
            let limit_k = self.requirements().heat.limit_k(file.map(|file| file.high_c));
            let (Some(carried), Some(limit_k), Some(detector_k)) = (carried, limit_k, reported.detector_k) else {
                continue;
            };
            let rate_k_s = reported.warming_k_s.filter(|rate| *rate > 0.0);
            let by_rate_s = rate_k_s.map(|rate| (limit_k - detector_k) / rate);
            let by_file_s = file.filter(|_| reported.is_pointing).and_then(|file| {
                let detector = Detector {
                    power_w: file.self_heating_w,
                    conductance_w_k: file.conductance_w_k,
                    capacity_j_k: file.heat_capacity_j_k,
                    limit_c: limit_k - ICE_K,
                };
                detector.time_to_limit_s(detector_k - ICE_K, self.flown.outside_k? - ICE_K)
            });
            let soonest_s = by_rate_s.into_iter().chain(by_file_s).reduce(f64::min);
            let margin_k = limit_k - detector_k;
            let ahead = soonest_s.filter(|after_s| *after_s <= self.requirements().look_ahead_s);
            let after_s = if margin_k < 0.0 { Some(0.0) } else { ahead };
            let order = |after: Option<f64>, margin: f64| (after.unwrap_or(f64::INFINITY), margin);
            if worst.is_none_or(|(margin, after, _)| order(after_s, margin_k) < order(after, margin)) {
                worst = Some((margin_k, after_s, &carried.name));
            }
        }
        let (margin, after_s, camera) = worst?;
        Some(Reading {
            concern: Concern::Sensor,
            name: "heat",
            margin,
            unit: Dimension::TEMPERATURE,
            after_s,
            response_s: SWITCH_S,
            what: camera.to_string(),
            response: Response::Cool,
        })
    }

    /// Returns the first instant of the route at which a counter reaches its limit: it rises while `is_spent` holds and falls `recovery`
    /// times as fast otherwise.
    fn first_spent(
        &self,
        allowed_s: f64,
        spent_s: f64,
        recovery: f64,
        is_spent: impl Fn(Position, f64, f64) -> bool,
    ) -> Option<f64> {
        let until_s = self.route.end_s().min(self.requirements().look_ahead_s);
        let count = libm::ceil(until_s / STEP_S) as u32;
        let (mut spent_s, mut before_s) = (spent_s, 0.0);
        for number in 1..=count {
            let after_s = (f64::from(number) * STEP_S).min(until_s);
            let state = self.route.at(0.5 * (before_s + after_s))?;
            let step_s = after_s - before_s;
            if is_spent(self.plane.position(state.point), state.altitude_m, state.after_s) {
                if spent_s + step_s > allowed_s {
                    return Some(before_s + (allowed_s - spent_s).max(0.0));
                }
                spent_s += step_s;
            } else {
                spent_s = (spent_s - recovery * step_s).max(0.0);
            }
            before_s = after_s;
        }
        None
    }
}
