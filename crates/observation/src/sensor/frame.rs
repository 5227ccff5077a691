//! Frame cameras: ground sample, footprint, spacing of lines and triggers, smear.

use serde::{Deserialize, Serialize};

/// A camera that takes single pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameCamera {
    /// Pixels across the track (the long side, if it is mounted so).
    pub pixels_across: u32,
    /// Pixels along the track.
    pub pixels_along: u32,
    /// Pixel pitch.
    pub pixel_um: f64,
    /// Focal length.
    pub focal_length_mm: f64,
    /// Least time between two pictures.
    pub interval_s_min: f64,
    /// Exposure time.
    pub exposure_s: f64,
}

/// Spacing of lines and triggers of a photo run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotoSpacing {
    /// Distance between successive pictures along the line (base).
    pub base_m: f64,
    /// Distance between lines.
    pub lines_m: f64,
    /// Greatest ground speed at which the camera keeps the base.
    pub ground_speed_mps_max: f64,
}

impl FrameCamera {
    /// Returns the angle of one pixel at the middle of the picture.
    pub fn pixel_rad(&self) -> f64 {
        self.pixel_um * 1e-3 / self.focal_length_mm
    }

    /// Returns metres per pixel at the nadir: `h p / f`.
    pub fn ground_sample_m(&self, height_m: f64) -> f64 {
        height_m * self.pixel_rad()
    }

    /// Returns metres per pixel of an oblique view: at right angles to the plane of view, and in it, where the line of sight meets the
    /// ground at `incidence_rad`. `slant_m` is the distance to the ground point.
    pub fn oblique_sample_m(&self, slant_m: f64, incidence_rad: f64) -> (f64, f64) {
        let sample_m = self.pixel_rad() * slant_m;
        (sample_m, sample_m / libm::cos(incidence_rad))
    }

    /// Returns the greatest height with at most `wanted_m` per pixel at the nadir.
    pub fn height_m_max(&self, wanted_m: f64) -> f64 {
        wanted_m / self.pixel_rad()
    }

    /// Returns the full field of view across and along, in radians.
    pub fn fields_of_view_rad(&self) -> (f64, f64) {
        let angle = |pixels: u32| 2.0 * libm::atan(0.5 * f64::from(pixels) * self.pixel_rad());
        (angle(self.pixels_across), angle(self.pixels_along))
    }

    /// Returns the footprint across and along the track of a picture straight down.
    pub fn footprint_m(&self, height_m: f64) -> (f64, f64) {
        let sample_m = self.ground_sample_m(height_m);
        (f64::from(self.pixels_across) * sample_m, f64::from(self.pixels_along) * sample_m)
    }

    /// Returns the spacing of pictures and lines for an overlap along the line and a sidelap between lines, each 0..1 exclusive.
    pub fn spacing(&self, height_m: f64, overlap: f64, sidelap: f64) -> PhotoSpacing {
        let (across_m, along_m) = self.footprint_m(height_m);
        let base_m = along_m * (1.0 - overlap);
        let ground_speed_mps_max = if self.interval_s_min > 0.0 { base_m / self.interval_s_min } else { f64::INFINITY };
        PhotoSpacing { base_m, lines_m: across_m * (1.0 - sidelap), ground_speed_mps_max }
    }

    /// Returns the smear of one exposure in pixels: motion over ground plus residual rotation of the camera.
    pub fn smear_pixels(&self, height_m: f64, ground_speed_mps: f64, rotation_rad_s: f64) -> f64 {
        self.exposure_s * (ground_speed_mps / self.ground_sample_m(height_m) + rotation_rad_s.abs() / self.pixel_rad())
    }
}
