//! Timing `o = o_window o_slope o_light o_overpass o_latency o_order`, each 0..1, per look.
//!
//! Times are seconds since the start of the mission. Bound: O(windows + passes) per look.

pub mod passes;
pub mod sun;

use crate::sensor::scanner::ramp_down;
use serde::{Deserialize, Serialize};

/// A window of time with ramps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WindowNeed {
    /// First instant of full worth.
    pub from_s: f64,
    /// Last instant of full worth.
    pub until_s: f64,
    /// Outside, the factor falls linearly to 0 over this time; 0: at once.
    pub ramp_s: f64,
}

/// Value that falls with time after an instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ValueSlope {
    /// `max(0, 1 - (t - t0) / T)`.
    Linear {
        /// t0: the factor is 1 until here.
        since_s: f64,
        /// T: time until the factor is 0.
        zero_after_s: f64,
    },
    /// `exp(-(t - t0) / T)`.
    Exponential {
        /// t0: the factor is 1 until here.
        since_s: f64,
        /// T: time until the factor is 1/e.
        decay_s: f64,
    },
}

/// Wanted light by the elevation of the sun's centre at the cell, without refraction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LightNeed {
    /// Any.
    #[default]
    Any,
    /// The sun is at least this high: 0 for daylight, 20 for imaging with reflected light.
    Day {
        /// Full worth from this elevation on.
        elevation_deg_min: f64,
        /// Below, the factor falls linearly to 0 over this angle; 0: at once.
        ramp_deg: f64,
    },
    /// The sun is at most this high: -6 for civil night.
    Night {
        /// Full worth up to this elevation.
        elevation_deg_max: f64,
        /// Above, the factor falls linearly to 0 over this angle; 0: at once.
        ramp_deg: f64,
    },
}

impl LightNeed {
    /// Sun above the horizon, without a ramp.
    pub const DAY: LightNeed = LightNeed::Day { elevation_deg_min: 0.0, ramp_deg: 0.0 };
    /// Civil night, without a ramp.
    pub const NIGHT: LightNeed = LightNeed::Night { elevation_deg_max: -6.0, ramp_deg: 0.0 };

    /// Returns the factor at an elevation of the sun.
    pub fn factor(&self, elevation_deg: f64) -> f64 {
        match *self {
            LightNeed::Any => 1.0,
            LightNeed::Day { elevation_deg_min, ramp_deg } => off_limit(elevation_deg_min - elevation_deg, ramp_deg),
            LightNeed::Night { elevation_deg_max, ramp_deg } => off_limit(elevation_deg - elevation_deg_max, ramp_deg),
        }
    }
}

/// Wanted nearness in time to a pass of a satellite. Compute the instants with [`passes::passes`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OverpassNeed {
    /// Instants of the passes that see the target.
    pub passes_s: Vec<f64>,
    /// Full worth up to this time before or after a pass; 1,800 s is usual.
    pub full_s: f64,
    /// No worth from this time on; 3,600 s is usual.
    pub zero_s: f64,
}

/// Wanted time from the look until its image is on the ground.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LatencyNeed {
    /// Full worth up to this time; 600 s is usual.
    pub full_s: f64,
    /// No worth from this time on; 3,600 s is usual.
    pub zero_s: f64,
}

/// Returns 1 at or below a limit, falling linearly to 0 over `ramp` beyond it; at once for a ramp of 0.
fn off_limit(beyond: f64, ramp: f64) -> f64 {
    ramp_down(beyond, 0.0, ramp)
}

impl WindowNeed {
    /// Returns the factor at an instant.
    pub fn factor(&self, time_s: f64) -> f64 {
        off_limit((self.from_s - time_s).max(time_s - self.until_s), self.ramp_s)
    }
}

/// Returns the factor of the best window at an instant; 1 without windows.
pub fn windows_factor(windows: &[WindowNeed], time_s: f64) -> f64 {
    if windows.is_empty() {
        return 1.0;
    }
    windows.iter().fold(0.0, |best: f64, window| best.max(window.factor(time_s)))
}

impl ValueSlope {
    /// Returns the factor at an instant.
    pub fn factor(&self, time_s: f64) -> f64 {
        match *self {
            ValueSlope::Linear { since_s, zero_after_s } => ramp_down(time_s - since_s, 0.0, zero_after_s),
            ValueSlope::Exponential { since_s, decay_s } => libm::exp(-(time_s - since_s).max(0.0) / decay_s),
        }
    }
}

impl OverpassNeed {
    /// Returns the factor of the nearest pass; 0 without passes.
    pub fn factor(&self, time_s: f64) -> f64 {
        let nearest_s = self.passes_s.iter().fold(f64::INFINITY, |best, pass_s| best.min((time_s - pass_s).abs()));
        ramp_down(nearest_s, self.full_s, self.zero_s)
    }
}

impl LatencyNeed {
    /// Returns the factor for a time from look to ground; 0 if the image never arrives (`None`).
    pub fn factor(&self, latency_s: Option<f64>) -> f64 {
        latency_s.map_or(0.0, |latency_s| ramp_down(latency_s, self.full_s, self.zero_s))
    }
}
