//! Energy for the way to a landing place.

use super::commanded::FlightOrder;
use super::readings::{LandingSite, Reading, Scene};
use super::response::Response;
use crate::descent::Descent;
use crate::vehicle::Airframe;
use apex_geo::geodesy::{self, Position};
use apex_geo::wind::triangle;
use apex_model::quantity::Dimension;
use apex_requirements::Concern;
use apex_requirements::margin::energy;
use apex_vehicle::EnergyModel;

/// Detour of the way home, as a factor of the distance.
const DETOUR: f64 = 1.1;
/// Margin where the wind leaves no way home, negative.
const NO_WAY_S: f64 = 86_400.0;

impl<'a> Scene<'a> {
    /// Returns the flight time left: as reported or, for a vehicle that reports fuel or charge instead, what these allow at cruise.
    pub(super) fn endurance_s(&self) -> Option<f64> {
        let full = self.mission.model.stored_full();
        let share = || match self.mission.model.energy {
            EnergyModel::Fuel(_) => self.flown.fuel_kg.map(|fuel_kg| fuel_kg / full),
            EnergyModel::Battery(_) => self.flown.charge,
        };
        self.flown.endurance_s.or_else(|| share().map(|share| share * self.mission.model.endurance_cruise_s()))
    }

    pub(super) fn energy(&self) -> Option<Reading> {
        let reserve_s = self.requirements().energy_reserve_s?;
        let endurance_s = self.endurance_s()?;
        let left_s = |position: Position, altitude_m: f64, after_s: f64| {
            let (site, way) = self.way_to_site(position);
            self.energy_left_s((endurance_s - after_s, reserve_s), way, (altitude_m, &site))
        };
        let open = self.nearest_open_site(false);
        let mut site = open;
        let nearest = self.nearest_site(self.here).0;
        let is_nearest = open.name == nearest.name;
        let left_s = |position: Position, altitude_m: f64, after_s: f64| match is_nearest {
            true => left_s(position, altitude_m, after_s),
            // A storm closes the nearest site.
            false => {
                let way = geodesy::inverse(position, open.position);
                self.energy_left_s((endurance_s - after_s, reserve_s), way, (altitude_m, &open))
            }
        };
        let mut margin = left_s(self.here, self.flown.altitude_m, 0.0);
        if margin < 0.0
            && let Some((better, left_s)) = self.site_of_most_energy((endurance_s, reserve_s))
        {
            (site, margin) = (better, left_s);
        }
        // Every second flown costs one, and the way home may grow as fast: before half of the margin nothing can be violated.
        // A vehicle that lands descends on the way, and cannot land earlier.
        let is_landing = matches!(self.order, Some(FlightOrder::Land(_)));
        let after_s = if is_landing || margin > 4.0 * self.requirements().look_ahead_s {
            None
        } else {
            self.first_below(|state| left_s(self.plane.position(state.point), state.altitude_m, state.after_s))
        };
        let is_critical = margin < -0.5 * reserve_s;
        let response = match self.mission.model.airframe {
            Airframe::Rotorcraft if is_critical => Response::LandHere,
            _ => Response::LandAt,
        };
        Some(Reading {
            concern: Concern::Energy,
            name: "energy",
            margin,
            unit: Dimension::TIME,
            after_s,
            response_s: self.turn_away_s(),
            what: site.name.to_string(),
            response,
        })
    }

    /// Returns the endurance that is left, beyond the reserve, after a way home of this length on this track and the descent from one
    /// altitude to another. The wind of the way is the forecast or the one measured now, whichever delays more: a forecast that is wrong
    /// here is wrong on the way, too.
    fn energy_left_s(
        &self,
        (endurance_s, reserve_s): (f64, f64),
        (distance_m, track_deg): (f64, f64),
        (from_altitude_m, site): (f64, &LandingSite<'_>),
    ) -> f64 {
        let model = &self.mission.model;
        let cruise_mps = model.true_airspeed_m_s_cruise;
        let forecast_mps = self.ground_speed_mps(track_deg, cruise_mps);
        let measured_mps = self.flown.wind().map(|wind| {
            let at = |airspeed_mps: f64| triangle(track_deg, airspeed_mps, wind).map(|found| found.ground_speed_mps);
            at(cruise_mps).or_else(|| at(model.true_airspeed_m_s_max)).unwrap_or(0.0)
        });
        let home_mps = measured_mps.map_or(forecast_mps, |measured_mps| measured_mps.min(forecast_mps));
        let arrives_s = self.now_s + if home_mps > 0.0 { DETOUR * distance_m / home_mps } else { 0.0 };
        let landing_s = self.landing_endurance_s(from_altitude_m, site, arrives_s);
        energy::energy(endurance_s - landing_s, reserve_s, 1.0, DETOUR * distance_m, home_mps).max(-NO_WAY_S)
    }

    /// Returns the energy of a descent as the time of level flight for which it lasts, as the vehicle counts its endurance.
    /// A vehicle that lands already has most of the turns behind it.
    fn landing_endurance_s(&self, from_altitude_m: f64, site: &LandingSite<'_>, arrives_s: f64) -> f64 {
        let model = &self.mission.model;
        let airspeed_mps = self.flown.true_airspeed_mps.unwrap_or(model.true_airspeed_m_s_cruise);
        let level = model.drain_per_s(airspeed_mps, self.flown.altitude_m, 0.0);
        let altitudes_m = (from_altitude_m, site.elevation_m);
        if matches!(self.order, Some(FlightOrder::Land(_))) {
            return Descent::straight(model, altitudes_m).energy / level;
        }
        let wind_mps = |altitude_m: f64| self.wind_over_mps(site.position, altitude_m, arrives_s);
        Descent::new(model, altitudes_m, &wind_mps).energy / level
    }

    /// Returns the endurance that is left at a landing site, beyond the reserve.
    fn site_left_s(&self, energy_s: (f64, f64), site: &LandingSite<'_>) -> f64 {
        self.energy_left_s(energy_s, geodesy::inverse(self.here, site.position), (self.flown.altitude_m, site))
    }

    /// Returns the landing site that leaves most endurance, where the nearest one leaves too little: it may lie against the wind.
    fn site_of_most_energy(&self, energy_s: (f64, f64)) -> Option<(LandingSite<'a>, f64)> {
        let left_s = |site: LandingSite<'a>| (site, self.site_left_s(energy_s, &site));
        let most = |sites: &mut dyn Iterator<Item = LandingSite<'a>>| {
            sites.map(left_s).max_by(|(_, a), (_, b)| a.total_cmp(b))
        };
        // A storm over the only site in reach is a lesser evil than no energy.
        let open = most(&mut self.landing_sites().filter(|site| !self.is_closed_by_storm(site)));
        open.filter(|(_, left_s)| *left_s > -energy_s.1).or_else(|| most(&mut self.landing_sites()))
    }

    /// Returns the landing site to which a violation of the energy requirement leads.
    pub(super) fn site_for_energy(&self) -> LandingSite<'a> {
        let reserve_s = self.requirements().energy_reserve_s.unwrap_or(0.0);
        let nearest = self.nearest_open_site(false);
        let Some(endurance_s) = self.endurance_s() else { return nearest };
        let near_s = self.site_left_s((endurance_s, reserve_s), &nearest);
        let better = self.site_of_most_energy((endurance_s, reserve_s)).filter(|_| near_s < 0.0);
        better.map_or(nearest, |(site, _)| site)
    }
}
