//! Emergency landing places: distance of the nearest one, and legs that stay near enough.
//!
//! Bound: O(places) per position; a leg takes at most [`LEG_LOOKS_MAX`] samples.

use crate::direction::{ARC_APART_M_MAX, ARC_RAD_MAX, Direction, EARTH_RADIUS_M_MAX, EARTH_RADIUS_M_MIN};
use crate::geodesy::{self, Position};
pub use apex_model::problem::LandingPlace;

/// Maximum number of samples of one leg; with steps of at least [`LOOK_M_MIN`] this covers 20,000 km.
pub const LEG_LOOKS_MAX: usize = 40_000;
/// Least step between samples: an excursion shorter than this may be missed.
pub const LOOK_M_MIN: f64 = 500.0;

/// Returns the nearest landing place and its distance; `None` if there are none or the position is not finite.
pub fn nearest(places: &[LandingPlace], position: Position) -> Option<(&LandingPlace, f64)> {
    let distances = places.iter().map(|place| (place, geodesy::distance_m(position, place.position)));
    distances.filter(|(_, distance_m)| distance_m.is_finite()).min_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// Returns true if every point of the leg has a landing place within `distance_m_max`. Steps by the slack at each
/// sample, which is exact except for excursions shorter than [`LOOK_M_MIN`]. Without places the answer is false.
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

/// Landing places with the greatest permitted distance, prepared for many queries: the ellipsoid is used only if directions alone cannot
/// decide.
#[derive(Clone, Debug)]
pub struct Reach {
    places: Vec<LandingPlace>,
    directions: Vec<Direction>,
    distance_m_max: f64,
    /// A position within this angle of a place is surely near enough.
    sure_rad: f64,
    /// A position beyond this angle from every place is surely too far.
    doubtful_rad: f64,
}

impl Reach {
    /// Returns the reach: all points within `distance_m_max` of one of `places`.
    pub fn new(places: Vec<LandingPlace>, distance_m_max: f64) -> Reach {
        let directions = places.iter().map(|place| Direction::of(place.position)).collect();
        // The factor allows for the error of distances, the constant for the distance of arcs from geodesics.
        let sure_rad = (distance_m_max * 0.9999 - ARC_APART_M_MAX) / EARTH_RADIUS_M_MAX;
        let doubtful_rad = (distance_m_max * 1.0001 + ARC_APART_M_MAX) / EARTH_RADIUS_M_MIN;
        Reach { places, directions, distance_m_max, sure_rad, doubtful_rad }
    }

    /// Returns the landing places.
    pub fn places(&self) -> &[LandingPlace] {
        &self.places
    }

    /// Returns the distance that must be kept.
    pub fn distance_m_max(&self) -> f64 {
        self.distance_m_max
    }

    /// Returns true if a landing place is near enough to `position`, which lies in `direction`.
    pub fn holds(&self, position: Position, direction: Direction) -> bool {
        let cosine = self.directions.iter().fold(-1.0, |most: f64, place| most.max(place.dot(direction)));
        if self.sure_rad > 0.0 && cosine >= libm::cos(self.sure_rad.min(3.0)) {
            return true;
        }
        if cosine < libm::cos(self.doubtful_rad.min(3.0)) {
            return false;
        }
        nearest(&self.places, position).is_some_and(|(_, distance_m)| distance_m <= self.distance_m_max)
    }

    /// Returns the points at which the edges of two places' reaches meet outside of all others: the shortest paths within reach bend
    /// there. Computed on the sphere, slightly inside the reach: by 400 m and 0.01 % (equator) to 0.35 % (poles) of the distance.
    pub fn crossings(&self) -> Vec<Position> {
        let least = libm::cos(self.sure_rad * (1.0 - 1e-9));
        if self.sure_rad <= 0.0 || self.sure_rad > 1.5 {
            return Vec::new();
        }
        let mut found = Vec::new();
        for (number, one) in self.directions.iter().enumerate() {
            for (other_number, other) in self.directions.iter().enumerate().skip(number + 1) {
                let inside = |here: &Direction| {
                    let others = self.directions.iter().enumerate();
                    let mut others = others.filter(|(third, _)| *third != number && *third != other_number);
                    others.any(|(_, third)| third.dot(*here) > least)
                };
                found.extend(one.at_angle_from_both(*other, least).into_iter().flatten().filter(|here| !inside(here)));
            }
        }
        found.into_iter().map(Direction::position).collect()
    }

    /// Like [`leg_is_within`]; unless `exact`, returns false for undecided legs, which is fast.
    pub fn holds_leg(
        &self,
        (from, from_direction): (Position, Direction),
        (to, to_direction): (Position, Direction),
        exact: bool,
    ) -> bool {
        let quick = self.sure_rad > 0.0 && self.doubtful_rad < 1.5;
        if quick {
            let least = libm::cos(self.sure_rad);
            let near = |place: &Direction| place.dot(from_direction) >= least && place.dot(to_direction) >= least;
            // A point between two ends near one place is near that place.
            if self.directions.iter().any(near) {
                return true;
            }
            let angle_rad = from_direction.angle_rad(to_direction);
            let quarter = from_direction.quarter_turn_to(to_direction).filter(|_| angle_rad <= ARC_RAD_MAX);
            if let Some(quarter) = quarter {
                let covered = |within_rad| self.covers((from_direction, quarter), angle_rad, within_rad);
                if covered(self.sure_rad) {
                    return true;
                }
                if !exact || !covered(self.doubtful_rad) {
                    return false;
                }
            }
        }
        leg_is_within(&self.places, from, to, self.distance_m_max)
    }

    /// Returns true if the whole arc from `start` over `angle_rad` towards `quarter` is within `within_rad` of places. Each place covers
    /// one span of the arc.
    fn covers(&self, (start, quarter): (Direction, Direction), angle_rad: f64, within_rad: f64) -> bool {
        let least = libm::cos(within_rad);
        let span = |place: &Direction| {
            let (along, ahead) = (place.dot(start), place.dot(quarter));
            let most = libm::sqrt(along * along + ahead * ahead);
            let half_rad = libm::acos((least / most).min(1.0));
            let middle_rad = libm::atan2(ahead, along);
            (most > least).then_some((middle_rad - half_rad, middle_rad + half_rad))
        };
        let mut spans: Vec<(f64, f64)> = self.directions.iter().filter_map(span).collect();
        spans.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut covered_rad = 0.0;
        for (from_rad, until_rad) in spans {
            if from_rad <= covered_rad {
                covered_rad = until_rad.max(covered_rad);
            }
        }
        covered_rad >= angle_rad
    }
}

/// Returns the distance over ground of a glide from `height_m` above the landing place, with `tail_wind_mps` (negative for head wind) at
/// a gliding speed; 0 if the wind is stronger than the speed.
pub fn glide_range_m(height_m: f64, glide_ratio: f64, speed_mps: f64, tail_wind_mps: f64) -> f64 {
    let still_m = height_m.max(0.0) * glide_ratio.max(0.0);
    if speed_mps > 0.0 { (still_m * (speed_mps + tail_wind_mps) / speed_mps).max(0.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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

    proptest! {
        #[test]
        fn the_fast_answer_is_the_slow_one(
            spots in prop::collection::vec((34.0..46.0f64, -124.0..-110.0f64), 0..8), limit_m in 1_000.0..900_000.0f64,
            from in (34.0..46.0f64, -124.0..-110.0f64), to in (34.0..46.0f64, -124.0..-110.0f64),
        ) {
            let places: Vec<LandingPlace> = spots.iter().map(|(latitude, longitude)| place("x", *latitude, *longitude)).collect();
            let reach = Reach::new(places.clone(), limit_m);
            let (from, to) = (Position::new(from.0, from.1), Position::new(to.0, to.1));
            let (from_direction, to_direction) = (Direction::of(from), Direction::of(to));
            let near = nearest(&places, from).is_some_and(|(_, distance_m)| distance_m <= limit_m);
            prop_assert_eq!(reach.holds(from, from_direction), near);
            let slow = leg_is_within(&places, from, to, limit_m);
            let quick = reach.holds_leg((from, from_direction), (to, to_direction), true);
            // Stepping may miss a gap shorter than a step, but never reports a gap that does not exist.
            prop_assert!(quick == slow || (slow && !leg_is_within(&places, from, to, limit_m - LOOK_M_MIN)));
        }
    }

    #[test]
    fn head_wind_shortens_the_glide() {
        assert_eq!(glide_range_m(1000.0, 15.0, 50.0, 0.0), 15_000.0);
        assert_eq!(glide_range_m(1000.0, 15.0, 50.0, -25.0), 7_500.0);
        assert_eq!(glide_range_m(1000.0, 15.0, 50.0, -60.0), 0.0);
    }
}
