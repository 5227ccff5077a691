//! Energy for the way to a landing place.

use super::readings::{LandingSite, Reading, Scene};
use super::response::Response;
use crate::vehicle::Airframe;
use apex_geo::geodesy::{self, Position};
use apex_geo::wind::triangle;
use apex_model::quantity::Dimension;
use apex_requirements::Concern;
use apex_requirements::margin::energy;

/// Detour of the way home, as a factor of the distance.
const DETOUR: f64 = 1.1;
/// Margin where the wind leaves no way home, negative.
const NO_WAY_S: f64 = 86_400.0;

impl<'a> Scene<'a> {
    pub(super) fn energy(&self) -> Option<Reading> {
        let reserve_s = self.requirements().energy_reserve_s?;
        let endurance_s = self.flown.endurance_s?;
        let left_s = |position: Position, after_s: f64| {
            let (_, (distance_m, track_deg)) = self.way_to_site(position);
            self.energy_left_s((endurance_s - after_s, reserve_s), (distance_m, track_deg))
        };
        let mut margin = left_s(self.here, 0.0);
        let mut site = self.nearest_site(self.here).0;
        if margin < 0.0
            && let Some((better, left_s)) = self.site_of_most_energy((endurance_s, reserve_s))
        {
            (site, margin) = (better, left_s);
        }
        // A second of flight uses a second of endurance, and the way home may get longer by a second: no violation within half of the
        // margin.
        let after_s = if margin > 4.0 * self.requirements().look_ahead_s {
            None
        } else {
            self.first_below(|state| left_s(self.plane.position(state.point), state.after_s))
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

    /// Returns the endurance that is left, beyond the reserve, after a way home of this length on this track. The wind of the way is the
    /// forecast or the one measured now, whichever delays more: a forecast that is wrong here is wrong on the way, too.
    fn energy_left_s(&self, (endurance_s, reserve_s): (f64, f64), (distance_m, track_deg): (f64, f64)) -> f64 {
        let model = &self.mission.model;
        let cruise_mps = model.true_airspeed_m_s_cruise;
        let forecast_mps = self.ground_speed_mps(track_deg, cruise_mps);
        let measured_mps = self.flown.wind().map(|wind| {
            let at = |airspeed_mps: f64| triangle(track_deg, airspeed_mps, wind).map(|found| found.ground_speed_mps);
            at(cruise_mps).or_else(|| at(model.true_airspeed_m_s_max)).unwrap_or(0.0)
        });
        let home_mps = measured_mps.map_or(forecast_mps, |measured_mps| measured_mps.min(forecast_mps));
        energy::energy(endurance_s, reserve_s, 1.0, DETOUR * distance_m, home_mps).max(-NO_WAY_S)
    }

    /// Returns the landing site that leaves most endurance, where the nearest one leaves too little: it may lie against the wind.
    fn site_of_most_energy(&self, energy_s: (f64, f64)) -> Option<(LandingSite<'a>, f64)> {
        let left_s = |site: &LandingSite<'_>| self.energy_left_s(energy_s, geodesy::inverse(self.here, site.position));
        let sites = self.landing_sites().map(|site| (site, left_s(&site)));
        sites.max_by(|(_, a), (_, b)| a.total_cmp(b))
    }

    /// Returns the landing site to which a violation of the energy requirement leads.
    pub(super) fn site_for_energy(&self) -> LandingSite<'a> {
        let reserve_s = self.requirements().energy_reserve_s.unwrap_or(0.0);
        let nearest = self.nearest_site(self.here).0;
        let Some(endurance_s) = self.flown.endurance_s else { return nearest };
        let near_s = self.energy_left_s((endurance_s, reserve_s), geodesy::inverse(self.here, nearest.position));
        let better = self.site_of_most_energy((endurance_s, reserve_s)).filter(|_| near_s < 0.0);
        better.map_or(nearest, |(site, _)| site)
    }
}
