//! Requirements `terrain` and `airspace` of the flight along the path of a manoeuvre.
//!
//! The watcher responds to a violation ahead, and only a turn or a climb remains then; a manoeuvre that cannot keep a requirement is
//! refused before it begins.
//! Bound: O(samples x edges of the zones), with at most [`SAMPLES_MAX`] samples for each leg.

use crate::Mission;
use apex_geo::geodesy;
use apex_geo::plane::Plane;
use apex_geo::terrain::Terrain;
use apex_model::problem::{AirspaceZone, Position, ZoneKind};
use apex_observation::manoeuvres::{Refusal, rounded_down, rounded_up};
use apex_requirements::margin::zone::{KeepIn, LocalZone, ZoneBuffer};
use std::sync::Arc;

/// Distance of the samples along a leg, and their greatest number.
const STEP_M: f64 = 20.0;
const SAMPLES_MAX: usize = 64;
/// Time of flight within which the ground counts, as for requirement `terrain` ahead.
const GROUND_S: f64 = 1.0;
/// Height by which a vehicle may leave its altitude: a proposed height keeps it in addition.
const LEVEL_M: f64 = 3.0;
/// Deficit that counts as an error of rounding.
const ROUNDING_M: f64 = 0.01;

/// The requirements of a mission on the positions of its vehicle.
#[derive(Clone, Debug)]
pub(super) struct PathRequirements {
    clearance_m: Option<f64>,
    terrain: Option<Arc<Terrain>>,
    ground_reach_m: f64,
    airspace: Option<ZoneBuffer>,
    zones: Vec<AirspaceZone>,
}

/// The path of a manoeuvre with the data of its target.
pub(super) struct PlacedPath<'a> {
    /// Name of the manoeuvre in PDL.
    pub(super) name: &'a str,
    /// Points with altitudes above mean sea level, in the order of flight.
    pub(super) points: &'a [(Position, f64)],
    /// Height of the manoeuvre above the target.
    pub(super) height_m: f64,
    /// Elevation of the target, and of the ground where no terrain is known.
    pub(super) target_m: f64,
    pub(super) ground_m: f64,
    /// Begin and end, in seconds of mission time.
    pub(super) span_s: (f64, f64),
}

impl PathRequirements {
    /// Returns the requirements of a mission.
    pub(super) fn of(mission: &Mission) -> PathRequirements {
        PathRequirements {
            airspace: mission.requirements.airspace,
            zones: mission.zones.clone(),
            ..PathRequirements::of_terrain(mission)
        }
    }

    /// Returns the requirement `terrain` of a mission alone: a plan does not know yet when it flies the path, and zones have times.
    pub(super) fn of_terrain(mission: &Mission) -> PathRequirements {
        PathRequirements {
            clearance_m: mission.requirements.terrain_clearance_m,
            terrain: mission.terrain.clone(),
            ground_reach_m: GROUND_S * mission.model.true_airspeed_m_s_cruise,
            airspace: None,
            zones: Vec::new(),
        }
    }

    /// Checks a path.
    ///
    /// # Errors
    /// The requirement that it breaks, its limit, and a height that keeps it.
    pub(super) fn check(&self, path: &PlacedPath<'_>) -> Result<(), Refusal> {
        let samples = samples(path.points);
        self.check_terrain(path, &samples)?;
        self.check_airspace(path, &samples)
    }

    fn check_terrain(&self, path: &PlacedPath<'_>, samples: &[(Position, f64)]) -> Result<(), Refusal> {
        let Some(clearance_m) = self.clearance_m else { return Ok(()) };
        let lacking_m = |(position, altitude_m): &(Position, f64)| {
            let terrain = self.terrain.as_ref();
            let ground_m = terrain.and_then(|terrain| terrain.highest_m_near(*position, self.ground_reach_m));
            ground_m.unwrap_or(path.ground_m) + clearance_m - altitude_m
        };
        let Some(lacking_m) = samples.iter().map(lacking_m).reduce(f64::max) else { return Ok(()) };
        if lacking_m <= ROUNDING_M {
            return Ok(());
        }
        let limit_m = path.height_m + lacking_m;
        Err(Refusal {
            manoeuvre: path.name.to_string(),
            figure: "a height".to_string(),
            value: path.height_m,
            limit: limit_m,
            unit: "m".into(),
            because: format!("requirement terrain keeps {clearance_m:.0} m above the ground along its path").into(),
            nearest: format!("{} m works", rounded_up(limit_m + LEVEL_M, 0)),
        })
    }

