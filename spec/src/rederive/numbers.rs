//! Checks of computed values: estimates and aggregates are computed again, in the simplest way, from the samples in the record.

use super::require::require;
use super::world::World;
use apex_model::estimate::{Aggregate, Estimate, Estimator};
use apex_model::event::StateVariable;
use apex_model::quantity::Dimension;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Returns the recorded samples of the variable, or none if a program publishes them itself.
fn known<'a>(world: &'a World<'_>, variable: &StateVariable) -> Result<Option<&'a Vec<(Time, Value)>>, String> {
    match world.samples.get(&variable.to_string()) {
        Some(known) => Ok(Some(known)),
        None => {
            let publishes = world.library.sources.iter().any(|source| source.text.contains("(publish"));
            require(publishes, "no such variable was measured").map(|()| None)
        }
    }
}

/// Returns the last arrival of each instant from `start` to `end`, as pure numbers; empty where units are involved.
fn numbers(known: &[(Time, Value)], (start, end): (Time, Time)) -> Vec<(Time, f64)> {
    let mut found: Vec<(Time, f64)> = Vec::new();
    for (at, value) in known.iter().filter(|(at, _)| (start..=end).contains(at)) {
        match value.as_number() {
            Some((number, Dimension::NONE)) if number.is_finite() => {
                match found.iter_mut().find(|(when, _)| when == at) {
                    Some(present) => present.1 = number,
                    None => found.push((*at, number)),
                }
            }
            _ => return Vec::new(),
        }
    }
    found.sort_by_key(|(at, _)| *at);
    found
}

fn near(a: f64, b: f64, size: f64) -> bool {
    (a - b).abs() <= 1e-6 * size.abs().max(1.0)
}

fn same(value: &Value, expected: f64, size: f64) -> Result<(), String> {
    match value.as_number() {
        Some((number, Dimension::NONE)) => require(near(number, expected, size), "another number comes of it"),
        _ => Ok(()),
    }
}

/// Checks an estimate: its samples are in the record, and it follows from them.
pub(super) fn estimate(world: &World<'_>, estimate: &Estimate) -> Result<(), String> {
    let Estimate { extent: (start, end), at, .. } = estimate;
    require(start < end, "its extent ends before it begins")?;
    let Some(known) = known(world, &estimate.variable)? else { return Ok(()) };
    require(known.iter().any(|(when, _)| when == start), "no sample where its extent begins")?;
    match estimate.estimator {
        Estimator::Persistence => {
            require(at >= start && at < end, "it is evidence of an instant at which it is not valid")
        }
        Estimator::LinearRegression => {
            let last = *end - Duration(1);
            require(known.iter().any(|(when, _)| *when == last), "no sample at the end of the fit")?;
            let samples = numbers(known, (*start, last));
            if samples.len() as u64 != estimate.samples {
                return Ok(());
            }
            let count = samples.len() as f64;
            let seconds = |at: Time| (at - *start).seconds();
            let mean_t = samples.iter().map(|(at, _)| seconds(*at)).sum::<f64>() / count;
            let mean_x = samples.iter().map(|(_, x)| x).sum::<f64>() / count;
            let spread: f64 = samples.iter().map(|(at, _)| (seconds(*at) - mean_t).powi(2)).sum();
            let common: f64 = samples.iter().map(|(at, x)| (seconds(*at) - mean_t) * (x - mean_x)).sum();
            let predicted = mean_x + common / spread * (seconds(*at) - mean_t);
            same(&estimate.value, predicted, mean_x.abs() + predicted.abs())
        }
    }
}

/// Checks a statistic or trend: its samples are in the record, and simple ones are computed again.
pub(super) fn aggregate(world: &World<'_>, aggregate: &Aggregate) -> Result<(), String> {
    let Aggregate { interval: (start, end), samples, .. } = aggregate;
    require(start <= end, "it ends before it begins")?;
    require(*samples >= 1, "it rests on no sample")?;
    let Some(known) = known(world, &aggregate.variable)? else { return Ok(()) };
    let is_sample = |at: &Time| known.iter().any(|(when, _)| when == at);
    require(is_sample(start) && is_sample(end), "no sample at its start or end")?;
    let values = numbers(known, (*start, *end));
    if values.len() as u64 != *samples {
        return Ok(());
    }
    let sum: f64 = values.iter().map(|(_, x)| x).sum();
    let size = values.iter().map(|(_, x)| x.abs()).fold(1.0, f64::max);
    match aggregate.name.as_str() {
        "count" => same(&aggregate.value, values.len() as f64, 1.0),
        "sum" => same(&aggregate.value, sum, size),
        "mean" => same(&aggregate.value, sum / values.len() as f64, size),
        "min" => same(&aggregate.value, values.iter().map(|(_, x)| *x).fold(f64::INFINITY, f64::min), size),
        "max" => same(&aggregate.value, values.iter().map(|(_, x)| *x).fold(f64::NEG_INFINITY, f64::max), size),
        _ => Ok(()),
    }
}
