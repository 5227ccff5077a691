//! Ways to observe a look with a camera: pictures of a point from a vantage point, of a line and of an area by distance.

mod heights;
mod runs;
mod vantage;

use super::scanner::quality;
use super::wish::Wish;
use crate::observing::{ForecastAir, NoTerrain, camera_names, camera_of};
use apex_model::problem::{Manoeuvre, PictureWork, Position, QualityFactors};
use apex_observation::pictures::{PlannedPicture, predict_pictures};
use apex_observation::predict::PredictionContext;
use apex_observation::sensor::CameraSetting;
use apex_observation::target::{ObservedTarget, TargetArea};
use apex_observation::timing::sun::solar_position;
use std::collections::BTreeMap;

/// The ways with what they are predicted to give.
///
/// # Errors
/// Why there is none, with what comes nearest.
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
fn camera(wish: &Wish<'_>) -> Result<CameraSetting, String> {
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

/// Time between two looks at the sun, s.
const SUN_STEP_S: f64 = 60.0;
/// How far ahead daylight is looked for, s.
const SUN_WAIT_S: f64 = 86_400.0;

/// A camera without a band for the night needs the sun at some time before the end of the mission.
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

/// A way before its factors are predicted.
struct Draft {
    name: String,
    altitude_m: f64,
    lines: Vec<(Position, Position)>,
    duration_s: f64,
    length_m: f64,
    /// Pictures, one list for each separate chance.
    passes: Vec<Vec<PlannedPicture>>,
    work: PictureWork,
}

/// The draft with its predicted factors; none if it is worth nothing.
fn predicted(wish: &Wish<'_>, draft: Draft) -> Option<Manoeuvre> {
    let wanted = ObservedTarget { looks: vec![wish.look.clone()], after: Vec::new(), ..wish.fire.wanted.clone() };
    let air = ForecastAir::new(wish.mission);
    let first_valid_s = BTreeMap::new();
    let context = PredictionContext {
        zero_unix_s: wish.mission.settings.epoch_unix_s.unwrap_or(0.0),
        ground: &NoTerrain { lowest_m: wanted.elevation_m },
        conditions: &air,
        seen: None,
        products: &[],
        first_valid_s: &first_valid_s,
        is_explained: true,
    };
    let result = predict_pictures(&wanted, &wish.fire.grid, &draft.passes, &context);
    let quality: QualityFactors = quality(result.looks.first()?);
    (quality.product() > 0.0).then_some(Manoeuvre {
        name: draft.name,
        altitude_m: draft.altitude_m,
        lines: draft.lines,
        duration_s: draft.duration_s,
        length_m: draft.length_m,
        quality,
        pictures: Some(draft.work),
    })
}
