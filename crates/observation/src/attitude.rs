//! Attitude: body axes x forward, y right, z down in local north-east-down axes; yaw, pitch and roll in that order.

use apex_geo::geodesy::{RAD_PER_DEG, wrap_180, wrap_360};
use serde::{Deserialize, Serialize};

/// A vector with components north, east, down (or forward, right, down in body axes).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vector {
    /// North or forward.
    pub x: f64,
    /// East or right.
    pub y: f64,
    /// Down.
    pub z: f64,
}

impl Vector {
    /// Returns the vector of these components.
    pub const fn new(x: f64, y: f64, z: f64) -> Vector {
        Vector { x, y, z }
    }

    /// Returns the scalar product.
    pub fn dot(self, other: Vector) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Returns the vector product.
    pub fn cross(self, other: Vector) -> Vector {
        Vector {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// Returns the length.
    pub fn length(self) -> f64 {
        libm::sqrt(self.dot(self))
    }

    /// Returns `self + scale * other`.
    pub fn plus(self, scale: f64, other: Vector) -> Vector {
        Vector { x: self.x + scale * other.x, y: self.y + scale * other.y, z: self.z + scale * other.z }
    }

    /// Returns the angle between two vectors in radians, exact for small and for large angles; 0 if a vector has no length.
    pub fn angle_rad(self, other: Vector) -> f64 {
        libm::atan2(self.cross(other).length(), self.dot(other))
    }
}

/// Yaw (heading, clockwise from north), pitch (nose up) and roll (right wing down).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Attitude {
    /// Heading of the nose.
    pub heading_deg: f64,
    /// Pitch, nose up positive.
    pub pitch_deg: f64,
    /// Roll, right wing down positive.
    pub roll_deg: f64,
}

/// The rotation from body axes to north-east-down: `Rz(yaw) Ry(pitch) Rx(roll)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    rows: [Vector; 3],
}

impl Attitude {
    /// Returns the rotation of this attitude.
    pub fn rotation(&self) -> Rotation {
        let angle = |degrees: f64| (libm::sin(degrees * RAD_PER_DEG), libm::cos(degrees * RAD_PER_DEG));
        let ((sy, cy), (sp, cp), (sr, cr)) = (angle(self.heading_deg), angle(self.pitch_deg), angle(self.roll_deg));
        Rotation {
            rows: [
                Vector::new(cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
                Vector::new(sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
                Vector::new(-sp, cp * sr, cp * cr),
            ],
        }
    }

    /// Returns the attitude at `fraction` (0 here, 1 at `to`) on the shortest turn. For the small differences between successive samples
    /// the angles are interpolated separately; the error against a turn about one axis is the product of the differences.
    pub fn interpolate(&self, to: &Attitude, fraction: f64) -> Attitude {
        let between = |a: f64, b: f64| a + fraction * wrap_180(b - a);
        Attitude {
            heading_deg: wrap_360(between(self.heading_deg, to.heading_deg)),
            pitch_deg: between(self.pitch_deg, to.pitch_deg),
            roll_deg: between(self.roll_deg, to.roll_deg),
        }
    }
}

impl Rotation {
    /// Converts `vector` from body axes to north-east-down axes.
    pub fn to_ground(&self, vector: Vector) -> Vector {
        let [north, east, down] = self.rows;
        Vector::new(north.dot(vector), east.dot(vector), down.dot(vector))
    }

    /// Converts `vector` from north-east-down axes to body axes.
    pub fn to_body(&self, vector: Vector) -> Vector {
        let [north, east, down] = self.rows;
        let sum = |a: f64, b: f64, c: f64| a * vector.x + b * vector.y + c * vector.z;
        Vector::new(sum(north.x, east.x, down.x), sum(north.y, east.y, down.y), sum(north.z, east.z, down.z))
    }
}
