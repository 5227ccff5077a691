//! Cameras as mounted and operated: field of view, mount, exposure, limits of motion and light; the weight of a picture for the vehicle's
//! motion, and the greatest permitted motion.

use super::gimbal::{Gimbal, GimbalAngles};
use super::scanner::{RateLimits, RollLimits};
use crate::attitude::{Attitude, Vector};
use crate::clarity::{AttitudeHold, ClarityWeights, share_within};
use apex_geo::geodesy::RAD_PER_DEG;

/// A camera for single pictures, or a video camera of which single pictures count.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraSetting {
    /// Name in commands and events.
    pub name: String,
    /// Full field of view along the rows of a picture, which are across the track when it looks straight down.
    pub wide_deg: f64,
    /// Full field of view along the columns.
    pub high_deg: f64,
    /// Angle of one pixel at the middle of the picture.
    pub pixel_mrad: f64,
    /// Exposure time.
    pub exposure_s: f64,
    /// Least time between two pictures.
    pub interval_s_min: f64,
    /// Limits of the mount; both ends of a range are equal where it does not move.
    pub mount: Gimbal,
    /// True if the mount holds tilt relative to the horizon and pan relative to the heading; false if it is fixed to the body.
    pub is_stabilised: bool,
    /// Limits of the vehicle's roll.
    pub roll: RollLimits,
    /// Limits of the smear of a picture.
    pub smear: RateLimits,
    /// Least elevation of the sun; `None` if the camera works at night.
    pub sun_deg_min: Option<f64>,
}

/// Motion of the vehicle at an exposure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExposureMotion {
    /// Roll angle; `None` if it is not known.
    pub roll_deg: Option<f64>,
    /// Speed over ground.
    pub ground_speed_mps: f64,
    /// Angular rate of the body.
    pub rotation_rad_s: f64,
    /// Distance to the ground in the middle of the picture.
    pub slant_m: f64,
    /// Elevation of the sun; `None` if it is not known.
    pub sun_deg: Option<f64>,
}

impl CameraSetting {
    /// Returns the angle of one pixel in radians.
    pub fn pixel_rad(&self) -> f64 {
        self.pixel_mrad * 1e-3
    }

    /// Returns the footprint of a picture straight down: across and along the track.
    pub fn footprint_m(&self, height_m: f64) -> (f64, f64) {
        let size = |angle_deg: f64| 2.0 * height_m * libm::tan(0.5 * angle_deg * RAD_PER_DEG);
        (size(self.wide_deg), size(self.high_deg))
    }

    /// Returns true if the mount can look straight down.
    pub fn sees_nadir(&self) -> bool {
        self.mount.tilt_deg.0 <= -90.0
    }

    /// Returns the angles of the mount for a view straight down.
    pub fn straight_down() -> GimbalAngles {
        GimbalAngles { pan_deg: 0.0, tilt_deg: -90.0 }
    }

    /// Returns the smear in pixels: motion over ground and, where the mount is not stabilised, rotation of the body.
    pub fn smear_pixels(&self, ground_speed_mps: f64, rotation_rad_s: f64, slant_m: f64) -> f64 {
        let rotation_rad_s = if self.is_stabilised { 0.0 } else { rotation_rad_s };
        self.exposure_s * (ground_speed_mps / slant_m + rotation_rad_s) / self.pixel_rad()
    }

    /// Returns the greatest ground speed without degrading smear, seen from `slant_m`, the body not rotating.
    pub fn ground_speed_mps_max(&self, slant_m: f64) -> f64 {
        self.smear.full_pixels * self.pixel_rad() * slant_m / self.exposure_s
    }

    /// Returns the weights of a flown picture. Cloud is unknown here: `clear_share` is 1.
    pub fn weights(&self, motion: &ExposureMotion) -> ClarityWeights {
        let smear = self.smear_pixels(motion.ground_speed_mps, motion.rotation_rad_s, motion.slant_m);
        ClarityWeights {
            roll: motion.roll_deg.map_or(1.0, |roll_deg| self.roll.weight(roll_deg)),
            attitude_known: if motion.roll_deg.is_some() { 1.0 } else { 0.0 },
            smear: self.smear.weight(smear),
            exposed: self.exposed(motion.sun_deg),
            ..ClarityWeights::CLEAR
        }
    }

    /// Returns the weights of a planned picture in turbulence of `edr`: roll is the probability of a valid picture.
    pub fn planned_weights(&self, motion: &ExposureMotion, hold: &AttitudeHold, edr: f64) -> ClarityWeights {
        let level = ExposureMotion { roll_deg: Some(0.0), ..*motion };
        ClarityWeights { roll: share_within(hold.roll_sigma_deg(edr), &self.roll), ..self.weights(&level) }
    }

    /// Returns 1 if the sun is high enough for the exposure or its elevation is unknown; otherwise 0.
    fn exposed(&self, sun_deg: Option<f64>) -> f64 {
        match (self.sun_deg_min, sun_deg) {
            (Some(least_deg), Some(sun_deg)) if sun_deg < least_deg => 0.0,
            _ => 1.0,
        }
    }
}

/// Returns the rotation of a sight line of the mount into north-east-down axes, for a mount at `angles` on a body with this attitude.
pub fn sight_of(attitude: &Attitude, angles: GimbalAngles, is_stabilised: bool) -> impl Fn(Vector) -> Vector + use<> {
    let body = match is_stabilised {
        true => Attitude { heading_deg: attitude.heading_deg, pitch_deg: 0.0, roll_deg: 0.0 },
        false => *attitude,
    };
    let (body, mount) =
        (body.rotation(), Attitude { heading_deg: angles.pan_deg, pitch_deg: angles.tilt_deg, roll_deg: 0.0 });
    let mount = mount.rotation();
    move |ray: Vector| body.to_ground(mount.to_ground(ray))
}
