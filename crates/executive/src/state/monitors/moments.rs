//! Moments of samples: count, mean, spread and slope, numerically stable (`condition-rules.md`, rules 10 to 13).
//!
//! All sums are relative to an anchor, which is one of the samples, so that neither a large offset nor the size of an instant in
//! nanoseconds costs digits. Nothing is ever subtracted, so that a spike that has left the window leaves no error behind. Two disjoint
//! sets are merged in constant time.

use apex_model::time::{Duration, Time};
use serde::{Deserialize, Serialize};

/// Numbers larger than this have no finite square.
pub const MAGNITUDE_MAX: f64 = 1e150;

/// A sum that also carries its rounding error: exact to twice the digits of a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sum {
    high: f64,
    low: f64,
}

impl Sum {
    /// Adds a number.
    pub fn add(&mut self, number: f64) {
        let sum = self.high + number;
        let part = sum - self.high;
        self.low += (self.high - (sum - part)) + (number - part);
        self.high = sum;
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: Sum) {
        self.add(other.high);
        self.low += other.low;
    }

    /// Returns the sum as a number.
    pub fn value(self) -> f64 {
        self.high + self.low
    }
}

/// Moments of a set of samples of finite numbers; times in nanoseconds from the anchor's instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Moments {
    count: u64,
    anchor_at: Time,
    anchor: f64,
    mean_time_ns: f64,
    mean: f64,
    time_spread: f64,
    common_spread: f64,
    spread: f64,
    sum: Sum,
    least: f64,
    greatest: f64,
    first_at: Time,
    last_at: Time,
}

impl Moments {
    /// Returns the moments of one sample.
    pub fn of(at: Time, number: f64) -> Moments {
        Moments {
            count: 1,
            anchor_at: at,
            anchor: number,
            sum: Sum { high: number, low: 0.0 },
            least: number,
            greatest: number,
            first_at: at,
            last_at: at,
            ..Moments::default()
        }
    }

    /// Adds a sample.
    pub fn add(&mut self, at: Time, number: f64) {
        if self.count == 0 {
            *self = Moments::of(at, number);
            return;
        }
        self.count += 1;
        let count = self.count as f64;
        let time = (at - self.anchor_at).0 as f64;
        let value = number - self.anchor;
        let (time_off, off) = (time - self.mean_time_ns, value - self.mean);
        self.mean_time_ns += time_off / count;
        self.mean += off / count;
        let off_after = value - self.mean;
        self.time_spread += time_off * (time - self.mean_time_ns);
        self.common_spread += time_off * off_after;
        self.spread += off * off_after;
        self.sum.add(number);
        self.widen(number, number, at, at);
    }

    /// Adds the samples of `other`; constant time.
    pub fn merge(&mut self, other: &Moments) {
        if self.count == 0 || other.count == 0 {
            if self.count == 0 {
                *self = *other;
            }
            return;
        }
        let (own, others) = (self.count as f64, other.count as f64);
        self.count += other.count;
        let share = others / self.count as f64;
        let time_off = (other.anchor_at - self.anchor_at).0 as f64 + (other.mean_time_ns - self.mean_time_ns);
        let off = (other.anchor - self.anchor) + (other.mean - self.mean);
        self.mean_time_ns += time_off * share;
        self.mean += off * share;
        let weight = own * share;
        self.time_spread += other.time_spread + time_off * time_off * weight;
        self.common_spread += other.common_spread + time_off * off * weight;
        self.spread += other.spread + off * off * weight;
        self.sum.merge(other.sum);
        self.widen(other.least, other.greatest, other.first_at, other.last_at);
    }

    fn widen(&mut self, least: f64, greatest: f64, first_at: Time, last_at: Time) {
        self.least = self.least.min(least);
        self.greatest = self.greatest.max(greatest);
        self.first_at = self.first_at.min(first_at);
        self.last_at = self.last_at.max(last_at);
    }

    /// Returns the number of samples.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Returns the first and last instant; `None` without samples.
    pub fn span(&self) -> Option<(Time, Time)> {
        (self.count > 0).then_some((self.first_at, self.last_at))
    }

    /// Returns the sum of the values.
    pub fn sum(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum.value())
    }

    /// Returns the mean; `None` without samples.
    pub fn mean(&self) -> Option<f64> {
        self.sum().map(|sum| sum / self.count as f64)
    }

    /// Returns the population variance; `None` without samples.
    pub fn variance(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.spread / self.count as f64).max(0.0))
    }

    /// Returns the least value.
    pub fn least(&self) -> Option<f64> {
        (self.count > 0).then_some(self.least)
    }

    /// Returns the greatest value.
    pub fn greatest(&self) -> Option<f64> {
        (self.count > 0).then_some(self.greatest)
    }

    /// Returns the slope of the least-squares line per second; `None` with fewer than two distinct instants.
    pub fn slope_per_s(&self) -> Option<f64> {
        self.slope_per_ns().map(|slope| slope * 1e9)
    }

    fn slope_per_ns(&self) -> Option<f64> {
        (self.time_spread > 0.0).then(|| self.common_spread / self.time_spread)
    }

    /// Returns the value of the line of least squares at an instant; `None` with fewer than two distinct instants.
    pub fn line_at(&self, at: Time) -> Option<f64> {
        let time = (at - self.anchor_at).0 as f64;
        Some(self.anchor + (self.mean + self.slope_per_ns()? * (time - self.mean_time_ns)))
    }

    /// Returns the instant of the anchor, and the time in nanoseconds from it to the point at which the line has this value; `None` if
    /// the line is level.
    pub fn line_reaches(&self, value: f64) -> Option<(Time, f64)> {
        let slope = self.slope_per_ns().filter(|slope| *slope != 0.0)?;
        Some((self.anchor_at, self.mean_time_ns + ((value - self.anchor) - self.mean) / slope))
    }

    /// Returns the sum of the squared residuals of the line; `None` with fewer than two distinct instants.
    pub fn residual(&self) -> Option<f64> {
        let explained = self.slope_per_ns()? * self.common_spread;
        // Below this the difference is rounding, not residual.
        let rest = self.spread - explained;
        Some(if rest <= 8.0 * f64::EPSILON * self.spread { 0.0 } else { rest })
    }

    /// Returns the root mean square of the residuals of the line.
    pub fn error(&self) -> Option<f64> {
        self.residual().map(|residual| libm::sqrt(residual / self.count as f64))
    }

    /// Returns the spread of the instants around their mean, in nanoseconds squared.
    pub fn time_spread(&self) -> f64 {
        self.time_spread
    }

    /// Returns the samples per second over the span; `None` with fewer than two distinct instants.
    pub fn frequency_hz(&self) -> Option<f64> {
        let span = self.last_at - self.first_at;
        (span > Duration::ZERO).then(|| (self.count - 1) as f64 / span.seconds())
    }
}

