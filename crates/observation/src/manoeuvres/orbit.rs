//! Orbit: circles over ground around the target, seen from all sides.

use super::craft::circle_bank_deg;
use super::refusal::{Limit, Refusal, positive, rounded_down, rounded_up};
use super::scene::Scene;
use super::track::{Element, Sight, Track, TrackPoint, arc_points, chord_m_max};
use super::{Craft, Instrument};
use apex_geo::geodesy::RAD_PER_DEG;
use apex_geo::plane::Point;
use apex_geo::wind::{self, Wind};
use serde::{Deserialize, Serialize};

/// A circle around the target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Orbit {
    /// Radius over ground.
    pub radius_m: f64,
    /// Height above the target.
    pub height_m: f64,
    /// Number of circles; a fraction is an arc.
    pub turns: f64,
    /// Azimuth of the beginning, seen from the target.
    pub from_deg: f64,
    /// True for clockwise.
    pub clockwise: bool,
}

impl Orbit {
    /// Name in PDL.
    pub const NAME: &'static str = "orbit";
    /// Maximum number of circles of one orbit.
    const TURNS_MAX: f64 = 100.0;
    /// Rounding error of a tilt angle, and angle by which a mount reaches further down than its limit.
    pub(super) const TILT_SPARE_DEG: (f64, f64) = (1e-9, 1.0);
    /// Steps of the integral over a circle.
    const STEPS: u32 = 720;

    /// Returns the angle off the vertical at which the target is seen: `atan(r / h)`.
    pub fn look_angle_deg(&self) -> f64 {
        libm::atan2(self.radius_m, self.height_m) / RAD_PER_DEG
    }

    /// Returns the distance to the target.
    pub fn slant_m(&self) -> f64 {
        libm::hypot(self.radius_m, self.height_m)
    }

    /// Returns the time of one circle at an airspeed in a wind: the integral of `r / gs(track)`. `None` if the wind is too strong.
    pub fn period_s(&self, true_airspeed_mps: f64, wind: Wind) -> Option<f64> {
        let step_deg = 360.0 / f64::from(Self::STEPS);
        let step_m = self.radius_m * step_deg * RAD_PER_DEG;
        (0..Self::STEPS)
            .map(|step| {
                let triangle = wind::triangle((f64::from(step) + 0.5) * step_deg, true_airspeed_mps, wind)?;
                Some(step_m / triangle.ground_speed_mps)
            })
            .sum()
    }

    /// Returns the least and greatest bank on the circle, into and with the wind.
    pub fn bank_deg(&self, true_airspeed_mps: f64, wind_mps: f64) -> (f64, f64) {
        let bank = |ground_speed_mps: f64| circle_bank_deg(ground_speed_mps, self.radius_m, 0.0);
        (bank(true_airspeed_mps - wind_mps), bank(true_airspeed_mps + wind_mps))
    }

    pub(crate) fn check(
        &self,
        airspeed_mps: f64,
        craft: &Craft,
        instrument: &Instrument,
        scene: &Scene,
    ) -> Result<(), Refusal> {
        positive(Self::NAME, "a height", "m", self.height_m)?;
        positive(Self::NAME, "a radius", "m", self.radius_m)?;
        positive(Self::NAME, "a number of turns", "", self.turns)?;
        let turns = Limit { manoeuvre: Self::NAME, figure: "a number of turns", unit: "" };
        turns.at_most(self.turns, Self::TURNS_MAX, "an orbit may have at most this many turns", || {
            "repeat the orbit".to_string()
        })?;
        self.check_sight(craft, instrument)?;
        if craft.can_hover {
            return Ok(());
        }
        let least_m = craft.circle_radius_m_min(airspeed_mps, scene.wind_mps());
        let limit = Limit { manoeuvre: Self::NAME, figure: "a radius", unit: "m" };
        let because =
            format!("{} cannot turn more tightly with {:.0} degrees of bank in this wind", craft.name, craft.bank_deg);
        limit.at_least(self.radius_m, least_m, &because, || format!("{} m works", rounded_up(least_m, 0)))
    }

    /// Rejects an orbit from which the mount of the camera cannot see the target. A scanner looks straight down: it records the ground
    /// below the circle.
    fn check_sight(&self, craft: &Craft, instrument: &Instrument) -> Result<(), Refusal> {
        let Instrument::Camera(camera) = instrument else { return Ok(()) };
        let aside = "no orbit works; fly over the target, for example by a sweep or straight over it".to_string();
        if !craft.can_hover && !instrument.pans() {
            let limit = Limit { manoeuvre: Self::NAME, figure: "a pan range", unit: "degrees" };
            let because =
                format!("{} circles with the target at its side, and `{}` does not pan", craft.name, camera.name);
            return Err(limit.refusal(0.0, 90.0, &because, aside));
        }
        let (low_deg, high_deg) = camera.mount.tilt_deg;
        let (above_deg, below_deg) = Self::TILT_SPARE_DEG;
        let (most_deg, least_deg) = (90.0 + high_deg + above_deg, 90.0 + low_deg - below_deg);
        let limit = Limit { manoeuvre: Self::NAME, figure: "a look angle", unit: "degrees" };
        let because = format!("`{}` tilts from {low_deg} to {high_deg} degrees", camera.name);
        let radius_m = |angle_deg: f64| self.height_m * libm::tan(angle_deg * RAD_PER_DEG);
        limit.at_most(self.look_angle_deg(), most_deg, &because, || match radius_m(90.0 + high_deg) {
            radius_m if high_deg > -90.0 && radius_m >= 1.0 => {
                format!("a radius of {} m works", rounded_down(radius_m, 0))
            }
            _ => aside,
        })?;
        limit.at_least(self.look_angle_deg(), least_deg, &because, || {
            format!("a radius of {} m works", rounded_up(radius_m(90.0 + low_deg), 0))
        })
    }

    pub(crate) fn track(
        &self,
        airspeed_mps: f64,
        craft: &Craft,
        instrument: &Instrument,
        scene: &Scene,
    ) -> Result<Track, Refusal> {
        self.check(airspeed_mps, craft, instrument, scene)?;
        let sweep_deg = 360.0 * self.turns * if self.clockwise { 1.0 } else { -1.0 };
        let circle = arc_points(Point { x: 0.0, y: 0.0 }, self.radius_m, self.from_deg, sweep_deg, chord_m_max(craft));
        // A hovering vehicle needs acceleration to turn.
        let fastest = if craft.can_hover { libm::sqrt(craft.braking_mps2 * self.radius_m) } else { f64::INFINITY };
        let place = |point: Point| TrackPoint { point, height_m: self.height_m, speed_mps_max: fastest };
        let points = circle.into_iter().map(place).collect();
        Ok(Track { elements: vec![Element::Follow { points, is_observed: true }], sight: Sight::Target })
    }
}
