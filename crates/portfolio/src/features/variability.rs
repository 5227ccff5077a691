//! Variation of a quantity between targets: none, two groups, or any.

use super::classifier::Classification;
use crate::cell::Spread;

/// Words of the bins, in the order of [`Spread::ALL`].
pub(super) const BINS: &[&str] = &["clustered", "fixed", "uniform"];
/// Coefficient of variation below which targets are taken for alike.
const ALIKE: f64 = 0.1;
/// Share of the variance explained by two groups above which there are two groups. Equally spaced numbers leave a quarter of the variance
/// unexplained; groups with a spread of a tenth leave a hundredth.
const TWO_GROUPS: f64 = 0.975;
/// Width of the smooth transition around [`TWO_GROUPS`].
const PASSAGE: f64 = 0.01;

/// Reads the spread of `numbers`.
pub(super) fn read(numbers: &[f64]) -> Classification {
    let (variation, bimodality) = (variation(numbers), bimodality(numbers));
    let grouped = 1.0 / (1.0 + libm::exp((TWO_GROUPS - bimodality) / PASSAGE));
    let distances = Spread::ALL.map(|spread| match spread {
        Spread::Fixed => (0.5 * variation / ALIKE).min(1.0),
        _ if variation < ALIKE => 1.0,
        Spread::Clustered => 1.0 - grouped,
        Spread::Uniform => grouped,
    });
    let numbers = vec![("coefficient of variation", variation), ("bimodality", bimodality)];
    Classification { numbers, distances: distances.to_vec() }
}

/// Returns the standard deviation divided by the mean; 0 if the mean is 0.
fn variation(numbers: &[f64]) -> f64 {
    let (mean, variance) = moments(numbers);
    if mean > 0.0 { libm::sqrt(variance) / mean } else { 0.0 }
}

/// Returns the share of the variance that is between the two groups of the best division in two; 0 where all are equal.
fn bimodality(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (_, whole) = moments(&sorted);
    if whole <= 0.0 {
        return 0.0;
    }
    let within = (1..sorted.len()).filter_map(|at| {
        let (low, high) = sorted.split_at_checked(at)?;
        Some(moments(low).1 * low.len() as f64 + moments(high).1 * high.len() as f64)
    });
    let least = within.fold(f64::INFINITY, f64::min) / sorted.len() as f64;
    (1.0 - least / whole).max(0.0)
}

/// Returns the mean and variance.
fn moments(numbers: &[f64]) -> (f64, f64) {
    let count = numbers.len().max(1) as f64;
    let mean = numbers.iter().sum::<f64>() / count;
    (mean, numbers.iter().map(|number| (number - mean) * (number - mean)).sum::<f64>() / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variation_and_bimodality_of_known_numbers() {
        assert_eq!((variation(&[2.0, 2.0]), bimodality(&[2.0, 2.0])), (0.0, 0.0));
        assert_eq!(variation(&[1.0, 3.0]), 0.5);
        assert_eq!(bimodality(&[1.0, 1.0, 5.0]), 1.0);
        // 0, 1, 2, 3: variance 1.25, within the halves 0.25.
        assert!((bimodality(&[3.0, 0.0, 2.0, 1.0]) - 0.8).abs() < 1e-12);
        assert_eq!(variation(&[]), 0.0);
    }

    #[test]
    fn bins() {
        let bin = |numbers: &[f64]| BINS[read(numbers).bin()];
        assert_eq!(bin(&[1.0, 1.0, 1.0]), "fixed");
        assert_eq!(bin(&[0.2, 1.8, 0.21, 1.75]), "clustered");
        assert_eq!(bin(&[0.2, 0.7, 1.2, 1.8]), "uniform");
    }
}
