//! Straight over the target: one level line, with a lead-in for levelling the wings.

use super::refusal::{Refusal, positive};
use super::scene::{Scene, along};
use super::track::{Element, Sight, Track, lines_with_turns};
use super::{Craft, Instrument};
use apex_geo::plane::Point;
use serde::{Deserialize, Serialize};

/// One line over the centre of the target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StraightOver {
    /// Direction over ground, clockwise from north.
    pub track_deg: f64,
    /// Height above the target.
    pub height_m: f64,
    /// Extent of the target along the track.
    pub length_m: f64,
    /// Length recorded beyond the far edge: half of a footprint for pictures, 0 for a scanner.
    pub run_out_m: f64,
}

impl StraightOver {
    /// Name in PDL.
    pub const NAME: &'static str = "straight-over";

    /// Returns the line `offset_m` to the right of the middle.
    pub(crate) fn line(&self, offset_m: f64) -> (Point, Point) {
        let half_m = 0.5 * self.length_m;
        let aside = along(self.track_deg + 90.0, offset_m);
        (
            aside.plus(1.0, along(self.track_deg, -half_m)),
            aside.plus(1.0, along(self.track_deg, half_m + self.run_out_m)),
        )
    }

    /// Rejects figures that are not positive.
    pub(crate) fn check(&self) -> Result<(), Refusal> {
        positive(Self::NAME, "a height", "m", self.height_m)?;
        positive(Self::NAME, "a length", "m", self.length_m + self.run_out_m)
    }

    pub(crate) fn track(
        &self,
        airspeed_mps: f64,
        craft: &Craft,
        _: &Instrument,
        scene: &Scene,
    ) -> Result<Track, Refusal> {
        let elements: Vec<Element> =
            lines_with_turns(Self::NAME, &[self.line(0.0)], self.height_m, airspeed_mps, craft, scene)?;
        Ok(Track { elements, sight: Sight::Down })
    }
}