    fn check_airspace(&self, path: &PlacedPath<'_>, samples: &[(Position, f64)]) -> Result<(), Refusal> {
        let (Some(buffer), Some((middle, _))) = (self.airspace, samples.first()) else { return Ok(()) };
        let plane = Plane::new(*middle);
        let (from_s, until_s) = (path.span_s.0 - buffer.time_s, path.span_s.1 + buffer.time_s);
        let active = self
            .zones
            .iter()
            .enumerate()
            .filter(|(_, zone)| zone.active.from_s < until_s && zone.active.until_s > from_s);
        let zones: Vec<LocalZone> = active.filter_map(|(number, zone)| LocalZone::new(number, zone, &plane)).collect();
        let mut area: Option<(u64, Option<KeepIn>)> = None;
        for (position, altitude_m) in samples {
            let Some(point) = plane.project(*position) else { continue };
            let is_broken =
                |zone: &&LocalZone| zone.is_restricted() && zone.keep_out_m(point, *altitude_m, &buffer) < -ROUNDING_M;
            if let Some(zone) = zones.iter().find(is_broken).and_then(|zone| self.zones.get(zone.number)) {
                return Err(self.near_zone(path, zone, (*altitude_m, &buffer)));
            }
            if area.as_ref().is_none_or(|(bits, _)| *bits != altitude_m.to_bits()) {
                area = Some((altitude_m.to_bits(), KeepIn::new(&zones, *altitude_m, path.span_s.0)));
            }
            let inside_m = area.as_ref().and_then(|(_, area)| area.as_ref());
            let inside_m = inside_m.map(|area| area.keep_in_m(point, *altitude_m, &buffer));
            if let Some(short_m) = inside_m.filter(|margin_m| *margin_m < -ROUNDING_M).map(f64::abs) {
                return Err(outside(path, short_m, &buffer));
            }
        }
        Ok(())
    }

    /// Returns the refusal of a path that comes too near to a restricted zone.
    fn near_zone(
        &self,
        path: &PlacedPath<'_>,
        zone: &AirspaceZone,
        (altitude_m, buffer): (f64, &ZoneBuffer),
    ) -> Refusal {
        let above_m = zone.altitude_m_max + buffer.vertical_m;
        let below_m = zone.altitude_m_min - buffer.vertical_m;
        let lowest_m = path.ground_m + self.clearance_m.unwrap_or(0.0) + LEVEL_M;
        let is_open_below = zone.kind == ZoneKind::Restricted && below_m - LEVEL_M > lowest_m;
        // Heights of the manoeuvre, by which its points at this altitude are outside.
        let height_m = |limit_m: f64| path.height_m + limit_m - altitude_m;
        let over = rounded_up(height_m(above_m + LEVEL_M), 0);
        let nearest = match is_open_below {
            true => format!("at most {} m or at least {over} m works", rounded_down(height_m(below_m - LEVEL_M), 0)),
            false => format!("{over} m works, or a place farther away"),
        };
        let nearer_m = if is_open_below && altitude_m - below_m < above_m - altitude_m { below_m } else { above_m };
        Refusal {
            manoeuvre: path.name.to_string(),
            figure: "a height".to_string(),
            value: path.height_m,
            limit: height_m(nearer_m),
            unit: "m".into(),
            because: format!(
                "requirement airspace keeps {:.0} m from the faces of zone `{}`, {:.0} m to {:.0} m above sea level, and {:.0} m from its \
                 edges; the target lies at {:.0} m",
                buffer.vertical_m,
                zone.name,
                zone.altitude_m_min,
                zone.altitude_m_max,
                buffer.horizontal_m,
                path.target_m
            )
            .into(),
            nearest,
        }
    }
}

/// Returns the refusal of a path that leaves the permitted area or comes too near to its limits.
fn outside(path: &PlacedPath<'_>, short_m: f64, buffer: &ZoneBuffer) -> Refusal {
    Refusal {
        manoeuvre: path.name.to_string(),
        figure: "a margin".to_string(),
        value: -short_m,
        limit: 0.0,
        unit: "m".into(),
        because: format!(
            "requirement airspace keeps {:.0} m inside the edges of the permitted area and {:.0} m from its faces",
            buffer.horizontal_m, buffer.vertical_m
        )
        .into(),
        nearest: format!("a path that lies {} m farther inside works", rounded_up(short_m, 0)),
    }
}

