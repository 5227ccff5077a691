//! Resolution r: pixel size relative to the wanted size, times the factor of the look angle.

use crate::sensor::scanner::ramp_down;
use crate::target::{LookAngles, PixelMeasure, ResolutionNeed};

impl ResolutionNeed {
    /// Returns the factor of a pixel of `along_m` by `across_m` on the ground: 1 up to the wanted size, falling linearly to 0 at
    /// `zero_multiple` times that size.
    pub fn factor(&self, along_m: f64, across_m: f64) -> f64 {
        let size_m = match self.measure {
            PixelMeasure::WorstDirection => along_m.max(across_m),
            PixelMeasure::GeometricMean => libm::sqrt(along_m * across_m),
        };
        ramp_down(size_m, self.wanted_m, self.zero_multiple * self.wanted_m)
    }
}

impl LookAngles {
    /// Returns the factor of a look angle: 1 inside, falling linearly to 0 over the ramp outside.
    pub fn factor(&self, look_angle_deg: f64) -> f64 {
        ramp_down((self.min_deg - look_angle_deg).max(look_angle_deg - self.max_deg), 0.0, self.ramp_deg)
    }
}
