//! Stand-off: a line parallel to the target at the distance that gives the wanted look angle. For targets that must not be overflown.

use super::orbit::Orbit;
use super::refusal::{Limit, Refusal, positive, rounded_down, rounded_up};
use super::scene::Scene;
use super::straight_over::StraightOver;
use super::track::{Sight, Track, lines_with_turns};
use super::{Craft, Instrument};
use apex_geo::geodesy::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// The side of the vehicle on which the target lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// To the left.
    Left,
    /// To the right.
    Right,
}

/// One line offset from the target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StandOff {
    /// Direction over ground, clockwise from north.
    pub track_deg: f64,
    /// The side on which the target lies.
    pub side: Side,
    /// Height above the target.
    pub height_m: f64,
    /// Angle off the vertical at which the middle of the target is seen.
    pub look_angle_deg: f64,
    /// Extent of the target along the track.
    pub length_m: f64,
}

impl StandOff {
    /// Name in PDL.
    pub const NAME: &'static str = "stand-off";

    /// Returns the distance of the line from the middle of the target: `h tan o`.
    pub fn offset_m(&self) -> f64 {
        self.height_m * libm::tan(self.look_angle_deg * RAD_PER_DEG)
    }

    /// Returns metres per pixel across the view at the target: `ifov h / cos^2 o` on flat ground.
    pub fn pixel_m(&self, pixel_rad: f64) -> f64 {
        let cosine = libm::cos(self.look_angle_deg * RAD_PER_DEG);
        pixel_rad * self.height_m / (cosine * cosine)
    }

    pub(crate) fn check(&self, craft: &Craft, instrument: &Instrument) -> Result<(), Refusal> {
        positive(Self::NAME, "a height", "m", self.height_m)?;
        positive(Self::NAME, "a length", "m", self.length_m)?;
        positive(Self::NAME, "a look angle", "degrees", self.look_angle_deg)?;
        let (most_deg, because) = match instrument {
            Instrument::Scanner(scanner) => {
                (scanner.setting.mode.half_field_rad() / RAD_PER_DEG, "the field of view of the scanner ends there")
            }
            Instrument::Camera(_) => {
                (crate::footprint::OFF_NADIR_DEG_MAX, "pictures at a greater angle from the vertical have no value")
            }
        };
        let limit = Limit { manoeuvre: Self::NAME, figure: "a look angle", unit: "degrees" };
        limit.at_most(self.look_angle_deg, most_deg, because, || {
            let nearest = rounded_down(most_deg, 0);
            let aside_m = self.height_m * libm::tan(nearest.parse().unwrap_or(most_deg) * RAD_PER_DEG);
            format!("{nearest} degrees works, {aside_m:.0} m aside")
        })?;
        self.check_sight(craft, instrument)
    }

    /// Rejects a line from which the mount of the camera cannot be pointed at the target.
    fn check_sight(&self, craft: &Craft, instrument: &Instrument) -> Result<(), Refusal> {
        let Instrument::Camera(camera) = instrument else { return Ok(()) };
        if !craft.can_hover && !instrument.pans() {
            let limit = Limit { manoeuvre: Self::NAME, figure: "a pan range", unit: "degrees" };
            let because =
                format!("{} passes with the target at its side, and `{}` does not pan", craft.name, camera.name);
            return Err(limit.refusal(0.0, 90.0, &because, "fly straight over the target, or sweep".to_string()));
        }
        let (low_deg, high_deg) = camera.mount.tilt_deg;
        let (above_deg, below_deg) = Orbit::TILT_SPARE_DEG;
        let limit = Limit { manoeuvre: Self::NAME, figure: "a look angle", unit: "degrees" };
        let because = format!("`{}` tilts from {low_deg} to {high_deg} degrees", camera.name);
        limit.at_most(self.look_angle_deg, 90.0 + high_deg + above_deg, &because, || match 90.0 + high_deg {
            most_deg if most_deg >= 1.0 => format!("{} degrees works", rounded_down(most_deg, 0)),
            _ => "fly straight over the target, or sweep".to_string(),
        })?;
        limit.at_least(self.look_angle_deg, 90.0 + low_deg - below_deg, &because, || {
            format!("{} degrees works", rounded_up(90.0 + low_deg, 0))
        })
    }

    pub(crate) fn track(
        &self,
        airspeed_mps: f64,
        craft: &Craft,
        instrument: &Instrument,
        scene: &Scene,
    ) -> Result<Track, Refusal> {
        let line = StraightOver {
            track_deg: self.track_deg,
            height_m: self.height_m,
            length_m: self.length_m,
            run_out_m: 0.0,
        };
        let right_m = match self.side {
            Side::Left => self.offset_m(),
            Side::Right => -self.offset_m(),
        };
        let elements = lines_with_turns(Self::NAME, &[line.line(right_m)], self.height_m, airspeed_mps, craft, scene)?;
        let sight = match instrument {
            Instrument::Scanner(_) => Sight::Down,
            Instrument::Camera(_) => Sight::Target,
        };
        Ok(Track { elements, sight })
    }
}
