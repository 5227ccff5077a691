//! Doubts about a mission whose data are valid: requirements and visits that a flight cannot keep or make as planned.

use crate::energy::energy;
use crate::site_pictures::{self, Daylight};
use crate::situation::Situation;
use crate::visit_altitude::sites;
use crate::{Mission, Target, TargetKind};
use apex_geo::{geodesy, wind};

/// Distance from the start and from every target beyond which the coordinates of a zone are doubted.
const ZONE_FAR_M: f64 = 2.0e6;

impl Mission {
    /// Returns sentences about sites of which visits give no valid picture, about forecast air at cruise altitude that a requirement does
    /// not permit or in which the vehicle does not advance, about a vehicle without sensors, about targets and zones far away, and about properties and scripted messages without
    /// effect; empty for most missions.
    pub fn doubts(&self) -> Vec<String> {
        let mut found: Vec<String> = Vec::new();
        let mut troubles: Vec<(String, Vec<&str>)> = Vec::new();
        for (site, why) in sites(self).filter_map(|site| Some((site, site_pictures::trouble(self, site)?))) {
            match troubles.iter_mut().find(|(known, _)| *known == why) {
                Some((_, names)) => names.push(&site.id),
                None => troubles.push((why, vec![&site.id])),
            }
        }
        let all = |(why, names): (String, Vec<&str>)| {
            format!("no visit of {} gives a valid picture: {why}", names.join(", "))
        };
        found.extend(troubles.into_iter().map(all));
        let has_fires = self.targets.iter().any(|target| matches!(target.kind, TargetKind::Fire(_)));
        if !has_fires && sites(self).next().is_some() {
            match Daylight::next(self, 0.0) {
                Ok(daylight) => found.extend(daylight.map(|daylight| daylight.told(0.0))),
                Err(dark) => found.push(dark),
            }
        }
        if has_fires {
            found.extend(self.rough_cruise());
        }
        if !self.targets.is_empty() && self.model.sensors.is_empty() {
            found.push(format!(
                "the vehicle `{}` carries no line scanner and no camera: it cannot observe a target",
                self.model.name
            ));
        }
        found.extend(self.strong_wind());
        found.extend(self.distant_targets());
        found.extend(self.distant_zones());
        found.extend(self.data_doubts());
        found
    }

    /// Returns a message about the first target over which the forecast wind is not weaker than the vehicle flies: no way leads against it.
    fn strong_wind(&self) -> Option<String> {
        let (altitude_m, cruise_mps) = (self.cruise_altitude_m(), self.model.true_airspeed_m_s_cruise);
        let end_s = self.settings.duration.seconds();
        let changes_s = self.forecast.layers.iter().map(|layer| layer.from_s);
        let mut times_s: Vec<f64> = changes_s.filter(|at_s| (0.0..end_s).contains(at_s)).chain([0.0]).collect();
        times_s.sort_by(f64::total_cmp);
        let over = |target: &Target, time_s: f64| {
            let there = wind::at(&self.forecast, target.position, altitude_m, time_s);
            libm::hypot(there.east_mps, there.north_mps)
        };
        let visited = self.targets.iter().filter(|target| target.is_observable());
        let mut all = visited.flat_map(|target| times_s.iter().map(move |time_s| (target, *time_s)));
        let (target, time_s) = all.find(|(target, time_s)| over(target, *time_s) >= cruise_mps)?;
        let from = if time_s > 0.0 { format!(" from {:.1} h on", time_s / 3600.0) } else { String::new() };
        Some(format!(
            "the forecast wind over {} at {altitude_m:.0} m is {:.1} m/s{from}, and `{}` cruises at {cruise_mps:.1} m/s: no way leads against \
             this wind",
            target.id,
            over(target, time_s),
            self.model.name
        ))
    }

