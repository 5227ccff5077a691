//! Azimuth and distance between positions on the WGS84 ellipsoid, in radians and metres.

use apex_geo::geodesy::{self, RAD_PER_DEG};
use apex_model::problem::Position;

/// Returns the azimuth at `from` (radians, clockwise from north, 0..2pi) and the length in metres of the geodesic to `to`.
/// Between two equal positions the azimuth is 0.
pub(crate) fn bearing(from: Position, to: Position) -> (f64, f64) {
    if from == to {
        return (0.0, 0.0);
    }
    let (distance_m, azimuth_deg) = geodesy::inverse(from, to);
    (azimuth_deg * RAD_PER_DEG, distance_m)
}
