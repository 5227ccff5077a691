//! The nearest of several places, with few geodesics.
//!
//! A chord through the ellipsoid is shorter than the geodesic between its ends and costs a fiftieth of it. So a place whose chord is longer
//! than the shortest geodesic so far cannot be the nearest.

use apex_geo::geodesy::{Position, RAD_PER_DEG};

/// Semi-major axis and first eccentricity squared of WGS84.
const AXIS_M: f64 = 6_378_137.0;
const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_141_316e-3;
/// More than the rounding errors of a chord and of a geodesic together.
const ROUNDING_M: f64 = 1e-3;

/// Returns the index of the place with the least `distance_m`, the length of the geodesic from `from`; the first one of equal distances,
/// `None` without places.
pub(super) fn nearest(
    from: Position,
    places: impl Iterator<Item = Position>,
    mut distance_m: impl FnMut(Position) -> f64,
) -> Option<usize> {
    let here = point(from);
    let chords: Vec<(f64, Position)> = places.map(|place| (length(here, point(place)), place)).collect();
    let (first, (_, place)) = chords.iter().enumerate().min_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b))?;
    let mut best = (distance_m(*place), first);
    for (index, (chord_m, place)) in chords.iter().enumerate() {
        // The condition is false for NaN: a place that is not a number is compared as such.
        if index == first || chord_m - ROUNDING_M > best.0 {
            continue;
        }
        let distance_m = distance_m(*place);
        if distance_m.total_cmp(&best.0).then(index.cmp(&best.1)).is_lt() {
            best = (distance_m, index);
        }
    }
    Some(best.1)
}

/// Returns the point of a position on the ellipsoid, in metres from the centre of the earth.
fn point(position: Position) -> [f64; 3] {
    let (latitude, longitude) = (position.latitude_deg * RAD_PER_DEG, position.longitude_deg * RAD_PER_DEG);
    let sine = libm::sin(latitude);
    let normal_m = AXIS_M / libm::sqrt(1.0 - ECCENTRICITY_SQUARED * sine * sine);
    let from_axis_m = normal_m * libm::cos(latitude);
    [
        from_axis_m * libm::cos(longitude),
        from_axis_m * libm::sin(longitude),
        normal_m * (1.0 - ECCENTRICITY_SQUARED) * sine,
    ]
}

fn length(from: [f64; 3], to: [f64; 3]) -> f64 {
    libm::sqrt(from.iter().zip(to).map(|(a, b)| (a - b) * (a - b)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_geo::geodesy;
    use proptest::prelude::*;

    fn positions(count: impl Into<proptest::collection::SizeRange>) -> impl Strategy<Value = Vec<Position>> {
        // Few longitudes and latitudes, so that equal and opposite places, poles and the 180th meridian occur.
        let coarse = (-6_i32..=6, -6_i32..=6).prop_map(|(latitude, longitude)| Position {
            latitude_deg: f64::from(latitude) * 15.0,
            longitude_deg: f64::from(longitude) * 30.0,
        });
        let fine = (-90.0..=90.0, -180.0..=180.0)
            .prop_map(|(latitude_deg, longitude_deg)| Position { latitude_deg, longitude_deg });
        prop::collection::vec(prop_oneof![coarse, fine], count)
    }

    proptest! {
        #[test]
        fn the_nearest_place_is_that_of_a_comparison_of_all_geodesics(places in positions(0..12), from in positions(1)) {
            let from = from[0];
            let exact = |place: Position| geodesy::distance_m(from, place);
            let all: Vec<f64> = places.iter().copied().map(exact).collect();
            let naive = (0..all.len()).min_by(|a, b| all[*a].total_cmp(&all[*b]));
            prop_assert_eq!(nearest(from, places.into_iter(), exact), naive);
        }
    }

    #[test]
    fn places_farther_than_the_nearest_cost_no_geodesic() {
        let places =
            (0..22).map(|place| Position { latitude_deg: 34.0 + 0.5 * f64::from(place), longitude_deg: -117.0 });
        let from = Position { latitude_deg: 40.1, longitude_deg: -116.8 };
        let mut geodesics = 0;
        let found = nearest(from, places, |place| {
            geodesics += 1;
            geodesy::distance_m(from, place)
        });
        assert_eq!((found, geodesics), (Some(12), 1));
    }

    #[test]
    fn a_place_that_is_not_a_number_is_not_the_nearest() {
        let place = |latitude_deg| Position { latitude_deg, longitude_deg: 0.0 };
        let from = place(1.0);
        let exact = |to: Position| geodesy::distance_m(from, to).abs();
        assert_eq!(nearest(from, [f64::NAN, 3.0, 2.0].into_iter().map(place), exact), Some(2));
    }
}
