//! Sector search (IAMSAR): three triangles through a datum, 3 x 3 legs of the radius with turns of 120 degrees.

use super::refusal::{Limit, Refusal, positive, rounded_up};
use super::scene::{Scene, along};
use super::track::{Element, Sight, Track, TrackPoint, chord_m_max, fillet_m, rounded, tangent_m, wide_fillet_m};
use super::{Craft, Instrument};
use apex_geo::plane::Point;
use serde::{Deserialize, Serialize};

/// A sector search: legs through the most likely position of the target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SectorSearch {
    /// Radius: the length of each leg.
    pub radius_m: f64,
    /// Height above the target.
    pub height_m: f64,
    /// Direction of the first leg; `None`: into the wind, or north without wind. To repeat a search, turn it by 30 degrees.
    pub first_track_deg: Option<f64>,
}

impl SectorSearch {
    /// Name in PDL.
    pub const NAME: &'static str = "sector-search";

    /// Returns the length of all legs: `9 r`.
    pub fn length_m(&self) -> f64 {
        9.0 * self.radius_m
    }

    /// Returns the ends of all legs, from datum to datum. Every turn is to the right by 120 degrees, except where two triangles
    /// meet at the datum: there the search goes straight on.
    pub fn corners(&self, scene: &Scene) -> Vec<Point> {
        let mut track_deg = self.first_track_deg.or(scene.wind_from_deg()).unwrap_or(0.0);
        let mut here = Point { x: 0.0, y: 0.0 };
        let mut corners = vec![here];
        for _ in 0..3 {
            for leg in 0..3 {
                here = here.plus(1.0, along(track_deg, self.radius_m));
                corners.push(here);
                if leg < 2 {
                    track_deg += 120.0;
                }
            }
        }
        corners
    }

    pub(crate) fn check(&self, airspeed_mps: f64, craft: &Craft, scene: &Scene) -> Result<(), Refusal> {
        positive(Self::NAME, "a height", "m", self.height_m)?;
        positive(Self::NAME, "a radius", "m", self.radius_m)?;
        let least_m = 2.0 * tangent_m(120.0, fillet_m(airspeed_mps, craft, scene));
        let limit = Limit { manoeuvre: Self::NAME, figure: "a radius", unit: "m" };
        let because = format!("{} needs room for two turns of 120 degrees on a leg", craft.name);
        limit.at_least(self.radius_m, least_m, &because, || format!("{} m works", rounded_up(least_m, 0)))
    }

    pub(crate) fn track(
        &self,
        airspeed_mps: f64,
        craft: &Craft,
        _: &Instrument,
        scene: &Scene,
    ) -> Result<Track, Refusal> {
        self.check(airspeed_mps, craft, scene)?;
        let radius_m = wide_fillet_m(fillet_m(airspeed_mps, craft, scene), 120.0, 0.5 * self.radius_m);
        let points = rounded(&self.corners(scene), radius_m, chord_m_max(craft));
        let points = points.into_iter().map(|point| TrackPoint::new(point, self.height_m)).collect();
        Ok(Track { elements: vec![Element::Follow { points, is_observed: true }], sight: Sight::Down })
    }
}
