//! Expanding square search (IAMSAR): legs of S, S, 2 S, 2 S, .. around a datum, each turned by 90 degrees.

use super::refusal::{Limit, Refusal, positive, rounded_up};
use super::scene::{Scene, along};
use super::track::{Element, Sight, Track, TrackPoint, chord_m_max, fillet_m, rounded, tangent_m, wide_fillet_m};
use super::{Craft, Instrument};
use apex_geo::plane::Point;
use serde::{Deserialize, Serialize};

/// A square that grows around the place where the target is most likely.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExpandingSquare {
    /// S: length of the first leg, and distance between parallel legs.
    pub spacing_m: f64,
    /// k: the square has 2 k legs.
    pub rounds: u32,
    /// Height above the target.
    pub height_m: f64,
    /// Direction of the first leg; `None`: into the wind, or north without wind.
    pub first_track_deg: Option<f64>,
}

impl ExpandingSquare {
    /// Name in PDL.
    pub const NAME: &'static str = "expanding-square";
    /// Maximum number of rounds.
    const ROUNDS_MAX: u32 = 200;

    /// Returns the length of all legs: `S k (k + 1)`.
    pub fn length_m(&self) -> f64 {
        let rounds = f64::from(self.rounds);
        self.spacing_m * rounds * (rounds + 1.0)
    }

    /// Returns the side of the square that is searched, half a swath beyond the outer legs: `(k + 1) S`.
    pub fn side_m(&self) -> f64 {
        self.spacing_m * (f64::from(self.rounds) + 1.0)
    }

    /// Returns the datum and the ends of all legs.
    pub fn corners(&self, scene: &Scene) -> Vec<Point> {
        let first_deg = self.first_track_deg.or(scene.wind_from_deg()).unwrap_or(0.0);
        let mut corners = vec![Point { x: 0.0, y: 0.0 }];
        let mut here = Point { x: 0.0, y: 0.0 };
        for leg in 0..2 * self.rounds {
            let length_m = self.spacing_m * f64::from(leg / 2 + 1);
            here = here.plus(1.0, along(first_deg + 90.0 * f64::from(leg), length_m));
            corners.push(here);
        }
        corners
    }

    pub(crate) fn check(&self, airspeed_mps: f64, craft: &Craft, scene: &Scene) -> Result<(), Refusal> {
        positive(Self::NAME, "a height", "m", self.height_m)?;
        positive(Self::NAME, "a spacing", "m", self.spacing_m)?;
        let rounds = Limit { manoeuvre: Self::NAME, figure: "a number of rounds", unit: "" };
        rounds.at_least(f64::from(self.rounds), 1.0, "the smallest expanding square has one round", || {
            "1 works".to_string()
        })?;
        let most = f64::from(Self::ROUNDS_MAX);
        rounds.at_most(f64::from(self.rounds), most, "the flight would take days", || "sweep the area".to_string())?;
        let least_m = 2.0 * tangent_m(90.0, fillet_m(airspeed_mps, craft, scene));
        let limit = Limit { manoeuvre: Self::NAME, figure: "a spacing", unit: "m" };
        let because = format!("{} needs two turn radii between corners", craft.name);
        limit.at_least(self.spacing_m, least_m, &because, || format!("{} m works", rounded_up(least_m, 0)))
    }

    pub(crate) fn track(
        &self,
        airspeed_mps: f64,
        craft: &Craft,
        _: &Instrument,
        scene: &Scene,
    ) -> Result<Track, Refusal> {
        self.check(airspeed_mps, craft, scene)?;
        let radius_m = wide_fillet_m(fillet_m(airspeed_mps, craft, scene), 90.0, 0.5 * self.spacing_m);
        let points = rounded(&self.corners(scene), radius_m, chord_m_max(craft));
        let points = points.into_iter().map(|point| TrackPoint::new(point, self.height_m)).collect();
        Ok(Track { elements: vec![Element::Follow { points, is_observed: true }], sight: Sight::Down })
    }
}
