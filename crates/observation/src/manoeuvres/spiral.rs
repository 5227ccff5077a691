//! Spiral: circles of growing (or shrinking) radius around the target, one swath apart.

use super::refusal::{Limit, Refusal, positive, rounded_up};
use super::scene::{Scene, along};
use super::track::{CHORD_DEG, Element, Sight, Track, TrackPoint, chord_m_max};
use super::{Craft, Instrument};
use apex_geo::geodesy::RAD_PER_DEG;
use apex_geo::plane::Point;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// An Archimedean spiral `r = r0 + s a / (2 pi)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spiral {
    /// Smallest radius.
    pub inner_radius_m: f64,
    /// Greatest radius.
    pub outer_radius_m: f64,
    /// Distance between successive turns: the swath less the sidelap.
    pub spacing_m: f64,
    /// Height above the target.
    pub height_m: f64,
    /// Azimuth of the inner end, seen from the target.
    pub from_deg: f64,
    /// True for clockwise.
    pub clockwise: bool,
    /// True to begin at the outer end.
    pub inward: bool,
}

impl Spiral {
    /// Name in PDL.
    pub const NAME: &'static str = "spiral";

    /// Returns the exact length of the curve.
    pub fn length_m(&self) -> f64 {
        let pitch = self.spacing_m / TAU;
        let part = |radius_m: f64| {
            let angle = radius_m / pitch;
            angle * libm::sqrt(1.0 + angle * angle) + libm::asinh(angle)
        };
        0.5 * pitch * (part(self.outer_radius_m) - part(self.inner_radius_m))
    }

    /// Returns the approximate length, that of concentric rings: `pi (r1^2 - r0^2) / s`.
    pub fn length_m_about(&self) -> f64 {
        let squares = self.outer_radius_m * self.outer_radius_m - self.inner_radius_m * self.inner_radius_m;
        PI * squares / self.spacing_m
    }

    /// Returns points of the curve, from the inner end, on chords no longer than the limit.
    pub(crate) fn points(&self, chord_m_max: f64) -> Vec<Point> {
        let pitch = self.spacing_m / TAU;
        let whole_rad = (self.outer_radius_m - self.inner_radius_m) / pitch;
        let sense = if self.clockwise { 1.0 } else { -1.0 };
        let mut points = Vec::new();
        let mut angle_rad = 0.0;
        loop {
            let radius_m = self.inner_radius_m + pitch * angle_rad;
            points.push(along(self.from_deg + sense * angle_rad / RAD_PER_DEG, radius_m));
            if angle_rad >= whole_rad || points.len() >= super::track::POINTS_MAX {
                break;
            }
            // Far from the middle, a chord of the usual angle would be longer than the limit.
            let chord_rad = (CHORD_DEG * RAD_PER_DEG).min(chord_m_max / radius_m.max(1.0));
            angle_rad = (angle_rad + chord_rad).min(whole_rad);
        }
        points
    }

    pub(crate) fn check(&self, airspeed_mps: f64, craft: &Craft, scene: &Scene) -> Result<(), Refusal> {
        positive(Self::NAME, "a height", "m", self.height_m)?;
        positive(Self::NAME, "a spacing", "m", self.spacing_m)?;
        let outer = Limit { manoeuvre: Self::NAME, figure: "an outer radius", unit: "m" };
        if self.outer_radius_m.is_nan() || self.outer_radius_m <= self.inner_radius_m {
            let nearest = format!("an outer radius of {} m works", rounded_up(self.inner_radius_m + self.spacing_m, 0));
            let because = "the outer radius is greater than the inner one";
            return Err(outer.refusal(self.outer_radius_m, self.inner_radius_m, because, nearest));
        }
        let least_m = if craft.can_hover { 0.0 } else { craft.circle_radius_m_min(airspeed_mps, scene.wind_mps()) };
        let limit = Limit { manoeuvre: Self::NAME, figure: "an inner radius", unit: "m" };
        let because = format!("{} cannot turn more tightly at {airspeed_mps:.0} m/s in this wind", craft.name);
        limit.at_least(self.inner_radius_m, least_m, &because, || {
            let inner = rounded_up(least_m, 0);
            if self.outer_radius_m > inner.parse().unwrap_or(least_m) {
                return format!("{inner} m works");
            }
            format!("{inner} m works with an outer radius of {} m", rounded_up(least_m + 1.0 + self.spacing_m, 0))
        })
    }

    pub(crate) fn track(
        &self,
        airspeed_mps: f64,
        craft: &Craft,
        _: &Instrument,
        scene: &Scene,
    ) -> Result<Track, Refusal> {
        self.check(airspeed_mps, craft, scene)?;
        let mut points = self.points(chord_m_max(craft));
        if self.inward {
            points.reverse();
        }
        let points = points.into_iter().map(|point| TrackPoint::new(point, self.height_m)).collect();
        Ok(Track { elements: vec![Element::Follow { points, is_observed: true }], sight: Sight::Down })
    }
}
