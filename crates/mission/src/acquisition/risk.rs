//! Risk of a manoeuvre: the greatest share that it uses of a limit of the flight, 0 to 1: of the clearance over ground, of the distance from
//! restricted zones, and of the wind that the vehicle bears.
//!
//! The limits are those that the mission requires, otherwise the figures with which heights are chosen. Bound: O(poses x edges of the zones).

use super::candidates::{FACE_M, clearance_m, ground_m};
use super::goal::AcquisitionGoal;
use crate::Mission;
use apex_geo::plane::Plane;
use apex_geo::terrain::Terrain;
use apex_model::problem::ZoneKind;
use apex_observation::manoeuvres::{Craft, FlownPath, PathPose, Scene};
use apex_requirements::margin::zone::{LocalZone, ZoneBuffer};
use std::fmt;
use std::sync::Arc;

/// Share of a limit up to which a path is at no risk: twice the required distance, or half of the wind.
const SAFE_SHARE: f64 = 0.5;
/// Steps of a risk in all: smaller differences are not worth another answer.
const STEPS: f64 = 100.0;

/// The limit that a manoeuvre uses most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RiskCause {
    /// Clearance over ground.
    Ground,
    /// Distance from a restricted zone.
    Zone,
    /// Wind.
    Wind,
}

impl fmt::Display for RiskCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            RiskCause::Ground => "clearance over ground",
            RiskCause::Zone => "distance from a zone",
            RiskCause::Wind => "wind",
        })
    }
}

/// Share of a limit that is used: 1 at the limit, 0 up to [`SAFE_SHARE`], with its cause.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Risk {
    /// In steps of a hundredth.
    pub(super) share: f64,
    pub(super) cause: RiskCause,
}

impl Risk {
    fn new(share: f64, cause: RiskCause) -> Risk {
        let share = match share {
            share if share.is_nan() => 1.0,
            share if share <= SAFE_SHARE => 0.0,
            share => share.min(1.0),
        };
        Risk { share: libm::round(STEPS * share) / STEPS, cause }
    }

    /// Returns the greater of two risks, the first of equal ones.
    fn or(self, other: Risk) -> Risk {
        if other.share > self.share { other } else { self }
    }
}

/// The limits of a mission at one target.
pub(super) struct RiskLimits {
    clearance_m: f64,
    ground_m: f64,
    terrain: Option<Arc<Terrain>>,
    buffer: ZoneBuffer,
    /// Restricted zones on the plane around the target, with the times in which they are active.
    zones: Vec<(LocalZone, (f64, f64))>,
}

impl RiskLimits {
    /// Returns the limits at the target of a goal.
    pub(super) fn of(mission: &Mission, goal: &AcquisitionGoal) -> RiskLimits {
        let plane = Plane::new(goal.position);
        let usual = ZoneBuffer { horizontal_m: FACE_M, vertical_m: FACE_M, time_s: 0.0 };
        let restricted = mission.zones.iter().enumerate().filter(|(_, zone)| zone.kind == ZoneKind::Restricted);
        let zones = restricted.filter_map(|(number, zone)| {
            Some((LocalZone::new(number, zone, &plane)?, (zone.active.from_s, zone.active.until_s)))
        });
        RiskLimits {
            clearance_m: clearance_m(mission),
            ground_m: ground_m(mission, goal),
            terrain: mission.terrain.clone(),
            buffer: mission.requirements.airspace.unwrap_or(usual),
            zones: zones.collect(),
        }
    }

    /// Returns the risk of a flown path.
    pub(super) fn risk(&self, flown: &FlownPath, craft: &Craft, scene: &Scene) -> Risk {
        let wind = Risk::new(scene.wind_mps() / craft.wind_mps_max, RiskCause::Wind);
        let until_s = scene.from_s + flown.time_s;
        let near: Vec<&LocalZone> = self
            .zones
            .iter()
            .filter(|(_, (from_s, to_s))| *from_s < until_s && *to_s > scene.from_s)
            .map(|(zone, _)| zone)
            .collect();
        flown
            .poses
            .iter()
            .fold(wind, |most, pose| most.or(self.of_ground(pose, scene)).or(self.of_zones(pose, &near, scene)))
    }

    fn of_ground(&self, pose: &PathPose, scene: &Scene) -> Risk {
        let terrain = self.terrain.as_ref().and_then(|terrain| terrain.elevation_m_at(scene.position(pose.point)));
        self.over_ground(scene.elevation_m + pose.height_m - terrain.unwrap_or(self.ground_m))
    }

    /// Returns the risk at a height over ground.
    pub(super) fn over_ground(&self, height_m: f64) -> Risk {
        Risk::new(if height_m > 0.0 { self.clearance_m / height_m } else { 1.0 }, RiskCause::Ground)
    }

    fn of_zones(&self, pose: &PathPose, near: &[&LocalZone], scene: &Scene) -> Risk {
        let altitude_m = scene.elevation_m + pose.height_m;
        let margins = near.iter().map(|zone| zone.keep_out_m(pose.point, altitude_m, &self.buffer));
        let wide_m = self.buffer.horizontal_m.max(self.buffer.vertical_m);
        let share = margins.reduce(f64::min).map_or(0.0, |least_m| wide_m / (wide_m + least_m.max(0.0)));
        Risk::new(share, RiskCause::Zone)
    }
}
