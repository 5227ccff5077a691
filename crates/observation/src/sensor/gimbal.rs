//! Gimbals: pan and tilt of a line of sight, the cone around the nadir, pointing tolerance, sun keep-out.
//!
//! Tilt 0 points ahead, -90 straight down; pan is positive to the right. Straight below the vehicle pan is undetermined: inside a cone
//! around the pan axis it is held, and only the error of the sight line counts.

use crate::attitude::{Rotation, Vector};
use apex_geo::geodesy::{RAD_PER_DEG, wrap_180};
use serde::{Deserialize, Serialize};

/// A two-axis mount, or one with tilt only (`pan_deg` of zero width).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gimbal {
    /// Least and greatest tilt.
    pub tilt_deg: (f64, f64),
    /// Least and greatest pan; equal for a mount that does not pan.
    pub pan_deg: (f64, f64),
    /// Greatest rate of either axis.
    pub rate_deg_s: f64,
    /// Time until vibration after a slew has died down; 0.3 to 0.5 s is usual.
    pub settle_s: f64,
}

/// Angles of a gimbal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GimbalAngles {
    /// Pan, right positive.
    pub pan_deg: f64,
    /// Tilt, 0 ahead, -90 straight down.
    pub tilt_deg: f64,
}

/// Required accuracy of a sight line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointingTolerance {
    /// Full field of view of the sensor, the narrower one.
    pub field_of_view_deg: f64,
    /// Standard deviation of the attitude.
    pub attitude_sigma_deg: f64,
    /// Angle of one pixel.
    pub pixel_mrad: f64,
}

/// Angles of a gimbal that looks along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pointing {
    /// Angles to take, inside the limits.
    pub angles: GimbalAngles,
    /// Remaining angle between the sight line and the wanted line, because of limits, a missing pan axis or the nadir cone.
    pub error_deg: f64,
    /// True if the line is inside the cone around the axis of pan, where pan is held.
    pub is_in_nadir_cone: bool,
}

/// Half angle of the cone around the pan axis in which pan is held, unless a slow pan axis needs a wider one.
pub const NADIR_CONE_DEG: f64 = 3.0;

impl PointingTolerance {
    /// Returns the accepted angle between sight line and target: the largest of a twentieth of the field of view, two standard deviations
    /// of the attitude, and a pixel.
    pub fn tolerance_deg(&self) -> f64 {
        (self.field_of_view_deg / 20.0).max(2.0 * self.attitude_sigma_deg).max(self.pixel_mrad * 1e-3 / RAD_PER_DEG)
    }
}

/// Returns the pan and tilt of a line of sight given in body axes.
pub fn angles_of(line: Vector) -> GimbalAngles {
    GimbalAngles {
        pan_deg: libm::atan2(line.y, line.x) / RAD_PER_DEG,
        tilt_deg: -libm::atan2(line.z, libm::hypot(line.x, line.y)) / RAD_PER_DEG,
    }
}

/// Returns the unit line of sight in body axes at these angles.
pub fn line_of(angles: GimbalAngles) -> Vector {
    let (pan_rad, tilt_rad) = (angles.pan_deg * RAD_PER_DEG, angles.tilt_deg * RAD_PER_DEG);
    let level = libm::cos(tilt_rad);
    Vector::new(level * libm::cos(pan_rad), level * libm::sin(pan_rad), -libm::sin(tilt_rad))
}

impl Gimbal {
    /// Returns the half angle of the cone around the pan axis in which pan is held. A target that moves through the body axes at
    /// `sight_rate_deg_s` needs the pan rate `sight rate / sin(cone)`; the cone is wide enough for the axis to follow.
    pub fn nadir_cone_deg(&self, sight_rate_deg_s: f64) -> f64 {
        let ratio = (sight_rate_deg_s / self.rate_deg_s).clamp(0.0, 1.0);
        NADIR_CONE_DEG.max(libm::asin(ratio) / RAD_PER_DEG)
    }

    /// Returns the angles for a line of sight in body axes, from the present angles. `cone_deg` is [`Gimbal::nadir_cone_deg`].
    pub fn point(&self, line: Vector, present: GimbalAngles, cone_deg: f64) -> Pointing {
        let wanted = angles_of(line);
        let level = libm::hypot(line.x, line.y);
        let is_in_nadir_cone = level < libm::sin(cone_deg * RAD_PER_DEG) * line.length();
        let pan_deg = if is_in_nadir_cone { present.pan_deg } else { self.reachable_pan_deg(wanted.pan_deg) };
        let pan_deg = pan_deg.clamp(self.pan_deg.0, self.pan_deg.1);
        // With the present pan, the best tilt points along the projection of the line on the plane of tilt.
        let pan_rad = pan_deg * RAD_PER_DEG;
        let ahead = line.x * libm::cos(pan_rad) + line.y * libm::sin(pan_rad);
        let tilt_deg = -libm::atan2(line.z, ahead) / RAD_PER_DEG;
        let angles = GimbalAngles { pan_deg, tilt_deg: self.nearest_tilt_deg(tilt_deg) };
        Pointing { angles, error_deg: line_of(angles).angle_rad(line) / RAD_PER_DEG, is_in_nadir_cone }
    }

