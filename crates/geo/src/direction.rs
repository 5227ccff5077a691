//! Fast geometry: positions as directions from the centre of the Earth.
//!
//! On the sphere of geocentric directions, an angle times the local Earth radius is a distance, accurate to 1 in 10,000 up to 2,500 km,
//! and arcs between two directions stay within [`ARC_APART_M_MAX`] of the geodesic. A caller that needs an exact answer uses `geodesy` if
//! the fast answer is too close to a limit. Bound: every function is O(1).

use crate::geodesy::{Position, RAD_PER_DEG};

/// Least distance of the ellipsoid's surface from its middle.
pub const EARTH_RADIUS_M_MIN: f64 = 6_356_752.314_245;
/// Greatest distance of the ellipsoid's surface from its middle.
pub const EARTH_RADIUS_M_MAX: f64 = 6_378_137.0;
/// Arcs up to this angle (2,500 km) stay close to geodesics.
pub const ARC_RAD_MAX: f64 = 0.392;
/// Greatest distance of an arc of at most [`ARC_RAD_MAX`] from the geodesic between the same ends.
pub const ARC_APART_M_MAX: f64 = 400.0;
/// Square of the first eccentricity of WGS84.
const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_141_316e-3;

/// A unit vector from the middle of the Earth in Earth-fixed axes: x towards (0, 0), y towards (0, 90 E), z to the north pole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Direction {
    x: f64,
    y: f64,
    z: f64,
}

impl Direction {
    /// Returns the direction of the surface at `position`; not finite where the position is not.
    pub fn of(position: Position) -> Direction {
        let latitude_rad = position.latitude_deg * RAD_PER_DEG;
        let longitude_rad = position.longitude_deg * RAD_PER_DEG;
        let cosine = libm::cos(latitude_rad);
        Direction {
            x: cosine * libm::cos(longitude_rad),
            y: cosine * libm::sin(longitude_rad),
            z: (1.0 - ECCENTRICITY_SQUARED) * libm::sin(latitude_rad),
        }
        .scaled_to_unit()
    }

    /// Returns the position on the surface in this direction, longitude -180..180.
    pub fn position(self) -> Position {
        let equatorial = libm::sqrt(self.x * self.x + self.y * self.y);
        Position {
            latitude_deg: libm::atan2(self.z, (1.0 - ECCENTRICITY_SQUARED) * equatorial) / RAD_PER_DEG,
            longitude_deg: libm::atan2(self.y, self.x) / RAD_PER_DEG,
        }
    }

