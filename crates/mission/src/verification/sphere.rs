//! Geometry of the check, which shares no arithmetic with the travel computation that chose the paths.

use apex_model::problem::Position;
use libm::{atan, atan2, cos, sin, sqrt, tan};

/// Returns true if a polygon contains a position: the bearings of its corners, followed edge by edge, then make a full turn.
pub(super) fn is_around(corners: &[Position], here: Position) -> bool {
    let next = corners.iter().skip(1).chain(corners.first());
    let turned: f64 =
        corners.iter().zip(next).map(|(a, b)| half_turns(bearing_rad(here, *b) - bearing_rad(here, *a))).sum();
    turned.abs() > std::f64::consts::PI
}

fn half_turns(angle_rad: f64) -> f64 {
    atan2(sin(angle_rad), cos(angle_rad))
}

fn bearing_rad(from: Position, to: Position) -> f64 {
    let (phi_1, phi_2) = (from.latitude_deg.to_radians(), to.latitude_deg.to_radians());
    let east = (to.longitude_deg - from.longitude_deg).to_radians();
    atan2(sin(east) * cos(phi_2), cos(phi_1) * sin(phi_2) - sin(phi_1) * cos(phi_2) * cos(east))
}

/// Returns the distance by Lambert's formula (W. D. Lambert, "The distance between two widely separated points on the surface of the
/// earth", Journal of the Washington Academy of Sciences 32, 1942) on WGS84.
pub(super) fn lambert_distance_m(a: Position, b: Position) -> f64 {
    const SEMI_MAJOR_M: f64 = 6_378_137.0;
    const FLATTENING: f64 = 1.0 / 298.257_223_563;
    let reduced = |position: Position| atan((1.0 - FLATTENING) * tan(position.latitude_deg.to_radians()));
    let (beta_1, beta_2) = (reduced(a), reduced(b));
    let east = (b.longitude_deg - a.longitude_deg).to_radians();
    let (half_north, half_east) = (sin(0.5 * (beta_2 - beta_1)), sin(0.5 * east));
    let chord = half_north * half_north + cos(beta_1) * cos(beta_2) * half_east * half_east;
    let sigma = 2.0 * atan2(sqrt(chord), sqrt((1.0 - chord).max(0.0)));
    if sigma < 1e-9 {
        return 0.0;
    }
    let (p, q) = (0.5 * (beta_1 + beta_2), 0.5 * (beta_2 - beta_1));
    let (half_sine, half_cosine) = (sin(0.5 * sigma), cos(0.5 * sigma));
    let square = |x: f64| x * x;
    let x = (sigma - sin(sigma)) * square(sin(p) * cos(q)) / square(half_cosine);
    let y = (sigma + sin(sigma)) * square(cos(p) * sin(q)) / square(half_sine);
    SEMI_MAJOR_M * (sigma - 0.5 * FLATTENING * (x + y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_vincenty() {
        // Flinders Peak to Buninyon: 54,972.271 m on GRS80, which differs from WGS84 by less than a millimetre here.
        let flinders =
            Position::new(-(37.0 + 57.0 / 60.0 + 3.720_30 / 3600.0), 144.0 + 25.0 / 60.0 + 29.524_40 / 3600.0);
        let buninyon =
            Position::new(-(37.0 + 39.0 / 60.0 + 10.156_10 / 3600.0), 143.0 + 55.0 / 60.0 + 35.383_90 / 3600.0);
        assert!((lambert_distance_m(flinders, buninyon) - 54_972.271).abs() < 1.0);
    }

    #[test]
    fn corners_go_around_what_is_inside() {
        let corners = [(37.3, -117.05), (37.88, -116.92), (37.88, -115.3), (36.85, -115.3), (36.85, -116.45)];
        let corners = corners.map(|(latitude, longitude)| Position::new(latitude, longitude));
        assert!(is_around(&corners, Position::new(37.4, -116.0)));
        assert!(!is_around(&corners, Position::new(36.95, -116.9)));
        assert!(!is_around(&corners, Position::new(37.4, -115.2)));
    }
}
