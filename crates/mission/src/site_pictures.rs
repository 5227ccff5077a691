//! Pictures of sites from visits of surveillance: the reason for which no visit can give a valid one, and the daylight that they need.
//!
//! Bound: O(sites x hours) for the daylight until its end, with one position of the sun every [`STEP_S`].

use crate::observing::looks_with;
use crate::vehicle::{Airframe, turn_radius_m};
use crate::visit_altitude::{sites, visit_altitude_m};
use crate::{Mission, Target, TargetKind};
use apex_geo::geodesy::RAD_PER_DEG;
use apex_model::problem::{LaterTimes, SurveillanceProblem, TravelTimes};
use apex_model::time::Time;
use apex_observation::footprint::OFF_NADIR_DEG_MAX;
use apex_observation::sensor::CameraSetting;
use apex_observation::target::ResolutionNeed;
use apex_observation::timing::sun::solar_position;

/// Step in which the elevation of the sun is computed, s.
const STEP_S: f64 = 300.0;
/// Halvings of a step to find the instant of a change: to less than a second.
const HALVINGS: u32 = 10;
/// Angle by which a camera sees beyond the limits of its mount, deg.
const TILT_SPARE_DEG: f64 = 1.0;

/// Returns the reason for which no visit of a site gives a valid picture, whenever it takes place; `None` if one can, and for a vehicle
/// without sensors, of which every visit counts as an observation.
pub(crate) fn trouble(mission: &Mission, site: &Target) -> Option<String> {
    let (model, TargetKind::Site(wanted)) = (&mission.model, &site.kind) else { return None };
    let Some(camera) = looks_with(model) else {
        let names: Vec<&str> = model.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
        let (flown, need) = match model.airframe {
            Airframe::FixedWing => ("circles around it", "can be turned sideways"),
            Airframe::Rotorcraft => ("hovers over it", "looks straight down"),
        };
        let why = || format!("`{}` {flown}, and none of its sensors ({}) {need}", model.name, names.join(", "));
        return (!names.is_empty()).then(why);
    };
    let height_m = visit_altitude_m(mission, site) - site.elevation_m - site.height_m;
    let aside_m = match model.airframe {
        Airframe::FixedWing => model.turns.circle_width * turn_radius_m(model),
        Airframe::Rotorcraft => 0.0,
    };
    let off_nadir_deg = libm::atan2(aside_m, height_m) / RAD_PER_DEG;
    if off_nadir_deg > OFF_NADIR_DEG_MAX {
        return Some(format!(
            "`{}` sees it {off_nadir_deg:.0} degrees off the vertical, pictures count up to {OFF_NADIR_DEG_MAX:.0} degrees",
            camera.name
        ));
    }
    let (tilt_deg, (low_deg, high_deg)) = (off_nadir_deg - 90.0, camera.mount.tilt_deg);
    if !(low_deg - TILT_SPARE_DEG..=high_deg + TILT_SPARE_DEG).contains(&tilt_deg) {
        return Some(format!(
            "`{}` tilts from {low_deg:.0} to {high_deg:.0} degrees, and sees it at {tilt_deg:.0} degrees",
            camera.name
        ));
    }
    let slant_m = libm::hypot(aside_m, height_m);
    let pixel_m = camera.pixel_rad() * slant_m * slant_m / height_m;
    let need = ResolutionNeed { wanted_m: wanted.resolution_m, ..ResolutionNeed::default() };
    (need.factor(pixel_m, pixel_m) <= 0.0).then(|| {
        format!(
            "pixels of {:.1} cm are wanted, and those of `{}` are {:.1} cm from {slant_m:.0} m",
            100.0 * wanted.resolution_m,
            camera.name,
            100.0 * pixel_m
        )
    })
}

/// Time in which the camera has enough light at all sites.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Daylight {
    camera: String,
    /// Beginning, in seconds of mission time: now, or the next instant with light.
    pub(crate) from_s: f64,
    /// End; infinite if it lasts until the end of the mission.
    pub(crate) until_s: f64,
}

