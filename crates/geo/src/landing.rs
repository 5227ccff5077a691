//! Emergency landing places: how far is the nearest one, and does a leg stay near enough?
//!
//! Bound: O(places) per position; a leg takes at most [`LEG_LOOKS_MAX`] looks.

use crate::geodesy::{self, Position};
pub use apex_model::problem::LandingPlace;

/// Looks at one leg; with steps of at least [`LOOK_M_MIN`] this covers 20,000 km.
pub const LEG_LOOKS_MAX: usize = 40_000;
/// Least step between looks: an excursion shorter than this may be missed.
pub const LOOK_M_MIN: f64 = 500.0;

/// The nearest landing place and its distance; none where there are none or the position is not finite.
pub fn nearest(places: &[LandingPlace], position: Position) -> Option<(&LandingPlace, f64)> {
    let distances = places.iter().map(|place| (place, geodesy::distance_m(position, place.position)));
    distances.filter(|(_, distance_m)| distance_m.is_finite()).min_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// Does every point of the leg have a landing place within `distance_m_max`? Steps by the slack at each look, which is
/// exact but for excursions shorter than [`LOOK_M_MIN`]. Without places the answer is no.
pub fn leg_is_within(places: &[LandingPlace], from: Position, to: Position, distance_m_max: f64) -> bool {
    let slack =
        |position| nearest(places, position).map_or(f64::NEG_INFINITY, |(_, distance_m)| distance_m_max - distance_m);
    let (length_m, azimuth_deg) = geodesy::inverse(from, to);
    let (first, last) = (slack(from), slack(to));
    if first < 0.0 || last < 0.0 || !length_m.is_finite() {
        return false;
    }
    let mut travelled_m = first.max(LOOK_M_MIN);
    for _ in 0..LEG_LOOKS_MAX {
        if travelled_m >= length_m - last {
            return true;
        }
        let here = slack(geodesy::destination(from, azimuth_deg, travelled_m));
        if here < 0.0 {
            return false;
        }
        travelled_m += here.max(LOOK_M_MIN);
    }
    false
}

/// Distance over ground that a glide from `height_m` above the landing place gives, with `tail_wind_mps` (negative for
/// head wind) at a gliding speed; 0 where the wind is stronger than the speed.
pub fn glide_range_m(height_m: f64, glide_ratio: f64, speed_mps: f64, tail_wind_mps: f64) -> f64 {
    let still_m = height_m.max(0.0) * glide_ratio.max(0.0);
    if speed_mps > 0.0 { (still_m * (speed_mps + tail_wind_mps) / speed_mps).max(0.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(name: &str, latitude: f64, longitude: f64) -> LandingPlace {
        LandingPlace { name: name.to_string(), position: Position::new(latitude, longitude) }
    }

    #[test]
    fn the_gap_between_two_places_is_found() {
        let places = [place("west", 40.0, -120.0), place("east", 40.0, -116.0)];
        let (from, to) = (Position::new(40.0, -120.0), Position::new(40.0, -116.0));
        assert!(!leg_is_within(&places, from, to, 160_000.0));
        assert!(leg_is_within(&places, from, to, 175_000.0));
        assert!(!leg_is_within(&[], from, to, 1e9));
        let (nearest, distance_m) = nearest(&places, Position::new(40.1, -119.9)).unwrap();
        assert_eq!(nearest.name, "west");
        assert!(distance_m < 15_000.0);
    }

    #[test]
    fn head_wind_shortens_the_glide() {
        assert_eq!(glide_range_m(1000.0, 15.0, 50.0, 0.0), 15_000.0);
        assert_eq!(glide_range_m(1000.0, 15.0, 50.0, -25.0), 7_500.0);
        assert_eq!(glide_range_m(1000.0, 15.0, 50.0, -60.0), 0.0);
    }
}
