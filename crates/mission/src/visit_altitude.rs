//! Altitudes from which sites are observed.

use crate::observing::looks_with;
use crate::vehicle::{Airframe, turn_radius_m};
use crate::{Mission, Target, TargetKind};
use apex_geo::wind;
use apex_observation::footprint::OFF_NADIR_DEG_MAX;

/// Angle that lines of sight from circles keep from the limit of pictures.
const OFF_NADIR_SPARE_DEG: f64 = 5.0;

pub(crate) fn sites(mission: &Mission) -> impl Iterator<Item = &Target> {
    mission.targets.iter().filter(|target| matches!(target.kind, TargetKind::Site(_)))
}

/// Returns the altitude above mean sea level from which a site is observed.
pub fn visit_altitude_m(mission: &Mission, site: &Target) -> f64 {
    match mission.model.airframe {
        Airframe::Rotorcraft => {
            let clear_m = mission.clear_altitude_m(site.position, 0.0).map(|clear_m| clear_m + LEVEL_M);
            (site.elevation_m + hover_height_m(mission, site)).max(clear_m.unwrap_or(f64::NEG_INFINITY))
        }
        Airframe::FixedWing => {
            let planning = &mission.model.planning;
            let highest_m = sites(mission).map(|site| site.elevation_m).fold(f64::NEG_INFINITY, f64::max);
            let clear_m = sites(mission).filter_map(|site| mission.clear_altitude_m(site.position, 0.0));
            let clear_m = clear_m.fold(f64::NEG_INFINITY, f64::max) + LEVEL_M;
            let height_m = planning.visit_height_m.max(steep_height_m(mission));
            (highest_m + height_m).max(clear_m).min(planning.ceiling_share * mission.model.ceiling_m)
        }
    }
}

/// Returns the least height from which a camera of a fixed wing sees the middle of its circle as steeply as pictures need; 0 without such a
/// camera.
fn steep_height_m(mission: &Mission) -> f64 {
    let model = &mission.model;
    if looks_with(model).is_none() {
        return 0.0;
    }
    let drift = 1.0 + wind::speed_mps_max(&mission.forecast) / model.true_airspeed_m_s_cruise;
    let radius_m = model.turns.circle_width * turn_radius_m(model) * drift * drift;
    radius_m / libm::tan((OFF_NADIR_DEG_MAX - OFF_NADIR_SPARE_DEG).to_radians())
}

/// Returns the height over the ground from which a rotorcraft observes a site: that of its vehicle file; lower if the camera needs that
/// for the wanted pixels; but not below the clearance from terrain.
fn hover_height_m(mission: &Mission, site: &Target) -> f64 {
    let usual_m = mission.model.planning.visit_height_m;
    let (Some(camera), TargetKind::Site(wanted)) = (looks_with(&mission.model), &site.kind) else { return usual_m };
    let fine_m = site.height_m + wanted.resolution_m / camera.pixel_rad();
    usual_m.min(fine_m.max(mission.requirements.terrain_clearance_m.unwrap_or(0.0) + LEVEL_M))
}

/// Height by which a vehicle may leave its altitude.
const LEVEL_M: f64 = 3.0;
