//! Loss by distance: free space, and reflection from the ground below low antennas.

use libm::{log10, pow};
use std::f64::consts::PI;

/// Speed of light in vacuum, m/s (defined by the SI).
const LIGHT_M_PER_S: f64 = 299_792_458.0;
/// Free-space loss at 1 MHz and 1 km, dB: `20 log10(4 pi 1e9 / c)`, rounded as in ITU-R P.525.
const FREE_SPACE_DB_AT_1_MHZ_1_KM: f64 = 32.45;

/// Returns the wavelength in vacuum, m.
pub fn wavelength_m(frequency_hz: f64) -> f64 {
    LIGHT_M_PER_S / frequency_hz
}

/// Returns the free-space loss between isotropic antennas, dB: `32.45 + 20 log10 f_MHz + 20 log10 d_km` (ITU-R P.525).
pub fn free_space_loss_db(frequency_hz: f64, distance_m: f64) -> f64 {
    FREE_SPACE_DB_AT_1_MHZ_1_KM + 20.0 * log10(frequency_hz / 1e6) + 20.0 * log10(distance_m / 1e3)
}

/// Returns the distance at which free-space loss is `loss_db`, m: the inverse of [`free_space_loss_db`].
pub fn free_space_range_m(frequency_hz: f64, loss_db: f64) -> f64 {
    1e3 * pow(10.0, (loss_db - FREE_SPACE_DB_AT_1_MHZ_1_KM - 20.0 * log10(frequency_hz / 1e6)) / 20.0)
}

/// Returns the distance beyond which reflection from the ground cancels a part of the direct wave, m: `4 pi h1 h2 / lambda`.
pub fn two_ray_crossover_m(frequency_hz: f64, height_m: f64, other_height_m: f64) -> f64 {
    4.0 * PI * height_m * other_height_m / wavelength_m(frequency_hz)
}

/// Returns two-ray loss over flat ground, dB: free space up to the crossover, `40 log10 d - 20 log10(h1 h2)` beyond it. Both
/// agree at the crossover. An antenna below 0.1 m counts as 0.1 m high.
pub fn two_ray_loss_db(frequency_hz: f64, distance_m: f64, height_m: f64, other_height_m: f64) -> f64 {
    let (height_m, other_height_m) = (height_m.max(0.1), other_height_m.max(0.1));
    let crossover_m = two_ray_crossover_m(frequency_hz, height_m, other_height_m);
    if distance_m <= crossover_m {
        return free_space_loss_db(frequency_hz, distance_m);
    }
    free_space_loss_db(frequency_hz, crossover_m) + 40.0 * log10(distance_m / crossover_m)
}
