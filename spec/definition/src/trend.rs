//! Trends of a run (rule 12).

use crate::aggregate::Inside;
use crate::condition::{Episode, Relation, Trend};
use crate::history::Sample;
use crate::statistics::{finite, infinite, only_counts};
use crate::value::{Value, numbers};

/// Returns true if all tests of trends hold.
pub(crate) fn hold(episode: &Episode, inside: &Inside) -> bool {
    episode
        .trend
        .iter()
        .all(|(trend, relation, bound)| judged(episode, (*trend, *relation, *bound), &inside.samples) == Some(true))
}

/// Returns true if a test of a trend that has a value fails.
pub(crate) fn fail(episode: &Episode, inside: &Inside) -> bool {
    episode
        .trend
        .iter()
        .any(|(trend, relation, bound)| judged(episode, (*trend, *relation, *bound), &inside.samples) == Some(false))
}

/// Returns true if the samples satisfy the constraint; `None` if they show no trend, as with fewer than two distinct instants.
fn judged(episode: &Episode, (trend, relation, bound): (Trend, Relation, f64), samples: &[Sample]) -> Option<bool> {
    let points = points(samples);
    match trend {
        Trend::Rate => slope(&points).map(|slope| numbers(relation, slope, bound)),
        Trend::Step => {
            let all = points.windows(2).all(|pair| numbers(relation, pair[1].1 - pair[0].1, bound));
            (points.len() > 1).then_some(all)
        }
        Trend::Frequency => frequency(episode, samples).map(|value| numbers(relation, value, bound)),
    }
}

/// Returns seconds since the first, and the value, of every sample that is a finite number.
pub(crate) fn points(samples: &[Sample]) -> Vec<(f64, f64)> {
    let Some(first) = samples.first() else { return Vec::new() };
    let numbers = samples.iter().filter_map(|sample| match sample.value {
        Value::Number(number) if number.is_finite() => Some(((sample.at - first.at) as f64 / 1e9, number)),
        _ => None,
    });
    numbers.collect()
}

/// Returns the slope of the least-squares line, per second.
fn slope(points: &[(f64, f64)]) -> Option<f64> {
    line(points).map(|(_, _, slope)| slope)
}

/// Returns the least-squares line: mean of the instants, mean of the values, slope.
pub(crate) fn line(points: &[(f64, f64)]) -> Option<(f64, f64, f64)> {
    let count = points.len() as f64;
    let (mean_t, mean_v) =
        (points.iter().map(|(t, _)| t).sum::<f64>() / count, points.iter().map(|(_, v)| v).sum::<f64>() / count);
    let spread: f64 = points.iter().map(|(t, _)| (t - mean_t) * (t - mean_t)).sum();
    let common: f64 = points.iter().map(|(t, v)| (t - mean_t) * (v - mean_v)).sum();
    (spread > 0.0).then(|| (mean_t, mean_v, common / spread))
}

/// Intervals between the samples that count, per second.
fn frequency(episode: &Episode, samples: &[Sample]) -> Option<f64> {
    let number = |sample: &&Sample| !finite(std::slice::from_ref(*sample)).is_empty();
    let counts = |sample: &&Sample| if only_counts(episode) { !infinite(sample) } else { number(sample) };
    let samples: Vec<&Sample> = samples.iter().filter(counts).collect();
    let (first, last) = (samples.first()?, samples.last()?);
    let seconds = (last.at - first.at) as f64 / 1e9;
    (seconds > 0.0).then(|| (samples.len() - 1) as f64 / seconds)
}
