//! A small seeded generator (SplitMix64): equal seeds give equal plans on every platform.

/// The generator.
#[derive(Clone, Debug)]
pub struct Generator(u64);

impl Generator {
    /// Returns a generator that yields the sequence of `seed`.
    pub fn new(seed: u64) -> Generator {
        Generator(seed)
    }

    /// Returns the next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^ (bits >> 31)
    }

    /// Returns a real number in 0..1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns an integer below `count`; 0 for a count of 0.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_known_and_in_range() {
        assert_eq!(Generator::new(0).bits(), 0xE220_A839_7B1D_CDAF, "the published first number of seed 0");
        let mut generator = Generator::new(7);
        let mean = (0..10_000).map(|_| generator.unit()).sum::<f64>() / 10_000.0;
        assert!((mean - 0.5).abs() < 0.01);
        assert!((0..1000).all(|_| generator.below(3) < 3));
        assert_eq!(generator.below(0), 0);
    }
}