impl Daylight {
    /// Returns the next daylight from `now_s` on; `None` if every time has enough light for the camera.
    ///
    /// # Errors
    /// The reason, if it is dark until the end of surveillance.
    pub(crate) fn next(mission: &Mission, now_s: f64) -> Result<Option<Daylight>, String> {
        let settings = &mission.settings;
        let Some(camera) = looks_with(&mission.model) else { return Ok(None) };
        let (Some(least_deg), Some(zero_unix_s)) = (camera.sun_deg_min, settings.epoch_unix_s) else { return Ok(None) };
        let is_light = |time_s: f64| {
            sites(mission).all(|site| solar_position(site.position, zero_unix_s + time_s).elevation_deg >= least_deg)
        };
        let end_s = (settings.duration - settings.watch_margin).seconds();
        let from_s = match is_light(now_s) {
            true => now_s,
            false => change_s(&is_light, (now_s, end_s)).ok_or_else(|| dark(&camera, least_deg))?,
        };
        let until_s = change_s(&is_light, (from_s, end_s));
        if from_s <= now_s && until_s.is_none() {
            return Ok(None);
        }
        Ok(Some(Daylight { camera: camera.name, from_s, until_s: until_s.unwrap_or(f64::INFINITY) }))
    }

    /// Restricts the visits of a problem that begins at `now_s` to the daylight: the first begins after its beginning, the last ends
    /// before its end.
    pub(crate) fn restrict(&self, problem: &mut SurveillanceProblem, now_s: f64) {
        let wait_s = self.from_s - now_s;
        let TravelTimes { from_start_s, later, .. } = &mut problem.travel;
        let longer =
            |times_s: &mut [f64], wait_s: f64| times_s.iter_mut().for_each(|time_s| *time_s = time_s.max(wait_s));
        longer(from_start_s, wait_s);
        later.iter_mut().for_each(|LaterTimes { depart_s, from_start_s, .. }| longer(from_start_s, wait_s - *depart_s));
        let left_s = self.until_s - now_s;
        if left_s < problem.horizon_s {
            problem.endurance_s = Some(problem.endurance_s.map_or(left_s, |endurance_s| endurance_s.min(left_s)));
        }
    }

    /// Returns the cause for which visits outside of the daylight do not count.
    pub(crate) fn cause(&self) -> String {
        format!("`{}` has no band for the night", self.camera)
    }

    /// Returns the sentence about the daylight in the summary of a plan that begins at `now_s`.
    pub(crate) fn told(&self, now_s: f64) -> String {
        let at = |time_s: f64| Time::from_seconds(libm::floor(time_s));
        let begin = (self.from_s > now_s).then(|| format!("from {} on", at(self.from_s)));
        let end = self.until_s.is_finite().then(|| format!("until {}", at(self.until_s)));
        let span: Vec<String> = begin.into_iter().chain(end).collect();
        format!("Visits count {}, by daylight: {}.", span.join(" "), self.cause())
    }
}

fn dark(camera: &CameraSetting, least_deg: f64) -> String {
    format!(
        "no visit can give a valid picture: `{}` has no band for the night and needs the sun at {least_deg:.0} degrees, which stays lower \
         until the end of the mission",
        camera.name
    )
}

/// Returns the first instant at which `state` differs from its value at the beginning of the span; `None` without one.
fn change_s(state: &impl Fn(f64) -> bool, (from_s, until_s): (f64, f64)) -> Option<f64> {
    let first = state(from_s);
    let count = libm::ceil((until_s - from_s).max(0.0) / STEP_S) as u32;
    let at = |step: u32| (from_s + STEP_S * f64::from(step)).min(until_s);
    let step = (1..=count).find(|step| state(at(*step)) != first)?;
    let (mut same_s, mut other_s) = (at(step - 1), at(step));
    for _ in 0..HALVINGS {
        let middle_s = 0.5 * (same_s + other_s);
        if state(middle_s) == first { same_s = middle_s } else { other_s = middle_s }
    }
    // The earlier instant of an end, and the later one of a beginning, has light.
    Some(if first { same_s } else { other_s })
}
