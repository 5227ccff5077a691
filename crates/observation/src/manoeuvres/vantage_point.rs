//! Vantage point: a place on a sphere around the target from which it is seen best, held for some time.

use super::refusal::{Limit, Refusal, positive, rounded_up};
use super::scene::{Scene, along};
use super::track::{Element, Sight, Track, TrackPoint};
use super::{Craft, Instrument};
use apex_geo::geodesy::{RAD_PER_DEG, wrap_180};
use serde::{Deserialize, Serialize};

/// A place to look from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VantagePoint {
    /// Azimuth of the place, seen from the target.
    pub azimuth_deg: f64,
    /// Angle off the vertical at which the target is seen.
    pub look_angle_deg: f64,
    /// Distance to the target.
    pub slant_m: f64,
    /// Time that the vehicle stays.
    pub dwell_s: f64,
}

/// Criteria for a place in addition to its geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VantageNeeds {
    /// Wanted metres per pixel.
    pub wanted_m: f64,
    /// Angle of one pixel.
    pub pixel_rad: f64,
    /// Wanted look angles off the vertical.
    pub look_angle_deg: (f64, f64),
    /// Azimuth and elevation of the sun; `None` if light does not matter.
    pub sun_deg: Option<(f64, f64)>,
    /// Strongest wind in which the vehicle hovers steadily.
    pub wind_mps_max: f64,
}

/// The factors of a place, each 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VantageScore {
    /// Line of sight.
    pub sight: f64,
    /// Look angle.
    pub angle: f64,
    /// Resolution.
    pub resolution: f64,
    /// Light: the target is seen from the lit side, and not against the sun.
    pub sun: f64,
    /// Wind: the share of the vehicle's wind limit that remains.
    pub wind: f64,
    /// Link to the ground.
    pub link: f64,
}

impl VantageScore {
    /// Returns the product of the factors, by which places are compared.
    pub fn product(&self) -> f64 {
        self.sight * self.angle * self.resolution * self.sun * self.wind * self.link
    }
}

impl VantagePoint {
    /// Name in PDL.
    pub const NAME: &'static str = "vantage-point";

    /// Returns the height above the target.
    pub fn height_m(&self) -> f64 {
        self.slant_m * libm::cos(self.look_angle_deg * RAD_PER_DEG)
    }

    /// Returns the distance over ground from the target.
    pub fn distance_m(&self) -> f64 {
        self.slant_m * libm::sin(self.look_angle_deg * RAD_PER_DEG)
    }

    /// Returns the factors of the place. `sight` and `link` (0 to 1) are the shares that terrain and radio leave.
    pub fn score(&self, needs: &VantageNeeds, (sight, link): (f64, f64), wind_mps: f64) -> VantageScore {
        let cosine = libm::cos(self.look_angle_deg * RAD_PER_DEG).max(1e-6);
        let pixel_m = needs.pixel_rad * self.slant_m / cosine;
        let (low, high) = needs.look_angle_deg;
        let inside = (low..=high).contains(&self.look_angle_deg);
        let sun = needs.sun_deg.map_or(1.0, |(azimuth_deg, elevation_deg)| {
            if elevation_deg <= 0.0 {
                return 0.0;
            }
            // From the sun's side the target is lit; towards the sun its shadow side is seen.
            0.5 + 0.5 * libm::cos(wrap_180(self.azimuth_deg - azimuth_deg) * RAD_PER_DEG)
        });
        VantageScore {
            sight,
            angle: if inside { 1.0 } else { 0.0 },
            resolution: crate::sensor::scanner::ramp_down(pixel_m, needs.wanted_m, 2.0 * needs.wanted_m),
            sun,
            wind: (1.0 - wind_mps / needs.wind_mps_max).clamp(0.0, 1.0),
            link,
        }
    }

    pub(crate) fn check(&self, craft: &Craft, instrument: &Instrument, scene: &Scene) -> Result<(), Refusal> {
        let limit = |figure, unit| Limit { manoeuvre: Self::NAME, figure, unit };
        positive(Self::NAME, "a distance", "m", self.slant_m)?;
        let angle = limit("a look angle", "degrees");
        angle.at_least(self.look_angle_deg, 0.0, "look angles are measured from the vertical", || {
            "0 works".to_string()
        })?;
        angle.at_most(self.look_angle_deg, 85.0, "the camera would see the target at too low an angle", || {
            "85 degrees works".to_string()
        })?;
        if !craft.can_hover {
            let because = format!("{} cannot hover", craft.name);
            let least_m = craft.circle_radius_m_min(craft.true_airspeed_mps, scene.wind_mps());
            let nearest = match instrument {
                Instrument::Camera(_) if !instrument.pans() => "fly straight over the target".to_string(),
                _ => format!("an orbit of {} m works", rounded_up(least_m, 0)),
            };
            return Err(limit("a slowest airspeed", "m/s").refusal(
                craft.true_airspeed_mps_min,
                0.0,
                &because,
                nearest,
            ));
        }
        let because = format!("{} cannot hover in stronger wind", craft.name);
        let most = craft.wind_mps_max;
        limit("a wind", "m/s").at_most(scene.wind_mps(), most, &because, || "wait for less wind".to_string())
    }

    pub(crate) fn track(
        &self,
        _: f64,
        craft: &Craft,
        instrument: &Instrument,
        scene: &Scene,
    ) -> Result<Track, Refusal> {
        self.check(craft, instrument, scene)?;
        let point = along(self.azimuth_deg, self.distance_m());
        let hover = Element::Hover {
            at: TrackPoint::new(point, self.height_m()),
            headings_deg: vec![self.azimuth_deg + 180.0],
            yaw_rate_deg_s: craft.yaw_rate_deg_s,
            dwell_s: self.dwell_s,
        };
        Ok(Track { elements: vec![hover], sight: Sight::Target })
    }
}
