//! Statistics of paired measurements: mean with its interval, Wilcoxon's signed-rank test, Holm's correction.
//!
//! Sources: F. Wilcoxon, "Individual comparisons by ranking methods", Biometrics 1 (1945); S. Holm, "A simple sequentially
//! rejective multiple test procedure", Scand. J. Statist. 6 (1979); quantiles after M. Abramowitz and I. A. Stegun,
//! "Handbook of Mathematical Functions", 26.2.23 and 26.7.5.

/// Number of pairs up to which the distribution of the rank sum is exact; above, the normal approximation is used.
pub const EXACT_PAIRS_MAX: usize = 100;

/// Returns the mean of `numbers` and half the width of its 95 % interval by Student's distribution; the width is infinite for fewer than
/// two numbers.
pub fn mean_interval(numbers: &[f64]) -> (f64, f64) {
    let count = numbers.len() as f64;
    if numbers.len() < 2 {
        return (numbers.first().copied().unwrap_or(0.0), f64::INFINITY);
    }
    let mean = numbers.iter().sum::<f64>() / count;
    let variance = numbers.iter().map(|number| (number - mean) * (number - mean)).sum::<f64>() / (count - 1.0);
    (mean, student_975(numbers.len() - 1) * libm::sqrt(variance / count))
}

/// Returns the 97.5 % quantile of Student's distribution; wrong by less than 0.001 from ten degrees of freedom on, and tabulated
/// below.
fn student_975(freedom: usize) -> f64 {
    const FEW: [f64; 9] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262];
    if let Some(known) = freedom.checked_sub(1).and_then(|at| FEW.get(at)) {
        return *known;
    }
    let (z, n) = (1.959_963_985_f64, freedom as f64);
    let z2 = z * z;
    let g1 = z * (z2 + 1.0) / 4.0;
    let g2 = z * (5.0 * z2 * z2 + 16.0 * z2 + 3.0) / 96.0;
    let g3 = z * (3.0 * z2 * z2 * z2 + 19.0 * z2 * z2 + 17.0 * z2 - 15.0) / 384.0;
    z + g1 / n + g2 / (n * n) + g3 / (n * n * n)
}

/// Returns the two-sided probability of differences at least as one-sided as these if their signs were random.
///
/// Zeros are left out, and equal sizes share their mean rank, as in Wilcoxon's test. Exact up to [`EXACT_PAIRS_MAX`] pairs, ties
/// included; above, normal with corrections for ties and continuity.
pub fn signed_rank(differences: &[f64]) -> f64 {
    let mut sizes: Vec<(f64, bool)> =
        differences.iter().filter(|one| **one != 0.0).map(|one| (one.abs(), *one > 0.0)).collect();
    if sizes.is_empty() {
        return 1.0;
    }
    sizes.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let doubled = doubled_ranks(&sizes);
    let positive: usize = doubled.iter().zip(&sizes).filter(|(_, (_, up))| *up).map(|(rank, _)| rank).sum();
    let whole: usize = doubled.iter().sum();
    let smaller = positive.min(whole - positive);
    if sizes.len() <= EXACT_PAIRS_MAX { exact(&doubled, smaller) } else { normal(&doubled, smaller) }
}

/// Returns twice the rank of each size, in rising order: the mean ranks of ties can be halves.
fn doubled_ranks(sizes: &[(f64, bool)]) -> Vec<usize> {
    let mut ranks = Vec::with_capacity(sizes.len());
    while let Some((size, _)) = sizes.get(ranks.len()) {
        let first = ranks.len();
        let equal = sizes.iter().skip(first).take_while(|(other, _)| other == size).count();
        // Ranks first + 1 .. first + equal: twice their mean.
        ranks.extend(std::iter::repeat_n(2 * first + equal + 1, equal));
    }
    ranks
}

/// Returns the exact two-sided probability, from the distribution of the sum of (doubled) ranks over all choices of signs.
fn exact(ranks: &[usize], smaller: usize) -> f64 {
    // chances[sum]: probability that the ranks of the positive differences add up to `sum`.
    let mut chances = vec![0.0; ranks.iter().sum::<usize>() + 1];
    if let Some(first) = chances.first_mut() {
        *first = 1.0;
    }
    let mut reached = 0;
    for rank in ranks {
        reached += rank;
        for sum in (0..=reached).rev() {
            let without = chances.get(sum).copied().unwrap_or(0.0);
            let with = sum.checked_sub(*rank).and_then(|less| chances.get(less)).copied().unwrap_or(0.0);
            if let Some(chance) = chances.get_mut(sum) {
                *chance = 0.5 * (without + with);
            }
        }
    }
    (2.0 * chances.iter().take(smaller + 1).sum::<f64>()).min(1.0)
}

fn normal(ranks: &[usize], smaller: usize) -> f64 {
    // With doubled ranks the mean is half of the sum and the variance a quarter of the sum of squares; this covers ties.
    let mean = 0.5 * ranks.iter().sum::<usize>() as f64;
    let variance = 0.25 * ranks.iter().map(|rank| (rank * rank) as f64).sum::<f64>();
    let off = (mean - smaller as f64 - 1.0).max(0.0);
    libm::erfc(off / libm::sqrt(2.0 * variance)).min(1.0)
}

