//! Statistics of a run (rule 11). Samples are unweighted, or weighted by the time for which each value held; the variance is that of the
//! population.

use crate::aggregate::Inside;
use crate::condition::{Episode, Statistic, Trend};
use crate::history::Sample;
use crate::value::{Value, numbers};

/// Returns true if all tests of statistics hold. A value that is not a finite number has no statistics.
pub(crate) fn hold(episode: &Episode, inside: &Inside) -> bool {
    episode.stats.iter().all(|(statistic, relation, bound)| {
        value_of(*statistic, episode, inside).is_some_and(|value| numbers(*relation, value, *bound))
    })
}

/// Returns true if a test of a statistic that has a value fails.
pub(crate) fn fail(episode: &Episode, inside: &Inside) -> bool {
    episode.stats.iter().any(|(statistic, relation, bound)| {
        value_of(*statistic, episode, inside).is_some_and(|value| !numbers(*relation, value, *bound))
    })
}

/// Returns the statistic of the samples, or of the values by time; `None` if it is unknown.
pub(crate) fn value_of(statistic: Statistic, episode: &Episode, inside: &Inside) -> Option<f64> {
    let counted = counted(episode, &inside.samples);
    match statistic {
        // Without a number inside the window nothing is known, even if an earlier number still holds.
        _ if counted.is_empty() => None,
        Statistic::TimeWeightedMean => weighted(&inside.held).map(|(mean, _)| mean),
        Statistic::TimeWeightedVariance => weighted(&inside.held).map(|(_, variance)| variance),
        Statistic::TimeWeightedDeviation => weighted(&inside.held).map(|(_, variance)| variance.sqrt()),
        _ => of(statistic, &counted),
    }
}

/// Returns true for a statistic that is weighted by time.
pub(crate) fn is_weighted(statistic: Statistic) -> bool {
    matches!(
        statistic,
        Statistic::TimeWeightedMean | Statistic::TimeWeightedVariance | Statistic::TimeWeightedDeviation
    )
}

/// Returns the mean and variance of values weighted by the seconds for which they held; `None` if the total is zero.
fn weighted(held: &[(f64, f64)]) -> Option<(f64, f64)> {
    let seconds: f64 = held.iter().map(|(_, seconds)| seconds).sum();
    let mean = held.iter().map(|(value, seconds)| value * seconds).sum::<f64>() / seconds;
    let squares = held.iter().map(|(value, seconds)| (value - mean) * (value - mean) * seconds);
    (seconds > 0.0).then(|| (mean, squares.sum::<f64>() / seconds))
}

/// Returns the numbers for the statistics. If samples are only counted, a sample that is not a number counts, too.
fn counted(episode: &Episode, samples: &[Sample]) -> Vec<f64> {
    if !only_counts(episode) {
        return finite(samples);
    }
    samples.iter().filter_map(|sample| if infinite(sample) { None } else { Some(0.0) }).collect()
}

/// Returns true if samples are only counted.
pub(crate) fn only_counts(episode: &Episode) -> bool {
    episode.stats.iter().all(|(statistic, ..)| *statistic == Statistic::Count)
        && episode.trend.iter().all(|(trend, ..)| *trend == Trend::Frequency)
}

pub(crate) fn infinite(sample: &Sample) -> bool {
    matches!(sample.value, Value::Number(number) if !number.is_finite())
}

/// Returns the values that are finite numbers, in order of time (rule 18: infinities compare, but are in no statistics).
pub(crate) fn finite(samples: &[Sample]) -> Vec<f64> {
    let numbers = samples.iter().filter_map(|sample| match sample.value {
        Value::Number(number) if number.is_finite() => Some(number),
        _ => None,
    });
    numbers.collect()
}

/// Returns the statistic; `None` if there are no values.
pub(crate) fn of(statistic: Statistic, values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (least, most) = (*sorted.first()?, *sorted.last()?);
    let count = values.len() as f64;
    let mean = mean_of(values);
    let variance = mean_of(&values.iter().map(|value| (value - mean) * (value - mean)).collect::<Vec<_>>());
    Some(match statistic {
        Statistic::Count => count,
        Statistic::Mean => mean,
        Statistic::Sum => values.iter().sum(),
        Statistic::Min => least,
        Statistic::Max => most,
        Statistic::Median => (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2]) / 2.0,
        Statistic::Difference => most - least,
        Statistic::Variance => variance,
        Statistic::StandardDeviation => variance.sqrt(),
        Statistic::TimeWeightedMean | Statistic::TimeWeightedVariance | Statistic::TimeWeightedDeviation => {
            return None;
        }
    })
}

/// Returns the mean, anchored at the first value and corrected once.
fn mean_of(values: &[f64]) -> f64 {
    let Some(anchor) = values.first() else { return 0.0 };
    let count = values.len() as f64;
    let mean = anchor + values.iter().map(|value| value - anchor).sum::<f64>() / count;
    mean + values.iter().map(|value| value - mean).sum::<f64>() / count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_to_ninety_nine() {
        let values: Vec<f64> = (1..=99).map(f64::from).collect();
        assert!((of(Statistic::Variance, &values).unwrap() - 816.666_666_666).abs() < 1e-6);
        assert!((of(Statistic::StandardDeviation, &values).unwrap() - 28.577_381).abs() < 1e-6);
        assert_eq!(of(Statistic::Median, &values), Some(50.0));
        assert_eq!(of(Statistic::Difference, &values), Some(98.0));
        assert_eq!(of(Statistic::Mean, &[]), None);
        assert_eq!(of(Statistic::Count, &[]), None);
    }
}
