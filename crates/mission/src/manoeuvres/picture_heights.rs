//! Heights for pictures: the lowest that the mission permits, the highest that the wanted pixels permit, and some between.

use super::air_limits::CalmBands;
use super::altitudes::{permitted_bands, zones_near};
use super::wish::Wish;
use apex_geo::geodesy::RAD_PER_DEG;
use apex_observation::manoeuvres::rounded_up;
use apex_observation::sensor::CameraSetting;

/// Altitude error of a vehicle in metres, in addition to the distance to keep from ground and zones.
pub(super) const LEVEL_M: f64 = 3.0;
/// Relative difference below which two heights count as equal.
const APART_SHARE: f64 = 0.04;
/// Decimals of a pixel size in metres that is printed.
const PIXEL_DECIMALS: usize = 3;
/// Greatest planned height, as a share of the height at which pixels lose all value.
const WORTH_SHARE: f64 = 0.95;

/// Returns the candidate altitudes above mean sea level, ascending, for pictures at this angle off the vertical.
///
/// # Errors
/// If none is possible: the required altitude, the obstacle, and a remedy.
pub(super) fn of(wish: &Wish<'_>, camera: &CameraSetting, look_angle_deg: f64) -> Result<Vec<f64>, String> {
    let Wish { mission, look, .. } = wish;
    let (model, ground_m, seen_m) = (&mission.model, wish.target.elevation_m, wish.fire.wanted.elevation_m);
    let clearance_m = mission.requirements.terrain_clearance_m.unwrap_or(0.0);
    let clear_m = mission.clear_altitude_m(wish.target.position, wish.fire.radius_m);
    let lowest_m = clear_m.unwrap_or(f64::NEG_INFINITY).max(ground_m.max(seen_m) + clearance_m) + LEVEL_M;
    let ceiling_m = model.ceiling_m * model.planning.ceiling_share;
    let cosine = libm::cos(look_angle_deg * RAD_PER_DEG);
    // The longer side of a pixel on the ground grows with the square of the distance over the height.
    let height_m = |pixel_m: f64| pixel_m * cosine * cosine / camera.pixel_rad();
    let wanted_m = look.resolution.wanted_m;
    let coarsest_m = WORTH_SHARE * look.resolution.zero_multiple.max(1.0 / WORTH_SHARE) * wanted_m;
    let highest_m = seen_m + height_m(coarsest_m);
    if lowest_m > highest_m {
        let finest_m = rounded_up((lowest_m - seen_m) / height_m(1.0), PIXEL_DECIMALS);
        return Err(format!(
            "`{}` needs {:.0} m above it or lower for pixels of {wanted_m} m, the vehicle stays {:.0} m above it (requirement \
             terrain); {finest_m} m works",
            camera.name,
            highest_m - seen_m,
            lowest_m - seen_m,
        ));
    }
    if lowest_m > ceiling_m {
        return Err(format!("the ground lies at {ground_m:.0} m, the vehicle flies no higher than {ceiling_m:.0} m"));
    }
    let top_m = highest_m.min(ceiling_m);
    let calm = CalmBands::between(wish, (lowest_m, top_m))?;
    let mut found = vec![lowest_m, ground_m + model.planning.visit_height_m, mission.cruise_altitude_m()];
    if wanted_m.is_finite() {
        let corner_rad = 0.5 * libm::hypot(camera.wide_deg, camera.high_deg) * RAD_PER_DEG;
        let at_corner = libm::cos(corner_rad);
        let full_m = height_m(wanted_m);
        found.extend([seen_m + full_m, seen_m + full_m * at_corner * at_corner, top_m]);
    }
    let face_m = mission.requirements.airspace.map_or(0.0, |buffer| buffer.vertical_m) + LEVEL_M;
    for zone in zones_near(wish) {
        found.extend([zone.altitude_m_max + face_m, zone.altitude_m_min - face_m]);
    }
    found.extend(calm.iter().flat_map(CalmBands::ends_m));
    let bands = permitted_bands(wish, face_m);
    found.extend(bands.iter().flat_map(|(low_m, high_m)| [*low_m, *high_m]));
    found.retain(|altitude_m| (lowest_m..=top_m).contains(altitude_m));
    found.retain(|altitude_m| calm.as_ref().is_none_or(|calm| calm.contain(*altitude_m)));
    if !bands.is_empty() {
        found.retain(|altitude_m| bands.iter().any(|(low_m, high_m)| (*low_m..=*high_m).contains(altitude_m)));
        if let (true, Some((low_m, high_m))) = (found.is_empty(), bands.first()) {
            return Err(format!(
                "`{}` needs {:.0} m to {:.0} m above it, the permitted area leaves {:.0} m to {:.0} m",
                camera.name,
                lowest_m - seen_m,
                top_m - seen_m,
                low_m - seen_m,
                high_m - seen_m
            ));
        }
    }
    found.sort_by(f64::total_cmp);
    found.dedup_by(|next, before| *next - *before < APART_SHARE * (*before - seen_m).max(1.0));
    Ok(found)
}