/// Returns Holm's adjusted probabilities, in the order given.
pub fn holm(probabilities: &[f64]) -> Vec<f64> {
    let mut order: Vec<(usize, f64)> = probabilities.iter().copied().enumerate().collect();
    order.sort_by(|(_, a), (_, b)| a.total_cmp(b));
    let mut adjusted = vec![1.0; probabilities.len()];
    let mut least: f64 = 0.0;
    for (place, (index, probability)) in order.into_iter().enumerate() {
        least = least.max((probability * (probabilities.len() - place) as f64).min(1.0));
        if let Some(slot) = adjusted.get_mut(index) {
            *slot = least;
        }
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn known_probabilities() {
        // Darwin's plants of maize (Fisher, "The Design of Experiments"): rank sum 24 of 15 pairs, p = 0.04126.
        let maize = [6.0, 8.0, 14.0, 16.0, 23.0, 24.0, 28.0, 29.0, 41.0, -48.0, 49.0, 56.0, 60.0, -67.0, 75.0];
        assert!((signed_rank(&maize) - 0.041_259_765_625).abs() < 1e-12, "{}", signed_rank(&maize));
        // All five of one sign: 2 of 32 sign patterns.
        assert_eq!(signed_rank(&[1.0, 2.0, 3.0, 4.0, 5.0]), 0.0625);
        assert_eq!(signed_rank(&[1.0, -1.0, 0.0]), 1.0);
        assert_eq!((signed_rank(&[]), signed_rank(&[0.0, 0.0])), (1.0, 1.0));
    }

    #[test]
    fn many_pairs_are_normal() {
        // 1, -2, 3, -4, .. 200: positive odd ranks sum to 10 000, mean 10 050, deviation 820.5.
        let alternating: Vec<f64> = (1..=200).map(|k| if k % 2 == 1 { f64::from(k) } else { f64::from(-k) }).collect();
        let expected = libm::erfc((49.5 / 819.797_8) / std::f64::consts::SQRT_2);
        assert!((signed_rank(&alternating) - expected).abs() < 1e-3, "{} {expected}", signed_rank(&alternating));
        let ranks: Vec<usize> = (1..=80).map(|rank| 2 * rank).collect();
        for smaller in [1600, 2000, 2600, 3200] {
            assert!((exact(&ranks, smaller) - normal(&ranks, smaller)).abs() < 0.003, "{smaller}");
        }
    }

    #[test]
    fn holm_by_hand() {
        let adjusted = holm(&[0.04, 0.01, 0.03, 0.5]);
        for (found, expected) in adjusted.iter().zip([0.09, 0.04, 0.09, 0.5]) {
            assert!((found - expected).abs() < 1e-12, "{adjusted:?}");
        }
        assert_eq!(holm(&[0.9, 0.8]), [1.0, 1.0]);
    }

    #[test]
    fn intervals() {
        for (freedom, quantile) in [(1, 12.706), (5, 2.5706), (10, 2.2281), (49, 2.0096), (1000, 1.9623)] {
            assert!((student_975(freedom) - quantile).abs() < 1e-3, "{freedom} {}", student_975(freedom));
        }
        let (mean, half) = mean_interval(&[1.0, 2.0, 3.0]);
        assert!((mean - 2.0).abs() < 1e-12 && (half - 4.303 / 3.0_f64.sqrt()).abs() < 1e-3);
        assert_eq!(mean_interval(&[4.0]), (4.0, f64::INFINITY));
    }

    proptest! {
        #[test]
        fn exact_is_what_counting_all_signs_gives(sizes in prop::collection::vec(1..6u32, 1..9), signs in 0..256u32) {
            let value = |at: usize, bits: u32| {
                let size = f64::from(sizes[at]);
                if bits >> at & 1 == 1 { size } else { -size }
            };
            let positive = |bits: u32| -> f64 {
                let all: Vec<f64> = sizes.iter().map(|size| f64::from(*size)).collect();
                // Mean rank by counting.
                let rank = |size: f64| {
                    let below = all.iter().filter(|other| **other < size).count() as f64;
                    let equal = all.iter().filter(|other| **other == size).count() as f64;
                    below + (equal + 1.0) / 2.0
                };
                (0..sizes.len()).filter(|at| bits >> at & 1 == 1).map(|at| rank(all[at])).sum()
            };
            let whole: f64 = (sizes.len() * (sizes.len() + 1)) as f64 / 2.0;
            let off = |bits: u32| positive(bits).min(whole - positive(bits));
            let choices = 1_u32 << sizes.len();
            let signs = signs % choices;
            let as_odd = (0..choices).filter(|bits| off(*bits) <= off(signs)).count() as f64 / f64::from(choices);
            let differences: Vec<f64> = (0..sizes.len()).map(|at| value(at, signs)).collect();
            prop_assert!((signed_rank(&differences) - as_odd).abs() < 1e-12);
        }
    }
}