/// Moments of values that each held for a while: weights are nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldMoments {
    weight_ns: f64,
    anchor: f64,
    mean: f64,
    spread: f64,
}

impl HeldMoments {
    /// Adds a value that held for this duration.
    pub fn add(&mut self, number: f64, held: Duration) {
        if held > Duration::ZERO {
            self.merge(&HeldMoments { weight_ns: held.0 as f64, anchor: number, mean: 0.0, spread: 0.0 });
        }
    }

    /// Adds all values of `other`.
    pub fn merge(&mut self, other: &HeldMoments) {
        if self.weight_ns == 0.0 || other.weight_ns == 0.0 {
            if self.weight_ns == 0.0 {
                *self = *other;
            }
            return;
        }
        let own = self.weight_ns;
        self.weight_ns += other.weight_ns;
        let share = other.weight_ns / self.weight_ns;
        let off = (other.anchor - self.anchor) + (other.mean - self.mean);
        self.mean += off * share;
        self.spread += other.spread + off * off * own * share;
    }

    /// Returns the sum of the weights, in nanoseconds.
    pub fn weight_ns(&self) -> f64 {
        self.weight_ns
    }

    /// Returns the mean over time; `None` if no value has held for longer than an instant.
    pub fn mean(&self) -> Option<f64> {
        (self.weight_ns > 0.0).then_some(self.anchor + self.mean)
    }

    /// Returns the variance over time; `None` if no value has held for longer than an instant.
    pub fn variance(&self) -> Option<f64> {
        (self.weight_ns > 0.0).then(|| (self.spread / self.weight_ns).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_to_ninety_nine() {
        let mut all = Moments::default();
        (1..=99).for_each(|number| all.add(Time(number), number as f64));
        assert_eq!(all.count(), 99);
        assert_eq!(all.mean(), Some(50.0));
        assert!((all.variance().unwrap() - 816.666_666_666_666_6).abs() < 1e-10);
        assert!((libm::sqrt(all.variance().unwrap()) - 28.577_380_332_470_41).abs() < 1e-12);
        assert!((all.slope_per_s().unwrap() - 1e9).abs() < 1e-3);
        assert_eq!((all.least(), all.greatest()), (Some(1.0), Some(99.0)));
    }

    #[test]
    fn merging_is_adding_one_by_one() {
        let number = |index: i64| ((index * 7919) % 101) as f64 - 3.0;
        let mut whole = Moments::default();
        (0..100).for_each(|index| whole.add(Time(index * 10), number(index)));
        let mut left = Moments::default();
        let mut right = Moments::default();
        (0..37).for_each(|index| left.add(Time(index * 10), number(index)));
        (37..100).for_each(|index| right.add(Time(index * 10), number(index)));
        left.merge(&right);
        assert!((left.variance().unwrap() - whole.variance().unwrap()).abs() < 1e-9);
        assert!((left.slope_per_s().unwrap() - whole.slope_per_s().unwrap()).abs() < 1e-3);
        assert_eq!((left.span(), left.sum()), (whole.span(), whole.sum()));
    }

    #[test]
    fn nothing_is_said_of_nothing_and_no_slope_of_one_instant() {
        let none = Moments::default();
        assert_eq!((none.mean(), none.variance(), none.slope_per_s(), none.span()), (None, None, None, None));
        let one = Moments::of(Time(5), 7.0);
        assert_eq!(
            (one.mean(), one.variance(), one.slope_per_s(), one.line_at(Time(9))),
            (Some(7.0), Some(0.0), None, None)
        );
    }

    #[test]
    fn a_sum_forgets_nothing_when_a_spike_cancels() {
        let mut sum = Sum::default();
        [1e16, 1.0, -1e16].into_iter().for_each(|number| sum.add(number));
        assert_eq!(sum.value(), 1.0);
    }

    #[test]
    fn values_weigh_by_how_long_they_held() {
        let mut held = HeldMoments::default();
        held.add(10.0, Duration(1));
        held.add(20.0, Duration(3));
        held.add(99.0, Duration::ZERO);
        assert_eq!(held.mean(), Some(17.5));
        assert_eq!(held.variance(), Some(18.75));
    }
}