    /// Returns a message for each target that the vehicle could not reach and come back from with its whole energy, and the strongest wind
    /// behind it.
    fn distant_targets(&self) -> impl Iterator<Item = String> {
        let endurance_s = energy(self, &Situation::default()).endurance_s;
        let speed_mps = self.model.true_airspeed_m_s_cruise + wind::speed_mps_max(&self.forecast);
        let reach_m = 0.5 * endurance_s * speed_mps;
        self.targets.iter().filter_map(move |target| {
            let away_m = geodesy::distance_m(self.start, target.position);
            (away_m > reach_m).then(|| {
                format!(
                    "target {} is {:.0} km from the start, and the vehicle flies {:.0} km at most and back: check the order and the signs of \
                     its coordinates",
                    target.id,
                    away_m / 1e3,
                    reach_m / 1e3
                )
            })
        })
    }

    /// Returns a message for each zone that is far from the start and from all targets: its coordinates are probably wrong.
    fn distant_zones(&self) -> impl Iterator<Item = String> {
        let places: Vec<_> =
            std::iter::once(self.start).chain(self.targets.iter().map(|target| target.position)).collect();
        self.zones.iter().filter_map(move |zone| {
            let all = zone.corners.iter().flat_map(|corner| places.iter().map(move |place| (corner, place)));
            let least_m = all.map(|(corner, place)| geodesy::distance_m(*corner, *place)).reduce(f64::min)?;
            (least_m > ZONE_FAR_M).then(|| {
                format!(
                    "zone {} is {:.0} km from the start and from every target: check the order and the signs of its coordinates",
                    zone.name,
                    least_m / 1e3
                )
            })
        })
    }

    /// Returns true if the quality of an observation depends on its instant: the forecast of winds, turbulence or clouds changes during the
    /// mission, or the sun, which moves, is mirrored by the water of a target.
    pub fn air_changes(&self) -> bool {
        let is_water = |target: &Target| matches!(&target.kind, TargetKind::Fire(fire) if fire.wanted.is_water);
        if self.settings.epoch_unix_s.is_some() && self.targets.iter().any(is_water) {
            return true;
        }
        let end_s = self.settings.duration.seconds();
        let layers = self.forecast.layers.iter().flat_map(|layer| [layer.from_s, layer.until_s]);
        let decks = self.clouds.iter().flat_map(|deck| [deck.active.from_s, deck.active.until_s]);
        layers.chain(decks).any(|at_s| at_s > 0.0 && at_s < end_s)
    }

    /// Returns the first forecast at cruise altitude over a target that a requirement does not permit.
    fn rough_cruise(&self) -> Option<String> {
        let (altitude_m, requirements) = (self.cruise_altitude_m(), &self.requirements);
        let changes = self.forecast.layers.iter().flat_map(|layer| [layer.from_s, layer.until_s]);
        let end_s = self.settings.duration.seconds();
        let mut times_s: Vec<f64> = changes.filter(|at_s| (0.0..end_s).contains(at_s)).chain([0.0]).collect();
        times_s.sort_by(f64::total_cmp);
        let told = |target: &Target, time_s: f64| {
            let there = wind::at(&self.forecast, target.position, altitude_m, time_s);
            let wind_mps = libm::hypot(there.east_mps, there.north_mps);
            let figures = [
                ("turbulence", there.edr, requirements.edr_max, "m^(2/3)/s"),
                ("wind", wind_mps, requirements.wind_mps_max, "m/s"),
            ];
            let exceeded = figures.into_iter().find(|(_, forecast, most, _)| most.is_some_and(|most| *forecast > most));
            exceeded.map(|(name, forecast, most, unit)| {
                format!(
                    "requirement {name} permits at most {} {unit}, and the forecast has {forecast:.2} {unit} over {} at {altitude_m:.0} m, \
                     the altitude of flights between targets: the flight leaves this altitude, and lands after its fourth alarm within \
                     an hour",
                    most.unwrap_or_default(),
                    target.id
                )
            })
        };
        let places = self.targets.iter().filter(|target| matches!(target.kind, TargetKind::Fire(_)));
        let mut all = times_s.iter().flat_map(|time_s| places.clone().map(move |target| (target, *time_s)));
        all.find_map(|(target, time_s)| told(target, time_s))
    }
}
