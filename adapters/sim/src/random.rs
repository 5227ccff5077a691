//! Seeded randomness: one stream for each use, so that a new use never changes the others.

use libm::{cos, exp, log, sqrt};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub(crate) struct Random(ChaCha8Rng);

impl Random {
    /// Returns stream number `stream` of `seed`.
    pub(crate) fn new(seed: u64, stream: u64) -> Random {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        Random(generator)
    }

    /// Draws a number uniformly from the open interval from 0 to 1.
    pub(crate) fn uniform(&mut self) -> f64 {
        // 53 bits, shifted by half a step so that zero, whose logarithm is infinite, cannot occur.
        ((self.0.next_u64() >> 11) as f64 + 0.5) / 9_007_199_254_740_992.0
    }

    /// Draws a normally distributed number with mean 0 and standard deviation 1.
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = sqrt(-2.0 * log(self.uniform()));
        radius * cos(std::f64::consts::TAU * self.uniform())
    }

    /// Skips the number that [`Random::normal`] would draw.
    pub(crate) fn skip_normal(&mut self) {
        self.uniform();
        self.uniform();
    }
}

/// A stationary random process with standard deviation one and exponential correlation.
#[derive(Clone, Debug)]
pub(crate) struct Wander {
    random: Random,
    correlation_s: f64,
    value: f64,
}

impl Wander {
    /// Returns a process with the correlation time `correlation_s`.
    pub(crate) fn new(mut random: Random, correlation_s: f64) -> Wander {
        let value = random.normal();
        Wander { random, correlation_s, value }
    }

    /// Returns its value `elapsed_s` seconds after the last call.
    pub(crate) fn after(&mut self, elapsed_s: f64) -> f64 {
        let kept = exp(-elapsed_s / self.correlation_s);
        self.value = self.value * kept + sqrt(1.0 - kept * kept) * self.random.normal();
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_and_repeat() {
        let draw = |seed, stream| Random::new(seed, stream).uniform();
        assert_eq!(draw(1, 1).to_bits(), draw(1, 1).to_bits());
        assert_ne!(draw(1, 1).to_bits(), draw(1, 2).to_bits());
        assert_ne!(draw(1, 1).to_bits(), draw(2, 1).to_bits());
    }

    #[test]
    fn a_skipped_number_is_the_next_one_that_is_drawn() {
        let (mut drawn, mut skipped) = (Random::new(1, 1), Random::new(1, 1));
        drawn.normal();
        skipped.skip_normal();
        assert_eq!(drawn.normal().to_bits(), skipped.normal().to_bits());
    }

    #[test]
    fn the_wander_has_deviation_one() {
        let mut wander = Wander::new(Random::new(3, 0), 5.0);
        let squares: f64 = (0..20_000).map(|_| wander.after(5.0)).map(|value| value * value).sum();
        assert!((squares / 20_000.0 - 1.0).abs() < 0.1);
    }
}
