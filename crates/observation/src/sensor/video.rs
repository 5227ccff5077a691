//! Video cameras: line pairs on a target and the probability that a viewer detects, recognises or identifies it.
//!
//! Source: J. Johnson, "Analysis of image forming systems", Image Intensifier Symposium, 1958 (cycles for 50 %); target
//! transfer probability function of the night vision models: `P = x^E / (1 + x^E)`, `E = 2.7 + 0.7 x`.

use serde::{Deserialize, Serialize};

/// A video camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VideoCamera {
    /// Instantaneous field of view of one pixel.
    pub pixel_mrad: f64,
    /// Full horizontal field of view.
    pub horizontal_field_deg: f64,
    /// Full vertical field of view.
    pub vertical_field_deg: f64,
}

/// Task of a viewer for a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ViewerTask {
    /// Notice that an object is there.
    Detect,
    /// See its orientation.
    Orient,
    /// See its class.
    Recognise,
    /// See its type.
    Identify,
}

impl ViewerTask {
    /// Returns the line pairs across the critical dimension for a probability of one half.
    pub fn line_pairs_at_half(self) -> f64 {
        match self {
            ViewerTask::Detect => 1.0,
            ViewerTask::Orient => 1.4,
            ViewerTask::Recognise => 4.0,
            ViewerTask::Identify => 6.4,
        }
    }

    /// Returns the probability of success with this number of line pairs on the target.
    pub fn probability(self, line_pairs: f64) -> f64 {
        let ratio = line_pairs / self.line_pairs_at_half();
        if ratio.is_nan() || ratio <= 0.0 {
            return 0.0;
        }
        if ratio > 100.0 {
            return 1.0;
        }
        let power = libm::pow(ratio, 2.7 + 0.7 * ratio);
        if power.is_finite() { power / (1.0 + power) } else { 1.0 }
    }
}

impl VideoCamera {
    /// Returns the line pairs across a target: `d k / (2 ifov L)`.
    ///
    /// `critical_m` is the smaller dimension, `foreshortening` the sine of the depression for a flat object, its cosine
    /// for an upright one, `slant_m` the distance.
    pub fn line_pairs(&self, critical_m: f64, foreshortening: f64, slant_m: f64) -> f64 {
        critical_m * foreshortening / (2.0 * self.pixel_mrad * 1e-3 * slant_m)
    }

    /// Returns the greatest distance with this number of line pairs across a target that is seen without foreshortening.
    pub fn range_m_max(&self, critical_m: f64, line_pairs: f64) -> f64 {
        critical_m / (2.0 * self.pixel_mrad * 1e-3 * line_pairs)
    }
}

/// Returns the probability of at least one success in glimpses at `rate_hz` over `dwell_s`, each with `probability`.
pub fn glimpse_probability(probability: f64, rate_hz: f64, dwell_s: f64) -> f64 {
    let missed = (1.0 - probability).clamp(0.0, 1.0);
    1.0 - libm::pow(missed, (rate_hz * dwell_s).max(0.0))
}
