//! Conditions of a manoeuvre: target, wind, approach, and the sensor.

use crate::predict::PredictedScanner;
use crate::sensor::CameraSetting;
use apex_geo::geodesy::{self, Position, RAD_PER_DEG};
use apex_geo::plane::Point;
use apex_geo::wind::Wind;

/// The place and the air of a manoeuvre. Points are metres east (x) and north (y) of the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// Middle of the target: the origin of points.
    pub target: Position,
    /// Elevation of the target above mean sea level.
    pub elevation_m: f64,
    /// Wind at the altitude of the manoeuvre, as the velocity of the air.
    pub wind: Wind,
    /// Point from which the vehicle arrives.
    pub approach: Point,
    /// Instant of the beginning.
    pub from_s: f64,
}

impl Scene {
    /// Returns a scene in still air in which the vehicle arrives from the south and begins at instant 0.
    pub fn still(target: Position, elevation_m: f64) -> Scene {
        Scene { target, elevation_m, wind: Wind::default(), approach: Point { x: 0.0, y: -1.0 }, from_s: 0.0 }
    }

    /// Returns the position of a point.
    pub fn position(&self, point: Point) -> Position {
        let distance_m = point.length();
        if distance_m == 0.0 {
            return self.target;
        }
        geodesy::destination(self.target, libm::atan2(point.x, point.y) / RAD_PER_DEG, distance_m)
    }

    /// Returns the point of a position.
    pub fn point(&self, position: Position) -> Point {
        let (distance_m, azimuth_deg) = geodesy::inverse(self.target, position);
        along(azimuth_deg, if distance_m.is_finite() { distance_m } else { 0.0 })
    }

    /// Returns the speed of the wind.
    pub fn wind_mps(&self) -> f64 {
        libm::hypot(self.wind.east_mps, self.wind.north_mps)
    }

    /// Returns the direction from which the wind comes, clockwise from north; `None` without wind.
    pub fn wind_from_deg(&self) -> Option<f64> {
        (self.wind_mps() > 0.1)
            .then(|| geodesy::wrap_360(libm::atan2(-self.wind.east_mps, -self.wind.north_mps) / RAD_PER_DEG))
    }
}

/// Returns the point `distance_m` from the origin in a direction clockwise from north.
pub(crate) fn along(azimuth_deg: f64, distance_m: f64) -> Point {
    let azimuth_rad = azimuth_deg * RAD_PER_DEG;
    Point { x: distance_m * libm::sin(azimuth_rad), y: distance_m * libm::cos(azimuth_rad) }
}

/// The sensor that observes.
#[derive(Clone, Debug, PartialEq)]
pub enum Instrument {
    /// A line scanner that looks straight down.
    Scanner(PredictedScanner),
    /// A camera on its mount.
    Camera(CameraSetting),
}

impl Instrument {
    /// Returns true if the mount turns around the vertical.
    pub(crate) fn pans(&self) -> bool {
        matches!(self, Instrument::Camera(camera) if camera.mount.pan_deg.1 > camera.mount.pan_deg.0)
    }

    /// Returns the rate of the mount; infinite for a scanner, which does not point.
    pub(crate) fn slew_rate_deg_s(&self) -> f64 {
        match self {
            Instrument::Scanner(_) => f64::INFINITY,
            Instrument::Camera(camera) => camera.mount.rate_deg_s,
        }
    }

    /// Returns the width of the strip seen straight down, with pixels of at most `wanted_m` across the track for a scanner.
    pub fn swath_m(&self, height_m: f64, wanted_m: f64) -> f64 {
        match self {
            Instrument::Scanner(scanner) => scanner.setting.mode.useful_swath_m(height_m, wanted_m),
            Instrument::Camera(camera) => camera.footprint_m(height_m).0,
        }
    }

    /// Returns the angle of one pixel.
    pub fn pixel_rad(&self) -> f64 {
        match self {
            Instrument::Scanner(scanner) => scanner.setting.mode.pixel_rad(),
            Instrument::Camera(camera) => camera.pixel_rad(),
        }
    }

    /// Returns the greatest ground speed at which successive pictures straight down overlap by `overlap`.
    pub fn overlap_speed_mps(&self, height_m: f64, overlap: f64) -> f64 {
        match self {
            Instrument::Scanner(scanner) => {
                let mode = &scanner.setting.mode;
                mode.scan_rate_hz_max()
                    .map_or(f64::INFINITY, |rate| rate * mode.nadir_pixel_m(height_m) / (1.0 + overlap))
            }
            Instrument::Camera(camera) if camera.interval_s_min > 0.0 => {
                camera.footprint_m(height_m).1 * (1.0 - overlap) / camera.interval_s_min
            }
            Instrument::Camera(_) => f64::INFINITY,
        }
    }

    /// Returns the greatest ground speed at which a picture smears by at most `pixels`, seen from `slant_m`.
    pub(crate) fn smear_speed_mps(&self, slant_m: f64, pixels: f64) -> f64 {
        match self {
            Instrument::Scanner(_) => f64::INFINITY,
            Instrument::Camera(camera) => pixels * camera.pixel_rad() * slant_m / camera.exposure_s,
        }
    }
}
