//! The standard atmosphere up to 20 km: temperature, pressure, density, speed of sound, indicated airspeed.

use libm::{exp, pow, sqrt};

/// Standard gravity, m/s2.
pub(crate) const GRAVITY: f64 = 9.806_65;
/// Zero degrees Celsius, K.
pub(crate) const ICE_K: f64 = 273.15;
const GAS: f64 = 287.052_87;
const SEA_LEVEL_TEMPERATURE_K: f64 = 288.15;
const SEA_LEVEL_PRESSURE_PA: f64 = 101_325.0;
const SEA_LEVEL_DENSITY: f64 = 1.225;
const LAPSE_K_M: f64 = 0.0065;
const TROPOPAUSE_M: f64 = 11_000.0;
const TROPOPAUSE_TEMPERATURE_K: f64 = 216.65;

/// Still air at one altitude.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Air {
    pub(crate) temperature_k: f64,
    pub(crate) pressure_pa: f64,
    pub(crate) density: f64,
}

impl Air {
    /// Returns the standard air at `altitude_m` above mean sea level.
    pub(crate) fn at(altitude_m: f64) -> Air {
        let troposphere_m = altitude_m.clamp(-1_000.0, TROPOPAUSE_M);
        let temperature_k = SEA_LEVEL_TEMPERATURE_K - LAPSE_K_M * troposphere_m;
        let exponent = GRAVITY / (GAS * LAPSE_K_M);
        let mut pressure_pa = SEA_LEVEL_PRESSURE_PA * pow(temperature_k / SEA_LEVEL_TEMPERATURE_K, exponent);
        if altitude_m > TROPOPAUSE_M {
            pressure_pa *= exp(-GRAVITY * (altitude_m - TROPOPAUSE_M) / (GAS * TROPOPAUSE_TEMPERATURE_K));
        }
        Air { temperature_k, pressure_pa, density: pressure_pa / (GAS * temperature_k) }
    }

    /// Returns the true airspeed for one metre per second of indicated airspeed, without instrument and compressibility errors.
    pub(crate) fn true_per_indicated(&self) -> f64 {
        sqrt(SEA_LEVEL_DENSITY / self.density)
    }

    /// Returns the speed of sound, m/s.
    pub(crate) fn sound_m_s(&self) -> f64 {
        sqrt(1.4 * GAS * self.temperature_k)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_the_standard_atmosphere() {
        let air = Air::at(7_000.0);
        assert!((air.temperature_k - 242.65).abs() < 0.01);
        assert!((air.pressure_pa - 41_061.0).abs() < 50.0, "{}", air.pressure_pa);
        let high = Air::at(15_000.0);
        assert!((high.pressure_pa - 12_045.0).abs() < 30.0, "{}", high.pressure_pa);
        assert!((Air::at(0.0).true_per_indicated() - 1.0).abs() < 1e-4);
    }
}
