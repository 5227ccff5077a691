//! What routes can be worth at all: where all values are multiples of one number, so is their sum.

use crate::planners::single_visit::steady::network::Network;

/// Decimals of values that are looked at.
const DECIMALS_MAX: i32 = 3;
/// Values and sums of them are this near to a multiple, in units of the last decimal.
const SAME: f64 = 1e-6;
/// The most that one value may be off, in units of the last decimal: a thousand of them are not off by more than `SAME`.
const OFF_MAX: f64 = 1e-9;
const TARGETS_MAX: usize = 1_000;
/// Larger values are not looked at: their last places are lost in a sum.
const VALUE_MAX: f64 = 1e9;
/// Share by which a bound is lifted, so that rounding cannot put it below the truth.
const ROUNDING: f64 = 1e-9;

/// The number that all values are multiples of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grain {
    /// None where there is no such number, or none large enough to tell.
    step: Option<f64>,
    /// How far a sum may be from a multiple.
    off: f64,
}

impl Grain {
    pub(super) fn new(network: &Network) -> Grain {
        let values: Vec<f64> = network.visits().map(|node| network.node(node).value).collect();
        if network.targets <= TARGETS_MAX {
            for decimals in 0..=DECIMALS_MAX {
                let scale = libm::round(libm::pow(10.0, f64::from(decimals)));
                if let Some(divisor) = divisor(values.iter().map(|value| value * scale)) {
                    return Grain { step: Some(divisor as f64 / scale), off: SAME / scale };
                }
            }
        }
        Grain { step: None, off: 0.0 }
    }

    /// A route that is worth more than `reached` is worth this much at least.
    pub(super) fn above(&self, reached: f64) -> f64 {
        match self.step {
            Some(step) => (libm::floor((reached + self.off) / step) + 1.0) * step - self.off,
            // Half of what a bound is lifted by: nothing between the two is lost.
            None => reached + 0.5 * ROUNDING * (1.0 + reached.abs()),
        }
    }

    /// A route that is worth no more than `bound`, which rounding may have lowered a little, is worth no more than this.
    pub(super) fn below(&self, bound: f64) -> f64 {
        let lifted = bound + ROUNDING * (1.0 + bound.abs());
        match self.step {
            // Sums of whole numbers are told exactly.
            Some(step) if step == libm::floor(step) => libm::floor((lifted + self.off) / step) * step,
            Some(step) => libm::floor((lifted + self.off) / step) * step + self.off,
            None => lifted,
        }
    }
}

/// The greatest common divisor of numbers that are whole, or nearly so; none where one is not, or there are none.
fn divisor(values: impl Iterator<Item = f64>) -> Option<u64> {
    let mut divisor = 0;
    for value in values {
        let whole = libm::round(value);
        if !(0.0..VALUE_MAX).contains(&value) || (value - whole).abs() > OFF_MAX {
            return None;
        }
        let (mut a, mut b) = (divisor, whole as u64);
        while b != 0 {
            (a, b) = (b, a % b);
        }
        divisor = a;
    }
    (divisor > 0).then_some(divisor)
}