    /// Returns the cosine of the angle between two directions.
    pub fn dot(self, other: Direction) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Returns the vector product: perpendicular to both, of length 1 if they are at right angles.
    pub fn cross(self, other: Direction) -> Direction {
        Direction {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// Returns the length of the straight line between the tips of two directions: never more than the angle in radians.
    pub fn chord(self, other: Direction) -> f64 {
        let (x, y, z) = (self.x - other.x, self.y - other.y, self.z - other.z);
        libm::sqrt(x * x + y * y + z * z)
    }

    /// Returns the angle between two directions.
    pub fn angle_rad(self, other: Direction) -> f64 {
        2.0 * libm::asin((0.5 * self.chord(other)).min(1.0))
    }

    /// Returns the distance over ground, good to 1 in 10,000 up to 2,500 km.
    pub fn distance_m(self, other: Direction) -> f64 {
        let middle = Direction { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }.scaled_to_unit();
        let polar = 1.0 - ECCENTRICITY_SQUARED * (1.0 - middle.z * middle.z);
        self.angle_rad(other) * EARTH_RADIUS_M_MIN / libm::sqrt(polar)
    }

    /// Returns a distance over ground that the geodesic never undercuts: the straight line through the Earth.
    pub fn distance_m_min(self, other: Direction) -> f64 {
        self.chord(other) * EARTH_RADIUS_M_MIN
    }

    /// Returns the direction 90 degrees from this one on the way to `other`; `None` if both are equal or opposite.
    pub fn quarter_turn_to(self, other: Direction) -> Option<Direction> {
        let along = self.dot(other);
        let ahead = Direction { x: other.x - along * self.x, y: other.y - along * self.y, z: other.z - along * self.z };
        let length = libm::sqrt(ahead.dot(ahead));
        (length > 1e-9).then(|| Direction { x: ahead.x / length, y: ahead.y / length, z: ahead.z / length })
    }

    /// Returns the two directions whose angle from both has this cosine; `None` if the circles of that angle do not meet.
    pub fn at_angle_from_both(self, other: Direction, cosine: f64) -> Option<[Direction; 2]> {
        let between = self.dot(other);
        let share = cosine / (1.0 + between);
        let normal = self.cross(other);
        let room = (1.0 - 2.0 * cosine * share) / normal.dot(normal);
        if !(room > 0.0 && room.is_finite()) {
            return None;
        }
        let (foot, side) = (self.blended(share, other, share), libm::sqrt(room));
        Some([foot.blended(1.0, normal, side), foot.blended(1.0, normal, -side)])
    }

    /// Returns the sum of two directions, each times its share.
    pub fn blended(self, share: f64, other: Direction, other_share: f64) -> Direction {
        Direction {
            x: share * self.x + other_share * other.x,
            y: share * self.y + other_share * other.y,
            z: share * self.z + other_share * other.z,
        }
    }

    /// Returns the east and north parts of a vector `along` the surface here; at the poles along the meridian of Greenwich.
    pub fn east_north(self, along: Direction) -> (f64, f64) {
        let equatorial = libm::sqrt(self.x * self.x + self.y * self.y);
        let (sine, cosine) = if equatorial > 0.0 { (self.y / equatorial, self.x / equatorial) } else { (0.0, 1.0) };
        let east = cosine * along.y - sine * along.x;
        let north = equatorial * along.z - self.z * (cosine * along.x + sine * along.y);
        (east, north)
    }

    fn scaled_to_unit(self) -> Direction {
        let length = libm::sqrt(self.dot(self));
        Direction { x: self.x / length, y: self.y / length, z: self.z / length }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesy;
    use proptest::prelude::*;

    #[test]
    fn what_is_not_on_the_map_is_not_finite() {
        let lost = Direction::of(Position::new(f64::NAN, 0.0));
        assert!(lost.distance_m(Direction::of(Position::new(1.0, 2.0))).is_nan());
        let here = Direction::of(Position::new(40.0, -120.0));
        assert_eq!(here.quarter_turn_to(here), None);
        assert_eq!(here.distance_m(here), 0.0);
    }

    proptest! {
        #[test]
        fn distances_and_arcs_agree_with_geodesics(
            latitude in -85.0..85.0f64, longitude in -180.0..180.0f64, turn in 0.0..360.0f64, length_m in 10.0..2.49e6f64,
            share in 0.0..1.0f64,
        ) {
            let from = Position::new(latitude, longitude);
            let to = geodesy::destination(from, turn, length_m);
            let (a, b) = (Direction::of(from), Direction::of(to));
            prop_assert!(geodesy::distance_m(a.position(), from) < 1e-3);
            prop_assert!((a.distance_m(b) / length_m - 1.0).abs() < 1e-4, "{} of {length_m}", a.distance_m(b));
            prop_assert!(a.distance_m_min(b) <= length_m);
            let angle_rad = a.angle_rad(b);
            prop_assert!(angle_rad * EARTH_RADIUS_M_MIN <= length_m * 1.0001);
            prop_assert!(angle_rad * EARTH_RADIUS_M_MAX >= length_m * 0.9999);
            if let Some(quarter) = a.quarter_turn_to(b) {
                let at_rad = share * angle_rad;
                let on_arc = a.blended(libm::cos(at_rad), quarter, libm::sin(at_rad));
                let beside_m = geodesy::distance_m(on_arc.position(), geodesy::destination(from, turn, share * length_m));
                prop_assert!(beside_m < ARC_APART_M_MAX, "{beside_m} m apart");
                let (east, north) = a.east_north(quarter);
                let track_deg = libm::atan2(east, north) / RAD_PER_DEG;
                prop_assert!(length_m < 1e4 || geodesy::wrap_180(track_deg - turn).abs() < 0.3, "{track_deg} {turn}");
            }
        }
    }
}
