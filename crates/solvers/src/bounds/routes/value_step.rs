//! Common divisor of all values: if all values are multiples of a number, so are their sums.

use crate::routing::network::Network;

/// Number of decimals considered.
const DECIMALS_MAX: i32 = 3;
/// Tolerance of values and sums around a multiple, in units of the last decimal.
const SAME: f64 = 1e-6;
/// Greatest error of one value, in units of the last decimal: the sum of a thousand such errors stays within `SAME`.
const OFF_MAX: f64 = 1e-9;
const TARGETS_MAX: usize = 1_000;
/// Greatest value considered: larger ones lose their last decimals in a sum.
const VALUE_MAX: f64 = 1e9;
/// Relative amount by which a bound is raised, so that rounding cannot put it below the true value.
const ROUNDING: f64 = 1e-9;

/// Step of which all values are multiples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ValueStep {
    /// `None` if no such step exists, or none large enough to distinguish sums.
    step: Option<f64>,
    /// Greatest distance of a sum from a multiple.
    off: f64,
}

impl ValueStep {
    pub(super) fn new(network: &Network) -> ValueStep {
        let values: Vec<f64> = network.visits().map(|node| network.node(node).value).collect();
        if network.targets <= TARGETS_MAX {
            for decimals in 0..=DECIMALS_MAX {
                let scale = libm::round(libm::pow(10.0, f64::from(decimals)));
                if let Some(divisor) = divisor(values.iter().map(|value| value * scale)) {
                    return ValueStep { step: Some(divisor as f64 / scale), off: SAME / scale };
                }
            }
        }
        ValueStep { step: None, off: 0.0 }
    }

    /// Returns the least profit of a route that has more than `incumbent`.
    pub(super) fn above(&self, incumbent: f64) -> f64 {
        match self.step {
            Some(step) => (libm::floor((incumbent + self.off) / step) + 1.0) * step - self.off,
            // Half of the raise of a bound: no route lies between the two.
            None => incumbent + 0.5 * ROUNDING * (1.0 + incumbent.abs()),
        }
    }

    /// Returns the greatest profit of a route that has at most `bound`, which rounding may have lowered slightly.
    pub(super) fn below(&self, bound: f64) -> f64 {
        let lifted = bound + ROUNDING * (1.0 + bound.abs());
        match self.step {
            // Sums of whole numbers are exact.
            Some(step) if step == libm::floor(step) => libm::floor((lifted + self.off) / step) * step,
            Some(step) => libm::floor((lifted + self.off) / step) * step + self.off,
            None => lifted,
        }
    }
}

/// Returns the greatest common divisor of whole or nearly whole numbers; `None` if one is not whole, or there are none.
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
