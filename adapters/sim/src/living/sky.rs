//! Clouds and convective cells: the conditions at a place, and the visibility of the ground through the clouds.
//!
//! A field consists of cells, each with a number drawn by seed. A cell hides the ground from above if its number is below
//! `1 - (1 - n)^(1 + 0.5 tan o)`, for cover n and a line of sight at the angle o from the vertical (assumption, `docs/reference/world.md`).
//! So two looks within a short time see the same clouds. Bound: O(fields).

use super::{CloudField, StormCell};
use crate::random::Random;
use apex_geo::geodesy;
use apex_model::problem::Position;
use libm::{pow, tan};

/// Lines of sight flatter than this are treated as this flat.
const OFF_NADIR_RAD_MAX: f64 = 1.4;
/// Side of a cell.
const CELL_M: f64 = 5_000.0;
const STREAM: u64 = 3_000;

fn moved(latitude_deg: f64, longitude_deg: f64, east_mps: f64, north_mps: f64, time_s: f64) -> Position {
    crate::motion::moved(Position { latitude_deg, longitude_deg }, north_mps * time_s, east_mps * time_s)
}

fn is_there(from_h: f64, until_h: Option<f64>, time_s: f64) -> bool {
    let hour = time_s / 3_600.0;
    from_h <= hour && until_h.is_none_or(|until_h| hour < until_h)
}

impl CloudField {
    fn middle(&self, time_s: f64) -> Position {
        moved(self.latitude_deg, self.longitude_deg, self.east_mps, self.north_mps, time_s)
    }

    fn is_above(&self, position: Position, time_s: f64) -> bool {
        is_there(self.from_h, self.until_h, time_s)
            && geodesy::distance_m(self.middle(time_s), position) <= self.radius_m
    }
}

impl StormCell {
    /// Returns the middle of the cell.
    pub(crate) fn middle(&self, time_s: f64) -> Position {
        moved(self.latitude_deg, self.longitude_deg, self.east_mps, self.north_mps, time_s)
    }

    /// Returns the distance to the edge, m; negative inside, `None` at times when the cell does not exist.
    pub(crate) fn distance_m(&self, position: Position, time_s: f64) -> Option<f64> {
        is_there(self.from_h, self.until_h, time_s)
            .then(|| geodesy::distance_m(self.middle(time_s), position) - self.radius_m)
    }
}

/// Returns true inside of a cloud field, between base and top.
pub(crate) fn is_in_cloud(clouds: &[CloudField], position: Position, altitude_m: f64, time_s: f64) -> bool {
    clouds.iter().any(|cloud| {
        cloud.cover > 0.0 && (cloud.base_m..cloud.top_m).contains(&altitude_m) && cloud.is_above(position, time_s)
    })
}

/// A look from a vehicle to the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SightLine {
    /// The place at which the line of sight meets the ground.
    pub(crate) place: Position,
    /// Altitude of the vehicle.
    pub(crate) altitude_m: f64,
    /// Angle off the vertical.
    pub(crate) off_nadir_rad: f64,
}

/// Returns true if no cloud lies between the vehicle and the ground of a look.
pub(crate) fn is_clear(clouds: &[CloudField], seed: u64, sight: SightLine, time_s: f64) -> bool {
    let exponent = 1.0 + 0.5 * tan(sight.off_nadir_rad.clamp(0.0, OFF_NADIR_RAD_MAX));
    clouds.iter().zip(0u64..).all(|(cloud, index)| {
        let between = sight.altitude_m > cloud.base_m && cloud.is_above(sight.place, time_s);
        !between || cell_number(cloud, seed, index, sight.place, time_s) >= 1.0 - pow(1.0 - cloud.cover, exponent)
    })
}

/// Returns the number of the cell above a place, from 0 to 1. Cells move with their field.
fn cell_number(cloud: &CloudField, seed: u64, index: u64, place: Position, time_s: f64) -> f64 {
    let (azimuth_rad, distance_m) = crate::path::bearing(cloud.middle(time_s), place);
    let row = libm::floor(distance_m * libm::cos(azimuth_rad) / CELL_M) as i64;
    let column = libm::floor(distance_m * libm::sin(azimuth_rad) / CELL_M) as i64;
    let row = (row as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    Random::new(seed.wrapping_add(row) ^ (column as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F), STREAM + index).uniform()
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: Position = Position { latitude_deg: 44.0, longitude_deg: -115.0 };

    fn field(cover: f64, east_mps: f64) -> CloudField {
        let Position { latitude_deg, longitude_deg } = HERE;
        CloudField {
            latitude_deg,
            longitude_deg,
            radius_m: 10_000.0,
            base_m: 2_000.0,
            top_m: 3_000.0,
            cover,
            east_mps,
            north_mps: 0.0,
            from_h: 0.0,
            until_h: Some(5.0),
        }
    }

    #[test]
    fn looks_from_above_are_clear_as_often_as_the_cover_says() {
        let share = |altitude_m, off_nadir_rad, time_s| {
            let clear = |seed: &u64| {
                let sight = SightLine { place: HERE, altitude_m, off_nadir_rad };
                is_clear(&[field(0.5, 0.0)], *seed, sight, time_s)
            };
            (0..4_000).filter(clear).count() as f64 / 4_000.0
        };
        assert!((share(7_000.0, 0.0, 0.0) - 0.5).abs() < 0.03);
        assert!((share(7_000.0, std::f64::consts::FRAC_PI_4, 0.0) - pow(0.5, 1.5)).abs() < 0.03);
        assert_eq!((share(1_500.0, 0.0, 0.0), share(7_000.0, 0.0, 19_000.0)), (1.0, 1.0));
    }

    #[test]
    fn looks_shortly_after_each_other_see_the_same_clouds() {
        let sight = SightLine { place: HERE, altitude_m: 7_000.0, off_nadir_rad: 0.1 };
        let clear = |seed, time_s| is_clear(&[field(0.5, 10.0)], seed, sight, time_s);
        let same = (0..1_000).filter(|seed| clear(*seed, 100.0) == clear(*seed, 110.0)).count();
        assert!(same > 980, "{same}");
    }

    #[test]
    fn fields_move_and_have_two_faces() {
        let clouds = [field(0.5, 20.0)];
        let inside = |altitude_m, time_s| is_in_cloud(&clouds, HERE, altitude_m, time_s);
        assert_eq!(
            [1_999.0, 2_000.0, 2_999.0, 3_000.0].map(|altitude_m| inside(altitude_m, 0.0)),
            [false, true, true, false]
        );
        assert_eq!([490.0, 510.0].map(|time_s| inside(2_500.0, time_s)), [true, false]);
    }
}
