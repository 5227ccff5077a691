//! Geodesics on the WGS84 ellipsoid: distance, azimuth, destination, interpolation, cross and along track.
//!
//! Bound: every function is O(1). Positions that are not finite or outside -90..90 degrees latitude give NaN, never a panic.

use apex_model::problem::Area;
pub use apex_model::problem::Position;
use geographiclib_rs::{DirectGeodesic, Geodesic, InverseGeodesic};

/// Radius of the sphere with the volume of the WGS84 ellipsoid, for local projections and rough bounds.
pub const EARTH_RADIUS_M_MEAN: f64 = 6_371_008.8;

/// Degrees to radians.
pub const RAD_PER_DEG: f64 = std::f64::consts::PI / 180.0;

/// Returns the length and azimuth (clockwise from north, 0..360) at the beginning of the geodesic between two positions.
/// Between two equal positions the azimuth is 0.
pub fn inverse(from: Position, to: Position) -> (f64, f64) {
    if from == to {
        return (0.0, 0.0);
    }
    let (distance_m, azimuth_deg, _, _) =
        Geodesic::wgs84().inverse(from.latitude_deg, from.longitude_deg, to.latitude_deg, to.longitude_deg);
    (distance_m, wrap_360(azimuth_deg))
}

/// Returns the length of the geodesic between two positions.
pub fn distance_m(from: Position, to: Position) -> f64 {
    inverse(from, to).0
}

/// Returns the azimuth at `from` of the geodesic to `to`, clockwise from north, 0..360.
pub fn azimuth_deg(from: Position, to: Position) -> f64 {
    inverse(from, to).1
}

/// Returns the position after `distance_m` along the geodesic that leaves `from` at `azimuth_deg`. A negative distance is behind `from`.
pub fn destination(from: Position, azimuth_deg: f64, distance_m: f64) -> Position {
    if distance_m == 0.0 {
        return from;
    }
    let (latitude_deg, longitude_deg): (f64, f64) =
        Geodesic::wgs84().direct(from.latitude_deg, from.longitude_deg, azimuth_deg, distance_m);
    Position { latitude_deg, longitude_deg }
}

/// Returns the point at `fraction` (0 at `from`, 1 at `to`) of the geodesic.
pub fn interpolate(from: Position, to: Position, fraction: f64) -> Position {
    if fraction == 0.0 {
        return from;
    }
    if fraction == 1.0 {
        return to;
    }
    let (distance_m, azimuth_deg) = inverse(from, to);
    destination(from, azimuth_deg, distance_m * fraction)
}

/// Returns the middle of the geodesic.
pub fn midpoint(from: Position, to: Position) -> Position {
    interpolate(from, to, 0.5)
}

/// Returns the distance of `point` along and across the geodesic `from` → `to`; right of track is positive. On the mean sphere: accurate
/// to 0.6 % of the distance from `from`.
pub fn along_cross_track_m(from: Position, to: Position, point: Position) -> (f64, f64) {
    let (distance_m, azimuth_point_deg) = inverse(from, point);
    let azimuth_track_deg = azimuth_deg(from, to);
    let angle_rad = distance_m / EARTH_RADIUS_M_MEAN;
    let turn_rad = (azimuth_point_deg - azimuth_track_deg) * RAD_PER_DEG;
    let across_rad = libm::asin((libm::sin(angle_rad) * libm::sin(turn_rad)).clamp(-1.0, 1.0));
    let along_rad = libm::atan2(libm::sin(angle_rad) * libm::cos(turn_rad), libm::cos(angle_rad));
    (along_rad * EARTH_RADIUS_M_MEAN, across_rad * EARTH_RADIUS_M_MEAN)
}

/// Normalises `angle_deg` to 0..360.
pub fn wrap_360(angle_deg: f64) -> f64 {
    let wrapped = libm::fmod(angle_deg, 360.0);
    if wrapped < 0.0 { wrapped + 360.0 } else { wrapped }
}

/// Normalises `angle_deg` to -180..180 (180 itself becomes -180).
pub fn wrap_180(angle_deg: f64) -> f64 {
    wrap_360(angle_deg + 180.0) - 180.0
}

