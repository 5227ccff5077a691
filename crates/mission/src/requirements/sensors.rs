//! The sun on cameras: the margin of each camera that points, now and along the commanded route.
//!
//! A camera points by its mount's last reported angles. Along the route it stays on the ground that it sees now; a camera that sees no
//! ground keeps its angles.

use super::readings::{Reading, Scene};
use super::response::Response;
use crate::Mission;
use crate::observing::camera_of;
use apex_geo::geodesy::{self, Position};
use apex_geo::plane::Point;
use apex_model::quantity::Dimension;
use apex_observation::timing::sun::solar_position;
use apex_requirements::Concern;
use apex_requirements::margin::sensor::{ViewDirection, sun_deg};

/// Returns the margin of requirement `sun` for a camera at `position` that looks along `sight` at `time_s`; infinite at night, `None` if
/// it is not watched or the position of the sun is unknown.
pub(crate) fn sun_margin_deg(
    mission: &Mission,
    camera: &str,
    position: Position,
    sight: ViewDirection,
    time_s: f64,
) -> Option<f64> {
    let keep_out = mission.requirements.sun?;
    let zero_unix_s = mission.settings.epoch_unix_s?;
    let carried = mission.model.sensors.iter().find(|sensor| sensor.name.eq_ignore_ascii_case(camera))?;
    let setting = camera_of(&mission.model, camera)?;
    let sun = solar_position(position, zero_unix_s + time_s);
    let sun = ViewDirection { azimuth_deg: sun.azimuth_deg, elevation_deg: sun.elevation_deg };
    let margin_deg = keep_out.margin_deg.unwrap_or(carried.model.sun_keep_out_deg);
    Some(sun_deg(sight, sun, setting.wide_deg, margin_deg))
}

/// Time in which a camera is turned away.
const STOW_S: f64 = 5.0;
/// Steps along the route.
const STEP_S: f64 = 5.0;
/// A sight line that is less steep is not followed to the ground.
const GROUND_TILT_DEG: f64 = -3.0;

impl Scene<'_> {
    /// Returns the least margin of all cameras that point, 180 degrees by night and while none points; `None` without civil time, and until
    /// a camera has pointed.
    pub(super) fn sun(&self) -> Option<Reading> {
        let keep_out = self.requirements().sun?;
        let zero_unix_s = self.mission.settings.epoch_unix_s?;
        let margin_at = |position: Position, sight: ViewDirection, camera: (f64, f64), after_s: f64| {
            let sun = solar_position(position, zero_unix_s + self.now_s + after_s);
            let sun = ViewDirection { azimuth_deg: sun.azimuth_deg, elevation_deg: sun.elevation_deg };
            sun_deg(sight, sun, camera.0, camera.1)
        };
        let mut worst: Option<(f64, Option<f64>, &str)> = None;
        for (name, reported) in self.flown.cameras.iter().filter(|(_, reported)| reported.is_pointing) {
            let Some(carried) = self.mission.model.sensors.iter().find(|sensor| sensor.name.eq_ignore_ascii_case(name))
            else {
                continue;
            };
            let Some(camera) = camera_of(&self.mission.model, name) else { continue };
            let figures = (camera.wide_deg, keep_out.margin_deg.unwrap_or(carried.model.sun_keep_out_deg));
            let heading_deg = self.flown.heading_deg.unwrap_or_else(|| self.flown.track_deg());
            let here = ViewDirection { azimuth_deg: heading_deg + reported.pan_deg, elevation_deg: reported.tilt_deg };
            let now_deg = margin_at(self.here, here, figures, 0.0);
            if !now_deg.is_finite() {
                continue;
            }
            let ahead = self.first_sun(here, |position, sight, after_s| margin_at(position, sight, figures, after_s));
            let after_s = if now_deg < 0.0 { Some(0.0) } else { ahead };
            let is_worse = worst.is_none_or(|(deg, after, _)| {
                (after_s.unwrap_or(f64::INFINITY), now_deg) < (after.unwrap_or(f64::INFINITY), deg)
            });
            if is_worse {
                worst = Some((now_deg, after_s, &carried.name));
            }
        }
        if worst.is_none() && self.flown.cameras.values().any(|camera| camera.has_pointed) {
            // The margin of a camera that rests is the greatest possible one.
            worst = Some((180.0, None, "camera"));
        }
        let (margin_deg, after_s, camera) = worst?;
        Some(Reading {
            concern: Concern::Sensor,
            name: "sun",
            margin: margin_deg.to_radians(),
            unit: Dimension::ANGLE,
            after_s,
            response_s: STOW_S,
            what: camera.to_string(),
            response: Response::Stow,
        })
    }

    /// Returns the first instant along the route at which the sight line, kept on the ground that it meets now, is too near to the sun.
    fn first_sun(&self, here: ViewDirection, margin_deg: impl Fn(Position, ViewDirection, f64) -> f64) -> Option<f64> {
        let height_m = self.flown.height_above_ground_m.unwrap_or(0.0);
        let seen = (here.elevation_deg < GROUND_TILT_DEG && height_m > 0.0).then(|| {
            let away_m = height_m / libm::tan(-here.elevation_deg.to_radians());
            geodesy::destination(self.here, here.azimuth_deg, away_m)
        });
        let until_s = self.route.end_s().min(self.requirements().look_ahead_s);
        let count = (until_s / STEP_S) as u32;
        (1..=count).map(|number| f64::from(number) * STEP_S).find(|after_s| {
            let (Some(state), Some(before)) = (self.route.at(*after_s), self.route.at(*after_s - STEP_S)) else {
                return false;
            };
            let position = self.plane.position(state.point);
            let sight = match seen {
                Some(place) => {
                    let (distance_m, azimuth_deg) = geodesy::inverse(position, place);
                    ViewDirection { azimuth_deg, elevation_deg: -libm::atan2(height_m, distance_m).to_degrees() }
                }
                None => {
                    ViewDirection { azimuth_deg: here.azimuth_deg + self.turned_deg(before.point, state.point), ..here }
                }
            };
            margin_deg(position, sight, *after_s) < 0.0
        })
    }

    /// Returns the angle from the present course to the course between two points of the route.
    fn turned_deg(&self, from: Point, to: Point) -> f64 {
        let along = to.minus(from);
        if along.length() < 1.0 { 0.0 } else { libm::atan2(along.x, along.y).to_degrees() - self.flown.track_deg() }
    }
}
