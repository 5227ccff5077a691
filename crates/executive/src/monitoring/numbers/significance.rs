//! Significance (M&I)
//! What: computes the probability of a slope at least this steep without a trend: two-sided Student's t test.
//! Runs: from trends, where `:significance` is stated.
//! Reads: nothing.
//! Writes: nothing.
//! Bound: at most `FRACTION_TERMS_MAX` terms of a continued fraction.
//! PDL: `:trend (:significance P)`.
//! Paper: Table 1, row 9.

use crate::state::monitors::moments::Moments;

/// Maximum number of terms. The fraction converges in about the square root of the degrees of freedom, or faster in the tails.
const FRACTION_TERMS_MAX: u32 = 10_000;

/// Returns the probability that samples without a trend show a slope at least this far from zero; `None` with fewer than three samples or
/// two distinct instants.
pub(crate) fn slope_by_chance(moments: &Moments) -> Option<f64> {
    let slope = moments.slope_per_s()? / 1e9;
    let freedom = moments.count().checked_sub(2).filter(|freedom| *freedom > 0)? as f64;
    let residual = moments.residual()?;
    if slope == 0.0 {
        return Some(1.0);
    }
    if residual == 0.0 {
        return Some(0.0);
    }
    let squared = slope * slope * moments.time_spread() * freedom / residual;
    Some(beta_ratio(freedom / (freedom + squared), squared / (freedom + squared), freedom / 2.0, 0.5))
}

/// Returns the regularised incomplete beta function at `x`, with `rest` = 1 - x.
fn beta_ratio(x: f64, rest: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if rest <= 0.0 {
        return 1.0;
    }
    let log_front = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * libm::log(x) + b * libm::log(rest);
    let front = libm::exp(log_front);
    // The continued fraction converges fast only on one side of the mean; the other side uses the symmetry of the function.
    if x < (a + 1.0) / (a + b + 2.0) { front * fraction(x, a, b) / a } else { 1.0 - front * fraction(rest, b, a) / b }
}

/// Returns the continued fraction of the incomplete beta function, evaluated forwards (Lentz).
fn fraction(x: f64, a: f64, b: f64) -> f64 {
    let away_from_zero = |number: f64| if libm::fabs(number) < 1e-300 { 1e-300 } else { number };
    let mut c = 1.0;
    let mut d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
    let mut value = d;
    for term in 1..FRACTION_TERMS_MAX {
        let m = f64::from(term);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / away_from_zero(1.0 + even * d);
        c = away_from_zero(1.0 + even / c);
        value *= d * c;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / away_from_zero(1.0 + odd * d);
        c = away_from_zero(1.0 + odd / c);
        let step = d * c;
        value *= step;
        if libm::fabs(step - 1.0) < 1e-15 {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::time::Time;

    /// Returns the two-sided probability of Student's t.
    fn two_sided(t: f64, freedom: f64) -> f64 {
        beta_ratio(freedom / (freedom + t * t), t * t / (freedom + t * t), freedom / 2.0, 0.5)
    }

    #[test]
    fn agrees_with_the_printed_tables_of_students_t() {
        for (t, freedom, expected) in [
            (12.706_204_736, 1.0, 0.05),
            (2.228_138_852, 10.0, 0.05),
            (2.749_995_654, 30.0, 0.01),
            (1.0, 1.0, 0.5),
            (1.960_201_263, 10_000.0, 0.05),
        ] {
            assert!((two_sided(t, freedom) - expected).abs() < 1e-7, "{t} {freedom}: {}", two_sided(t, freedom));
        }
        // With two degrees of freedom there is a closed form.
        for t in [0.1_f64, 0.9, 3.0, 40.0] {
            assert!((two_sided(t, 2.0) - (1.0 - t / (2.0 + t * t).sqrt())).abs() < 1e-13);
        }
    }

    #[test]
    fn a_perfect_line_is_not_a_chance_and_a_level_one_is_nothing_else() {
        let of = |numbers: &[f64]| {
            let mut moments = Moments::default();
            numbers.iter().zip(1..).for_each(|(number, at)| moments.add(Time(at * 1_000_000_000), *number));
            slope_by_chance(&moments)
        };
        assert_eq!(of(&[1.0, 2.0, 3.0, 4.0]), Some(0.0));
        assert_eq!(of(&[2.0, 2.0, 2.0]), Some(1.0));
        assert_eq!(of(&[1.0, 2.0]), None);
        // Slope 1/2, residual 3/2 with one degree of freedom, spread 2: t = 1 / sqrt(3), p = 2/3.
        assert!((of(&[0.0, 2.0, 1.0]).unwrap() - 2.0 / 3.0).abs() < 1e-12);
    }
}
