//! Pirouette: the vehicle hovers and turns on the spot; its camera sees a ring of the ground.

use super::refusal::{Limit, Refusal, positive, rounded_down, rounded_up};
use super::scene::Scene;
use super::track::{Element, Sight, Track, TrackPoint};
use super::{Craft, Instrument};
use crate::sensor::CameraSetting;
use apex_geo::geodesy::RAD_PER_DEG;
use apex_geo::plane::Point;
use serde::{Deserialize, Serialize};

/// A full turn on the spot over the target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pirouette {
    /// Height above the target.
    pub height_m: f64,
    /// Angle of the camera below the horizon, positive.
    pub depression_deg: f64,
    /// Share of a picture that the next one overlaps.
    pub overlap: f64,
    /// Direction of the first picture, clockwise from north.
    pub from_deg: f64,
    /// Time in each direction: settling and exposure.
    pub dwell_s: f64,
}

impl Pirouette {
    /// Name in PDL.
    pub const NAME: &'static str = "pirouette";

    /// Returns the number of pictures of a full turn: `ceil(360 / (HFOV (1 - overlap)))`.
    pub fn frames(&self, wide_deg: f64) -> usize {
        libm::ceil(360.0 / (wide_deg * (1.0 - self.overlap)) - 1e-9).max(1.0) as usize
    }

    /// Returns the inner and outer radius of the ring that is seen: `h / tan(depression +- VFOV/2)`. The hole in the middle is not seen.
    /// The outer radius is infinite where the picture reaches the horizon.
    pub fn ring_m(&self, high_deg: f64) -> (f64, f64) {
        let radius = |angle_deg: f64| {
            if angle_deg >= 90.0 {
                0.0
            } else if angle_deg <= 0.0 {
                f64::INFINITY
            } else {
                self.height_m / libm::tan(angle_deg * RAD_PER_DEG)
            }
        };
        (radius(self.depression_deg + 0.5 * high_deg), radius(self.depression_deg - 0.5 * high_deg))
    }

    /// Returns the greatest yaw rate at which a picture smears by its limit: one pixel angle by the exposure time.
    pub fn yaw_rate_deg_s_max(&self, camera: &CameraSetting) -> f64 {
        let level = libm::cos(self.depression_deg * RAD_PER_DEG).max(1e-6);
        camera.smear.full_pixels * camera.pixel_rad() / (camera.exposure_s * level) / RAD_PER_DEG
    }

    pub(crate) fn check(&self, craft: &Craft, instrument: &Instrument, scene: &Scene) -> Result<(), Refusal> {
        let limit = |figure, unit| Limit { manoeuvre: Self::NAME, figure, unit };
        positive(Self::NAME, "a height", "m", self.height_m)?;
        positive(Self::NAME, "a depression", "degrees", self.depression_deg)?;
        let overlap = limit("an overlap", "");
        overlap.at_least(self.overlap, 0.0, "pictures would leave gaps", || "0.3 works".to_string())?;
        overlap.at_most(self.overlap, 0.9, "it would take too many pictures", || "0.9 works".to_string())?;
        if !craft.can_hover {
            let because = format!("{} cannot hover", craft.name);
            let nearest = "sweep over the target".to_string();
            return Err(limit("a slowest airspeed", "m/s").refusal(
                craft.true_airspeed_mps_min,
                0.0,
                &because,
                nearest,
            ));
        }
        let wind = limit("a wind", "m/s");
        let most = craft.wind_mps_max;
        wind.at_most(scene.wind_mps(), most, &format!("{} cannot hover in stronger wind", craft.name), || {
            "wait for less wind, or fly lower".to_string()
        })?;
        let Instrument::Camera(camera) = instrument else {
            let nearest = "use a camera, or sweep".to_string();
            return Err(limit("a tilt range", "degrees").refusal(0.0, 90.0, "a line scanner does not tilt", nearest));
        };
        let (low, high) = camera.mount.tilt_deg;
        let tilt = limit("a tilt", "degrees");
        tilt.at_least(-self.depression_deg, low, "the mount cannot tilt lower", || {
            format!("{} degrees works", rounded_up(low, 0))
        })?;
        tilt.at_most(-self.depression_deg, high, "the mount cannot tilt higher", || {
            format!("{} degrees works", rounded_down(high, 0))
        })
    }

    pub(crate) fn track(
        &self,
        _: f64,
        craft: &Craft,
        instrument: &Instrument,
        scene: &Scene,
    ) -> Result<Track, Refusal> {
        self.check(craft, instrument, scene)?;
        let wide_deg = match instrument {
            Instrument::Camera(camera) => camera.wide_deg,
            Instrument::Scanner(_) => 360.0,
        };
        let frames = self.frames(wide_deg);
        let step_deg = 360.0 / frames as f64;
        let headings_deg = (0..frames).map(|frame| self.from_deg + step_deg * frame as f64).collect();
        let at = TrackPoint::new(Point { x: 0.0, y: 0.0 }, self.height_m);
        let hover = Element::Hover { at, headings_deg, yaw_rate_deg_s: craft.yaw_rate_deg_s, dwell_s: self.dwell_s };
        Ok(Track { elements: vec![hover], sight: Sight::Nose { tilt_deg: -self.depression_deg } })
    }
}
