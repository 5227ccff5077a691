//! Clarity s: the part of a look that motion, turbulence, cloud and glint leave usable.
//!
//! For each line or picture `q = roll x rates x line gaps x smear x exposed x ready x attitude known x cloud x glint`, each 0..1. As flown
//! the weights come from recorded attitude; as predicted, the share of valid lines comes from the turbulence: `sigma_phi = K EDR`.
//! Turbulence acts only through the attitude, so that it is not counted twice.
//!
//! Sources: MIL-F-8785C, roll gust spectrum of the Dryden model; S. Rice, "Mathematical analysis of random noise" (1945),
//! rate of level crossings.

use crate::sensor::{RateLimits, RollLimits};
use apex_geo::geodesy::RAD_PER_DEG;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, SQRT_2};

/// Response of a vehicle's attitude to turbulence: a damped oscillator driven by gusts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AttitudeHold {
    /// K: standard deviation of roll per unit of EDR (m^(2/3)/s).
    pub roll_deg_per_edr: f64,
    /// Natural frequency of the roll hold. None: not known; roll rates are then not predicted.
    pub natural_frequency_rad_s: Option<f64>,
    /// Damping ratio of the roll hold.
    pub damping_ratio: f64,
}

impl AttitudeHold {
    /// Returns the standard deviation of the roll angle in turbulence.
    pub fn roll_sigma_deg(&self, edr: f64) -> f64 {
        self.roll_deg_per_edr * edr.max(0.0)
    }

    /// Returns the standard deviation of the roll rate in turbulence; 0 where the natural frequency is not known.
    pub fn roll_rate_sigma_deg_s(&self, edr: f64) -> f64 {
        self.natural_frequency_rad_s.unwrap_or(0.0) * self.roll_sigma_deg(edr)
    }

    /// Returns the correlation time of the roll angle, `1 / (zeta omega_n)`.
    pub fn correlation_s(&self) -> Option<f64> {
        self.natural_frequency_rad_s.map(|frequency| 1.0 / (self.damping_ratio * frequency))
    }
}

/// Returns K in degrees per unit of EDR of a fixed wing at true airspeed `airspeed_mps`, from the roll gust spectrum at low frequency, a
/// first-order roll response with `roll_damping_s` and an attitude hold: `K = (1/tau) sqrt((0.8/0.7987) (pi/(4 b))^(1/3) / V * pi/(4 zeta
/// omega_n^3))`.
pub fn roll_deg_per_edr(
    airspeed_mps: f64,
    span_m: f64,
    roll_damping_s: f64,
    natural_frequency_rad_s: f64,
    damping_ratio: f64,
) -> f64 {
    let cubed = natural_frequency_rad_s * natural_frequency_rad_s * natural_frequency_rad_s;
    let gusts = 0.8 / 0.7987 * libm::cbrt(PI / (4.0 * span_m)) / airspeed_mps;
    libm::sqrt(gusts * PI / (4.0 * damping_ratio * cubed)) / roll_damping_s / RAD_PER_DEG
}

/// Returns the EDR of turbulence with a standard deviation of vertical gusts and a length scale (von Karman): `0.894 sigma L^(-1/3)`.
pub fn edr_of_gusts(sigma_mps: f64, scale_m: f64) -> f64 {
    0.894 * sigma_mps / libm::cbrt(scale_m)
}

/// Returns the share of time within a limit for a normal variable with mean 0; with a ramp, its mean weight. 1 without variation.
fn expected_ramp(sigma: f64, full: f64, zero: f64) -> f64 {
    if sigma.is_nan() || sigma <= 0.0 {
        return if sigma.is_nan() { 0.0 } else { 1.0 };
    }
    let (a, b) = (full / (SQRT_2 * sigma), zero / (SQRT_2 * sigma));
    if zero <= full {
        return libm::erf(a);
    }
    let fall =
        zero * (libm::erf(b) - libm::erf(a)) - sigma * libm::sqrt(2.0 / PI) * (libm::exp(-a * a) - libm::exp(-b * b));
    (libm::erf(a) + fall / (zero - full)).clamp(0.0, 1.0)
}

/// Returns the mean weight of a line at a standard deviation of the roll angle; without a ramp, the share of time within the limit.
pub fn share_within(roll_sigma_deg: f64, limits: &RollLimits) -> f64 {
    expected_ramp(roll_sigma_deg, limits.valid_deg, limits.zero_deg.unwrap_or(limits.valid_deg))
}

