//! Cross-track line scanners: pixel, swath, useful swath, V/H limit and choice of the scan rate.
//!
//! Flat ground; curvature widens the swath of an 86 degree field of view by 0.14 % at a height of 20 km
//! (`footprint::curved_ground_offset_m`).
//! Geometry: slant range `L = h / cos o`, pixel along the track `ifov L`, across the track `ifov L / cos i` with the
//! incidence `i = o` on flat ground.

use apex_geo::geodesy::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// One mode of a line scanner: a scan head, or a setting of one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScannerMode {
    /// Name, unique in the scanner.
    pub name: String,
    /// Instantaneous field of view of one pixel.
    pub pixel_mrad: f64,
    /// Full angle across the track, below 180.
    pub field_of_view_deg: f64,
    /// Scan rates that the mode offers. Empty: not known; then no V/H limit is applied and no line-to-line shift counted.
    pub scan_rates_hz: Vec<f64>,
    /// Least share of a line that the next line must repeat at the nadir, 0 for lines that touch.
    pub line_overlap: f64,
}

/// Degradation of a line by roll.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RollLimits {
    /// Lines with at most this roll angle are valid.
    pub valid_deg: f64,
    /// Roll angle from which on a line has no value; between the two angles the value falls linearly. `None`: lines have no value beyond
    /// `valid_deg`.
    pub zero_deg: Option<f64>,
}

/// Degradation of a line by angular rates, in pixels of shift between successive lines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RateLimits {
    /// Shift up to which a line has its full value.
    pub full_pixels: f64,
    /// Shift from which on a line has no value.
    pub zero_pixels: f64,
}

impl Default for RateLimits {
    /// Returns full value up to 2 pixels per line and no value from 6 on: attitude recorded at 50 Hz corrects smaller shifts.
    fn default() -> RateLimits {
        RateLimits { full_pixels: 2.0, zero_pixels: 6.0 }
    }
}

/// A line scanner that looks straight down at zero roll.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineScanner {
    /// Its modes; at least one.
    pub modes: Vec<ScannerMode>,
    /// Limits of roll. None: roll does not degrade lines (the scanner is stabilised).
    pub roll: Option<RollLimits>,
    /// Limits of angular rates. None: rates do not degrade lines.
    pub rates: Option<RateLimits>,
}

impl ScannerMode {
    /// Returns the angle of one pixel in radians.
    pub fn pixel_rad(&self) -> f64 {
        self.pixel_mrad * 1e-3
    }

    /// Returns the half of the field of view in radians.
    pub fn half_field_rad(&self) -> f64 {
        0.5 * self.field_of_view_deg * RAD_PER_DEG
    }

    /// Returns metres per pixel straight below.
    pub fn nadir_pixel_m(&self, height_m: f64) -> f64 {
        self.pixel_rad() * height_m
    }

    /// Returns metres per pixel along the track at the look angle.
    pub fn pixel_along_m(&self, height_m: f64, look_angle_rad: f64) -> f64 {
        self.pixel_rad() * height_m / libm::cos(look_angle_rad)
    }

    /// Returns metres per pixel across the track at the look angle, on flat ground.
    pub fn pixel_across_m(&self, height_m: f64, look_angle_rad: f64) -> f64 {
        let cosine = libm::cos(look_angle_rad);
        self.pixel_rad() * height_m / (cosine * cosine)
    }

    /// Returns the width of the strip seen at a roll angle, on flat ground. Infinite when an edge reaches the horizon.
    pub fn swath_m(&self, height_m: f64, roll_deg: f64) -> f64 {
        let (roll_rad, half_rad) = (roll_deg * RAD_PER_DEG, self.half_field_rad());
        if half_rad + roll_rad.abs() >= 0.5 * std::f64::consts::PI {
            return f64::INFINITY;
        }
        height_m * (libm::tan(roll_rad + half_rad) + libm::tan(half_rad - roll_rad))
    }

    /// Returns the largest look angle with pixels of at most `wanted_m` across the track; at most half the field of view, and 0 if even
    /// the nadir pixel is too large.
    pub fn useful_half_angle_rad(&self, height_m: f64, wanted_m: f64) -> f64 {
        let squared = self.pixel_rad() * height_m / wanted_m;
        if squared >= 1.0 {
            return 0.0;
        }
        self.half_field_rad().min(libm::acos(libm::sqrt(squared.max(0.0))))
    }

    /// Returns the width of the strip with pixels of at most `wanted_m` across the track with level wings; line spacing is planned with
    /// it.
    pub fn useful_swath_m(&self, height_m: f64, wanted_m: f64) -> f64 {
        2.0 * height_m * libm::tan(self.useful_half_angle_rad(height_m, wanted_m))
    }