/// Returns the points of a path, and points between them.
fn samples(points: &[(Position, f64)]) -> Vec<(Position, f64)> {
    let mut samples: Vec<(Position, f64)> = points.first().copied().into_iter().collect();
    for ((from, from_m), (to, to_m)) in points.iter().zip(points.iter().skip(1)) {
        let (length_m, azimuth_deg) = geodesy::inverse(*from, *to);
        let count = (libm::ceil(length_m / STEP_M) as usize).clamp(1, SAMPLES_MAX);
        for step in 1..count {
            let share = step as f64 / count as f64;
            let position = geodesy::destination(*from, azimuth_deg, share * length_m);
            samples.push((position, from_m + share * (to_m - from_m)));
        }
        samples.push((*to, *to_m));
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::TimeWindow;

    const TARGET: Position = Position { latitude_deg: 37.0, longitude_deg: -120.0 };

    fn zone(kind: ZoneKind, half_m: f64, (low_m, high_m): (f64, f64), active: TimeWindow) -> AirspaceZone {
        let corner = |azimuth_deg: f64| geodesy::destination(TARGET, azimuth_deg, half_m * std::f64::consts::SQRT_2);
        AirspaceZone {
            name: "z".to_string(),
            kind,
            corners: [45.0, 135.0, 225.0, 315.0].map(corner).to_vec(),
            altitude_m_min: low_m,
            altitude_m_max: high_m,
            active,
        }
    }

    /// Checks a line 400 m long over the target, 100 m above sea level, at a height.
    fn checked(zones: Vec<AirspaceZone>, height_m: f64) -> Result<(), String> {
        let requirements = PathRequirements {
            clearance_m: Some(36.0),
            terrain: None,
            ground_reach_m: 12.0,
            airspace: Some(ZoneBuffer { horizontal_m: 60.0, vertical_m: 18.0, time_s: 120.0 }),
            zones,
        };
        let ends = [0.0, 180.0].map(|azimuth_deg| (geodesy::destination(TARGET, azimuth_deg, 200.0), 100.0 + height_m));
        let path = PlacedPath {
            name: "straight-over",
            points: &ends,
            height_m,
            target_m: 100.0,
            ground_m: 100.0,
            span_s: (600.0, 640.0),
        };
        requirements.check(&path).map_err(|refusal| refusal.to_string())
    }

    #[test]
    fn a_path_near_the_ground_is_refused_with_a_height_that_works() {
        assert_eq!(
            checked(Vec::new(), 5.0).unwrap_err(),
            "`straight-over`: a height of 5 m breaks the limit of 36 m: requirement terrain keeps 36 m above the ground along its path; \
             39 m works"
        );
        assert_eq!(checked(Vec::new(), 36.0), Ok(()));
    }

    #[test]
    fn a_path_keeps_the_distance_from_zones_that_are_active() {
        let always = TimeWindow { from_s: 0.0, until_s: f64::INFINITY };
        // Between the ends of the path, which are outside.
        let low = || vec![zone(ZoneKind::Restricted, 20.0, (0.0, 150.0), always)];
        let refused = checked(low(), 60.0).unwrap_err();
        assert!(
            refused.contains("a height of 60 m breaks the limit of 68 m: requirement airspace keeps 18 m"),
            "{refused}"
        );
        assert!(refused.ends_with("71 m works, or a place farther away"), "{refused}");
        assert_eq!(checked(low(), 71.0), Ok(()));
        let high = vec![zone(ZoneKind::Restricted, 20.0, (200.0, 400.0), always)];
        let refused = checked(high, 90.0).unwrap_err();
        assert!(refused.contains("breaks the limit of 82 m"), "{refused}");
        assert!(refused.ends_with("at most 79 m or at least 321 m works"), "{refused}");
        let later = TimeWindow { from_s: 800.0, until_s: 1e9 };
        assert_eq!(checked(vec![zone(ZoneKind::Restricted, 20.0, (0.0, 150.0), later)], 60.0), Ok(()));
        let soon = TimeWindow { from_s: 700.0, until_s: 1e9 };
        assert!(checked(vec![zone(ZoneKind::Restricted, 20.0, (0.0, 150.0), soon)], 60.0).is_err());
    }

    #[test]
    fn a_path_stays_inside_the_permitted_area() {
        let always = TimeWindow { from_s: 0.0, until_s: f64::INFINITY };
        let permitted = |half_m: f64| vec![zone(ZoneKind::Permitted, half_m, (0.0, 500.0), always)];
        assert_eq!(checked(permitted(300.0), 60.0), Ok(()));
        let refused = checked(permitted(210.0), 60.0).unwrap_err();
        assert!(
            refused.contains("requirement airspace keeps 60 m inside the edges of the permitted area"),
            "{refused}"
        );
        assert!(checked(permitted(150.0), 60.0).is_err());
    }
}