    /// Returns the angle between the sight line of these angles and the target's line, both in north-east-down axes. Pan is not compared
    /// separately, so that for a target straight below only the sight line counts.
    pub fn sight_error_deg(angles: GimbalAngles, body: &Rotation, target: Vector) -> f64 {
        body.to_ground(line_of(angles)).angle_rad(target) / RAD_PER_DEG
    }

    /// Returns the time to slew between two sets of angles and settle.
    pub fn slew_s(&self, from: GimbalAngles, to: GimbalAngles) -> f64 {
        let greatest_deg = (to.pan_deg - from.pan_deg).abs().max((to.tilt_deg - from.tilt_deg).abs());
        greatest_deg / self.rate_deg_s + self.settle_s
    }

    /// Returns the deadline of a slew: its time and a margin of 2 s.
    pub fn deadline_s(&self, from: GimbalAngles, to: GimbalAngles) -> f64 {
        self.slew_s(from, to) + 2.0
    }

    /// Returns the pan angle equal to `pan_deg` up to whole turns that is inside the limits, or the nearer limit.
    fn reachable_pan_deg(&self, pan_deg: f64) -> f64 {
        let turns = [0.0, -360.0, 360.0].map(|turn| pan_deg + turn);
        let inside = turns.into_iter().find(|angle| self.pan_deg.0 <= *angle && *angle <= self.pan_deg.1);
        let beyond = |limit: f64| wrap_180(pan_deg - limit).abs();
        let nearer = if beyond(self.pan_deg.0) < beyond(self.pan_deg.1) { self.pan_deg.0 } else { self.pan_deg.1 };
        inside.unwrap_or(nearer)
    }

    /// Returns the reachable tilt nearest to `tilt_deg` on the circle: a line behind the vehicle is beyond -90.
    fn nearest_tilt_deg(&self, tilt_deg: f64) -> f64 {
        let (low, high) = self.tilt_deg;
        let turns = [0.0, -360.0, 360.0].map(|turn| tilt_deg + turn);
        if let Some(inside) = turns.into_iter().find(|angle| low <= *angle && *angle <= high) {
            return inside;
        }
        if wrap_180(tilt_deg - low).abs() < wrap_180(tilt_deg - high).abs() { low } else { high }
    }
}

/// Returns the angle in degrees that must stay between boresight and sun: half the field of view and a margin.
pub fn keep_out_deg(field_of_view_deg: f64, margin_deg: f64) -> f64 {
    0.5 * field_of_view_deg + margin_deg
}

/// Returns the least angle between the sun and the boresight during a slew on the great circle from one direction to another. All are
/// unit vectors in the same axes. Between opposite directions the great circle is undetermined: the angle is then 0.
pub fn least_sun_angle_deg(from: Vector, to: Vector, sun: Vector) -> f64 {
    let ends_rad = from.angle_rad(sun).min(to.angle_rad(sun));
    let normal = from.cross(to);
    let length = normal.length();
    if length < 1e-12 {
        return if from.dot(to) > 0.0 { ends_rad / RAD_PER_DEG } else { 0.0 };
    }
    let height = sun.dot(normal) / length;
    let foot = sun.plus(-height / length, normal);
    let is_between = from.cross(foot).dot(normal) >= 0.0 && foot.cross(to).dot(normal) >= 0.0;
    let least_rad = if is_between { libm::asin(height.abs().min(1.0)) } else { ends_rad };
    least_rad / RAD_PER_DEG
}

/// Sun elevation below which the keep-out does not apply.
pub const KEEP_OUT_ELEVATION_DEG_MIN: f64 = -1.0;

/// Returns true if the boresight may slew from one direction to another with the shutter open.
pub fn is_slew_allowed(from: Vector, to: Vector, sun: Vector, keep_out_deg: f64) -> bool {
    let elevation_deg = libm::asin((-sun.z).clamp(-1.0, 1.0)) / RAD_PER_DEG;
    elevation_deg < KEEP_OUT_ELEVATION_DEG_MIN || least_sun_angle_deg(from, to, sun) >= keep_out_deg
}

/// Returns the roll angle at which a down-looking scanner first sees the sun: `90 + elevation - F/2 - margin`.
pub fn scanner_sun_roll_deg(sun_elevation_deg: f64, field_of_view_deg: f64, margin_deg: f64) -> f64 {
    90.0 + sun_elevation_deg - 0.5 * field_of_view_deg - margin_deg
}

/// Returns the tilt and pan rates (deg/s) that hold a ground point in view in level flight: `height_m` above it, `offset_m` away
/// horizontally, moving at `along_mps` towards it and `across_mps` at right angles. The pan rate is `None` straight above it.
pub fn tracking_rates_deg_s(height_m: f64, offset_m: f64, along_mps: f64, across_mps: f64) -> (f64, Option<f64>) {
    let squared = height_m * height_m + offset_m * offset_m;
    let tilt = along_mps.abs() * height_m / squared / RAD_PER_DEG;
    (tilt, (offset_m > 0.0).then(|| across_mps.abs() / offset_m / RAD_PER_DEG))
}