    /// Returns the greatest height with pixels of at most `wanted_m` across the track at the look angle.
    pub fn height_m_max(&self, wanted_m: f64, look_angle_rad: f64) -> f64 {
        let cosine = libm::cos(look_angle_rad);
        wanted_m * cosine * cosine / self.pixel_rad()
    }

    /// Returns the least scan rate that leaves no gap between lines at the nadir: `gs (1 + overlap) / (ifov h)`.
    pub fn scan_rate_hz_min(&self, height_m: f64, ground_speed_mps: f64) -> f64 {
        ground_speed_mps * (1.0 + self.line_overlap) / (self.pixel_rad() * height_m)
    }

    /// Returns the least height above ground that leaves no gap between lines at the nadir at a scan rate.
    pub fn height_m_min(&self, scan_rate_hz: f64, ground_speed_mps: f64) -> f64 {
        ground_speed_mps * (1.0 + self.line_overlap) / (self.pixel_rad() * scan_rate_hz)
    }

    /// Returns the least height that any scan rate of the mode permits; 0 when the rates are not known.
    pub fn height_m_min_any(&self, ground_speed_mps: f64) -> f64 {
        match self.scan_rate_hz_max() {
            Some(rate_hz) => self.height_m_min(rate_hz, ground_speed_mps),
            None => 0.0,
        }
    }

    /// Returns the fastest scan rate; `None` if the rates are not known.
    pub fn scan_rate_hz_max(&self) -> Option<f64> {
        self.scan_rates_hz
            .iter()
            .copied()
            .fold(None, |best: Option<f64>, rate| Some(best.map_or(rate, |b| b.max(rate))))
    }

    /// Returns the lowest scan rate without gaps (a higher one oversamples), or the fastest if none suffices. `None` if the rates are
    /// unknown.
    pub fn choose_scan_rate_hz(&self, height_m: f64, ground_speed_mps: f64) -> Option<f64> {
        let least_hz = self.scan_rate_hz_min(height_m, ground_speed_mps);
        let enough = self.scan_rates_hz.iter().copied().filter(|rate| *rate >= least_hz);
        enough
            .fold(None, |best: Option<f64>, rate| Some(best.map_or(rate, |b| b.min(rate))))
            .or(self.scan_rate_hz_max())
    }

    /// Returns the share of the ground along the track that the lines cover at the nadir: 1 without gaps, `ifov h f / gs` below the
    /// V/H limit. Pitching at a rate widens the advance per line by `h q / f`.
    pub fn covered_share(&self, height_m: f64, ground_speed_mps: f64, pitch_rate_rad_s: f64, scan_rate_hz: f64) -> f64 {
        let advance_m = (ground_speed_mps + height_m * pitch_rate_rad_s.abs()) / scan_rate_hz;
        if advance_m <= 0.0 { 1.0 } else { (self.nadir_pixel_m(height_m) / advance_m).clamp(0.0, 1.0) }
    }

    /// Returns the roll rate that shifts successive lines by one pixel at the nadir: `ifov f`.
    pub fn roll_rate_rad_s_per_pixel(&self, scan_rate_hz: f64) -> f64 {
        self.pixel_rad() * scan_rate_hz
    }

    /// Returns the pitch rate above which a gap opens between lines: `ifov f - gs / h`, 0 without reserve.
    pub fn pitch_rate_rad_s_max(&self, height_m: f64, ground_speed_mps: f64, scan_rate_hz: f64) -> f64 {
        (self.pixel_rad() * scan_rate_hz - ground_speed_mps / height_m).max(0.0)
    }

    /// Returns the yaw rate that fans the lines apart by one nadir pixel at the edge of the field of view.
    pub fn yaw_rate_rad_s_per_pixel(&self, scan_rate_hz: f64) -> f64 {
        self.pixel_rad() * scan_rate_hz / libm::tan(self.half_field_rad())
    }
}

impl RollLimits {
    /// Returns the worth of a line at a roll angle: 1 valid, 0 not, between the two linear if a ramp is set.
    pub fn weight(&self, roll_deg: f64) -> f64 {
        ramp_down(roll_deg.abs(), self.valid_deg, self.zero_deg.unwrap_or(self.valid_deg))
    }
}

impl RateLimits {
    /// Returns the weight of a line that is shifted by this many pixels from the preceding one.
    pub fn weight(&self, pixels: f64) -> f64 {
        ramp_down(pixels.abs(), self.full_pixels, self.zero_pixels)
    }
}

/// Returns 1 up to `full`, 0 from `zero` on, linear between; a step where the two are equal. Not-a-number gives 0.
pub(crate) fn ramp_down(value: f64, full: f64, zero: f64) -> f64 {
    if value <= full {
        1.0
    } else if value < zero {
        (zero - value) / (zero - full)
    } else {
        0.0
    }
}