/// Returns the smallest box around `positions`, chosen across the 180th meridian where that is narrower; `None` for no positions.
pub fn bounding_area(positions: &[Position]) -> Option<Area> {
    let first = positions.first()?;
    let mut area = Area {
        south_deg: first.latitude_deg,
        north_deg: first.latitude_deg,
        west_deg: first.longitude_deg,
        east_deg: first.longitude_deg,
    };
    let (mut west_turn_deg, mut east_turn_deg) = (0.0_f64, 0.0_f64);
    for position in positions {
        area.south_deg = area.south_deg.min(position.latitude_deg);
        area.north_deg = area.north_deg.max(position.latitude_deg);
        let turn_deg = wrap_180(position.longitude_deg - first.longitude_deg);
        west_turn_deg = west_turn_deg.min(turn_deg);
        east_turn_deg = east_turn_deg.max(turn_deg);
    }
    area.west_deg = wrap_180(first.longitude_deg + west_turn_deg);
    area.east_deg = wrap_180(first.longitude_deg + east_turn_deg);
    Some(area)
}

#[cfg(test)]
mod tests {
    use super::*;

    const EDWARDS: Position = Position::new(34.905, -117.884);
    const ZACA: Position = Position::new(34.716, -119.783);

    #[test]
    fn known_distances_agree() {
        // Karney's example: JFK to Singapore Changi, 15347628 m.
        let jfk = Position::new(40.6, -73.8);
        let sin = Position::new(1.36666667, 103.98333333);
        assert!((distance_m(jfk, Position::new(51.6, -0.5)) - 5_551_759.400).abs() < 0.01);
        assert!((distance_m(jfk, sin) - 15_347_000.0).abs() < 5_000.0);
        // A degree of latitude at the equator and a quarter of the meridian.
        assert!((distance_m(Position::new(0.0, 0.0), Position::new(1.0, 0.0)) - 110_574.389).abs() < 0.01);
        assert!((distance_m(Position::new(0.0, 0.0), Position::new(90.0, 0.0)) - 10_001_965.729).abs() < 0.01);
    }

    #[test]
    fn destination_undoes_inverse() {
        let (distance, azimuth) = inverse(EDWARDS, ZACA);
        let there = destination(EDWARDS, azimuth, distance);
        assert!(distance_m(there, ZACA) < 1e-6);
        assert!((180_000.0 - distance).abs() < 10_000.0, "{distance}");
        assert!((azimuth - 263.0).abs() < 2.0, "{azimuth}");
    }

    #[test]
    fn the_middle_is_equally_far_from_both_ends() {
        let middle = midpoint(EDWARDS, ZACA);
        assert!((distance_m(EDWARDS, middle) - distance_m(middle, ZACA)).abs() < 1e-6);
        assert_eq!(interpolate(EDWARDS, ZACA, 0.0), EDWARDS);
        assert_eq!(interpolate(EDWARDS, ZACA, 1.0), ZACA);
    }

    #[test]
    fn right_of_track_is_positive() {
        let (from, to) = (Position::new(0.0, 0.0), Position::new(1.0, 0.0));
        let (along, across) = along_cross_track_m(from, to, Position::new(0.5, 0.1));
        assert!((across - 11_132.0).abs() < 80.0, "{across}");
        assert!((along - 55_287.0).abs() < 400.0, "{along}");
    }

    #[test]
    fn nonsense_gives_not_a_number_and_no_panic() {
        for bad in [f64::NAN, f64::INFINITY, 91.0] {
            assert!(!distance_m(EDWARDS, Position::new(bad, 0.0)).is_finite());
        }
        assert!(!distance_m(EDWARDS, Position::new(0.0, f64::NAN)).is_finite());
        let lost = destination(EDWARDS, f64::NAN, 10.0);
        assert!(lost.latitude_deg.is_nan() || lost.longitude_deg.is_nan());
    }

    #[test]
    fn a_box_may_span_the_date_line() {
        let area = bounding_area(&[Position::new(1.0, 179.0), Position::new(-1.0, -179.0)]).unwrap();
        assert_eq!((area.west_deg, area.east_deg), (179.0, -179.0));
        assert!(area.contains(Position::new(0.0, 180.0)) && !area.contains(Position::new(0.0, 0.0)));
    }
}