/// Returns the mean weight of a line at a standard deviation of the shift between lines, in pixels.
pub fn expected_rate_weight(shift_sigma_pixels: f64, limits: &RateLimits) -> f64 {
    expected_ramp(shift_sigma_pixels, limits.full_pixels, limits.zero_pixels)
}

/// Frequency and duration of roll angles outside a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excursions {
    /// Share of time outside.
    pub share: f64,
    /// Excursions per second.
    pub rate_hz: f64,
    /// Mean duration of an excursion; 0 if there are none.
    pub mean_s: f64,
}

/// Returns the excursions of a normal roll angle beyond `limit_deg`, from the standard deviations of angle and rate (Rice's formula).
pub fn excursions(roll_sigma_deg: f64, roll_rate_sigma_deg_s: f64, limit_deg: f64) -> Excursions {
    let share = 1.0 - expected_ramp(roll_sigma_deg, limit_deg, limit_deg);
    if roll_sigma_deg.is_nan() || roll_sigma_deg <= 0.0 {
        return Excursions { share, rate_hz: 0.0, mean_s: 0.0 };
    }
    let ratio = limit_deg / roll_sigma_deg;
    let rate_hz = roll_rate_sigma_deg_s / roll_sigma_deg / PI * libm::exp(-0.5 * ratio * ratio);
    Excursions { share, rate_hz, mean_s: if rate_hz > 0.0 { share / rate_hz } else { 0.0 } }
}

/// Classes of turbulence by EDR for large aircraft (ICAO Annex 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TurbulenceClass {
    /// EDR below 0.10.
    Nil,
    /// EDR 0.10 to 0.20.
    Light,
    /// EDR 0.20 to 0.45.
    Moderate,
    /// EDR 0.45 and more.
    Severe,
}

impl TurbulenceClass {
    /// Returns the class of an EDR.
    pub fn of(edr: f64) -> TurbulenceClass {
        if edr < 0.10 {
            TurbulenceClass::Nil
        } else if edr < 0.20 {
            TurbulenceClass::Light
        } else if edr < 0.45 {
            TurbulenceClass::Moderate
        } else {
            TurbulenceClass::Severe
        }
    }
}

/// Returns the probability that a line of sight is free of cloud: `(1 - n)^(1 + 0.5 tan o)` for the cover n seen straight down
/// (assumption: clouds half as high as wide).
pub fn clear_probability(clear_share: f64, tangent_look_angle: f64) -> f64 {
    if clear_share >= 1.0 {
        1.0
    } else if clear_share > 0.0 {
        libm::pow(clear_share, 1.0 + 0.5 * tangent_look_angle)
    } else {
        0.0
    }
}

/// Returns the weight of a property that older records do not contain.
fn fully() -> f64 {
    1.0
}

/// Weights of one line or picture that do not depend on the cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClarityWeights {
    /// Roll: 1 inside the limits. As predicted: the probability of a valid line.
    pub roll: f64,
    /// Angular rates.
    pub rates: f64,
    /// Gaps between lines.
    pub line_gaps: f64,
    /// Smear of a picture.
    pub smear: f64,
    /// 1 when there is enough light for the exposure of a picture.
    #[serde(default = "fully")]
    pub exposed: f64,
    /// 1 when the sensor is ready.
    pub ready: f64,
    /// 1 when the attitude is known.
    pub attitude_known: f64,
    /// Share of sky that is clear straight down. As flown: 0 or 1 by the line of sight.
    pub clear_share: f64,
}

impl ClarityWeights {
    /// Weights of a look that nothing degrades.
    pub const CLEAR: ClarityWeights = ClarityWeights {
        roll: 1.0,
        rates: 1.0,
        line_gaps: 1.0,
        smear: 1.0,
        exposed: 1.0,
        ready: 1.0,
        attitude_known: 1.0,
        clear_share: 1.0,
    };

    /// Returns the product of the weights that are never probabilities: rates, gaps, smear, exposure, readiness, known attitude.
    pub fn steady(&self) -> f64 {
        self.rates * self.line_gaps * self.smear * self.exposed * self.ready * self.attitude_known
    }
}
