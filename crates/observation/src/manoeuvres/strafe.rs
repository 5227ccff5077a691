//! Strafe: the vehicle moves sideways along a line or facade, with the nose and the camera at right angles to it.

use super::refusal::{Limit, Refusal, positive, rounded_down};
use super::scene::{Scene, along};
use super::track::{Element, Sight, Track, TrackPoint};
use super::{Craft, Instrument};
use apex_geo::geodesy::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// Motion sideways along a line through the target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Strafe {
    /// Direction of the facade, and of the motion, clockwise from north.
    pub track_deg: f64,
    /// Length of the facade.
    pub length_m: f64,
    /// Distance over ground from the line, which is to the right of the motion.
    pub distance_m: f64,
    /// Height above its foot.
    pub height_m: f64,
    /// Speed over ground.
    pub speed_mps: f64,
}

impl Strafe {
    /// Name in PDL.
    pub const NAME: &'static str = "strafe";

    /// Returns the distance for a wanted pixel: `g / ifov`.
    pub fn distance_m_for(wanted_m: f64, pixel_rad: f64) -> f64 {
        wanted_m / pixel_rad
    }

    /// Returns the angle of the camera below the horizon.
    pub fn depression_deg(&self) -> f64 {
        libm::atan2(self.height_m, self.distance_m) / RAD_PER_DEG
    }

    pub(crate) fn check(&self, craft: &Craft, instrument: &Instrument, scene: &Scene) -> Result<(), Refusal> {
        let limit = |figure, unit| Limit { manoeuvre: Self::NAME, figure, unit };
        for (figure, value) in
            [("a length", self.length_m), ("a distance", self.distance_m), ("a height", self.height_m)]
        {
            positive(Self::NAME, figure, "m", value)?;
        }
        positive(Self::NAME, "a speed", "m/s", self.speed_mps)?;
        if !craft.can_hover {
            let because = format!("{} cannot fly sideways", craft.name);
            let nearest = "fly a stand-off line with a camera that pans".to_string();
            return Err(limit("a slowest airspeed", "m/s").refusal(
                craft.true_airspeed_mps_min,
                0.0,
                &because,
                nearest,
            ));
        }
        if matches!(instrument, Instrument::Scanner(_)) {
            let nearest = "use a camera, or fly a stand-off line".to_string();
            return Err(limit("a tilt range", "degrees").refusal(0.0, 90.0, "a line scanner does not tilt", nearest));
        }
        let axis = along(self.track_deg, 1.0);
        let tail = scene.wind.east_mps * axis.x + scene.wind.north_mps * axis.y;
        let most = craft.sideways_mps_max;
        let because = format!("{} cannot fly faster sideways", craft.name);
        limit("an airspeed sideways", "m/s").at_most((self.speed_mps - tail).abs(), most, &because, || {
            match most + tail {
                fastest_mps if fastest_mps > 0.0 => {
                    format!("a speed of {} m/s works", rounded_down(fastest_mps, 1))
                }
                _ => "turn the track away from the wind".to_string(),
            }
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
        let aside = along(self.track_deg - 90.0, self.distance_m);
        let at = |along_m: f64| TrackPoint {
            point: aside.plus(1.0, along(self.track_deg, along_m)),
            height_m: self.height_m,
            speed_mps_max: self.speed_mps,
        };
        let points = vec![at(-0.5 * self.length_m), at(0.5 * self.length_m)];
        let sight = Sight::Direction { azimuth_deg: self.track_deg + 90.0, tilt_deg: -self.depression_deg() };
        Ok(Track { elements: vec![Element::Follow { points, is_observed: true }], sight })
    }
}
