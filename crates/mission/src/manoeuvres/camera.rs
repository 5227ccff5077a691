//! Ways to observe a look with a camera: pictures of a point from a vantage point, of a line and of an area by distance.

use super::wish::Wish;
use super::{picture_runs as runs, vantage};
use crate::observing::{camera_names, camera_of};
use apex_model::problem::Manoeuvre;
use apex_observation::sensor::CameraSetting;
use apex_observation::target::TargetArea;
use apex_observation::timing::sun::solar_position;

/// Returns the manoeuvres with their predicted quality.
///
/// # Errors
/// If there is none: the reason, with the nearest possibility.
pub(super) fn ways(wish: &Wish<'_>) -> Result<Vec<Manoeuvre>, String> {
    let camera = camera(wish)?;
    light(wish, &camera)?;
    let made = match &wish.fire.wanted.area {
        TargetArea::Point(place) => vantage::ways(wish, &camera, *place)?,
        TargetArea::Line(_) | TargetArea::Circle { .. } | TargetArea::Polygons(_) | TargetArea::Perimeter { .. } => {
            runs::ways(wish, &camera)?
        }
    };
    match made.is_empty() {
        true => Err(format!("every picture that `{}` could take of it is worth nothing", camera.name)),
        false => Ok(made),
    }
}

/// The camera that the target names, or the first that the vehicle carries.
pub(super) fn camera(wish: &Wish<'_>) -> Result<CameraSetting, String> {
    let model = &wish.mission.model;
    let names = camera_names(model);
    let wanted = wish.fire.pictures.camera.as_deref();
    let name = wanted.or(names.first().copied());
    let Some(name) = name else {
        return Err(format!("the vehicle `{}` carries no line scanner and no camera", model.name));
    };
    camera_of(model, name).ok_or_else(|| {
        let known = if names.is_empty() { "none".to_string() } else { names.join(", ") };
        format!("`camera` is `{name}`, the vehicle `{}` carries: {known}", model.name)
    })
}

/// Step in which the elevation of the sun is computed, s.
const SUN_STEP_S: f64 = 60.0;
/// Horizon of the search for daylight, s.
const SUN_WAIT_S: f64 = 86_400.0;

/// Checks light: a camera without a band for the night needs the sun at some time before the end of the mission.
fn light(wish: &Wish<'_>, camera: &CameraSetting) -> Result<(), String> {
    let settings = &wish.mission.settings;
    let (Some(least_deg), Some(zero_unix_s)) = (camera.sun_deg_min, settings.epoch_unix_s) else { return Ok(()) };
    let end_s = settings.duration.seconds();
    let sun_deg = |time_s: f64| solar_position(wish.target.position, zero_unix_s + time_s).elevation_deg;
    let steps = |from_s: f64, until_s: f64| {
        let count = libm::ceil((until_s - from_s).max(0.0) / SUN_STEP_S).min(1e4) as u32;
        (0..=count).map(move |step| from_s + SUN_STEP_S * f64::from(step))
    };
    let highest_deg = steps(wish.from_s, end_s).map(sun_deg).fold(f64::NEG_INFINITY, f64::max);
    if highest_deg >= least_deg {
        return Ok(());
    }
    let day_s = steps(end_s, end_s + SUN_WAIT_S).find(|time_s| sun_deg(*time_s) >= least_deg);
    let later = day_s
        .map_or_else(String::new, |day_s| format!("; {:.1} h after its end it is light", (day_s - end_s) / 3600.0));
    Err(format!(
        "`{}` has no band for the night and needs the sun at {least_deg:.0} degrees; until the end of the mission it comes \
         to {highest_deg:.0} degrees{later}",
        camera.name
    ))
}
