//! Checks of a predicted manoeuvre: requirements along its path, the sun, and restricted zones.
//!
//! Bound: O(poses x edges of the zones).

use super::candidates::{ManoeuvreCandidate, ground_m};
use super::goal::AcquisitionGoal;
use super::permitted::{PathRequirements, PlacedPath};
use crate::Mission;
use crate::requirements::sun_margin_deg;
use apex_geo::geodesy::{self, Position};
use apex_geo::plane::{self, Plane, Point};
use apex_model::problem::{AirspaceZone, ZoneKind};
use apex_observation::manoeuvres::{Forecast, PathPose, Refusal, Scene};
use apex_requirements::margin::sensor::ViewDirection;

/// Checks a candidate that begins at `from_s` by the requirements of the flight on its positions.
pub(super) fn requirements_kept(
    (mission, requirements): (&Mission, &PathRequirements),
    goal: &AcquisitionGoal,
    candidate: &ManoeuvreCandidate,
    (forecast, scene): (&Forecast, &Scene),
    from_s: f64,
) -> Result<(), Refusal> {
    let poses = forecast.flown.poses.iter();
    let points: Vec<(Position, f64)> =
        poses.map(|pose| (scene.position(pose.point), scene.elevation_m + pose.height_m)).collect();
    requirements.check(&PlacedPath {
        name: candidate.manoeuvre.path.name(),
        points: &points,
        height_m: candidate.height_m,
        target_m: goal.target.elevation_m,
        ground_m: ground_m(mission, goal),
        span_s: (from_s, from_s + forecast.time_s),
    })
}

/// Checks a manoeuvre by the requirement `terrain` along its path, as it is checked before it is flown.
///
/// # Errors
/// The height that keeps the requirement.
pub(crate) fn ground_kept(
    mission: &Mission,
    goal: &AcquisitionGoal,
    candidate: &ManoeuvreCandidate,
    seen: (&Forecast, &Scene),
) -> Result<(), Refusal> {
    requirements_kept((mission, &PathRequirements::of_terrain(mission)), goal, candidate, seen, 0.0)
}

/// Returns the angle by which a camera that is kept on the target points too near to the sun, as a share of 180 degrees, with the reason;
/// `None` if it keeps its distance from the sun.
pub(crate) fn sun_miss(mission: &Mission, camera: &str, forecast: &Forecast, scene: &Scene) -> Option<(f64, String)> {
    let margin_deg = |pose: &PathPose| {
        let position = scene.position(pose.point);
        let sight = ViewDirection {
            azimuth_deg: geodesy::azimuth_deg(position, scene.target),
            elevation_deg: -libm::atan2(pose.height_m, pose.point.length()).to_degrees(),
        };
        sun_margin_deg(mission, camera, position, sight, pose.time_s)
    };
    let observed = forecast.flown.poses.iter().filter(|pose| pose.is_observed);
    let least_deg = observed.filter_map(margin_deg).reduce(f64::min).filter(|deg| *deg < 0.0)?;
    let why = format!("has `{camera}` look {:.0} degrees too near to the sun", -least_deg);
    Some((-least_deg / 180.0, why))
}

/// Returns the restricted zone that the manoeuvre enters when it is flown at `from_s`; without an instant, only zones that are always
/// active count.
pub(crate) fn closed_by<'a>(
    mission: &'a Mission,
    forecast: &Forecast,
    scene: &Scene,
    from_s: Option<f64>,
) -> Option<&'a AirspaceZone> {
    let plane = Plane::new(scene.target);
    mission.zones.iter().filter(|zone| zone.kind == ZoneKind::Restricted).find(|zone| {
        let corners: Vec<Point> = zone.corners.iter().filter_map(|corner| plane.project(*corner)).collect();
        let active = match from_s {
            Some(from_s) => zone.active.from_s < from_s + forecast.time_s && zone.active.until_s > from_s,
            None => zone.active.from_s <= scene.from_s && zone.active.until_s >= mission.settings.duration.seconds(),
        };
        active
            && forecast.flown.poses.iter().any(|pose| {
                let altitude_m = scene.elevation_m + pose.height_m;
                let inside =
                    plane.project(scene.position(pose.point)).is_some_and(|point| plane::inside(point, &corners));
                inside && zone.altitude_m_min <= altitude_m && altitude_m <= zone.altitude_m_max
            })
    })
}
