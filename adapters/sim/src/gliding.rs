//! Landing without an engine: flight to the airfield, circles over it while there is surplus height, then the approach.
//!
//! The circle is wide enough for the airfield to lie outside the tightest turn towards it. A glide can be steepened but not stretched, so
//! the approach begins with surplus height, and its slope leads to the airfield.

use crate::path::{Circle, Path, bearing};
use crate::situation::Situation;
use apex_model::problem::Position;
use libm::{cos, sin};

/// Radius of the circle over the airfield, in radii of the tightest turn.
const CIRCLE_TURNS: f64 = 2.2;
/// Distance from that circle to its centre by the tightest turn and a straight line, in radii of the turn: `pi - acos(1 / 1.2)` of the
/// turn, and the tangent `sqrt(1.2^2 - 1)`.
const WAY_IN_TURNS: f64 = 3.22;
/// Slopes in units of the best glide: the slope at which the approach begins, and the slope that it follows.
const SLOPE_BEGIN: f64 = 1.3;
const SLOPE_IN: f64 = 1.4;

/// A glide to a field.
#[derive(Clone, Debug)]
pub(crate) struct Glide {
    field: Position,
    part: GlidePart,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum GlidePart {
    /// To the circle over the field, and around it.
    Over,
    In,
    /// Past the field, straight to the ground.
    Past,
}

impl Glide {
    /// Returns a glide to a field, from the beginning.
    pub(crate) fn to(field: Position) -> Glide {
        Glide { field, part: GlidePart::Over }
    }

    /// Returns the path to follow now.
    pub(crate) fn path(&self, here: &Situation) -> Path {
        let (_, distance_m) = bearing(here.state.position, self.field);
        let radius_m = CIRCLE_TURNS * here.turn_radius_m();
        match self.part {
            GlidePart::Over if distance_m <= 1.5 * radius_m => {
                Path::Circle(Circle { centre: self.field, radius_m, clockwise: true })
            }
            GlidePart::Over | GlidePart::In => Path::Point(self.field),
            GlidePart::Past => Path::Straight,
        }
    }

    /// Returns the altitude of the slope to the field here.
    pub(crate) fn altitude_m(&self, here: &Situation) -> f64 {
        let (_, distance_m) = bearing(here.state.position, self.field);
        match self.part {
            GlidePart::Over => here.state.altitude_m,
            GlidePart::In => here.ground_m + SLOPE_IN / here.model.glide_ratio * distance_m,
            GlidePart::Past => here.ground_m - 5.0,
        }
    }

    /// Returns the next part of the glide once it begins.
    pub(crate) fn next(&self, here: &Situation) -> Option<Glide> {
        let (azimuth_rad, distance_m) = bearing(here.state.position, self.field);
        let turn_m = here.turn_radius_m();
        let behind = cos(azimuth_rad - here.state.track_rad()) < 0.0;
        let part = match self.part {
            GlidePart::Over => {
                let airspeed = here.state.true_airspeed.max(1.0);
                let tail = here.wind.north_mps * cos(azimuth_rad) + here.wind.east_mps * sin(azimuth_rad);
                let near = distance_m <= 1.5 * CIRCLE_TURNS * turn_m;
                let way_m = if near { distance_m.max(WAY_IN_TURNS * turn_m) } else { distance_m };
                let reach = here.model.glide_ratio * ((airspeed + tail) / airspeed).clamp(0.2, 1.0);
                let height_m = here.state.altitude_m - here.ground_m;
                (height_m * reach <= SLOPE_BEGIN * way_m).then_some(GlidePart::In)
            }
            GlidePart::In => (behind && distance_m < turn_m).then_some(GlidePart::Past),
            GlidePart::Past => None,
        };
        part.map(|part| Glide { part, ..self.clone() })
    }
}
