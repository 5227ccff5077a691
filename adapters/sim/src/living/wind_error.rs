//! The difference between the real wind and that of the mission's weather: a Gaussian field over time and space, without state.
//!
//! Each component is a sum of waves with random directions, frequencies and phases (Rahimi and Recht 2007). The frequencies follow the
//! spectrum of an exponential correlation, like that of an AR(1) process: Cauchy in time, trivariate Cauchy over the chord in space. So
//! the correlation between two places or times falls with their distance, and the same seed gives the same wind at the same place and
//! time, regardless of other queries. Bound: O([`WAVES`]) for each query.

use super::WindErrorSpec;
use crate::random::Random;
use apex_geo::geodesy::RAD_PER_DEG;
use apex_geo::wind::Wind;
use apex_model::problem::Position;
use libm::{cos, exp, hypot, sin, sqrt, tan};

/// Number of waves of one component.
const WAVES: usize = 64;
const STREAM: u64 = 4_000;
/// The Cauchy distribution has no moments: waves beyond this many correlation lengths are noise that no vehicle resolves.
const FREQUENCY_MAX: f64 = 60.0;

#[derive(Clone, Copy, Debug)]
struct Wave {
    per_s: f64,
    per_m: [f64; 3],
    phase: f64,
}

/// Deviations of east wind, north wind and the logarithm of turbulence.
#[derive(Clone, Debug)]
pub(crate) struct WindError {
    spec: WindErrorSpec,
    components: [Vec<Wave>; 3],
}

impl WindError {
    pub(crate) fn new(spec: WindErrorSpec, seed: u64) -> WindError {
        let (time_s, length_m) = (spec.correlation_h * 3_600.0, spec.correlation_km * 1_000.0);
        let waves = |stream: u64| {
            let mut random = Random::new(seed, STREAM + stream);
            (0..WAVES).map(|_| wave(&mut random, time_s, length_m)).collect()
        };
        WindError { spec, components: [waves(0), waves(1), waves(2)] }
    }

    /// Adds the deviation at a place and time to `wind`.
    pub(crate) fn applied(&self, wind: Wind, position: Position, time_s: f64) -> Wind {
        let place_m = earth_fixed_m(position);
        let value = |waves: &[Wave]| {
            let sum: f64 = waves
                .iter()
                .map(|wave| {
                    let along: f64 = wave.per_m.iter().zip(place_m).map(|(per_m, metres)| per_m * metres).sum();
                    cos(wave.per_s * time_s + along + wave.phase)
                })
                .sum();
            sum * sqrt(2.0 / WAVES as f64)
        };
        let [east, north, edr] = &self.components;
        let sigma_mps = self.spec.sigma_mps + self.spec.sigma_share * hypot(wind.east_mps, wind.north_mps);
        Wind {
            east_mps: wind.east_mps + sigma_mps * value(east),
            north_mps: wind.north_mps + sigma_mps * value(north),
            edr: wind.edr * if self.spec.edr_log_sigma > 0.0 { exp(self.spec.edr_log_sigma * value(edr)) } else { 1.0 },
        }
    }
}

fn wave(random: &mut Random, time_s: f64, length_m: f64) -> Wave {
    let per_s = tan(std::f64::consts::PI * (random.uniform() - 0.5)).clamp(-FREQUENCY_MAX, FREQUENCY_MAX) / time_s;
    let direction = [random.normal(), random.normal(), random.normal()];
    let scale = 1.0 / random.normal().abs().max(1.0 / FREQUENCY_MAX) / length_m;
    let phase = std::f64::consts::TAU * random.uniform();
    Wave { per_s, per_m: direction.map(|part| part * scale), phase }
}

/// Returns the coordinates of a place on the sphere, in axes that rotate with the Earth.
fn earth_fixed_m(position: Position) -> [f64; 3] {
    const RADIUS_M: f64 = 6_371_000.0;
    let (latitude_rad, longitude_rad) = (position.latitude_deg * RAD_PER_DEG, position.longitude_deg * RAD_PER_DEG);
    let level = RADIUS_M * cos(latitude_rad);
    [level * cos(longitude_rad), level * sin(longitude_rad), RADIUS_M * sin(latitude_rad)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> WindErrorSpec {
        WindErrorSpec {
            sigma_mps: 1.5,
            sigma_share: 0.1,
            correlation_h: 6.0,
            correlation_km: 200.0,
            edr_log_sigma: 0.4,
        }
    }

    fn error(seed: u64, base: Wind, position: Position, time_s: f64) -> (f64, f64) {
        let wind = WindError::new(spec(), seed).applied(base, position, time_s);
        (wind.east_mps - base.east_mps, wind.north_mps - base.north_mps)
    }

    const HERE: Position = Position { latitude_deg: 44.0, longitude_deg: -115.0 };

    /// The length of the error over sigma has the Rayleigh distribution: mean sqrt(pi / 2), 39.3 % below 1, 86.5 % below 2.
    #[test]
    fn the_size_of_the_error_is_rayleigh() {
        let base = Wind { east_mps: 6.0, north_mps: -8.0, edr: 0.1 };
        let sigma = 1.5 + 0.1 * 10.0;
        let sizes: Vec<f64> = (0..4_000)
            .map(|seed| {
                let (east, north) = error(seed, base, HERE, 40_000.0);
                hypot(east, north) / sigma
            })
            .collect();
        let share = |limit: f64| sizes.iter().filter(|size| **size < limit).count() as f64 / sizes.len() as f64;
        let mean = sizes.iter().sum::<f64>() / sizes.len() as f64;
        assert!((mean - sqrt(std::f64::consts::FRAC_PI_2)).abs() < 0.03, "{mean}");
        assert!(
            (share(1.0) - 0.393).abs() < 0.025 && (share(2.0) - 0.865).abs() < 0.02,
            "{} {}",
            share(1.0),
            share(2.0)
        );
    }

    /// Correlation over six hours, and over 200 km, is 1/e.
    #[test]
    fn the_error_forgets_itself_over_time_and_distance() {
        let there = Position { latitude_deg: 44.0 + 200_000.0 / 111_195.0, ..HERE };
        let still = Wind::default();
        let (mut in_time, mut in_space, mut squares) = (0.0, 0.0, 0.0);
        for seed in 0..6_000 {
            let (here, _) = error(seed, still, HERE, 0.0);
            in_time += here * error(seed, still, HERE, 6.0 * 3_600.0).0;
            in_space += here * error(seed, still, there, 0.0).0;
            squares += here * here;
        }
        for correlation in [in_time / squares, in_space / squares] {
            assert!((correlation - exp(-1.0)).abs() < 0.06, "{correlation}");
        }
    }
}
