//! Trends of a run (rule 12).

use crate::condition::{Episode, Trend};
use crate::history::Sample;
use crate::value::{Value, numbers};

/// Do all tests of trends hold? Fewer than two distinct instants show no trend.
pub(crate) fn hold(episode: &Episode, samples: &[Sample]) -> bool {
    episode.trend.iter().all(|(trend, relation, bound)| {
        let points = points(samples);
        match trend {
            Trend::Rate => slope(&points).is_some_and(|slope| numbers(*relation, slope, *bound)),
            Trend::Step => {
                points.len() > 1 && points.windows(2).all(|pair| numbers(*relation, pair[1].1 - pair[0].1, *bound))
            }
            Trend::Frequency => frequency(samples).is_some_and(|value| numbers(*relation, value, *bound)),
        }
    })
}

/// Have all trends that are asked for a value?
pub(crate) fn defined(episode: &Episode, samples: &[Sample]) -> bool {
    episode.trend.is_empty() || (points(samples).len() > 1 && slope(&points(samples)).is_some())
}

/// Seconds since the first, and the value, of every sample that is a finite number.
pub(crate) fn points(samples: &[Sample]) -> Vec<(f64, f64)> {
    let Some(first) = samples.first() else { return Vec::new() };
    let numbers = samples.iter().filter_map(|sample| match sample.value {
        Value::Number(number) if number.is_finite() => Some(((sample.at - first.at) as f64 / 1e9, number)),
        _ => None,
    });
    numbers.collect()
}

/// The slope of the least-squares line, per second.
fn slope(points: &[(f64, f64)]) -> Option<f64> {
    line(points).map(|(_, _, slope)| slope)
}

/// The least-squares line: mean of the instants, mean of the values, slope.
pub(crate) fn line(points: &[(f64, f64)]) -> Option<(f64, f64, f64)> {
    let count = points.len() as f64;
    let (mean_t, mean_v) =
        (points.iter().map(|(t, _)| t).sum::<f64>() / count, points.iter().map(|(_, v)| v).sum::<f64>() / count);
    let spread: f64 = points.iter().map(|(t, _)| (t - mean_t) * (t - mean_t)).sum();
    let common: f64 = points.iter().map(|(t, v)| (t - mean_t) * (v - mean_v)).sum();
    (spread > 0.0).then(|| (mean_t, mean_v, common / spread))
}

/// Intervals between samples, per second.
fn frequency(samples: &[Sample]) -> Option<f64> {
    let (first, last) = (samples.first()?, samples.last()?);
    let seconds = (last.at - first.at) as f64 / 1e9;
    (seconds > 0.0).then(|| (samples.len() - 1) as f64 / seconds)
}
