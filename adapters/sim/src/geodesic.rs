//! Distance and azimuth on the WGS84 ellipsoid, cheap enough for every step of the flight.
//!
//! Vincenty's inverse with at most five rounds: less than a millimetre from `apex_geo::geodesy` up to thousands of
//! kilometres at a fifth of its price. Where the rounds do not settle (nearly antipodal places) `apex_geo` answers.

use apex_geo::geodesy::{self, RAD_PER_DEG, wrap_180};
use apex_model::problem::Position;
use libm::{atan2, cos, sin, sqrt};
use std::f64::consts::TAU;

const SEMI_MAJOR_M: f64 = 6_378_137.0;
const FLATTENING: f64 = 1.0 / 298.257_223_563;
const SEMI_MINOR_M: f64 = SEMI_MAJOR_M * (1.0 - FLATTENING);
/// Each round leaves about a three hundredth of the error; 1e-11 rad are 64 micrometres.
const ROUNDS_MAX: u32 = 5;
const SETTLED_RAD: f64 = 1e-11;

/// Sine and cosine of the reduced latitude.
fn reduced(latitude_deg: f64) -> (f64, f64) {
    let latitude_rad = latitude_deg * RAD_PER_DEG;
    let (sine, cosine) = ((1.0 - FLATTENING) * sin(latitude_rad), cos(latitude_rad));
    let length = sqrt(sine * sine + cosine * cosine);
    (sine / length, cosine / length)
}

/// Azimuth at `from` (radians, clockwise from north, 0..2pi) and length in metres of the geodesic to `to`.
/// Between two equal positions the azimuth is 0.
pub(crate) fn bearing(from: Position, to: Position) -> (f64, f64) {
    if from == to {
        return (0.0, 0.0);
    }
    vincenty(from, to).unwrap_or_else(|| {
        let (distance_m, azimuth_deg) = geodesy::inverse(from, to);
        (azimuth_deg * RAD_PER_DEG, distance_m)
    })
}

fn vincenty(from: Position, to: Position) -> Option<(f64, f64)> {
    let (sin_from, cos_from) = reduced(from.latitude_deg);
    let (sin_to, cos_to) = reduced(to.latitude_deg);
    let difference = wrap_180(to.longitude_deg - from.longitude_deg) * RAD_PER_DEG;
    let mut lambda = difference;
    for _ in 0..ROUNDS_MAX {
        let (sin_lambda, cos_lambda) = (sin(lambda), cos(lambda));
        let east = cos_to * sin_lambda;
        let north = cos_from * sin_to - sin_from * cos_to * cos_lambda;
        let sin_sigma = sqrt(east * east + north * north);
        if sin_sigma == 0.0 {
            return None;
        }
        let cos_sigma = sin_from * sin_to + cos_from * cos_to * cos_lambda;
        let sigma = atan2(sin_sigma, cos_sigma);
        let sin_alpha = cos_from * cos_to * sin_lambda / sin_sigma;
        let cos2_alpha = 1.0 - sin_alpha * sin_alpha;
        // Along the equator every middle is as good as another.
        let cos_2_middle = if cos2_alpha > 1e-12 { cos_sigma - 2.0 * sin_from * sin_to / cos2_alpha } else { 0.0 };
        let middle = 2.0 * cos_2_middle * cos_2_middle - 1.0;
        let c = FLATTENING / 16.0 * cos2_alpha * (4.0 + FLATTENING * (4.0 - 3.0 * cos2_alpha));
        let stretched = sigma + c * sin_sigma * (cos_2_middle + c * cos_sigma * middle);
        let next = difference + (1.0 - c) * FLATTENING * sin_alpha * stretched;
        let settled = (next - lambda).abs() < SETTLED_RAD;
        lambda = next;
        if settled {
            let azimuth_rad = atan2(east, north);
            let azimuth_rad = if azimuth_rad < 0.0 { azimuth_rad + TAU } else { azimuth_rad };
            return Some((azimuth_rad, length_m(sigma, sin_sigma, cos_sigma, cos2_alpha, cos_2_middle)));
        }
    }
    None
}

/// Vincenty's series for the length of an arc `sigma` of the auxiliary sphere.
fn length_m(sigma: f64, sin_sigma: f64, cos_sigma: f64, cos2_alpha: f64, cos_2_middle: f64) -> f64 {
    const SQUARED: f64 = (SEMI_MAJOR_M * SEMI_MAJOR_M - SEMI_MINOR_M * SEMI_MINOR_M) / (SEMI_MINOR_M * SEMI_MINOR_M);
    let u2 = cos2_alpha * SQUARED;
    let a = 1.0 + u2 / 16_384.0 * (4_096.0 + u2 * (u2 * (320.0 - 175.0 * u2) - 768.0));
    let b = u2 / 1_024.0 * (256.0 + u2 * (u2 * (74.0 - 47.0 * u2) - 128.0));
    let square = cos_2_middle * cos_2_middle;
    let inner = cos_sigma * (2.0 * square - 1.0)
        - b / 6.0 * cos_2_middle * (4.0 * sin_sigma * sin_sigma - 3.0) * (4.0 * square - 3.0);
    let correction = b * sin_sigma * (cos_2_middle + 0.25 * b * inner);
    SEMI_MINOR_M * a * (sigma - correction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::wrap_pi;

    #[test]
    fn it_agrees_with_the_exact_geodesic_at_every_distance_and_latitude() {
        for latitude_deg in [-75.0, -33.0, 0.0, 12.0, 44.0, 89.0] {
            for longitude_deg in [-179.9, -119.0, 0.0, 179.99] {
                let from = Position::new(latitude_deg, longitude_deg);
                for azimuth_deg in [0.0, 0.3, 45.0, 90.0, 133.0, 180.0, 270.0, 359.0] {
                    for distance_m in [0.5, 20.0, 3_000.0, 100_000.0, 900_000.0, 6_000_000.0] {
                        let to = geodesy::destination(from, azimuth_deg, distance_m);
                        let (exact_m, exact_deg) = geodesy::inverse(from, to);
                        let (azimuth_rad, mine_m) = bearing(from, to);
                        let label = format!("{latitude_deg} {longitude_deg} {azimuth_deg} {distance_m}");
                        assert!((mine_m - exact_m).abs() < 1e-3, "{label}: {mine_m} and {exact_m}");
                        let aside_m = wrap_pi(azimuth_rad - exact_deg * RAD_PER_DEG).abs() * distance_m.min(1e5);
                        assert!(aside_m < 2e-3, "{label}: {aside_m} m aside");
                    }
                }
            }
        }
    }

    #[test]
    fn antipodes_and_nonsense_are_answered_as_by_the_exact_geodesic() {
        let from = Position::new(10.0, 20.0);
        for to in [Position::new(-10.0, -160.0), Position::new(-9.9, -159.8), from] {
            let (exact_m, _) = geodesy::inverse(from, to);
            assert!((bearing(from, to).1 - exact_m).abs() < 1e-3, "{to:?}");
        }
        assert!(bearing(from, Position::new(f64::NAN, 0.0)).1.is_nan());
    }
}
